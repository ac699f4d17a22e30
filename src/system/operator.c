#include "system/operator.h"

_Static_assert((int)RAD_MOST_VECTORS >= (int)RAD_MAX_PRODUCT, "one pass for all");

#define PAYS 8.0 /* memory that compression must save before it also saves time (measured) */

struct rad_operator rad_operator_dense(const struct rad_dense *dense) {
  return (struct rad_operator){dense->mesh, dense->n, dense->sees, dense, NULL};
}

struct rad_operator rad_operator_h2(const struct rad_h2 *h2) {
  return (struct rad_operator){h2->mesh, h2->mesh->n_point, h2->sees, NULL, h2};
}

void rad_operator_apply(const struct rad_operator *k, int n_vector, const double *const *u,
                        double *const *y) {
  if (k->dense)
    rad_dense_apply(k->dense, n_vector, u, y);
  else
    rad_h2_apply(k->h2, n_vector, u, y);
}

enum rad_matrix rad_operator_pick(enum rad_matrix asked, double dense_bytes, double h2_bytes,
                                  double available) {
  if (asked != RAD_MATRIX_AUTO)
    return asked;
  int fits = dense_bytes <= 0.8 * available, saves = h2_bytes < dense_bytes / PAYS;
  if (dense_bytes <= RAD_SMALL_MATRIX || (fits && !saves) || h2_bytes >= dense_bytes)
    return RAD_MATRIX_DENSE;
  return RAD_MATRIX_HIERARCHICAL;
}
