/* Integrals of what a cell of one triangle sends to another one, with shadows, cell by cell. */
#ifndef RAD_FACTORS_CELLS_H
#define RAD_FACTORS_CELLS_H

#include <stdint.h>

#include "factors/engine.h"

enum { RAD_MAX_WEIGHT = RAD_MAX_BAND + 2 };

/**
 * Values of weights at points of the source triangle.
 *
 * @param[in]  lambda  [n][3] barycentric coordinates, in the order of the triangle's vertices
 * @param[out] w       [n, n_weight]
 */
typedef void rad_weight_at(void *context, int n, const double (*lambda)[3], double *w);

/* int_C w_k(y) F(y -> target) dS_y  [m2], k < n_weight, C a cell of the source triangle. */
struct rad_cell_task {
  int source, target;  /* triangles; they may see each other wholly, partly or not at all */
  double corner[3][3]; /* C: barycentric coordinates of its corners in the source; not degenerate */
  int n_weight;        /* at most RAD_MAX_WEIGHT */
  rad_weight_at *weight; /* NULL: one weight, 1 */
  void *context;
  const double *tolerance; /* [n_weight] absolute, of each integral [m2 times the weight's unit] */
  int64_t limit;           /* most points of y; 0: a default */
  int most_blockers;       /* 0: any; with more, nothing is done and errors are INFINITY */
};

/* Memory of one thread for as many tasks as it likes; zero at first. */
struct rad_cell_scratch;
struct rad_cell_scratch *rad_cell_scratch_new(void);    /* NULL without memory */
void rad_cell_scratch_free(struct rad_cell_scratch *s); /* NULL is fine */

/**
 * The source is the outer side: y runs over C, and what y sees of the target is exact.
 *
 * Signs of weights are free; they should be smooth on C (a polynomial of an element), because
 * errors are told by two rules where F is analytic. Where something may hide between points, the
 * error is what the weight's largest sampled value times the unobstructed factor allows.
 *
 * @param[out] value, error  [n_weight]; |value - exact| <= error
 * @return RAD_OK also if a tolerance was not met (error > tolerance: the limit was); RAD_ESYSTEM
 * without memory; RAD_ESTOPPED once rad_stop_asked(). Thread-safe: one scratch for a thread. The
 * same input gives the same bits.
 */
enum rad_code rad_cell_integrate(const struct rad_pair_engine *g, struct rad_cell_scratch *s,
                                 const struct rad_cell_task *task, double *value, double *error,
                                 struct rad_error *e);

/* Points of y that the last task took. */
int64_t rad_cell_points(const struct rad_cell_scratch *s);

#endif
