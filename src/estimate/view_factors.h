/* The matrix of view factors between surfaces, by adaptive cubature. */
#ifndef RAD_ESTIMATE_VIEW_FACTORS_H
#define RAD_ESTIMATE_VIEW_FACTORS_H

#include <stdint.h>

#include "base/error.h"
#include "scene/scene.h"

struct rad_view_factors {
  int n;               /* surfaces */
  double tolerance;    /* asked for, of every entry and every row sum */
  double *matrix;      /* owned [n, n] F_st: share of what leaves s that arrives at t; or NULL */
  double *error;       /* owned [n, n] estimates */
  double *row_sum;     /* owned [n] sum over t, by a cubature with an estimate of its own */
  double *reciprocity; /* owned [n, n] |A_s F_st - A_t F_ts| / max(A_s, A_t) */
  double worst_error, worst_reciprocity; /* worst_error: of the row sums as well */
  int64_t points;                        /* used for the cubature */
  double seconds;
  int converged;
  char reason[256]; /* why the tolerance was not met; empty if it was */
};

/**
 * F_st = 1/A_s int_s h_t dS,  h_t(x) = int_t G(x, y) dS(y)                          (theory 12.1)
 *
 * Both directions are computed, so that reciprocity A_s F_st = A_t F_ts tells something. The
 * estimates compare two rules on every cell; a pair whose reciprocity they do not explain is
 * refined until they do.
 *
 * @param[in]  tolerance  absolute
 * @param[in]  limit      most points, or 0: 1e8 over the number of triangles, and at least 400 for
 *                        each triangle
 * @param[out] f          to be freed with rad_view_factors_free, also after an error
 * @return RAD_OK also when the tolerance was not met: f->converged is 0 and f->reason says why
 * Cost: points times triangles in front of them. Memory: two numbers per surface for every cell of
 * about 13 points, at most a quarter of what there is. The same bits for any number of threads.
 */
enum rad_code rad_view_factors(const struct rad_scene *scene, double tolerance, double limit,
                               struct rad_view_factors *f, struct rad_error *e);
void rad_view_factors_free(struct rad_view_factors *f); /* safe twice */

#endif
