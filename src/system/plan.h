/* Dense or hierarchical, and what a solve will take, before anything large is made. */
#ifndef RAD_SYSTEM_PLAN_H
#define RAD_SYSTEM_PLAN_H

#include "system/solve.h"

struct rad_system_plan {
  enum rad_matrix matrix; /* dense or hierarchical */
  enum rad_solver solver;
  double matrix_bytes; /* of the finished matrix */
  double bytes;        /* most at once: while it is built, or with what the solver adds */
  double near_entries; /* of a hierarchical matrix */
};

/* The plan for a dense matrix, from counts alone. */
struct rad_system_plan rad_plan_dense(enum rad_solver solver, double n, int n_band);

/* True if what is asked for leaves room for a hierarchical matrix, which only the mesh can decide.
 */
int rad_plan_may_compress(enum rad_matrix matrix, enum rad_solver solver, double n);

/**
 * @param[in]  matrix, solver  asked for
 * @param[in]  tolerance       of the compression
 * @param[in]  available       memory [bytes], which decides where `auto` has a choice
 */
enum rad_code rad_plan_system(const struct rad_mesh *mesh, enum rad_matrix matrix,
                              enum rad_solver solver, double tolerance, double available,
                              struct rad_system_plan *plan, struct rad_error *e);

#endif
