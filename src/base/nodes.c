#include "base/nodes.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"

static double position(const struct rad_node_choice *c, int k, int a) {
  double step = fmin(0.1, 1.0 / k);
  if (c->kind == RAD_NODES_LIST)
    return c->at[a];
  if (k == 1)
    return 0.5;
  return c->kind == RAD_NODES_BIASED   ? 1 - step * (k - 1 - a)
         : c->kind == RAD_NODES_VERTEX ? (double)a / (k - 1)
                                       : (a + 0.5) / k;
}

/* T[a,m] = (2m+1)/2 sum_q w_q L_a(z_q) P_m(z_q): the k-point Gauss rule is exact for it. */
static void set_matrix(const struct rad_gauss *g, int k, const double *at, double *t) {
  const double *z = rad_gauss_node(g, k), *w = rad_gauss_weight(g, k);
  for (int a = 0; a < k; a++) {
    long double sum[RAD_NODES_MAX] = {0};
    for (int q = 0; q < k; q++) {
      long double value = w[q];
      double p[RAD_NODES_MAX];
      for (int b = 0; b < k; b++)
        value *= b == a ? 1 : ((long double)z[q] - at[b]) / ((long double)at[a] - at[b]);
      rad_legendre(k, z[q], p);
      for (int m = 0; m < k; m++)
        sum[m] += value * p[m];
    }
    for (int m = 0; m < k; m++)
      t[a * k + m] = (double)(0.5L * (2 * m + 1) * sum[m]);
  }
}

static double largest_row(int k, const double *t) {
  double most = 0;
  for (int a = 0; a < k; a++) {
    double sum = 0;
    for (int m = 0; m < k; m++)
      sum += fabs(t[a * k + m]);
    most = fmax(most, sum);
  }
  return most;
}

enum rad_code rad_nodes_init(const struct rad_gauss *g, const struct rad_node_choice *c,
                             struct rad_nodes *nodes, struct rad_error *e) {
  enum { N = RAD_NODES_MAX };
  nodes->at = rad_alloc(N * (N + 1) / 2, sizeof(double));
  nodes->matrix = rad_alloc(N * (N + 1) * (2 * N + 1) / 6, sizeof(double));
  if (!nodes->at || !nodes->matrix)
    return rad_fail_memory(e, "the trial functions", 8.0 * N * N * N / 3);
  for (int k = 1; k <= N; k++) {
    double *at = nodes->at + k * (k - 1) / 2, *t = nodes->matrix + (k - 1) * k * (2 * k - 1) / 6;
    int gauss = c->kind == RAD_NODES_GAUSS || (c->kind == RAD_NODES_LIST && k != c->n);
    rad_lagrange_from_legendre(g, k, t);
    double usual = largest_row(k, t);
    for (int a = 0; a < k; a++)
      at[a] = gauss ? rad_gauss_node(g, k)[a] : 2 * position(c, k, a) - 1;
    if (!gauss)
      set_matrix(g, k, at, t);
    nodes->loss[k] = gauss ? 1 : fmax(1, largest_row(k, t) / usual);
  }
  return RAD_OK;
}

void rad_nodes_free(struct rad_nodes *nodes) {
  free(nodes->at);
  free(nodes->matrix);
  *nodes = (struct rad_nodes){0};
}

void rad_lagrange(const struct rad_nodes *nodes, int k, double x, double *value) {
  double p[RAD_NODES_MAX];
  const double *t = rad_nodes_matrix(nodes, k);
  rad_legendre(k, x, p);
  for (int a = 0; a < k; a++) {
    value[a] = 0;
    for (int m = 0; m < k; m++)
      value[a] += t[a * k + m] * p[m];
  }
}
