/* Integrals of all pairs of triangles that see each other, each once. */
#ifndef RAD_FACTORS_PAIRS_H
#define RAD_FACTORS_PAIRS_H

#include <stdint.h>

#include "factors/engine.h"

/* Pairs (i, j), i < j, of row i: entries first[i] .. first[i + 1], j ascending. */
struct rad_pairs {
  const struct rad_pair_engine *g;     /* borrowed */
  int n;                               /* triangles */
  int64_t *first;                      /* owned [n + 1] */
  int *other;                          /* owned: j */
  double *value;                       /* owned: int_i int_j G dS dS [m2] */
  double *error;                       /* owned: at most [m2] */
  double *from_other;                  /* owned: the value from the other side, or NaN */
  int64_t points, n_partly, n_limited; /* n_limited: pairs that met the limit of their points */
  int limited[2];                      /* one of them */
};

/**
 * @param[in]  tolerance  of each row of surfaces, and so of each entry, over the surface's area
 * @param[in]  limit      most points of a partly visible pair
 * @param[out] p          to be freed with rad_pairs_free, also after an error
 * @return RAD_ESTOPPED once rad_stop_asked()
 */
enum rad_code rad_pairs_integrate(const struct rad_pair_engine *g, double tolerance, int64_t limit,
                                  struct rad_pairs *p, struct rad_error *e);
void rad_pairs_free(struct rad_pairs *p); /* safe twice */

#endif
