#include <lapacke.h>
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "mesh/cone.h"

enum { KRYLOV = 16 }; /* dimension between restarts of Arnoldi's method */
#define RESIDUAL 1e-7 /* of the eigenvector; the eigenvalue's error is its square */

struct iteration {
  int n;
  double *k;     /* [n, n] K_alpha */
  double *basis; /* [KRYLOV + 1, n]; the first row is the start vector */
};

static double dot(int n, const double *a, const double *b) {
  double sum = 0;
  for (int i = 0; i < n; i++)
    sum += a[i] * b[i];
  return sum;
}

static void scale(int n, double factor, double *a) {
  for (int i = 0; i < n; i++)
    a[i] *= factor;
}

/* Extend the basis by K v_m, orthogonal to it (twice is enough): row m + 1 and column m of h.
 * Returns the length of the new part, 0 if there is none. */
static double extend(const struct iteration *it, int m, double *h) {
  int n = it->n;
  const double *v = it->basis + (size_t)m * (size_t)n;
  double *w = it->basis + (size_t)(m + 1) * (size_t)n;
  for (int i = 0; i < n; i++)
    w[i] = dot(n, it->k + (size_t)i * (size_t)n, v);
  double before = sqrt(dot(n, w, w));
  for (int twice = 0; twice < 2; twice++)
    for (int j = 0; j <= m; j++) {
      const double *u = it->basis + (size_t)j * (size_t)n;
      double c = dot(n, w, u);
      h[j * KRYLOV + m] += c;
      for (int i = 0; i < n; i++)
        w[i] -= c * u[i];
    }
  double length = sqrt(dot(n, w, w));
  if (!(length > 1e-13 * before))
    return 0;
  scale(n, 1 / length, w);
  return length;
}

/* One Arnoldi cycle. Returns the largest Ritz value and its relative residual; its vector becomes
 * the start vector. */
static double cycle(const struct iteration *it, double *residual) {
  int n = it->n, m = 0, top = 0;
  double *v = it->basis, h[KRYLOV * KRYLOV] = {0}, next = 1;
  scale(n, 1 / sqrt(dot(n, v, v)), v);
  while (m < KRYLOV && m < n && next > 0) {
    if (m > 0)
      h[m * KRYLOV + m - 1] = next;
    next = extend(it, m++, h);
  }
  double re[KRYLOV], im[KRYLOV], ritz[KRYLOV * KRYLOV], none;
  LAPACKE_dgeev(LAPACK_ROW_MAJOR, 'N', 'V', m, h, KRYLOV, re, im, &none, 1, ritz, KRYLOV);
  for (int j = 1; j < m; j++)
    if (re[j] > re[top])
      top = j;
  *residual = next * fabs(ritz[(m - 1) * KRYLOV + top]) / fabs(re[top]);
  for (int i = 0; i < n; i++) {
    double sum = 0;
    for (int j = 0; j < m; j++)
      sum += v[(size_t)j * (size_t)n + (size_t)i] * ritz[j * KRYLOV + top];
    v[i] = sum;
  }
  return re[top];
}

/* The spectral radius of K_alpha: its largest eigenvalue, as K_alpha >= 0 (Perron). */
static double radius(const struct rad_cone *cone, double alpha, const struct iteration *it) {
  double value = 0, residual = 1;
  rad_cone_assemble(cone, alpha, it->k);
  for (int n = 0; n < 40 && residual > RESIDUAL; n++)
    value = cycle(it, &residual);
  return value;
}

/* 1/radius - 1 in x = (1+alpha)^2, in which I_alpha is even: smooth, falling, and -1 at x = 4, in
 * wide cones nearly linear. Secant steps, kept within the bracket. */
static double solve(const struct rad_cone *cone, const struct iteration *it) {
  double low = 1, high = 4, last_x = 4, last_h = -1, x = 1, h = 1 / radius(cone, 0, it) - 1;
  if (!(h > 0))
    return 0;
  for (int step = 0; step < 60; step++) {
    double next = x - h * (x - last_x) / (h - last_h);
    if (!(next > low && next < high))
      next = 0.5 * (low + high);
    last_x = x;
    last_h = h;
    x = next;
    if (4 - x < 4e-9)
      return INFINITY;
    if (fabs(x - last_x) < 1e-5 * fmin(x - 1, 4 - x))
      break;
    h = 1 / radius(cone, sqrt(x) - 1, it) - 1;
    if (h > 0)
      low = x;
    else
      high = x;
  }
  return sqrt(x) - 1;
}

enum rad_code rad_vertex_exponent(const struct rad_gauss *g, int n_face,
                                  const struct rad_cone_face *face, double *alpha,
                                  struct rad_error *e) {
  struct rad_cone cone;
  *alpha = INFINITY;
  enum rad_code code = rad_cone_build(g, n_face, face, &cone, e);
  if (code == RAD_OK && cone.n_block > 0) {
    size_t n = (size_t)cone.n;
    struct iteration it = {.n = cone.n};
    it.k = rad_alloc(n * n, sizeof *it.k);
    it.basis = rad_alloc((KRYLOV + 1) * n, sizeof *it.basis);
    if (it.k && it.basis) {
      for (size_t i = 0; i < n; i++)
        it.basis[i] = 1;
      *alpha = solve(&cone, &it);
    } else {
      code = rad_fail_memory(e, "the matrix of a vertex", 8. * (double)(n * n));
    }
    free(it.k);
    free(it.basis);
  }
  rad_cone_free(&cone);
  return code;
}
