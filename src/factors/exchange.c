#include "factors/exchange.h"

#include <math.h>

#include "factors/contour.h"
#include "factors/triangle_rule.h"

/* Product rules from 1 x 1 to 16 x 16 points. */
enum { LOWEST = 0, HIGHEST = 4, MOST_ROOM = 16 * (RAD_MAX_CORNER - 2) };

/* The error of a rule of degree p on both sides is at most GROWTH (p + 2)^2 q^{p + 1} of A_P A_Q /
 * (pi D^2), D the distance between centres and q the sum of radii over D (tests/unit/
 * test_exchange.c looks for worse in random pairs). */
#define GROWTH 0.1
#define FARTHEST_Q 0.6

#define ROUNDING 2e-15

static void center_of(const struct rad_flat *f, double center[3], double *radius) {
  double most = 0;
  for (int d = 0; d < 3; d++) {
    double low = INFINITY, high = -INFINITY;
    for (int c = 0; c < f->n; c++) {
      low = f->corner[c][d] < low ? f->corner[c][d] : low;
      high = f->corner[c][d] > high ? f->corner[c][d] : high;
    }
    center[d] = 0.5 * (low + high);
  }
  for (int c = 0; c < f->n; c++) {
    double r2 = rad_distance2(f->corner[c], center);
    most = r2 > most ? r2 : most;
  }
  *radius = sqrt(most);
}

/* Points with weights [m2] on a polygon, triangle by triangle; their number. */
static int points_on(const struct rad_gauss *g, const struct rad_flat *f, int rule,
                     double (*point)[3], double *weight) {
  double lambda[16][3], w[16];
  int n = rad_triangle_points[rule], count = 0;
  rad_triangle_rule(g, rule, lambda, w);
  for (int c = 1; c + 1 < f->n; c++) {
    const double *v[3] = {f->corner[0], f->corner[c], f->corner[c + 1]};
    double a[3], b[3], x[3];
    rad_sub(v[1], v[0], a);
    rad_sub(v[2], v[0], b);
    rad_cross(a, b, x);
    double area = 0.5 * rad_norm(x);
    for (int q = 0; q < n; q++, count++) {
      weight[count] = area * w[q];
      for (int d = 0; d < 3; d++)
        point[count][d] = v[0][d] + lambda[q][1] * a[d] + lambda[q][2] * b[d];
    }
  }
  return count;
}

static double by_points(const struct rad_gauss *g, const struct rad_flat *p,
                        const struct rad_flat *q, int rule) {
  double x[MOST_ROOM][3], y[MOST_ROOM][3], wx[MOST_ROOM], wy[MOST_ROOM], sum = 0;
  int nx = points_on(g, p, rule, x, wx), ny = points_on(g, q, rule, y, wy);
  for (int i = 0; i < nx; i++) {
    double row = 0;
    for (int j = 0; j < ny; j++) {
      double r[3];
      rad_sub(y[j], x[i], r);
      double r2 = rad_dot(r, r);
      row -= wy[j] * rad_dot(p->normal, r) * rad_dot(q->normal, r) / (r2 * r2);
    }
    sum += wx[i] * row;
  }
  return sum / M_PI;
}

double rad_exchange(const struct rad_gauss *g, const struct rad_flat *p, const struct rad_flat *q,
                    double goal, double *error) {
  *error = 0;
  if (p->n < 3 || q->n < 3)
    return 0;
  double cp[3], cq[3], rp, rq;
  center_of(p, cp, &rp);
  center_of(q, cq, &rq);
  double d2 = rad_distance2(cp, cq), ratio = (rp + rq) / sqrt(d2);
  if (ratio < FARTHEST_Q) {
    double scale = rad_flat_area(p) * rad_flat_area(q) / (M_PI * d2);
    for (int rule = LOWEST; rule <= HIGHEST; rule++) {
      int degree = rad_triangle_degree[rule];
      double bound = GROWTH * (degree + 2) * (degree + 2) * pow(ratio, degree + 1);
      if (bound <= goal) {
        *error = (bound + ROUNDING) * scale;
        return fmax(0, by_points(g, p, q, rule));
      }
    }
  }
  return rad_contour(g, p, q, error);
}

double rad_exchange_scale(const struct rad_flat *p, const struct rad_flat *q) {
  double cp[3], cq[3], rp, rq;
  center_of(p, cp, &rp);
  center_of(q, cq, &rq);
  double d2 = rad_distance2(cp, cq);
  return d2 > 0 ? rad_flat_area(p) * rad_flat_area(q) / (M_PI * d2) : 0;
}

void rad_flat_clip(struct rad_flat *f, const double at[3], const double normal[3], double zero) {
  struct rad_flat in = *f;
  double h[RAD_MAX_CORNER + 1];
  int any = 0;
  for (int c = 0; c < in.n; c++) {
    double r[3];
    rad_sub(in.corner[c], at, r);
    h[c] = rad_dot(normal, r);
    h[c] = fabs(h[c]) <= zero ? 0 : h[c];
    any |= h[c] > 0;
  }
  f->n = 0;
  if (!any)
    return;
  h[in.n] = h[0];
  for (int c = 0; c < in.n && f->n < RAD_MAX_CORNER; c++) {
    const double *p = in.corner[c], *q = in.corner[c + 1 < in.n ? c + 1 : 0];
    if (h[c] >= 0)
      memcpy(f->corner[f->n++], p, sizeof f->corner[0]);
    if (((h[c] < 0 && h[c + 1] > 0) || (h[c] > 0 && h[c + 1] < 0)) && f->n < RAD_MAX_CORNER)
      rad_between(p, q, h[c] / (h[c] - h[c + 1]), f->corner[f->n++]);
  }
}
