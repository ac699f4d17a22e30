/* Lambert's formula for polygons in coordinates of their plane. */
#include <check.h>
#include <math.h>
#include <stdio.h>

#include "base/vec.h"
#include "oracle.h"
#include "scene_help.h"
#include "suite.h"
#include "visibility/irradiance.h"

/* 2e-16 (1 + sum_e theta_e |r_e| / |distance of x from the line of e|), r_e to the nearer corner: a
 * rounding of each, see rad_polygon_form_factor. */
static double rounding(const struct rad_polygon *polygon, const double x[3]) {
  double sum = 1;
  for (int e = 0; e < polygon->n; e++) {
    const double *a = polygon->corner[e], *b = polygon->corner[(e + 1) % polygon->n];
    double p[3] = {a[0] - x[0], a[1] - x[1], -x[2]}, q[3] = {b[0] - x[0], b[1] - x[1], -x[2]};
    double side[3] = {b[0] - a[0], b[1] - a[1], 0}, cross[3];
    rad_cross(p, side, cross);
    double near = fmin(rad_norm(p), rad_norm(q)), area = rad_norm(cross);
    sum += area > 0 ? atan2(area, rad_dot(p, q)) * near * rad_norm(side) / area : 0;
  }
  return 2e-16 * sum;
}

/* Corner at the foot of x, sides A z and B z: textbook view factor, parallel and perpendicular. */
START_TEST(rectangles_at_a_corner) {
  start_random();
  for (int k = 0; k < 200; k++) {
    double a = pow(10, uniform(-2, 2)), b = pow(10, uniform(-2, 2)), z = pow(10, uniform(-12, 9));
    const struct rad_polygon r = {.n = 4,
                                  .corner = {{0, 0}, {a * z, 0}, {a * z, b * z}, {0, b * z}}};
    double ha = sqrt(1 + a * a), hb = sqrt(1 + b * b);
    double parallel = (a / ha * atan(b / ha) + b / hb * atan(a / hb)) / (2 * M_PI);
    double upright = (atan(b) - atan(b / ha) / ha) / (2 * M_PI);
    const double x[3] = {0, 0, z}, down[3] = {0, 0, -1}, along[3] = {1, 0, 0};
    double tolerance = rounding(&r, x);
    ck_assert_double_eq_tol(rad_polygon_form_factor(&r, x, down), parallel, tolerance);
    ck_assert_double_eq_tol(rad_polygon_form_factor(&r, x, along), upright, tolerance);
  }
}
END_TEST

/* Just above a polygon it fills the view of what faces it, and half that of what stands on it. */
START_TEST(next_to_the_polygon) {
  const struct rad_polygon square = {.n = 4, .corner = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  for (int k = 3; k < 140; k += 7) {
    const double x[3] = {0.25, 0.125, pow(10, -k)}, down[3] = {0, 0, -1};
    ck_assert_double_eq_tol(rad_polygon_form_factor(&square, x, down), 1, x[2] * x[2] + 1e-15);
    const struct rad_polygon half = {.n = 4, .corner = {{0.25, -1}, {1, -1}, {1, 1}, {0.25, 1}}};
    const double along[3] = {1, 0, 0};
    ck_assert_double_eq_tol(rad_polygon_form_factor(&half, x, along), 0.5, 2 * x[2] + 1e-15);
  }
}
END_TEST

/* Random polygons and receivers; in half of them x is at 1e-1 .. 1e-12 of a corner. Cut at random,
 * the parts add up. */
START_TEST(polygons_agree_with_the_oracle) {
  struct rad_parts parts = {0};
  double worst = 0, most = 0;
  int n = 0;
  start_random();
  while (n < 2000) {
    struct rad_polygon polygon = {.n = 3 + n % 6};
    double at[2] = {uniform(-1, 1), uniform(-1, 1)}, turn = uniform(0, 7), size = uniform(0.1, 1);
    double t = pow(10, -1 - n % 12), edge[2][3], normal[3], y[8][3];
    for (int c = 0; c < polygon.n; c++) {
      double angle = turn + (n % 2 ? 2 : -2) * M_PI * c / polygon.n;
      polygon.corner[c][0] = at[0] + size * cos(angle);
      polygon.corner[c][1] = at[1] + size * sin(angle);
    }
    int close = n % 4 < 2;
    double x[3] = {uniform(-1, 1), uniform(-1, 1), uniform(0, 1) * t};
    for (int d = 0; close && d < 2; d++)
      x[d] = polygon.corner[0][d] + t * x[d];
    random_direction(edge[0]);
    random_direction(edge[1]);
    rad_cross(edge[0], edge[1], normal);
    double length = rad_norm(normal);
    int in_front = length > 0.1;
    for (int d = 0; d < 3; d++)
      normal[d] /= length;
    for (int c = 0; c < polygon.n; c++) {
      for (int d = 0; d < 3; d++)
        y[c][d] = d < 2 ? polygon.corner[c][d] : 0;
      double r[3];
      rad_sub(y[c], x, r);
      in_front &= rad_dot(normal, r) > 0;
    }
    double tolerance = rounding(&polygon, x);
    if (!in_front || tolerance > 1e-12)
      continue;
    struct oracle_point point = {.mu1 = 0, .mu2 = 0};
    for (int d = 0; d < 3; d++) {
      point.vertex[d] = x[d];
      point.edge1[d] = edge[0][d];
      point.edge2[d] = edge[1][d];
      point.normal[d] = normal[d];
    }
    double expected =
        (double)oracle_lambert(&point, polygon.n, (const double(*)[3])y, (double[3]){0, 0, 1});
    double got = rad_polygon_form_factor(&polygon, x, normal);
    worst = fmax(worst, fabs(got - expected) / tolerance);
    most = fmax(most, tolerance);
    ck_assert_msg(fabs(got - expected) <= tolerance, "%.17g, expected %.17g, %.2g, seed %llu", got,
                  expected, got - expected, seed());
    /* a half-plane, and its complement as a shadow */
    double c[3] = {0, cos(turn), sin(turn)};
    c[0] = -(c[1] * at[0] + c[2] * at[1]);
    struct rad_half_planes shadow = {1, {{c[0], c[1], c[2]}}};
    struct rad_polygon rest = polygon;
    rad_clip(&rest, c[0], c[1], c[2]);
    ck_assert_int_eq(rad_visible(&polygon, 1, &shadow, &parts), RAD_PARTLY);
    double sum =
        rad_parts_form_factor(&parts, x, normal) + rad_polygon_form_factor(&rest, x, normal);
    double bound = tolerance + rounding(&rest, x) + rounding(&parts.part[0], x);
    ck_assert_double_eq_tol(sum, got, 2 * bound);
    n++;
  }
  printf("lambert: worst %.2g of the tolerance, which was at most %.1e\n", worst, most);
  rad_parts_free(&parts);
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", seed());
  Suite *suite = suite_create("irradiance");
  TCase *tests = tcase_create("irradiance");
  tcase_add_test(tests, rectangles_at_a_corner);
  tcase_add_test(tests, next_to_the_polygon);
  tcase_add_test(tests, polygons_agree_with_the_oracle);
  tcase_set_timeout(tests, 120);
  suite_add_tcase(suite, tests);
  return run_suite(suite);
}
