/* The matrix K in whatever form: dense, or hierarchical. */
#ifndef RAD_SYSTEM_OPERATOR_H
#define RAD_SYSTEM_OPERATOR_H

#include "system/dense.h"
#include "system/h2.h"

#define RAD_SMALL_MATRIX                                                                           \
  1.5e8 /* bytes of a dense matrix that is made and multiplied in no time                          \
         */

/* What the solvers know of K. Exactly one of dense and h2 is not NULL. */
struct rad_operator {
  const struct rad_mesh *mesh;
  int n;
  const unsigned char *sees; /* [n_triangle, n_triangle] of the scene's visibility */
  const struct rad_dense *dense;
  const struct rad_h2 *h2;
};

struct rad_operator rad_operator_dense(const struct rad_dense *dense);
struct rad_operator rad_operator_h2(const struct rad_h2 *h2);

/* y_v = K u_v for 1 .. RAD_MAX_PRODUCT vectors [n], no aliases; one product at a time. */
void rad_operator_apply(const struct rad_operator *k, int n_vector, const double *const *u,
                        double *const *y);

/**
 * The form that `auto` stands for: dense as long as that is small, or no larger than the
 * hierarchical form is predicted to be.
 *
 * @param[in] dense_bytes, h2_bytes  of both forms;  available: memory [bytes]
 */
enum rad_matrix rad_operator_pick(enum rad_matrix asked, double dense_bytes, double h2_bytes,
                                  double available);

#endif
