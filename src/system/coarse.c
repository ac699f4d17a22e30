#include "system/coarse.h"

#include <lapacke.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

double rad_coarse_bytes(double n, int n_band) {
  double coarse = fmin(n, RAD_COARSE);
  return 8 * coarse * coarse * n_band;
}

/* A_c = I - D_c C, factored; the last one in place of C. LAPACK runs on one thread here: more would
 * change the bits. */
static int set_factor(const struct rad_coarse *c, int number) {
  struct rad_coarse_factor *f = &c->factor[number];
  size_t n = (size_t)c->aggregates.n;
  f->lu = number == c->n_factor - 1 ? c->k : rad_pages_alloc(sizeof(double) * n * n);
  f->pivot = rad_alloc(n, sizeof(int));
  if (!f->lu || !f->pivot)
    return 0;
  for (size_t j = 0; j < n; j++)
    for (size_t i = 0; i < n; i++) {
      double rho = f->rho[c->tree->unknown[c->aggregates.first[i]]];
      f->lu[i + n * j] = (i == j) - rho * c->k[i + n * j];
    }
  if (LAPACKE_dgetrf(LAPACK_COL_MAJOR, (int)n, (int)n, f->lu, (int)n, f->pivot)) {
    rad_pages_free(f->lu, sizeof(double) * n * n);
    f->lu = NULL;
  }
  return 1;
}

static enum rad_code set_factors(struct rad_coarse *c, int n_system, const double *const *rho,
                                 struct rad_error *e) {
  c->factor = rad_calloc((size_t)n_system, sizeof *c->factor);
  if (!c->factor)
    return rad_fail_memory(e, "the preconditioner", 0);
  for (int s = 0; s < n_system; s++) {
    int known = 0;
    for (int f = 0; f < c->n_factor; f++)
      known |= c->factor[f].rho == rho[s];
    if (!known)
      c->factor[c->n_factor++].rho = rho[s];
  }
  int n = c->n_factor, failed = 0;
  for (int begin = 0, end; begin < n; begin = end) { /* all but the last, then the last */
    end = begin < n - 1 ? n - 1 : n;
#pragma omp parallel for schedule(dynamic) default(none) shared(c, begin, end) reduction(| : failed)
    for (int f = begin; f < end; f++)
      failed |= !set_factor(c, f);
  }
  c->k = NULL;
  double bytes = 8.0 * c->aggregates.n * c->aggregates.n;
  return failed ? rad_fail_memory(e, "the preconditioner", n * bytes) : RAD_OK;
}

enum rad_code rad_coarse_build(const struct rad_operator *k, int n_system, const double *const *rho,
                               struct rad_coarse *c, struct rad_error *e) {
  *c = (struct rad_coarse){.tree = k->h2 ? &k->h2->tree : &c->own};
  enum rad_code code = RAD_OK;
  if (k->mesh->scene->n_triangle > RAD_COARSE)
    return RAD_OK;
  if (!k->h2)
    code = rad_tree_build(k->mesh, RAD_LEAF, &c->own, e);
  if (!code)
    code = rad_aggregates_build(c->tree, RAD_COARSE, &c->aggregates, e);
  size_t n = (size_t)c->aggregates.n;
  if (!code && !(c->k = rad_pages_alloc(sizeof(double) * n * n)))
    code = rad_fail_memory(e, "the preconditioner", 8.0 * (double)n * (double)n);
  if (!code)
    code = k->h2 ? rad_coarse_h2(k->h2, &c->aggregates, c->k, e)
                 : rad_coarse_dense(k->dense, c->tree, &c->aggregates, c->k, e);
  return code ? code : set_factors(c, n_system, rho, e);
}

void rad_coarse_free(struct rad_coarse *c) {
  size_t bytes = sizeof(double) * (size_t)c->aggregates.n * (size_t)c->aggregates.n;
  for (int f = 0; f < c->n_factor; f++) {
    rad_pages_free(c->factor[f].lu, bytes);
    free(c->factor[f].pivot);
  }
  free(c->factor);
  rad_pages_free(c->k, bytes);
  rad_aggregates_free(&c->aggregates);
  rad_tree_free(&c->own);
  *c = (struct rad_coarse){0};
}

void rad_coarse_solve(const struct rad_coarse *c, const double *rho, const double *r, double *x) {
  const struct rad_aggregates *a = &c->aggregates;
  const struct rad_coarse_factor *f = c->factor;
  size_t n = (size_t)a->n;
  while (f->rho != rho)
    f++;
  for (size_t g = 0; g < n; g++) {
    x[g] = 0;
    for (int i = a->first[g]; i < a->first[g + 1] && f->lu; i++)
      x[g] += a->weight[i] * r[c->tree->unknown[i]];
  }
  if (f->lu)
    LAPACKE_dgetrs(LAPACK_COL_MAJOR, 'N', (int)n, 1, f->lu, (int)n, f->pivot, x, (int)n);
}

void rad_coarse_spread(const struct rad_coarse *c, const double *x, double *z) {
  const struct rad_aggregates *a = &c->aggregates;
  for (int g = 0; g < a->n; g++)
    for (int i = a->first[g]; i < a->first[g + 1]; i++)
      z[c->tree->unknown[i]] = x[g];
}

/* Columns of one aggregate summed, then means of the rows of each. */
static void set_column(const struct rad_dense *dense, const struct rad_tree *tree,
                       const struct rad_aggregates *a, int source, double *sum, double *column) {
  size_t n = (size_t)dense->n;
  memset(sum, 0, sizeof(double) * n);
  for (int j = a->first[source]; j < a->first[source + 1]; j++) {
    const double *k = dense->k + n * (size_t)tree->unknown[j];
    for (size_t i = 0; i < n; i++)
      sum[i] += k[i];
  }
  for (int g = 0; g < a->n; g++)
    for (int i = a->first[g]; i < a->first[g + 1]; i++)
      column[g] += a->weight[i] * sum[tree->unknown[i]];
}

enum rad_code rad_coarse_dense(const struct rad_dense *dense, const struct rad_tree *tree,
                               const struct rad_aggregates *a, double *k, struct rad_error *e) {
  int failed = 0;
#pragma omp parallel default(none) shared(dense, tree, a, k) reduction(| : failed)
  {
    double *sum = rad_alloc((size_t)dense->n, sizeof(double));
    failed |= !sum;
#pragma omp for schedule(dynamic)
    for (int g = 0; g < a->n; g++)
      if (sum)
        set_column(dense, tree, a, g, sum, k + (size_t)a->n * (size_t)g);
    free(sum);
  }
  return failed ? rad_fail_memory(e, "the preconditioner", 8.0 * dense->n) : RAD_OK;
}
