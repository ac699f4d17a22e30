/* Double surface integrals of polygons that see all of each other: contour form and product rules
 * against an outer integral of this file's own, graded towards what the two have in common. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "factors/contour.h"
#include "factors/exchange.h"
#include "factors/triangle_rule.h"
#include "suite.h"

enum { LEVELS = 16, POINTS = 12 };

static struct rad_gauss gauss;

static double uniform(double low, double high) {
  return low + (high - low) * drand48();
}

/* Lambert's form with nothing of src/. */
static double lambert(const double x[3], const double n[3], const struct rad_flat *f) {
  double sum = 0;
  for (int c = 0; c < f->n; c++) {
    double a[3], b[3], m[3];
    for (int d = 0; d < 3; d++) {
      a[d] = f->corner[c][d] - x[d];
      b[d] = f->corner[(c + 1) % f->n][d] - x[d];
    }
    m[0] = a[1] * b[2] - a[2] * b[1];
    m[1] = a[2] * b[0] - a[0] * b[2];
    m[2] = a[0] * b[1] - a[1] * b[0];
    double length = sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
    double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    if (length > 0)
      sum += atan2(length, cosine) * (m[0] * n[0] + m[1] * n[1] + m[2] * n[2]) / length;
  }
  return fabs(sum) / (2 * M_PI);
}

/* Points and weights on [0, 1], graded towards 0 and, if both, towards 1 too. */
static int graded(int both, double *x, double *w) {
  const double *node = rad_gauss_node(&gauss, POINTS), *weight = rad_gauss_weight(&gauss, POINTS);
  int n = 0;
  for (int l = 0; l < LEVELS; l++) {
    double high = pow(0.2, l), low = l + 1 < LEVELS ? 0.2 * high : 0;
    for (int q = 0; q < POINTS; q++) {
      double at = low + (high - low) * 0.5 * (1 + node[q]), share = 0.5 * (high - low) * weight[q];
      x[n] = both ? 0.5 * at : at;
      w[n++] = both ? 0.5 * share : share;
      if (both) {
        x[n] = 1 - 0.5 * at;
        w[n++] = 0.5 * share;
      }
    }
  }
  return n;
}

/* int_P F(x -> Q) dS, P a triangle, graded towards its first vertex and the sides there. */
static double oracle(const struct rad_flat *p, const struct rad_flat *q) {
  double r[LEVELS * POINTS], wr[LEVELS * POINTS], t[2 * LEVELS * POINTS], wt[2 * LEVELS * POINTS];
  int nr = graded(0, r, wr), nt = graded(1, t, wt);
  double sum = 0, area = rad_flat_area(p);
  for (int i = 0; i < nr; i++)
    for (int j = 0; j < nt; j++) {
      double x[3];
      for (int d = 0; d < 3; d++)
        x[d] = p->corner[0][d] + r[i] * ((1 - t[j]) * (p->corner[1][d] - p->corner[0][d]) +
                                         t[j] * (p->corner[2][d] - p->corner[0][d]));
      sum += 2 * area * r[i] * wr[i] * wt[j] * lambert(x, p->normal, q);
    }
  return sum;
}

static struct rad_flat triangle(const double a[3], const double b[3], const double c[3],
                                const double towards[3]) {
  struct rad_flat f = {.n = 3};
  double u[3], v[3], w[3];
  memcpy(f.corner[0], a, sizeof f.corner[0]);
  memcpy(f.corner[1], b, sizeof f.corner[0]);
  memcpy(f.corner[2], c, sizeof f.corner[0]);
  rad_sub(b, a, u);
  rad_sub(c, a, v);
  rad_cross(u, v, f.normal);
  rad_sub(towards, a, w);
  double length = rad_norm(f.normal) * (rad_dot(f.normal, w) < 0 ? -1 : 1);
  for (int d = 0; d < 3; d++)
    f.normal[d] /= length;
  return f;
}

static void hold(const char *name, struct rad_flat *p, struct rad_flat *q, double tolerance) {
  double exact = oracle(p, q), error, area = fmin(rad_flat_area(p), rad_flat_area(q));
  rad_flat_orient(p);
  rad_flat_orient(q);
  double value = rad_contour(&gauss, p, q, &error), turned = rad_contour(&gauss, q, p, &error);
  ck_assert_msg(fabs(value - exact) <= tolerance * area && fabs(value - turned) <= 2 * error,
                "%s: %.15g, turned %.15g, exact %.15g, of the area %.2g", name, value, turned,
                exact, (value - exact) / area);
}

/* The four faces of a tetrahedron share edges with each other and see nothing else: rows sum to 1.
 */
START_TEST(common_edges) {
  srand48(2003);
  for (int degrees = 1; degrees < 180; degrees++) {
    double c = cos(degrees * M_PI / 180), s = sin(degrees * M_PI / 180), reach = uniform(0.3, 2);
    const double v[4][3] = {{0, 0, 0},
                            {1, 0, 0},
                            {uniform(-0.5, 1.5), uniform(0.3, 2), 0},
                            {uniform(-0.5, 1.5), reach * c, reach * s}};
    struct rad_flat face[4];
    for (int k = 0; k < 4; k++) {
      face[k] = triangle(v[(k + 1) % 4], v[(k + 2) % 4], v[(k + 3) % 4], v[k]);
      rad_flat_orient(&face[k]);
    }
    for (int k = 0; k < 4; k++) {
      double sum = 0, area = rad_flat_area(&face[k]), error, all = 0;
      for (int m = 0; m < 4; m++)
        if (m != k) {
          sum += rad_contour(&gauss, &face[k], &face[m], &error);
          all += error;
        }
      ck_assert_msg(fabs(sum - area) <= all, "%d degrees, face %d: %.15g of %.15g, error %.2g",
                    degrees, k, sum, area, all);
      ck_assert_msg(all <= 1e-12 * area * 20, "%d degrees: error %.2g of %.2g", degrees, all, area);
    }
  }
}
END_TEST

START_TEST(common_vertices) {
  const double a[3] = {0, 0, 0};
  srand48(2003);
  for (int run = 0; run < 100; run++) {
    const double b[3] = {uniform(0.5, 2), uniform(0, 0.5), 0};
    const double c[3] = {uniform(-1, 1), uniform(0.6, 2), 0};
    const double d[3] = {uniform(-2, -0.2), uniform(-2, -0.2), uniform(0.01, 1)};
    const double e[3] = {uniform(0.2, 1), uniform(-2, -0.2), uniform(0.01, 1)};
    struct rad_flat low = triangle(a, b, c, d), high = triangle(a, d, e, c);
    double rb[3], up = 0;
    rad_sub(b, a, rb);
    up = rad_dot(rb, high.normal);
    if (up < 0)
      continue; /* not all in front */
    char name[64];
    snprintf(name, sizeof name, "common vertex, run %d", run);
    hold(name, &low, &high, 1e-11);
  }
}
END_TEST

/* A gap between facing triangles that closes: the whole is the sum of its parts. */
START_TEST(near_pairs) {
  const double a[3] = {0, 0, 0}, b[3] = {1, 0, 0}, c[3] = {0, 1, 0};
  for (double gap = 1; gap > 1e-8; gap /= 3) {
    const double d[3] = {0.2, 0.1, gap}, e[3] = {0.9, -0.3, 2 * gap}, f[3] = {-0.3, 1.2, gap * 1.5};
    struct rad_flat low = triangle(a, b, c, d), high = triangle(d, e, f, a);
    double error, value, sum = 0;
    rad_flat_orient(&low);
    rad_flat_orient(&high);
    value = rad_contour(&gauss, &low, &high, &error);
    /* cut in four: the sum is the whole */
    double m[3][3];
    for (int k = 0; k < 3; k++)
      rad_between(high.corner[(k + 1) % 3], high.corner[(k + 2) % 3], 0.5, m[k]);
    for (int k = 0; k < 4; k++) {
      double own;
      struct rad_flat part = high;
      for (int v = 0; v < 3; v++)
        memcpy(part.corner[v], k == 3 ? m[v] : v == k ? high.corner[k] : m[3 - k - v], sizeof m[0]);
      rad_flat_orient(&part);
      sum += rad_contour(&gauss, &low, &part, &own);
    }
    ck_assert_msg(fabs(sum - value) <= 5e-13, "gap %g: %.15g, in parts %.15g", gap, value, sum);
    ck_assert(value <= 0.5 && value > 0);
  }
}
END_TEST

/* Every goal is met, and a bound never grows as the goal falls. */
START_TEST(product_rules) {
  double worst = 0;
  srand48(2003);
  for (int run = 0; run < 20000; run++) {
    double v[2][3][3], far = pow(10, uniform(0.15, 2));
    for (int k = 0; k < 3; k++)
      for (int d = 0; d < 3; d++) {
        v[0][k][d] = uniform(-1, 1) * (d == 2 ? 0.5 : 1);
        v[1][k][d] = uniform(-1, 1) + (d == 2 ? 2 * far : 0.5 * far);
      }
    struct rad_flat p = triangle(v[0][0], v[0][1], v[0][2], v[1][0]);
    struct rad_flat q = triangle(v[1][0], v[1][1], v[1][2], v[0][0]);
    rad_flat_orient(&p);
    rad_flat_orient(&q);
    rad_flat_clip(&p, q.corner[0], q.normal, 0);
    rad_flat_clip(&q, v[0][0], p.normal, 0);
    if (p.n < 3 || q.n < 3)
      continue;
    double exact_error, exact = rad_contour(&gauss, &p, &q, &exact_error), last = INFINITY;
    for (double goal = 1e-1; goal > 1e-9; goal /= 10) {
      double error, value = rad_exchange(&gauss, &p, &q, goal, &error);
      ck_assert_msg(fabs(value - exact) <= error + exact_error,
                    "run %d, goal %g: %.12g +- %.2g, exact %.12g", run, goal, value, error, exact);
      ck_assert(error <= last || error <= exact_error);
      last = error;
      if (error > 10 * exact_error)
        worst = fmax(worst, fabs(value - exact) / error);
    }
  }
  printf("product_rules: error over bound at most %.3g\n", worst);
  ck_assert(worst > 1e-3); /* a bound that says something */
}
END_TEST

/* Polynomials up to the degree are integrated exactly: int l1^a l2^b = 2 a! b!/(a + b + 2)!. */
START_TEST(rules) {
  double lambda[RAD_TRIANGLE_POINTS][3], weight[RAD_TRIANGLE_POINTS];
  for (int rule = 0; rule < RAD_TRIANGLE_RULES; rule++) {
    rad_triangle_rule(&gauss, rule, lambda, weight);
    for (int a = 0; a <= rad_triangle_degree[rule]; a++)
      for (int b = 0; a + b <= rad_triangle_degree[rule]; b++) {
        double sum = 0, exact = 2 * tgamma(a + 1) * tgamma(b + 1) / tgamma(a + b + 3);
        for (int q = 0; q < rad_triangle_points[rule]; q++)
          sum += weight[q] * pow(lambda[q][1], a) * pow(lambda[q][2], b);
        ck_assert_msg(fabs(sum - exact) <= 1e-15, "rule %d, l1^%d l2^%d: %.17g, exact %.17g", rule,
                      a, b, sum, exact);
      }
  }
}
END_TEST

int main(void) {
  Suite *s = suite_create("exchange");
  TCase *c = tcase_create("exchange");
  struct rad_error e;
  if (rad_gauss_init(&gauss, &e))
    return 1;
  tcase_set_timeout(c, 300);
  tcase_add_test(c, common_edges);
  tcase_add_test(c, common_vertices);
  tcase_add_test(c, near_pairs);
  tcase_add_test(c, product_rules);
  tcase_add_test(c, rules);
  suite_add_tcase(s, c);
  return run_suite(s);
}
