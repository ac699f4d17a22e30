/* Invariants of whole solutions: closed scenes, energy, the Neumann series, scale, singular scenes.
 */
#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene_text.h"
#include "suite.h"

static const double rho_mixed[6] = {0.1, 0.9, 0.3, 0.5, 0.7, 0.2};

/* Every method, since a closed scene with E = 1 - rho has u = 1 in any of their spaces. */
static const char *const methods[] = {
    "{mesh: paper, elements: 2, degree: 0, solver: lu, quadrature_tolerance: 1e-12}",
    "{mesh: paper, elements: 2, grading: 2, degree: 1, solver: gmres, quadrature_tolerance: 1e-12}",
    "{mesh: paper, elements: 3, angle: duffy, constant_layers: 1, quadrature_tolerance: 1e-12}",
    "{mesh: graded, elements: 1, grading: 3, degree: 5, quadrature_tolerance: 1e-12}",
    "{mesh: uniform, elements: 3, degree: 0, quadrature_tolerance: 1e-12}",
    "{mesh: uniform, elements: 3, degree: 1, quadrature_tolerance: 1e-12}"};
enum { N_METHOD = sizeof methods / sizeof *methods };

static void solve(const struct deck_text *d, struct rad_case *c) {
  struct rad_error e;
  enum rad_code code = deck_solve(d, c, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
}

static void all_one(const struct rad_case *c) {
  double worst = 0;
  for (int i = 0; i < c->mesh->n_point; i++)
    worst = fmax(worst, fabs(c->u[i] - 1));
  ck_assert_msg(worst <= 1e-10, "largest |u - 1| is %g", worst);
}

/* Solve the deck's scene by this method, expect u = 1, and free the deck. */
static void solve_to_one(struct deck_text *d, const char *method) {
  struct rad_case c;
  deck_add(d, "method: %s\n", method);
  solve(d, &c);
  all_one(&c);
  rad_case_free(&c);
  free(d);
}

START_TEST(closed_cube) {
  struct deck_text *d = malloc(sizeof *d);
  double emission[6];
  for (int f = 0; f < 6; f++)
    emission[f] = 1 - rho_mixed[f];
  deck_begin(d);
  deck_cube(d, rho_mixed, emission);
  solve_to_one(d, methods[_i]);
}
END_TEST

static void tetrahedron(struct deck_text *d, const double rho[4], const double emission[4]) {
  static const double v[4][3] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  static const int face[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  for (int f = 0; f < 4; f++) {
    double corner[3][3];
    char name[2] = {(char)('a' + f), 0};
    for (int i = 0; i < 3; i++)
      memcpy(corner[i], v[face[f][i]], sizeof corner[i]);
    deck_polygon(d, name, 3, (const double(*)[3])corner, rho[f], emission[f]);
  }
}

START_TEST(closed_tetrahedron) {
  static const double rho[4] = {0.2, 0.95, 0, 0.6}, emission[4] = {0.8, 0.05, 1, 0.4};
  struct deck_text *d = malloc(sizeof *d);
  deck_begin(d);
  tetrahedron(d, rho, emission);
  solve_to_one(d, methods[_i]);
}
END_TEST

/* Closed scene: what is emitted is absorbed, int (1 - rho) H = int E with the irradiance H; where
 * rho is the same everywhere, also int (1 - rho) u = int E. Collocation loses a little, the less
 * the higher the degree. */
START_TEST(energy) {
  static const double emission[6] = {0, 1, 0.2, 0, 3, 0.5},
                      rho_even[6] = {0.6, 0.6, 0.6, 0.6, 0.6, 0.6};
  static const char *const name[] = {"floor", "ceiling", "x0", "x1", "y0", "y1"};
  const double *rho = _i ? rho_even : rho_mixed;
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  deck_begin(d);
  deck_cube(d, rho, emission);
  deck_add(
      d,
      "method: {mesh: graded, grading: 3, degree: 7, elements: 1, quadrature_tolerance: 1e-10}\n");
  solve(d, &c);
  double in = 0, absorbed = 0, radiosity = 0;
  for (int f = 0; f < 6; f++) {
    in += emission[f];
    absorbed += (1 - rho[f]) * surface_mean(&c, name[f], 1);
    radiosity += (1 - rho[f]) * surface_mean(&c, name[f], 0);
  }
  ck_assert_msg(fabs(absorbed - in) < 1e-6 * in, "emitted %.10g, absorbed %.10g", in, absorbed);
  if (_i)
    ck_assert_msg(fabs(radiosity - in) < 1e-6 * in, "emitted %.10g, (1 - rho) u %.10g", in,
                  radiosity);
  rad_case_free(&c);
  free(d);
}
END_TEST

/* The partial Neumann series stays within its bound of the solution, and approaches it. */
START_TEST(neumann) {
  static const double emission[6] = {0, 1, 0.2, 0, 3, 0.5};
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case full, part;
  double last = INFINITY;
  deck_begin(d);
  deck_cube(d, rho_mixed, emission);
  int head = d->length;
  deck_add(d, "method: {elements: 1, solver: lu}\n");
  solve(d, &full);
  for (int bounces = 0; bounces <= 60; bounces += 20) {
    d->length = head;
    deck_add(d, "method: {elements: 1, solver: neumann, bounces: %d}\n", bounces);
    solve(d, &part);
    double worst = 0;
    for (int i = 0; i < full.mesh->n_point; i++)
      worst = fmax(worst, fabs(full.u[i] - part.u[i]));
    ck_assert_msg(worst <= part.report.remainder && worst < last,
                  "%d bounces: error %g, bound %g, before %g", bounces, worst,
                  part.report.remainder, last);
    ck_assert_int_eq(part.report.iterations, bounces);
    last = worst;
    rad_case_free(&part);
  }
  rad_case_free(&full);
  free(d);
}
END_TEST

START_TEST(closed_and_white) {
  static const double rho[6] = {1, 1, 1, 1, 1, 1}, emission[6] = {1, 0, 0, 0, 0, 0};
  static const char *const solver[] = {"lu", "gmres", "neumann"};
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  struct rad_error e;
  deck_begin(d);
  deck_cube(d, rho, emission);
  deck_add(d, "method: {elements: 1, solver: %s}\n", solver[_i]);
  ck_assert_int_eq(deck_solve(d, &c, &e), RAD_ENUMERIC);
  ck_assert_msg(strstr(e.text, "closed") && strstr(e.text, "rho = 1") && strstr(e.text, "floor"),
                "%s", e.text);
  rad_case_free(&c);
  free(d);
}
END_TEST

/* One face of five may be white, and so may all but one: light is lost at the last. */
START_TEST(almost_white) {
  static const double rho[6] = {1, 1, 1, 1, 1, 0.5}, emission[6] = {0, 0, 0, 0, 0, 0.5};
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  deck_begin(d);
  deck_cube(d, rho, emission);
  deck_add(d, "method: {elements: 1, solver: lu, quadrature_tolerance: 1e-12}\n");
  solve(d, &c);
  all_one(&c); /* E = 1 - rho again */
  ck_assert_double_gt(c.report.inverse_norm, 2);
  rad_case_free(&c);
  free(d);
}
END_TEST

int main(void) {
  Suite *s = suite_create("balance");
  TCase *c = tcase_create("invariants");
  tcase_set_timeout(c, 300);
  tcase_add_loop_test(c, closed_cube, 0, N_METHOD);
  tcase_add_loop_test(c, closed_tetrahedron, 0, N_METHOD);
  tcase_add_loop_test(c, energy, 0, 2);
  tcase_add_test(c, neumann);
  tcase_add_loop_test(c, closed_and_white, 0, 3);
  tcase_add_test(c, almost_white);
  suite_add_tcase(s, c);
  return run_suite(s);
}
