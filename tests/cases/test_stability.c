/* Stability: norms of the inverse against closed forms, and what docs/stability.md says of methods
 * that fail, in small versions of its studies. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/grid.h"
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
  static const double v[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  static const int face[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
  for (int degree = 0; degree < 3; degree++) {
    struct deck_text d;
    deck_begin(&d);
    for (int f = 0; f < 4; f++) {
      double q[3][3];
      for (int c = 0; c < 3; c++)
        memcpy(q[c], v[face[f][c]], sizeof q[c]);
      deck_polygon(&d, "face", 3, (const double(*)[3])q, 0.8, 1);
    }
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

/* ---- verdicts of docs/stability.md ---------------------------------------------------------- */

static struct rad_stability wedge_norms(double degrees, double rho, const char *method) {
  struct deck_text d;
  wedge(&d, degrees, rho, method);
  return norms(&d);
}

/* Norm of the inverse operator of a wedge: 1/(1 - rho (1 + cos angle)/2) at the edge, the most. */
static double operator_norm(double degrees, double rho) {
  return 1 / (1 - rho * (1 + cos(degrees * M_PI / 180)) / 2);
}

/* Biased points: the norm grows tenfold with every layer, and the spectral radius does not tell.
 * Gauss points stay within the Lebesgue constant, 3, of the operator's norm. */
START_TEST(biased_points_fail) {
  double most = operator_norm(10, 0.99), before = 100;
  for (int layers = 1; layers <= 2; layers++) {
    char method[120];
    snprintf(method, sizeof method, "{mesh: geometric, elements: %d, nodes: biased}", layers);
    struct rad_stability biased = wedge_norms(10, 0.99, method);
    ck_assert_double_gt(biased.inverse_norm, 8 * before);
    ck_assert_double_lt(biased.spectral_radius, 0.95);
    before = biased.inverse_norm;
    snprintf(method, sizeof method, "{mesh: geometric, elements: %d}", layers);
    struct rad_stability gauss = wedge_norms(10, 0.99, method);
    ck_assert_double_lt(gauss.inverse_matrix, 1.08 * most);
    ck_assert_double_lt(gauss.inverse_norm, 3 * 1.08 * most);
  }
  struct rad_stability three =
      wedge_norms(10, 0.99, "{mesh: geometric, elements: 2, degree: 2, nodes: [0.6, 0.8, 1]}");
  ck_assert_double_gt(three.inverse_matrix, 5 * most);
}
END_TEST

/* Equidistant points of degree 4 are no longer stable; vertex points are. */
START_TEST(equidistant_and_vertex_points) {
  double most = operator_norm(10, 0.9);
  struct rad_stability five =
      wedge_norms(10, 0.9, "{mesh: geometric, elements: 1, degree: 4, nodes: equidistant}");
  struct rad_stability gauss = wedge_norms(10, 0.9, "{mesh: geometric, elements: 1, degree: 4}");
  struct rad_stability vertex =
      wedge_norms(10, 0.9, "{mesh: geometric, elements: 2, degree: 1, nodes: vertex}");
  ck_assert_double_gt(five.inverse_matrix, 1.5 * most);
  ck_assert_double_lt(gauss.inverse_matrix, 1.2 * most);
  ck_assert_double_lt(vertex.inverse_norm, 1.08 * most);
}
END_TEST

/* Gauss points at every angle, degree and grading, with constants next to the edge or not: w is
 * that of the operator, and the matrix' norm its own to 10 percent but for strong grading and high
 * degree: at 1 degree, where elements are much wider than the way to the other face, several times
 * that. */
START_TEST(gauss_points_hold) {
  static const double angle[] = {1, 5, 10, 45, 90, 135, 170, 179};
  static const char *const method[] = {
      "{mesh: paper, elements: 2, grading: 2, degree: 0}",
      "{mesh: paper, elements: 2, grading: 2, degree: 1}",
      "{mesh: paper, elements: 2, grading: 2, degree: 1, constant_layers: 1}",
      "{mesh: geometric, elements: 2, degree: 2}",
      "{mesh: graded, elements: 1, grading: 6, degree: 3}",
      "{mesh: graded, elements: 1, grading: 3, degree: 6}"};
  for (int m = 0; m < 6; m++) {
    struct deck_text d;
    struct rad_case c;
    struct rad_error e;
    struct rad_stability s;
    wedge(&d, angle[_i], 0.99, method[m]);
    ck_assert_msg(deck_solve(&d, &c, &e) == RAD_OK, "%s", e.text);
    ck_assert_msg(rad_stability(&c.dense, c.rho, &s, &e) == RAD_OK, "%s", e.text);
    double most = operator_norm(angle[_i], 0.99);
    double limit = m == 0 ? 1 : angle[_i] < 5 ? 5 : angle[_i] < 10 ? 2.2 : m < 4 ? 1.1 : 1.5;
    ck_assert_msg(s.inverse_matrix < limit * most * (1 + 1e-8), "%g degrees, %s: %g, operator %g",
                  angle[_i], method[m], s.inverse_matrix, most);
    ck_assert_double_lt(c.report.inverse_norm, 1.01 * most);
    ck_assert_double_lt(s.spectral_radius, 0.99);
    rad_case_free(&c);
  }
}
END_TEST

/* A cone of n faces from the origin to a polygon at height 2; with a dent, its first corner pulled
 * in beyond its neighbours. */
static void cone(struct deck_text *d, int n, int dent, const char *method) {
  double turn = 2 * M_PI / n;
  deck_begin(d);
  for (int k = 0; k < n; k++) {
    double corner[3][3] = {{0, 0, 0}};
    for (int c = 0; c < 2; c++) {
      double a = turn * ((k + c) % n);
      corner[1 + c][0] = dent && (k + c) % n == 0 ? cos(turn) - 0.35 : cos(a);
      corner[1 + c][1] = sin(a);
      corner[1 + c][2] = 2;
    }
    deck_polygon(d, k ? "dark" : "lit", 3, (const double(*)[3])corner, 0.99, k == 0);
  }
  deck_add(d, "method: %s\n", method);
}

/* Vertices in space: the matrix' norm stays that of the operator, 1/(1 - kappa) at most. */
START_TEST(vertices_hold) {
  static const int faces[] = {3, 4, 6, 12};
  for (int degree = 0; degree < 3; degree += 1 + (faces[_i % 4] > 3)) {
    struct deck_text d;
    struct rad_case c;
    struct rad_error e;
    struct rad_stability s;
    char method[120];
    snprintf(method, sizeof method, "{mesh: geometric, elements: 1, degree: %d}", degree);
    if (_i / 4 && faces[_i % 4] == 3)
      return;
    cone(&d, faces[_i % 4], _i / 4, method);
    ck_assert_msg(deck_solve(&d, &c, &e) == RAD_OK, "%s", e.text);
    ck_assert_msg(rad_stability(&c.dense, c.rho, &s, &e) == RAD_OK, "%s", e.text);
    double most = 1 / (1 - c.report.kappa);
    ck_assert_msg(s.inverse_matrix < 1.08 * most, "%d faces, dent %d, degree %d: %g, at most %g",
                  faces[_i % 4], _i / 4, degree, s.inverse_matrix, most);
    rad_case_free(&c);
  }
}
END_TEST

/* ---- what the program says ------------------------------------------------------------------- */

static void said(const struct rad_case *c, const char *what) {
  struct rad_notes notes = {0};
  int found = 0;
  rad_case_warn(c, &notes);
  for (int i = 0; i < notes.n; i++)
    found |= strstr(notes.text[i], what) != NULL;
  ck_assert_msg(found, "no warning holds '%s'", what);
  rad_notes_free(&notes);
}

/* Other points: a warning always, a second one when the inverse is too large, and a bound that
 * holds although the values mean nothing. */
START_TEST(failing_points_are_not_silent) {
  struct deck_text d;
  struct rad_case c, good;
  struct rad_error e;
  wedge(&d, 10, 0.99, "{mesh: geometric, elements: 4, nodes: biased}");
  ck_assert_msg(deck_solve(&d, &c, &e) == RAD_OK, "%s", e.text);
  said(&c, "Gauss points can be unstable");
  said(&c, "values mean nothing");
  ck_assert(c.has_bound);
  wedge(&d, 10, 0.99, "{}");
  ck_assert_msg(deck_solve(&d, &good, &e) == RAD_OK, "%s", e.text); /* 1e-3, adaptive */
  double scale = rad_indicator_scale(&c.adaptive.indicator, 1);
  double error = fabs(surface_mean(&c, "floor", 0) - surface_mean(&good, "floor", 0));
  ck_assert_double_gt(error, 0.5); /* of 7 */
  ck_assert_double_gt(c.adaptive.bound * scale, error);
  rad_case_free(&c);
  rad_case_free(&good);
}
END_TEST

/* Coarse quadrature between bright faces: the amplified tolerance is warned of, or in the bound. */
START_TEST(coarse_quadrature_is_not_silent) {
  struct deck_text d;
  struct rad_case c;
  struct rad_error e;
  wedge(&d, 10, 0.99,
        "{mesh: graded, elements: 1, grading: 3, degree: 3, quadrature_tolerance: 1e-2}");
  ck_assert_msg(deck_solve(&d, &c, &e) == RAD_OK, "%s", e.text);
  said(&c, "quadrature tolerance");
  rad_case_free(&c);
  wedge(&d, 10, 0.99,
        "{mesh: graded, elements: 1, grading: 3, degree: 3, quadrature_tolerance: 1e-2}\n"
        "accuracy: {tolerance: 1e-3}");
  ck_assert_msg(deck_solve(&d, &c, &e) == RAD_OK, "%s", e.text);
  ck_assert_double_gt(c.adaptive.bound, 2 * 1e-2); /* theory 6.4: 2 tol max u max w */
  rad_case_free(&c);
}
END_TEST

/* rho = 1 in a closed scene is refused, in an open one solved. */
START_TEST(white_scenes) {
  static const double white[6] = {1, 1, 1, 1, 1, 1}, emission[6] = {1};
  struct deck_text d;
  struct rad_case c;
  struct rad_error e;
  deck_begin(&d);
  deck_cube(&d, white, emission);
  deck_add(&d, "method: {elements: 1}\n");
  ck_assert_int_eq(deck_solve(&d, &c, &e), RAD_ENUMERIC);
  ck_assert_ptr_nonnull(strstr(e.text, "the scene is singular"));
  rad_case_free(&c);
  struct rad_stability s = wedge_norms(10, 1, "{mesh: geometric, elements: 2}");
  ck_assert_double_lt(s.inverse_matrix, 1.08 * operator_norm(10, 1));
}
END_TEST

/* ---- meshes that do not resolve the angle ---------------------------------------------------- */

static const double s1[3][3][3] = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                                   {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                   {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}}};

/* The cube corner of size `scale` at `at`, one face lit. */
static void corner(struct deck_text *d, double scale, double at, double rho, const char *how) {
  deck_begin(d);
  for (int f = 0; f < 3; f++) {
    double v[3][3];
    for (int c = 0; c < 9; c++)
      v[c / 3][c % 3] = scale * s1[f][c / 3][c % 3] + at;
    deck_polygon(d, f ? "dark" : "lit", 3, (const double(*)[3])v, rho, f == 0);
  }
  deck_add(d, "%s\n", how);
}

/* u_h of the corner on the closed grid; owned. */
static double *grid_values(const char *method, double area[3]) {
  struct deck_text d;
  struct rad_case c;
  struct rad_error e;
  corner(&d, 1, 0, 0.9, method);
  ck_assert_msg(deck_solve(&d, &c, &e) == RAD_OK, "%s", e.text);
  double *value = malloc(rad_grid_size(&c.scene, RAD_GRID_CLOSED) * sizeof *value);
  ck_assert_int_eq(rad_grid_evaluate(&c, RAD_GRID_CLOSED, 0, value, &e), RAD_OK);
  for (int t = 0; t < 3; t++)
    area[t] = c.scene.triangle[t].area;
  rad_case_free(&c);
  return value;
}

START_TEST(uniform_meshes_stop) {
  static const char *const mesh[] = {"uniform", "paper", "paper, angle: duffy"};
  double area[3],
      *exact = grid_values("method: {mesh: graded, elements: 1, grading: 3, degree: 8}", area);
  for (int m = 0; m < 3; m++) {
    struct rad_difference error[2];
    for (int k = 0; k < 2; k++) {
      char method[80];
      snprintf(method, sizeof method, "method: {mesh: %s, elements: %d}", mesh[m], 2 << k);
      double *value = grid_values(method, area);
      error[k] = rad_grid_difference(RAD_GRID_CLOSED, 3, 1, area, value, exact);
      free(value);
    }
    ck_assert_double_gt(error[0].mean_square, 1.7 * error[1].mean_square);
    if (m == 0)
      ck_assert_double_lt(error[0].largest, 1.02 * error[1].largest);
    else
      ck_assert_double_gt(error[0].largest, 1.3 * error[1].largest);
  }
  free(exact);
}
END_TEST

/* The mean square is that of the surface: of 1 it is 1, of r over a triangle 1/sqrt 2; roughly on
 * the crowded grid, where neighbours differ by 1.8. */
START_TEST(mean_square_of_known_functions) {
  static const enum rad_grid grid[] = {RAD_GRID_CLOSED, RAD_GRID_CROWDED};
  const double area[2] = {3, 0.5};
  for (int g = 0; g < 2; g++) {
    size_t n = rad_grid_points(grid[g], 2), side = g ? RAD_CROWD : RAD_GRID;
    double *a = calloc(n, sizeof *a), *zero = calloc(n, sizeof *zero);
    for (size_t i = 0; i < n; i++)
      a[i] = 1;
    ck_assert_double_eq_tol(rad_grid_difference(grid[g], 2, 1, area, a, zero).mean_square, 1,
                            1e-12);
    for (size_t i = 0; i < n; i++) {
      size_t q = i / side % side;
      a[i] = g ? pow(1e-6, 1 - (double)q / (double)(side - 1)) : (double)q / (double)(side - 1);
    }
    struct rad_difference d = rad_grid_difference(grid[g], 2, 1, area, a, zero);
    ck_assert_double_eq_tol(d.mean_square, sqrt(0.5), g ? 0.06 : 1e-4);
    ck_assert_double_eq(d.largest, 1);
    free(a);
    free(zero);
  }
}
END_TEST

/* ---- shapes ---------------------------------------------------------------------------------- */

/* Mean radiosity of the lit face of a corner. */
static double lit(double scale, double at) {
  struct deck_text d;
  struct rad_case c;
  struct rad_error e;
  corner(&d, scale, at, 0.9, "method: {mesh: graded, elements: 1, grading: 3, degree: 3}");
  ck_assert_msg(deck_solve(&d, &c, &e) == RAD_OK, "%s", e.text);
  double u = surface_mean(&c, "lit", 0);
  rad_case_free(&c);
  return u;
}

/* Size and place do not matter but for the rounding of the coordinates: a power of two changes
 * nothing, 1e9 the last bits, an offset of 1e6 its rounding, 1.2e-10, times the sensitivity. */
START_TEST(scale_and_shift) {
  double u = lit(1, 0);
  ck_assert_double_eq_tol(lit(1e-9, 0) / u, 1, 1e-11);
  ck_assert_double_eq_tol(lit(1e9, 0) / u, 1, 1e-11);
  ck_assert_double_eq_tol(lit(1, 1e6) / u, 1, 1e-8);
}
END_TEST

/* The solution that is reported, on the crowded grid; owned. */
static double *reported(const struct deck_text *d, size_t *n, double *bound) {
  struct rad_case c;
  struct rad_error e;
  ck_assert_msg(deck_solve(d, &c, &e) == RAD_OK, "%s", e.text);
  ck_assert_msg(!c.adaptive.reason[0], "%s", c.adaptive.reason);
  *n = rad_grid_size(&c.scene, RAD_GRID_CROWDED);
  *bound = c.adaptive.bound * rad_indicator_scale(&c.adaptive.indicator, 1);
  double *value = malloc(*n * sizeof *value);
  ck_assert_int_eq(rad_grid_evaluate(&c, RAD_GRID_CROWDED, 1, value, &e), RAD_OK);
  rad_case_free(&c);
  return value;
}

/* Adaptive runs of a scene with two tolerances: the first bound holds against the second run. */
static void bounded(void (*scene)(struct deck_text *, const char *), double first, double second) {
  double *value[2], bound[2], most = 0;
  size_t n = 0;
  for (int k = 0; k < 2; k++) {
    struct deck_text d;
    char accuracy[60];
    snprintf(accuracy, sizeof accuracy, "accuracy: {tolerance: %g}", k ? second : first);
    scene(&d, accuracy);
    value[k] = reported(&d, &n, &bound[k]);
  }
  for (size_t i = 0; i < n; i++)
    most = fmax(most, fabs(value[0][i] - value[1][i]));
  ck_assert_msg(most <= bound[0] + bound[1], "apart by %g, bounds %g and %g", most, bound[0],
                bound[1]);
  free(value[0]);
  free(value[1]);
}

static void needle(struct deck_text *d, const char *how) {
  double w = tan(0.1 * M_PI / 180), c = cos(M_PI / 3), s = sin(M_PI / 3);
  deck_begin(d);
  deck_polygon(d, "lit", 3, (const double[][3]){{0, 0, 0}, {1, 0, 0}, {1, w, 0}}, 0.9, 1);
  deck_polygon(d, "dark", 3, (const double[][3]){{1, 0, 0}, {0, 0, 0}, {1, w * c, w * s}}, 0.9, 0);
  deck_add(d, "%s\n", how);
}

static void slit(struct deck_text *d, const char *how) {
  static const double v[5][3] = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, -1, 0}, {0.5, 0, 1}};
  static const int face[4][3] = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {1, 0, 4}};
  deck_begin(d);
  for (int f = 0; f < 4; f++) {
    double q[3][3];
    for (int c = 0; c < 3; c++)
      memcpy(q[c], v[face[f][c]], sizeof q[c]);
    deck_polygon(d, f ? "dark" : "lit", 3, (const double(*)[3])q, 0.9, f == 0);
  }
  deck_add(d, "%s\n", how);
}

/* The first: a bound of 0.018 stood beside an error of 0.25 before needles were cut into parts. */
START_TEST(needles_and_slits_are_bounded) {
  bounded(needle, 1e-2, 1e-3);
  bounded(slit, 1e-2, 1e-3);
}
END_TEST

/* Two unit squares 1e-6 apart: u is that of infinite plates, E/(1 - rho^2) and rho E/(1 - rho^2),
 * but for a strip of the gap's width at the rim, by which alone light escapes. */
START_TEST(close_plates) {
  struct deck_text d;
  struct rad_case c;
  struct rad_error e;
  double rho = 0.9, h = 1e-6;
  deck_begin(&d);
  deck_polygon(&d, "lit", 4, (const double[][3]){{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, rho,
               1);
  deck_polygon(&d, "dark", 4, (const double[][3]){{0, 1, h}, {1, 1, h}, {1, 0, h}, {0, 0, h}}, rho,
               0);
  deck_add(&d, "method: {mesh: graded, elements: 1, grading: 2, degree: 3}\n");
  ck_assert_msg(deck_solve(&d, &c, &e) == RAD_OK, "%s", e.text);
  double edge = surface_mean(&c, "lit", 0), far = surface_mean(&c, "dark", 0);
  ck_assert_double_eq_tol(edge * (1 - rho * rho), 1, 2e-3);
  ck_assert_double_eq_tol(far * (1 - rho * rho) / rho, 1, 2e-3);
  rad_case_free(&c);
}
END_TEST

int main(void) {
  Suite *s = suite_create("stability");
  TCase *c = tcase_create("closed forms");
  tcase_set_timeout(c, 600);
  tcase_add_test(c, lebesgue_constants);
  tcase_add_test(c, closed_scene);
  tcase_add_test(c, mean_square_of_known_functions);
  suite_add_tcase(s, c);
  TCase *v = tcase_create("verdicts");
  tcase_set_timeout(v, 600);
  tcase_add_test(v, biased_points_fail);
  tcase_add_test(v, equidistant_and_vertex_points);
  tcase_add_loop_test(v, gauss_points_hold, 0, 8);
  tcase_add_loop_test(v, vertices_hold, 0, 8);
  tcase_add_test(v, failing_points_are_not_silent);
  tcase_add_test(v, coarse_quadrature_is_not_silent);
  tcase_add_test(v, white_scenes);
  tcase_add_test(v, uniform_meshes_stop);
  tcase_add_test(v, scale_and_shift);
  tcase_add_test(v, needles_and_slits_are_bounded);
  tcase_add_test(v, close_plates);
  suite_add_tcase(s, v);
  return run_suite(s);
}
