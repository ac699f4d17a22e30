/* Stability: norms of the inverse against closed forms, and what docs/stability.md says of methods
 * that fail, in small versions of its studies. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "scene_text.h"
#include "suite.h"
#include "system/stability.h"

/* Norms of one deck. */
static struct rad_stability norms(const struct deck_text *d) {
  struct rad_case c;
  struct rad_error e;
  struct rad_stability s;
  ck_assert_msg(deck_solve(d, &c, &e) == RAD_OK, "%s", e.text);
  ck_assert_msg(rad_stability(&c.dense, c.rho, &s, &e) == RAD_OK, "%s", e.text);
  rad_case_free(&c);
  return s;
}

/* Two faces that share an edge at an angle of so many degrees. */
static void wedge(struct deck_text *d, double degrees, double rho, const char *method) {
  double a = degrees * M_PI / 180;
  deck_begin(d);
  deck_polygon(d, "floor", 3, (const double[][3]){{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}}, rho, 1);
  deck_polygon(d, "wall", 3, (const double[][3]){{1, 0, 0}, {0, 0, 0}, {0.5, cos(a), sin(a)}}, rho,
               0);
  deck_add(d, "method: %s\n", method);
}

/* ---- closed forms ---------------------------------------------------------------------------- */

/* rho = 0: u_h interpolates E, and the norm is the Lebesgue constant of the points, squared. */
START_TEST(lebesgue_constants) {
  static const struct {
    const char *method;
    double constant;
  } c[] = {{"degree: 0", 1},
           {"degree: 1", 1.7320508075688772},     /* Gauss: at 1, (sqrt 3 + 1)/2 + (sqrt 3 - 1)/2 */
           {"degree: 1, nodes: biased", 19},      /* (.9, 1) at 0: 10 + 9 */
           {"degree: 2, nodes: [.6, .8, 1]", 31}, /* at 0: 10 + 15 + 6 */
           {"degree: 1, nodes: equidistant", 2},
           {"degree: 1, nodes: vertex", 1},
           {"degree: 2, nodes: vertex", 1.25}}; /* 0, 1/2, 1 at 1/4: 3/8 + 3/4 + 1/8 */
  static const char *const mesh[] = {"paper, elements: 1", "geometric, elements: 2"};
  for (int i = 0; i < 14; i++) {
    struct deck_text d;
    char method[120];
    snprintf(method, sizeof method, "{mesh: %s, %s}", mesh[i % 2], c[i / 2].method);
    wedge(&d, 60, 0, method);
    struct rad_stability s = norms(&d);
    double expected = c[i / 2].constant * c[i / 2].constant;
    ck_assert_msg(fabs(s.inverse_norm / expected - 1) < 1e-12, "%s: %.15g, expected %.15g", method,
                  s.inverse_norm, expected);
    ck_assert_double_eq(s.inverse_matrix, 1);
    ck_assert_double_eq(s.condition, 1);
    ck_assert_double_eq(s.spectral_radius, 0);
  }
}
END_TEST

/* A closed scene with one rho: K 1 = 1, so rho is an eigenvalue, the largest; for constants the
 * inverse is >= 0 and its norm 1/(1 - rho), that of the matrix 1 + rho (its diagonal is 1). */
START_TEST(closed_scene) {
  static const double rho[6] = {0.8, 0.8, 0.8, 0.8, 0.8, 0.8}, emission[6] = {1};
  for (int degree = 0; degree < 3; degree++) {
    struct deck_text d;
    deck_begin(&d);
    deck_cube(&d, rho, emission);
    deck_add(&d, "method: {elements: 1, degree: %d, quadrature_tolerance: 1e-12}\n", degree);
    struct rad_stability s = norms(&d);
    ck_assert_double_eq_tol(s.spectral_radius, 0.8, 1e-10);
    ck_assert_double_ge(s.inverse_norm, s.inverse_matrix * (1 - 1e-12));
    if (degree > 0)
      continue;
    ck_assert_double_eq_tol(s.inverse_matrix, 5, 1e-9);
    ck_assert_double_eq_tol(s.inverse_norm, 5, 1e-9);
    ck_assert_double_eq_tol(s.condition, 9, 1e-8);
  }
}
END_TEST

int main(void) {
  Suite *s = suite_create("stability");
  TCase *c = tcase_create("closed forms");
  tcase_set_timeout(c, 600);
  tcase_add_test(c, lebesgue_constants);
  tcase_add_test(c, closed_scene);
  suite_add_tcase(s, c);
  return run_suite(s);
}
