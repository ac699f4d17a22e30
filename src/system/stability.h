/* How stable collocation is on a mesh: exact norms of the inverse, for small systems. */
#ifndef RAD_SYSTEM_STABILITY_H
#define RAD_SYSTEM_STABILITY_H

#include "system/dense.h"

enum { RAD_STABILITY_MOST = 3000 }; /* unknowns up to which it is computed: 25 n^3 operations */

/* Norms in the maximum norm, with D = diag(rho): A = I - D K (theory 5.4 to 5.6). */
struct rad_stability {
  double
      inverse_norm; /* of E at the points -> u_h anywhere: sup_x sum_j |sum_b L_b(x) A^-1[b,j]| */
  double inverse_matrix;  /* ||A^-1||: of E at the points -> u_h at the points */
  double condition;       /* ||A|| ||A^-1|| */
  double spectral_radius; /* of D K, that is of P_N rho K */
};

/**
 * One band. inverse_norm is a maximum over (4 k + 1)^2 places of each element with k points per
 * direction, ends included: exact for k <= 2, where the sum is convex in each direction.
 *
 * @param[in]  rho  [n] reflectivity at the points
 * @param[out] s    norms of a singular matrix are infinite
 * @return RAD_ESYSTEM if there is no memory for two matrices more
 */
enum rad_code rad_stability(const struct rad_dense *dense, const double *rho,
                            struct rad_stability *s, struct rad_error *e);

#endif
