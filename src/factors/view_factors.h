/* The matrix of view factors between surfaces. */
#ifndef RAD_FACTORS_VIEW_FACTORS_H
#define RAD_FACTORS_VIEW_FACTORS_H

#include <stdint.h>

#include "base/error.h"
#include "scene/scene.h"

struct rad_view_factors {
  int n;               /* surfaces */
  double tolerance;    /* asked for, of every entry and every row sum */
  double *matrix;      /* owned [n, n] F_st: share of what leaves s that arrives at t; or NULL */
  double *error;       /* owned [n, n] sums of what all pairs of triangles may be wrong by */
  double *row_sum;     /* owned [n] sum over t */
  double *reciprocity; /* owned [n, n] largest difference of the two directions over the pairs of
                          triangles of s and t that were looked at, over max(A_s, A_t); NaN: none */
  double worst_error, worst_reciprocity; /* worst_error: of the row sums as well */
  int64_t points;                        /* at which visible parts were found */
  double seconds;
  int converged;
  char reason[256]; /* why the tolerance was not met; empty if it was */
};

/**
 * F_st = 1/A_s sum_{i in s, j in t} I_ij,  I_ij = int_i int_j G(x, y) dS dS = I_ji (theory 12.1)
 *
 * Each pair of triangles is integrated once, the outer integral over the smaller one. Pairs that
 * see all of each other are exact to rounding; others get a share of the tolerance, so that every
 * entry and every row sum meets it. A sample of pairs (1 %, all partly visible ones up to 200) is
 * integrated from the other side as well.
 *
 * @param[in]  tolerance  absolute
 * @param[in]  limit      most points in all, or 0: 3e8; each partly visible pair has an equal part
 *                        of it, at least 10000, at most 50000
 * @param[out] f          to be freed with rad_view_factors_free, also after an error
 * @return RAD_OK also when the tolerance was not met: f->converged is 0 and f->reason says why;
 *         RAD_ENUMERIC if the two directions of a pair differ by more than their errors. A smaller
 *         tolerance never has a larger error. The same bits for any number of threads.
 */
enum rad_code rad_view_factors(const struct rad_scene *scene, double tolerance, double limit,
                               struct rad_view_factors *f, struct rad_error *e);
void rad_view_factors_free(struct rad_view_factors *f); /* safe twice */

#endif
