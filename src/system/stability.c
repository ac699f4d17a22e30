#include "system/stability.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"

/* diag(rho) K, row by row: its columns for LAPACK are the rows of the matrix. */
static void form(const struct rad_dense *dense, const double *rho, double *a) {
  size_t n = (size_t)dense->n;
  const double *k = dense->k;
#pragma omp parallel for schedule(static) default(none) shared(n, k, rho, a)
  for (size_t i = 0; i < n; i++)
    for (size_t j = 0; j < n; j++)
      a[j + n * i] = rho[i] * k[i + n * j];
}

static double spectral_radius(int n, double *a, double *work) {
  double most = 0, *re = work, *im = work + n, unused;
  if (LAPACKE_dgeev(LAPACK_COL_MAJOR, 'N', 'N', n, a, n, re, im, &unused, 1, &unused, 1))
    return NAN;
  for (int i = 0; i < n; i++)
    most = fmax(most, hypot(re[i], im[i]));
  return most;
}

/* Largest sum of absolute values of a column. */
static double norm_1(size_t n, const double *a) {
  double most = 0;
  for (size_t i = 0; i < n; i++) {
    double sum = 0;
    for (size_t j = 0; j < n; j++)
      sum += fabs(a[j + n * i]);
    most = fmax(most, sum);
  }
  return most;
}

/* a becomes its inverse; returns 0 if it is singular. */
static int invert(int n, double *a, int *pivot) {
  return LAPACKE_dgetrf(LAPACK_COL_MAJOR, n, n, a, n, pivot) == 0 &&
         LAPACKE_dgetri(LAPACK_COL_MAJOR, n, a, n, pivot) == 0;
}

/* sum_j |sum_f value_f row_f[j]| for the rows of one element. */
static double combined(int n_function, const double *value, size_t n, const double *row,
                       double *sum) {
  double total = 0;
  for (size_t j = 0; j < n; j++)
    sum[j] = 0;
  for (int f = 0; f < n_function; f++)
    for (size_t j = 0; j < n; j++)
      sum[j] += value[f] * row[(size_t)f * n + j];
  for (size_t j = 0; j < n; j++)
    total += fabs(sum[j]);
  return total;
}

/* Values of the trial functions of an element at place q of m x m. */
static void functions_at(const struct rad_mesh *mesh, const struct rad_element *e, int m, int q,
                         double *value) {
  double lp[RAD_NODES_MAX], lr[RAD_NODES_MAX];
  int n = e->k_phi * e->k_r;
  double step = m > 1 ? 2.0 / (m - 1) : 0;
  rad_lagrange(&mesh->nodes, e->k_phi, q % m * step - 1, lp);
  rad_lagrange(&mesh->nodes, e->k_r, q / m * step - 1, lr);
  for (int f = 0; f < e->n_function; f++) {
    value[f] = e->fold ? 0 : lp[f % e->k_phi] * lr[f / e->k_phi];
    for (int b = 0; e->fold && b < n; b++)
      value[f] += e->fold[f * n + b] * lp[b % e->k_phi] * lr[b / e->k_phi];
  }
}

/* Largest sum over the places of one element. */
static double element_norm(const struct rad_mesh *mesh, int element, const double *inverse,
                           double *sum) {
  const struct rad_element *e = &mesh->element[element];
  size_t n = (size_t)mesh->n_point;
  int k = e->k_phi > e->k_r ? e->k_phi : e->k_r, m = k == 1 ? 1 : 4 * k + 1;
  double value[RAD_NODES_MAX * RAD_NODES_MAX], most = 0;
  for (int q = 0; q < m * m; q++) {
    functions_at(mesh, e, m, q, value);
    most = fmax(most, combined(e->n_function, value, n, inverse + n * (size_t)e->first, sum));
  }
  return most;
}

static double interpolated_norm(const struct rad_mesh *mesh, const double *inverse, double *norm,
                                int *failed) {
  int n = mesh->n_element, out = 0;
  double most = 0;
#pragma omp parallel default(none) shared(mesh, inverse, norm, n) reduction(|| : out)
  {
    double *sum = rad_alloc((size_t)mesh->n_point, sizeof(double));
    out = !sum;
#pragma omp for schedule(dynamic)
    for (int i = 0; i < n; i++)
      norm[i] = sum ? element_norm(mesh, i, inverse, sum) : 0;
    free(sum);
  }
  for (int i = 0; i < n; i++)
    most = fmax(most, norm[i]);
  *failed = out;
  return most;
}

enum rad_code rad_stability(const struct rad_dense *dense, const double *rho,
                            struct rad_stability *s, struct rad_error *e) {
  int n = dense->n, failed = 0;
  size_t size = (size_t)n, bytes = size * size * sizeof(double);
  double *a = rad_pages_alloc(bytes), *b = rad_pages_alloc(bytes);
  double *work = rad_alloc(2 * size, sizeof(double));
  int *pivot = rad_alloc(size, sizeof(int));
  *s = (struct rad_stability){INFINITY, INFINITY, INFINITY, NAN};
  if (a && b && work && pivot) {
    form(dense, rho, a);
    for (size_t i = 0; i < size * size; i++)
      b[i] = (i % (size + 1) == 0) - a[i];
    s->spectral_radius = spectral_radius(n, a, work);
    double norm = norm_1(size, b);
    if (invert(n, b, pivot)) {
      s->inverse_matrix = norm_1(size, b);
      s->condition = norm * s->inverse_matrix;
      s->inverse_norm = interpolated_norm(dense->mesh, b, work, &failed);
    }
  }
  failed |= !a || !b || !work || !pivot;
  rad_pages_free(a, bytes);
  rad_pages_free(b, bytes);
  free(work);
  free(pivot);
  return failed ? rad_fail_memory(e, "the stability of the matrix", 2.0 * (double)bytes) : RAD_OK;
}
