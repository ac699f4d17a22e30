/* Predicted time of a run, from samples of the real work on this machine. */
#include <lapacke.h>
#include <math.h>
#include <omp.h>
#include <stdlib.h>

#include "app/case.h"
#include "base/clock.h"
#include "base/memory.h"

enum { SAMPLE_POINTS = 32, SAMPLE_BLOCKS = 6, SAMPLE_LU = 800, SAMPLE_RUNS = 2 };

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

enum rad_code rad_case_predict(struct rad_case *c, struct rad_error *e) {
  enum rad_code code = rad_rules_build(c->mesh, c->deck.method.quadrature_tolerance, &c->rules, e);
  struct rad_scratch scratch = {0};
  if (!code)
    code = rad_scratch_init(c->mesh, &scratch, e);
  double *row = rad_alloc((size_t)c->mesh->n_point, SAMPLE_POINTS * sizeof(double));
  const unsigned char *sees = c->visibility.sight;
  if (!code && !row)
    code = rad_fail_memory(e, "the prediction", 8.0 * SAMPLE_POINTS * c->mesh->n_point);
  if (!code) {
    int threads =
        omp_get_max_threads() < omp_get_num_procs() ? omp_get_max_threads() : omp_get_num_procs();
    double pair = sample_pairs(c, sees, &scratch, row);
    c->plan.skipped = (double)rad_pairs_skipped(c->mesh, NULL);
    double n = c->plan.unknowns, pairs = c->plan.pairs - c->plan.skipped;
    c->plan.seconds = pair * pairs / threads;
    if (c->plan.matrix == RAD_MATRIX_HIERARCHICAL) /* near pairs, and what bases take (measured) */
      c->plan.seconds =
          (pair * c->plan.pairs * c->plan.near_entries / (n * n) + 5e-5 * n) / threads;
    double products = c->plan.solver == RAD_SOLVER_NEUMANN ? c->deck.method.bounces : 40;
    c->plan.seconds += c->plan.solver == RAD_SOLVER_LU
                           ? predict_lu(c->mesh->n_point) * c->scene.n_band
                           : products * c->plan.matrix_bytes / 1.5e10 * c->scene.n_band;
  }
  rad_scratch_free(&scratch);
  free(row);
  return code;
}
