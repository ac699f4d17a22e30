#include "system/plan.h"

#include <math.h>

#define WORK_BYTES 320 /* of each unknown: products and check of a hierarchical matrix */

struct rad_system_plan rad_plan_dense(enum rad_solver solver, double n, int n_band) {
  struct rad_system_plan p = {
      .matrix = RAD_MATRIX_DENSE, .solver = rad_solver_pick(solver, n), .matrix_bytes = 8 * n * n};
  p.bytes = rad_solver_bytes(p.solver, n, n_band);
  return p;
}

int rad_plan_may_compress(enum rad_matrix matrix, enum rad_solver solver, double n) {
  return matrix == RAD_MATRIX_HIERARCHICAL ||
         (matrix == RAD_MATRIX_AUTO && solver != RAD_SOLVER_LU && 8 * n * n > RAD_SMALL_MATRIX);
}

enum rad_code rad_plan_system(const struct rad_mesh *mesh, enum rad_matrix matrix,
                              enum rad_solver solver, double tolerance, double available,
                              struct rad_system_plan *plan, struct rad_error *e) {
  double n = mesh->n_point;
  int n_band = mesh->scene->n_band;
  struct rad_h2_plan h2;
  *plan = rad_plan_dense(solver, n, n_band);
  if (!rad_plan_may_compress(matrix, solver, n))
    return RAD_OK;
  enum rad_code code = rad_h2_predict(mesh, tolerance, &h2, e);
  if (code ||
      rad_operator_pick(matrix, plan->matrix_bytes, h2.bytes_build, available) == RAD_MATRIX_DENSE)
    return code;
  plan->matrix = RAD_MATRIX_HIERARCHICAL;
  plan->solver = plan->solver == RAD_SOLVER_LU ? RAD_SOLVER_GMRES : plan->solver;
  double vectors = rad_solver_bytes(plan->solver, n, n_band) - plan->matrix_bytes;
  plan->near_entries = h2.near_entries;
  plan->matrix_bytes = h2.bytes;
  plan->bytes = fmax(h2.bytes_build, h2.bytes + vectors) + WORK_BYTES * n;
  return RAD_OK;
}
