/* What every triangle receives: double surface integrals with the source outside. */
#ifndef RAD_ESTIMATE_RECEIVED_H
#define RAD_ESTIMATE_RECEIVED_H

#include <stdint.h>

#include "estimate/light_cell.h"

struct rad_received {
  int n_triangle, n_weight;
  double *value;               /* owned [n_triangle, n_weight] int_T K w dS [W] */
  double *error;               /* owned [n_triangle, n_weight] of the integration [W] */
  double sent[RAD_MAX_WEIGHT]; /* int w dS over all elements [W] */
  int64_t factors;             /* made, from points to triangles */
  int n_sender;                /* elements that send anything */
};

/**
 * int_T (K w)(x) dS_x = int w(y) F(y -> T) dS_y      for every triangle T (theory 17.1)
 *
 * G is symmetric, so the inner integral is that over T, Lambert's closed form with shadows, and the
 * outer one runs over the elements that send. What is near and small compared with T, and a spike
 * of irradiance on it, is smooth from there; cells shrink where T is near and small itself.
 *
 * @param[in]  to         the mesh's scene, or one whose first triangles are the same and whose
 *                        visibility is known;  first: the receivers are its triangles from there on
 * @param[in]  tolerance  [w->n] of the mean over each T [W/m2]; INFINITY: as it comes
 * @param[out] r          to be freed with rad_received_free, also after an error
 * @return RAD_ESTOPPED once rad_stop_asked()
 * The same bits for any number of threads. Elements where all w vanish cost nothing.
 */
enum rad_code rad_receive(const struct rad_weights *w, const struct rad_scene *to, int first,
                          const double *tolerance, struct rad_received *r, struct rad_error *e);
void rad_received_free(struct rad_received *r); /* safe twice */

#endif
