/* View factors with closed forms: a black source with E = 1, the mean irradiance of the target. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "scene_text.h"
#include "suite.h"

/* Graded: the irradiance has no Taylor series at edges that touch the source. Two elements a
 * direction where it changes within a tenth of the target. */
static const char method[] =
    "method: {mesh: graded, grading: 3, degree: 13, elements: %d, "
    "quadrature_tolerance: 1e-12}\n";

static double factor(int elements, const double (*target)[3], int n_target,
                     const double (*source)[3], int n_source) {
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  struct rad_error e;
  deck_begin(d);
  deck_polygon(d, "target", n_target, target, 0, 0);
  deck_polygon(d, "source", n_source, source, 0, 1);
  deck_add(d, method, elements);
  enum rad_code code = deck_solve(d, &c, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
  double f = surface_mean(&c, "target", 1);
  rad_case_free(&c);
  free(d);
  return f;
}

static void hold(const char *name, double f, double exact) {
  if (getenv("POLYRAD_TEST_VERBOSE"))
    printf("%-40s %.15f exact %.15f difference %.1e\n", name, f, exact, f - exact);
  ck_assert_msg(fabs(f - exact) <= 1e-9, "%s: %.15f, exact %.15f, difference %g", name, f, exact,
                f - exact);
}

/* Parallel rectangles a x b at distance 1, the upper one shifted by (s, t). */
static double parallel(int elements, double a, double b, double s, double t) {
  double low[4][3] = {{0, 0, 0}, {a, 0, 0}, {a, b, 0}, {0, b, 0}};
  double high[4][3] = {{s, t, 1}, {s, t + b, 1}, {s + a, t + b, 1}, {s + a, t, 1}};
  return factor(elements, (const double(*)[3])low, 4, (const double(*)[3])high, 4);
}

START_TEST(parallel_rectangles) {
  hold("parallel_squares_distance_1", parallel(1, 1, 1, 0, 0), 0.1998248956983874);
  hold("parallel_2x1_distance_1", parallel(1, 2, 1, 0, 0), 0.2858753848507147);
  hold("parallel_0.1", parallel(1, 0.1, 0.1, 0, 0), 0.0031620568387576);
  hold("parallel_10", parallel(2, 10, 10, 0, 0), 0.8269945223972566);
  hold("parallel_unit_squares_offset_(1,0)", parallel(1, 1, 1, 1, 0), 0.0860504891523273);
  hold("parallel_unit_squares_offset_(1,1)", parallel(1, 1, 1, 1, 1), 0.0433274095741047);
}
END_TEST

/* Rectangles 1 x w (target) and 1 x h on the common edge y = 0 .. 1 at an angle. */
static double inclined(int elements, double w, double h, double degrees) {
  double c = cos(degrees * M_PI / 180), s = sin(degrees * M_PI / 180);
  if (degrees == 90)
    c = 0;
  double low[4][3] = {{0, 0, 0}, {w, 0, 0}, {w, 1, 0}, {0, 1, 0}};
  double high[4][3] = {{0, 0, 0}, {0, 1, 0}, {h * c, 1, h * s}, {h * c, 0, h * s}};
  return factor(elements, (const double(*)[3])low, 4, (const double(*)[3])high, 4);
}

START_TEST(rectangles_on_an_edge) {
  static const double degrees[] = {10, 30, 45, 60, 120, 135, 150, 170};
  static const double exact[] = {0.8496061249628472,  0.6190283230908032,  0.4833476954788778,
                                 0.3709053211500514,  0.08661500111827607, 0.04830944780181794,
                                 0.02134532541268937, 0.00236205667876908};
  hold("perpendicular_unit_squares_common_edge", inclined(1, 1, 1, 90), 0.2000437760754032);
  hold("perpendicular_common_edge_H2_W0.5", inclined(1, 0.5, 2, 90), 0.314601082023923);
  for (int i = 0; i < 8; i++) {
    char name[64];
    snprintf(name, sizeof name, "inclined_unit_squares_common_edge %g", degrees[i]);
    hold(name, inclined(degrees[i] < 20 ? 2 : 1, 1, 1, degrees[i]), exact[i]);
  }
}
END_TEST

START_TEST(other_shapes) {
  static const double floor[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  static const double wall[3][3] = {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  hold("right_isosceles_triangles", factor(1, floor, 3, wall, 3), 0.2113248654051871);
  static const double square[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  static const double upright[4][3] = {{1, 1, 0}, {1, 1, 1}, {1, 2, 1}, {1, 2, 0}};
  hold("perpendicular_unit_squares_touching_at_a_point", factor(1, square, 4, upright, 4),
       0.04059223010155854);
}
END_TEST

/* Irradiance at a probe from a unit square with E = 1. */
static double at_probe(const double (*target)[3], const double (*source)[3], const char *at) {
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  struct rad_error e;
  struct rad_result r = {0};
  deck_begin(d);
  deck_polygon(d, "target", 3, target, 0, 0);
  deck_polygon(d, "source", 4, source, 0, 1);
  deck_add(
      d,
      "method: {elements: 1, quadrature_tolerance: 1e-13}\nprobes: [{surface: target, at: %s}]\n",
      at);
  enum rad_code code = deck_solve(d, &c, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
  ck_assert_int_eq(rad_case_result(&c, "", &r, &e), RAD_OK);
  double h = r.probe_irradiance[0];
  rad_result_free(&r);
  rad_case_free(&c);
  free(d);
  return h;
}

START_TEST(points) {
  static const double low[3][3] = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  static const double high[4][3] = {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}};
  static const double upright[4][3] = {{1, 0, 0}, {1, 0, 1}, {1, 1, 1}, {1, 1, 0}};
  hold("point_to_parallel_unit_square_corner_foot", at_probe(low, high, "[0, 0, 0]"),
       0.138531605994893);
  hold("point_to_perpendicular_unit_square_(x=1)", at_probe(low, upright, "[0, 0, 0]"),
       0.0557341970025535);
}
END_TEST

int main(void) {
  Suite *s = suite_create("view factors");
  TCase *c = tcase_create("closed forms");
  tcase_set_timeout(c, 300);
  tcase_add_test(c, parallel_rectangles);
  tcase_add_test(c, rectangles_on_an_edge);
  tcase_add_test(c, other_shapes);
  tcase_add_test(c, points);
  suite_add_tcase(s, c);
  return run_suite(s);
}
