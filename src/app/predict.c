/* Predicted time of a run, from samples of the real work on this machine. */
#include <lapacke.h>
#include <math.h>
#include <omp.h>
#include <stdlib.h>

#include "app/case.h"
#include "base/clock.h"
#include "base/memory.h"

enum { SAMPLE_POINTS = 32, SAMPLE_BLOCKS = 60, SAMPLE_LU = 1200, SAMPLE_RUNS = 2 };

/* Seconds that one thread needs for a pair of a point and an element, between triangles i and j. */
static double sample_block(struct rad_case *c, int i, int j, struct rad_scratch *scratch,
                           double *row) {
  const struct rad_mesh *m = c->mesh;
  int n_i = m->point_first[i + 1] - m->point_first[i],
      n = n_i < SAMPLE_POINTS ? n_i : SAMPLE_POINTS;
  int base[SAMPLE_POINTS];
  double mu[SAMPLE_POINTS][2];
  for (int q = 0; q < n; q++) {
    int p = m->point_first[i] + (int)((int64_t)n_i * q / n);
    base[q] = m->point_base[p];
    mu[q][0] = m->point_mu[p][0];
    mu[q][1] = m->point_mu[p][1];
  }
  struct rad_targets targets = {i, n, base, (const double(*)[2])mu, NULL};
  double start = rad_seconds();
  for (int p = m->patch_first[j]; p < m->patch_first[j + 1]; p++)
    rad_patch_block(m, &c->rules, &targets, p, NULL, row, n, scratch);
  int elements = m->element_first[m->patch_first[j + 1]] - m->element_first[m->patch_first[j]];
  return (rad_seconds() - start) / ((double)n * elements);
}

/* Mean over a few blocks spread over the scene. */
static double sample_pairs(struct rad_case *c, const unsigned char *sees,
                           struct rad_scratch *scratch, double *row) {
  int n = c->scene.n_triangle, taken = 0;
  int64_t facing = 0, seen = 0;
  for (int64_t at = 0; at < (int64_t)n * n; at++)
    facing += sees[at];
  int64_t every = facing / SAMPLE_BLOCKS + 1;
  double sum = 0;
  for (int64_t at = 0; at < (int64_t)n * n; at++)
    if (sees[at] && seen++ % every == 0) {
      sum += sample_block(c, (int)(at / n), (int)(at % n), scratch, row);
      taken++;
    }
  return taken ? sum / taken : 0;
}

/* Seconds of dgetrf for n unknowns, from a small one. */
static double predict_lu(int n) {
  enum { M = SAMPLE_LU };
  double *a = rad_alloc((size_t)M * M, sizeof(double));
  int *pivot = rad_alloc(M, sizeof(int));
  double seconds = 0;
  if (a && pivot) {
    seconds = INFINITY;
    for (int run = 0; run < SAMPLE_RUNS; run++) { /* the first one wakes the threads */
      for (int i = 0; i < M * M; i++)
        a[i] = i % (M + 1) == 0 ? 1 : 1e-4 * (i % 7);
      double start = rad_seconds();
      LAPACKE_dgetrf(LAPACK_COL_MAJOR, M, M, a, M, pivot);
      seconds = fmin(seconds, rad_seconds() - start);
    }
    seconds *= pow((double)n / M, 3);
  }
  free(a);
  free(pivot);
  return seconds;
}

/* Bytes a second that all threads read together. */
static double sample_reading(void) {
  enum { N = 6 << 20 };
  double *x = rad_pages_alloc(N * sizeof *x), sum = 0, best = INFINITY;
  for (int run = 0; x && run < 3; run++) { /* the first one makes the pages */
    double start = rad_seconds();
#pragma omp parallel for simd schedule(static) default(none) shared(x, run) reduction(+ : sum)
    for (int i = 0; i < N; i++)
      sum += run ? x[i] : (x[i] = 1);
    best = run ? fmin(best, rad_seconds() - start) : best;
  }
  rad_pages_free(x, N * sizeof *x);
  return x && sum > 0 ? N * sizeof(double) / best : 1e10;
}

/* Steps of GMRES: each multiplies the residual by a third of what a bounce does, or so (measured);
 * a bounce by rho at most. Narrow scenes near rho = 1 take more, with the coarse problem some
 * hundred. */
static double predict_steps(const struct rad_case *c) {
  double rho = 0;
  for (int i = 0; i < c->scene.n_triangle * c->scene.n_band; i++)
    rho = fmax(rho, c->scene.rho[i]);
  return fmin(4 + 0.3 * log(c->deck.method.solver_tolerance) / log(fmin(fmax(rho, 0.1), 0.9)), 60);
}

/* Everything after the matrix: products for kappa, u and w, and the residual; or LU. */
static double predict_solve(const struct rad_case *c) {
  const struct rad_plan *p = &c->plan;
  double n = p->unknowns, nb = c->scene.n_band, reading = sample_reading();
  double product = p->system.matrix_bytes / reading;
  if (p->system.solver == RAD_SOLVER_LU)
    return (predict_lu(c->mesh->n_point) + 10 * product) * nb;
  if (p->system.solver == RAD_SOLVER_NEUMANN)
    return (c->deck.method.bounces + 3) * product * nb;
  double steps = predict_steps(c), vectors = 2 * nb * 8 * n * steps * steps * 2;
  return (steps + 3) * product * (1 + 0.3 * (2 * nb - 1)) + vectors / reading;
}

/* The error estimate: points cost a quarter of what a row of the matrix does (measured), since K d
 * needs fewer digits and far parts next to nothing. */
static double predict_estimate(const struct rad_case *c, double matrix) {
  return c->wants_bound ? 0.25 * matrix * rad_indicate_points(c->mesh) / c->plan.unknowns : 0;
}

/* The picture: four numbers in every cell and more at its corners, packed at about 70 MB a second.
 */
#define PACKING 7e7

static double predict_output(const struct rad_case *c) {
  double cells = (double)c->mesh->n_element * c->deck.output.sampling * c->deck.output.sampling;
  return cells * (160 + 64.0 * c->scene.n_band) / PACKING;
}

/* The dense matrix, from pairs of points and elements. */
static enum rad_code predict_dense(struct rad_case *c, double *seconds, struct rad_error *e) {
  struct rad_scratch scratch = {0};
  enum rad_code code = rad_scratch_init(c->mesh, &scratch, e);
  double *row = rad_alloc((size_t)c->mesh->n_point, SAMPLE_POINTS * sizeof(double));
  if (!code && !row)
    code = rad_fail_memory(e, "the prediction", 8.0 * SAMPLE_POINTS * c->mesh->n_point);
  if (!code) {
    int most = omp_get_max_threads(),
        threads = most < omp_get_num_procs() ? most : omp_get_num_procs();
    *seconds = sample_pairs(c, c->visibility.sight, &scratch, row) *
               (c->plan.pairs - c->plan.skipped) / threads;
  }
  rad_scratch_free(&scratch);
  free(row);
  return code;
}

enum rad_code rad_case_predict(struct rad_case *c, struct rad_error *e) {
  double start = rad_seconds(), matrix = 0;
  enum rad_code code = rad_rules_build(c->mesh, c->deck.method.quadrature_tolerance, &c->rules, e);
  double rules = rad_seconds() - start;
  c->plan.skipped = (double)rad_pairs_skipped(c->mesh, NULL);
  if (!code && c->plan.system.matrix == RAD_MATRIX_HIERARCHICAL)
    code = rad_h2_sample(c->mesh, &c->rules, c->compression, &matrix, e);
  else if (!code)
    code = predict_dense(c, &matrix, e);
  if (!code)
    c->plan.seconds = c->seconds_scene + c->seconds_mesh + rules + matrix + predict_solve(c) +
                      predict_estimate(c, matrix) + predict_output(c);
  return code;
}
