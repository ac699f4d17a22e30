#include "system/interpolate.h"

#include <math.h>

#include "base/simd_math.h"
#include "base/vec.h"

/* Points for one digit, and for none (measured, theory 14.3). */
#define PER_DIGIT 1.3
#define LEAST 1.9

static void set_weights(struct rad_interpolation *p) {
  double weight[RAD_MAX_INTERPOLATION];
  int q = p->q;
  for (int i = 0; i < q; i++) { /* Fejer's first rule, over 2 */
    double angle = M_PI * (2 * i + 1) / (2.0 * q), sum = 0;
    for (int k = 1; k <= q / 2; k++)
      sum += cos(2 * k * angle) / (4.0 * k * k - 1);
    weight[i] = (1 - 2 * sum) / q;
  }
  for (int j = 0; j < q; j++)
    for (int i = 0; i < q; i++)
      p->root[i + q * j] = sqrt(weight[i] * weight[j]);
}

void rad_interpolation_init(struct rad_interpolation *p, double tolerance) {
  int q = (int)ceil(LEAST - PER_DIGIT * log10(tolerance));
  p->q = q < 3 ? 3 : q > RAD_MAX_INTERPOLATION ? RAD_MAX_INTERPOLATION : q;
  p->n = p->q * p->q;
  for (int i = 0; i < p->q; i++)
    p->node[i] = -cos(M_PI * (2 * i + 1) / (2.0 * p->q));
  for (int i = 0; i < p->q; i++) {
    double product = 1;
    for (int m = 0; m < p->q; m++)
      product *= m == i ? 1 : p->node[i] - p->node[m];
    p->inverse[i] = 1 / product;
  }
  set_weights(p);
}

void rad_interpolation_at(const struct rad_interpolation *p, double z, double *value) {
  double before = 1, after = 1;
  for (int i = 0; i < p->q; i++) {
    value[i] = before * p->inverse[i];
    before *= z - p->node[i];
  }
  for (int i = p->q - 1; i >= 0; i--) {
    value[i] *= after;
    after *= z - p->node[i];
  }
}

void rad_interpolation_between(const struct rad_interpolation *p, double low, double high,
                               double low1, double high1, double *e) {
  for (int i = 0; i < p->q; i++) {
    double x = 0.5 * (low1 + high1) + 0.5 * (high1 - low1) * p->node[i];
    double value[RAD_MAX_INTERPOLATION];
    rad_interpolation_at(p, (2 * x - low - high) / (high - low), value);
    for (int m = 0; m < p->q; m++)
      e[i + p->q * m] = value[m];
  }
}

void rad_interpolation_child(const struct rad_interpolation *p, const struct rad_cluster *parent,
                             const struct rad_cluster *child,
                             double e[2][RAD_MAX_INTERPOLATION * RAD_MAX_INTERPOLATION]) {
  for (int d = 0; d < 2; d++)
    rad_interpolation_between(p, parent->low[d], parent->high[d], child->low[d], child->high[d],
                              e[d]);
}

/* c = a b, all [q, q] column-major. */
static inline void multiply(int q, const double *restrict a, const double *restrict b,
                            double *restrict c) {
  for (int j = 0; j < q; j++) {
    double sum[RAD_MAX_INTERPOLATION] = {0};
    for (int m = 0; m < q; m++)
#pragma omp simd
      for (int i = 0; i < q; i++)
        sum[i] += a[i + q * m] * b[m + q * j];
    for (int i = 0; i < q; i++)
      c[i + q * j] = sum[i];
  }
}

static void transpose(int q, const double *a, double *t) {
  for (int j = 0; j < q; j++)
    for (int i = 0; i < q; i++)
      t[j + q * i] = a[i + q * j];
}

RAD_CLONES void rad_interpolation_transfer(const struct rad_interpolation *p, const double *a,
                                           const double *b, int transposed, int n,
                                           const double *restrict z, double *restrict out) {
  enum { MOST = RAD_MAX_INTERPOLATION * RAD_MAX_INTERPOLATION };
  double left[MOST], right[MOST], half[MOST];
  for (int i = 0; i < p->n; i++) {
    left[i] = a[i];
    right[i] = b[i];
  }
  if (transposed)
    transpose(p->q, a, left);
  else
    transpose(p->q, b, right);
  for (int c = 0; c < n; c++) {
    multiply(p->q, left, z + (size_t)c * (size_t)p->n, half);
    multiply(p->q, half, right, out + (size_t)c * (size_t)p->n);
  }
}

/* Nodes of a cluster in the plane of its triangle. */
static void nodes(const struct rad_interpolation *p, const struct rad_cluster *c, int direction,
                  double *x) {
  double mid = 0.5 * (c->low[direction] + c->high[direction]);
  double half = 0.5 * (c->high[direction] - c->low[direction]);
  for (int i = 0; i < p->q; i++)
    x[i] = mid + half * p->node[i];
}

RAD_CLONES void rad_interpolation_kernel(const struct rad_interpolation *p,
                                         const struct rad_tree *tree,
                                         const struct rad_cluster *target,
                                         const struct rad_cluster *source, double *s) {
  enum { MOST = RAD_MAX_INTERPOLATION * RAD_MAX_INTERPOLATION };
  const struct rad_plane *t = &tree->plane[target->triangle], *f = &tree->plane[source->triangle];
  double x0[RAD_MAX_INTERPOLATION], x1[RAD_MAX_INTERPOLATION], y0[RAD_MAX_INTERPOLATION],
      y1[RAD_MAX_INTERPOLATION], x[3][MOST], offset[3];
  nodes(p, target, 0, x0);
  nodes(p, target, 1, x1);
  nodes(p, source, 0, y0);
  nodes(p, source, 1, y1);
  rad_sub(t->origin, f->origin, offset);
  for (int d = 0; d < 3; d++) { /* targets in the frame of the source */
    double o = rad_dot(offset, f->axis[d]), a = rad_dot(t->axis[0], f->axis[d]);
    double b = rad_dot(t->axis[1], f->axis[d]);
    for (int i = 0; i < p->n; i++)
      x[d][i] = o + (x0[i % p->q] * a + x1[i / p->q] * b);
  }
  const double *normal = t->axis[2];
  double h = -rad_dot(normal, offset), h0 = rad_dot(normal, f->axis[0]);
  double h1 = rad_dot(normal, f->axis[1]);
  for (int b = 0; b < p->n; b++) {
    double u = y0[b % p->q], v = y1[b / p->q], height = (h + (u * h0 + v * h1)) / M_PI;
    double *restrict column = s + (size_t)b * (size_t)p->n;
#pragma omp simd
    for (int a = 0; a < p->n; a++) {
      double d0 = x[0][a] - u, d1 = x[1][a] - v, r2 = d0 * d0 + d1 * d1 + x[2][a] * x[2][a];
      column[a] = height * x[2][a] / (r2 * r2);
    }
  }
}
