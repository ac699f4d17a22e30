#include "base/gauss.h"

#include <math.h>

#include "base/memory.h"

#include <stdlib.h>

/* P_n(x), and its derivative in *slope. */
static long double legendre(int n, long double x, long double *slope) {
  long double p0 = 1, p1 = x;
  for (int m = 2; m <= n; m++) {
    long double p2 = ((2 * m - 1) * x * p1 - (m - 1) * p0) / m;
    p0 = p1;
    p1 = p2;
  }
  *slope = n * (x * p1 - p0) / (x * x - 1);
  return p1;
}

/* Newton in long double: the rules are good to the last bit of double. */
static void rule(int n, double *node, double *weight) {
  for (int i = 0; i < (n + 1) / 2; i++) {
    long double x = cosl(3.14159265358979323846L * (i + 0.75L) / (n + 0.5L)), slope;
    for (int step = 0; step < 100; step++) {
      long double value = legendre(n, x, &slope), dx = value / slope;
      x -= dx;
      if (fabsl(dx) < 1e-18L)
        break;
    }
    if (2 * i + 1 == n)
      x = 0;
    legendre(n, x, &slope);
    node[i] = (double)-x;
    node[n - 1 - i] = (double)x;
    weight[i] = weight[n - 1 - i] = (double)(2 / ((1 - x * x) * slope * slope));
  }
}

enum rad_code rad_gauss_init(struct rad_gauss *g, struct rad_error *e) {
  size_t total = RAD_GAUSS_MAX * (RAD_GAUSS_MAX + 1) / 2;
  g->node = rad_alloc(total, sizeof *g->node);
  g->weight = rad_alloc(total, sizeof *g->weight);
  if (!g->node || !g->weight)
    return rad_fail_memory(e, "the table of Gauss points", 16.0 * (double)total);
  for (int n = 1; n <= RAD_GAUSS_MAX; n++)
    rule(n, g->node + n * (n - 1) / 2, g->weight + n * (n - 1) / 2);
  return RAD_OK;
}

void rad_gauss_free(struct rad_gauss *g) {
  free(g->node);
  free(g->weight);
  *g = (struct rad_gauss){0};
}

void rad_legendre(int k, double x, double *p) {
  p[0] = 1;
  if (k > 1)
    p[1] = x;
  for (int m = 2; m < k; m++)
    p[m] = ((2 * m - 1) * x * p[m - 1] - (m - 1) * p[m - 2]) / m;
}

void rad_lagrange_from_legendre(const struct rad_gauss *g, int k, double *t) {
  const double *x = rad_gauss_node(g, k), *w = rad_gauss_weight(g, k);
  for (int a = 0; a < k; a++) {
    rad_legendre(k, x[a], t + a * k);
    for (int m = 0; m < k; m++)
      t[a * k + m] *= 0.5 * (2 * m + 1) * w[a];
  }
}
