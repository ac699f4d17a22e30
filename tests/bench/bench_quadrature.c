/* Relative error against kernel values for one nearly singular integral, by several rules; not a
 * test.
 *
 *   build/release/tests/bench_quadrature > quadrature.csv
 *   tools/plot quadrature quadrature.csv -o docs/img/quadrature.svg
 *
 * int G dS over the triangle (0,0) (1,0) (1,1), seen from a height above (0.6, 0.24), the direction
 * straight down: in local coordinates y = r (1, t), 0 <= r, t <= 1,
 *
 *   int int (d^2 / pi) r / |x - y|^4 dr dt.
 *
 * Rules: Gauss in t and r; the same after the paper's transformation [H, (3.33)] in both; after the
 * sinh map (theory 3.11) in both; the closed form along a ray with Gauss on panels of t that grow
 * by a factor 3; and what polyrad does (src/integrate/near.c). Exact value: Lambert's form.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/gauss.h"
#include "integrate/near.h"
#include "paper_map.h"

enum { PANEL = 32, MOST_PANELS = 32 };

static const double foot[2] = {0.6, 0.24}; /* of x, at t = 0.4 and r = 0.6 */

static double ray_t(void) {
  return foot[1] / foot[0];
}

/* One rule of [0, 1]: m panels of Gauss points. */
struct rule {
  int n;
  double at[PANEL * MOST_PANELS], weight[PANEL * MOST_PANELS];
};

/* n points, in panels of at most PANEL. */
static void set_rule(const struct rad_gauss *g, int n, struct rule *r) {
  int panels = (n + PANEL - 1) / PANEL, each = n / panels;
  const double *x = rad_gauss_node(g, each), *w = rad_gauss_weight(g, each);
  r->n = each * panels;
  for (int i = 0; i < r->n; i++) {
    r->at[i] = (i / each + 0.5 * (1 + x[i % each])) / panels;
    r->weight[i] = 0.5 * w[i % each] / panels;
  }
}

/* What a ray of direction (1, t) is to x at the height d: theory 3.5. */
struct ray {
  double a, r0, delta;
};

static struct ray ray_at(double d, double t) {
  double a = 1 + t * t, e = foot[1] - t * foot[0];
  return (struct ray){a, (foot[0] + t * foot[1]) / a, sqrt(d * d * a + e * e) / a};
}

/* r / (A^2 ((r - r0)^2 + delta^2)^2) with the distance s = r - r0. */
static double kernel(const struct ray *ray, double s) {
  double q = s * s + ray->delta * ray->delta;
  return (ray->r0 + s) / (ray->a * ray->a * q * q);
}

/* Imaginary part of t_c (3.7). */
static double ray_im(double d) {
  double q = foot[0] * foot[0] + d * d; /* e = X, b = (0, 1) */
  return d * sqrt(foot[0] * foot[0] + foot[1] * foot[1] + d * d) / q;
}

static double plain(double d, const struct rule *g) {
  double sum = 0;
  for (int i = 0; i < g->n; i++) {
    struct ray ray = ray_at(d, g->at[i]);
    for (int j = 0; j < g->n; j++)
      sum += g->weight[i] * g->weight[j] * kernel(&ray, g->at[j] - ray.r0);
  }
  return sum;
}

static double paper(double d, const struct rule *g) {
  struct paper_map t = paper_map(ray_t(), d), r = paper_map(foot[0], d);
  double sum = 0, dt, dr;
  for (int i = 0; i < g->n; i++) {
    struct ray ray = ray_at(d, paper_map_at(&t, g->at[i], &dt));
    for (int j = 0; j < g->n; j++) {
      double at = paper_map_at(&r, g->at[j], &dr);
      sum += g->weight[i] * g->weight[j] * dt * dr * kernel(&ray, at - ray.r0);
    }
  }
  return sum;
}

/* [lo, hi] as im sinh(z): distance from the centre, and its derivative by the place in [0, 1]. */
static double stretched(double im, double lo, double hi, double at, double *slope) {
  double z0 = asinh(lo / im), z1 = asinh(hi / im), z = z0 + (z1 - z0) * at;
  *slope = im * cosh(z) * (z1 - z0);
  return im * sinh(z);
}

static double stretch(double d, const struct rule *g) {
  double sum = 0, dt, dr, im = ray_im(d);
  for (int i = 0; i < g->n; i++) {
    struct ray ray = ray_at(d, ray_t() + stretched(im, -ray_t(), 1 - ray_t(), g->at[i], &dt));
    for (int j = 0; j < g->n; j++) {
      double s = stretched(ray.delta, -ray.r0, 1 - ray.r0, g->at[j], &dr);
      sum += g->weight[i] * g->weight[j] * dt * dr * kernel(&ray, s);
    }
  }
  return sum;
}

/* int kernel dr from 0 to 1. */
static double closed_form(const struct ray *ray) {
  double delta = ray->delta, s0 = -ray->r0, s1 = 1 - ray->r0;
  double q0 = s0 * s0 + delta * delta, q1 = s1 * s1 + delta * delta;
  double n0 = atan2(delta * (s1 - s0), delta * delta + s0 * s1) / delta;
  double m0 = (n0 + s1 / q1 - s0 / q0) / (2 * delta * delta);
  double m1 = (s1 - s0) * (s1 + s0) / (2 * q0 * q1);
  return (ray->r0 * m0 + m1) / (ray->a * ray->a);
}

/* Panels of t from the ray through the foot outwards. */
static double rays(const struct rad_gauss *g, double d, int n, int64_t *count) {
  double sum = 0, first = ray_im(d);
  const double *x = rad_gauss_node(g, n), *w = rad_gauss_weight(g, n);
  *count = 0;
  for (int side = -1; side <= 1; side += 2) {
    double end = side < 0 ? ray_t() : 1 - ray_t(), low = 0, high = first;
    for (; low < end; low = high, high *= 3) {
      high = fmin(high, end);
      for (int i = 0; i < n; i++, ++*count) {
        double off = low + 0.5 * (1 + x[i]) * (high - low);
        struct ray ray = ray_at(d, ray_t() + side * off);
        ray.delta = sqrt(d * d * ray.a + foot[0] * foot[0] * off * off) / ray.a;
        sum += 0.5 * w[i] * (high - low) * closed_form(&ray);
      }
    }
  }
  return sum;
}

static double near_to(const struct rad_gauss *g, double d, double tolerance, int64_t *count) {
  double matrix[4], out[4], sum = 0;
  struct rad_patch patch = {.angle = RAD_ANGLE_DUFFY, .a1 = 1, .b1 = 0, .b2 = 1};
  struct rad_element e = {
      .sigma = {0, 1}, .tau = {0, 1}, .p_phi = 1, .p_r = 1, .k_phi = 2, .k_r = 2, .n_function = 4};
  rad_lagrange_from_legendre(g, 2, matrix);
  struct rad_near w = {.gauss = g,
                       .patch = &patch,
                       .element = &e,
                       .to_lagrange_phi = matrix,
                       .to_lagrange_r = matrix,
                       .digits = log(100 / tolerance),
                       .n0 = d,
                       .x = {foot[0], foot[1], d}};
  struct rad_strip strip = {{0, 1}, {0, 1, 0}, {1, 1, 0}};
  rad_near(&w, &strip, 1, out);
  for (int b = 0; b < 4; b++)
    sum += out[b];
  *count = w.n_kernel;
  return sum;
}

/* Lambert's form (theory 3.9), over d^2 / pi. */
static double exact(double d) {
  static const double corner[3][2] = {{0, 0}, {1, 0}, {1, 1}};
  long double sum = 0;
  for (int i = 0; i < 3; i++) {
    const double *p = corner[i], *q = corner[(i + 1) % 3];
    long double a = (long double)p[0] - foot[0], b = (long double)p[1] - foot[1];
    long double u = (long double)q[0] - p[0], v = (long double)q[1] - p[1], h = d;
    long double flat = a * v - b * u, cross = sqrtl(flat * flat + h * h * (u * u + v * v));
    sum += atan2l(cross, a * (a + u) + b * (b + v) + h * h) * flat / cross;
  }
  return (double)(sum / 2 / ((long double)d * d)); /* 1/(2 pi) over d^2 / pi */
}

static void print(double d, const char *rule, double count, double value, double expected) {
  printf("%g,%s,%.0f,%.3e\n", d, rule, count, fabs(value / expected - 1));
}

int main(void) {
  struct rad_gauss g;
  struct rad_error e;
  static struct rule rule;
  if (rad_gauss_init(&g, &e)) {
    fprintf(stderr, "%s\n", e.text);
    return 3;
  }
  printf("distance,rule,kernel_values,relative_error\n");
  for (int k = 1; k <= 12; k++) {
    double d = pow(10, -k), v = exact(d);
    int64_t count;
    for (int n = 2; n <= PANEL * MOST_PANELS; n += n < 8 ? 2 : n / 3) {
      set_rule(&g, n, &rule);
      double values = (double)rule.n * rule.n;
      print(d, "Gauss", values, plain(d, &rule), v);
      print(d, "paper", values, paper(d, &rule), v);
      if (n <= 128)
        print(d, "sinh", values, stretch(d, &rule), v);
    }
    for (int n = 2; n <= 24; n += 2) {
      double value = rays(&g, d, n, &count);
      print(d, "closed form", (double)count, value, v);
    }
    for (double tolerance = 1e-1; tolerance > 2e-14; tolerance /= 10) {
      double value = near_to(&g, d, tolerance, &count);
      print(d, "polyrad", (double)count, value / (d * d / M_PI), v);
    }
  }
  rad_gauss_free(&g);
  return 0;
}
