/* Ask for an accuracy: the true error meets it, the bound holds, and the unknowns are few.
 *
 * True error: against a run with a far smaller tolerance, at points that crowd to 1e-6 at edges and
 * vertices. POLYRAD_TEST_FULL=1 runs all scenes and tolerances of docs/performance.md. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "adaptive_scenes.h"
#include "base/memory.h"
#include "estimate/adapt.h"
#include "suite.h"

/* ---- true errors ----------------------------------------------------------------------------- */

enum { SIDE = 11 };

/* u* at points that crowd at the edge and corner of every sub-triangle; returns their number. */
static int star(const struct rad_scene *s, const struct rad_adaptive *a, double **value) {
  static const double q[SIDE] = {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.03, 0.1, 0.25, 0.5, 0.8, 1};
  int n = s->n_triangle * RAD_N_SUB * SIDE * SIDE, at = 0;
  int *triangle = malloc(sizeof(int) * (size_t)n), *base = malloc(sizeof(int) * (size_t)n);
  double(*mu)[2] = malloc(sizeof *mu * (size_t)n), *u = malloc(sizeof *u * (size_t)n);
  for (int k = 0; k < s->n_triangle * RAD_N_SUB; k++) {
    struct rad_patch p;
    rad_patch_sub_triangle(s, k / RAD_N_SUB, k % RAD_N_SUB, RAD_ANGLE_POLAR, &p);
    for (int i = 0; i < SIDE * SIDE; i++, at++) {
      triangle[at] = p.triangle;
      base[at] = p.base;
      rad_patch_mu(&p, q[i % SIDE], q[i / SIDE], mu[at]);
    }
  }
  struct rad_point_list list = {n, triangle, base, (const double(*)[2])mu};
  struct rad_error e;
  ck_assert_int_eq(rad_irradiance_at(a->mesh, &a->rules, &list, 1, a->u, u, &e), RAD_OK);
  for (int i = 0; i < n; i++)
    u[i] = rad_emission(s, triangle[i], 0, base[i], mu[i]) + s->rho[triangle[i]] * u[i];
  free(triangle);
  free(base);
  free(mu);
  *value = u;
  return n;
}

static void adapt_with(const struct rad_scene *s, double tolerance, enum rad_matrix matrix,
                       struct rad_adaptive *a) {
  struct rad_goal goal = {
      .tolerance = tolerance, .matrix = matrix, .memory = rad_memory_available()};
  struct rad_error e;
  enum rad_code code = rad_adapt(s, &goal, a, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
  ck_assert_msg(a->reason[0] == 0, "tolerance %g not reached: %s", tolerance, a->reason);
  if (matrix != RAD_MATRIX_AUTO)
    ck_assert_int_eq(a->h2.mesh != NULL, matrix == RAD_MATRIX_HIERARCHICAL);
}

static void adapt(const struct rad_scene *s, double tolerance, struct rad_adaptive *a) {
  adapt_with(s, tolerance, RAD_MATRIX_AUTO, a);
}

static void hold(int scene, double reference, int n, const double *tolerance) {
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  struct rad_error e;
  struct rad_adaptive a;
  double *exact, *u, most = 0;
  const char *name = adaptive_scene(scene, d);
  enum rad_code code = deck_prepare(d, &c, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
  adapt(&c.scene, reference, &a);
  int points = star(&c.scene, &a, &exact);
  rad_adaptive_free(&a);
  for (int i = 0; i < points; i++)
    most = fmax(most, fabs(exact[i]));
  for (int t = 0; t < n; t++) {
    double error = 0;
    adapt(&c.scene, tolerance[t], &a);
    star(&c.scene, &a, &u);
    for (int i = 0; i < points; i++)
      error = fmax(error, fabs(u[i] - exact[i]) / most);
    if (getenv("POLYRAD_TEST_VERBOSE"))
      printf("%-14s tolerance %-6g unknowns %6d  true error %.2e  bound %.2e\n", name, tolerance[t],
             a.mesh->n_point, error, a.bound);
    ck_assert_msg(error <= tolerance[t], "%s: true error %g", name, error);
    ck_assert_msg(error <= a.bound + reference && a.bound <= 30 * error + reference,
                  "%s: bound %g, true error %g", name, a.bound, error);
    if (scene == 0)
      ck_assert_int_le(a.mesh->n_point, tolerance[t] >= 1e-3   ? 300
                                        : tolerance[t] >= 1e-6 ? 2000
                                                               : 6000);
    free(u);
    rad_adaptive_free(&a);
  }
  free(exact);
  rad_case_free(&c);
  free(d);
}

START_TEST(meets_tolerances) {
  static const double tolerance[] = {1e-2, 1e-3, 1e-4, 1e-6, 1e-8};
  int full = getenv("POLYRAD_TEST_FULL") != NULL, fine = _i == 0 || _i == 8;
  if (full)
    hold(_i, fine ? 5e-10 : 3e-8, fine ? 5 : 4, tolerance);
  else if (_i == 0)
    hold(_i, 1e-7, 4, tolerance);
  else
    hold(_i, _i < 8 ? 1e-5 : 1e-4, _i < 8 ? 2 : 1, tolerance);
}
END_TEST

/* ---- limits ---------------------------------------------------------------------------------- */

/* u of S1 with E = 1 and rho = .5 tends to 1.6 on every ray into the origin: the faces see three
 * quarters of each other's cones, u = 1 + .5 (3/4) u. */
START_TEST(vertex_limit) {
  static const double half[3] = {0.5, 0.5, 0.5}, one[3] = {1, 1, 1};
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  struct rad_error e;
  struct rad_adaptive a;
  deck_begin(d);
  three_faces(d, face_s1, half, one);
  ck_assert_int_eq(deck_prepare(d, &c, &e), RAD_OK);
  adapt(&c.scene, 1e-6, &a);
  int triangle[9], base[9] = {0};
  double mu[9][2], h[9];
  for (int i = 0; i < 9; i++) {
    double angle = M_PI / 2 * (i + 1) / 10, r = 1e-9;
    triangle[i] = 0;
    mu[i][0] = r * cos(angle);
    mu[i][1] = r * sin(angle);
  }
  struct rad_point_list list = {9, triangle, base, (const double(*)[2])mu};
  ck_assert_int_eq(rad_irradiance_at(a.mesh, &a.rules, &list, 1, a.u, h, &e), RAD_OK);
  for (int i = 0; i < 9; i++)
    ck_assert_msg(fabs(1 + 0.5 * h[i] - 1.6) <= 2e-6 * 1.6, "ray %d: u = %.9f", i, 1 + 0.5 * h[i]);
  rad_adaptive_free(&a);
  rad_case_free(&c);
  free(d);
}
END_TEST

/* At an edge u1 = E1 + rho1 ((1 + cos gamma)/2 u2 + rest): of two squares at 45 degrees nothing
 * else is seen, so the rest is 0. u approaches its limit like s^.46: s = 1e-18 leaves 1e-8. */
START_TEST(edge_limit) {
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  struct rad_error e;
  struct rad_adaptive a;
  adaptive_scene(4, d);
  ck_assert_int_eq(deck_prepare(d, &c, &e), RAD_OK);
  adapt(&c.scene, 1e-6, &a);
  double u[2][3];
  for (int side = 0; side < 2; side++)
    for (int i = 0; i < 3; i++) {
      double t = 0.15 + 0.3 * i,
             h; /* not 0.5, where sub-triangles meet: 1e-18 is below its rounding */
      int low = 0;
      for (int k = 0; k < c.scene.n_triangle;
           k++) { /* the triangle of that side on the edge x = z = 0 */
        const struct rad_triangle *tri = &c.scene.triangle[k];
        int on = 0;
        for (int v = 0; v < 3; v++)
          on += tri->v[v][0] == 0 && tri->v[v][2] == 0;
        if (on == 2 && tri->surface == side)
          low = k;
      }
      const struct rad_triangle *tri = &c.scene.triangle[low];
      int base = 0;
      while (!(tri->v[base][0] == 0 && tri->v[base][1] == 0))
        base++;
      int next_on_edge = tri->v[(base + 1) % 3][0] == 0 && tri->v[(base + 1) % 3][2] == 0;
      double mu[1][2] = {{next_on_edge ? t : 1e-18, next_on_edge ? 1e-18 : t}};
      struct rad_point_list list = {1, &low, &base, (const double(*)[2])mu};
      ck_assert_int_eq(rad_irradiance_at(a.mesh, &a.rules, &list, 1, a.u, &h, &e), RAD_OK);
      u[side][i] = rad_emission(&c.scene, low, 0, base, mu[0]) + 0.9 * h;
    }
  double slack = 2 * a.bound_limit * a.indicator.scale[0], half = 0.5 * (1 + cos(M_PI / 4));
  ck_assert_double_lt(slack, 0.01);
  for (int i = 0; i < 3; i++) {
    ck_assert_msg(fabs(u[0][i] - (1 + 0.9 * half * u[1][i])) <= slack, "low: %.9f %.9f", u[0][i],
                  u[1][i]);
    ck_assert_msg(fabs(u[1][i] - 0.9 * half * u[0][i]) <= slack, "high: %.9f %.9f", u[0][i],
                  u[1][i]);
  }
  rad_adaptive_free(&a);
  rad_case_free(&c);
  free(d);
}
END_TEST

/* u* at random points of every triangle. */
static double *star_at_random(const struct rad_scene *s, const struct rad_adaptive *a, int each) {
  int n = s->n_triangle * each;
  int *triangle = malloc(sizeof(int) * (size_t)n), *base = calloc((size_t)n, sizeof(int));
  double(*mu)[2] = malloc(sizeof *mu * (size_t)n), *u = malloc(sizeof *u * (size_t)n);
  srand48(2003);
  for (int i = 0; i < n; i++) {
    double x = drand48(), y = drand48();
    triangle[i] = i / each;
    mu[i][0] = x + y > 1 ? 1 - x : x;
    mu[i][1] = x + y > 1 ? 1 - y : y;
  }
  struct rad_point_list list = {n, triangle, base, (const double(*)[2])mu};
  struct rad_error e;
  ck_assert_int_eq(rad_irradiance_at(a->mesh, &a->rules, &list, 1, a->u, u, &e), RAD_OK);
  rad_iterated(s, &list, u, u);
  free(triangle);
  free(base);
  free(mu);
  return u;
}

/* A triangle in general position between two squares: kinks along its shadow's borders. */
START_TEST(shadows) {
  static const double tolerance[] = {1e-2, 1e-3, 1e-4, 3e-5}, reference = 3e-6;
  enum { EACH = 400 };
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  struct rad_error e;
  struct rad_adaptive a;
  double most = 0;
  blocker_scene(d);
  ck_assert_int_eq(deck_prepare(d, &c, &e), RAD_OK);
  ck_assert_int_gt((int)c.visibility.n_partly, 0);
  adapt(&c.scene, reference, &a);
  double *exact = star_at_random(&c.scene, &a, EACH);
  rad_adaptive_free(&a);
  for (int i = 0; i < c.scene.n_triangle * EACH; i++)
    most = fmax(most, exact[i]);
  for (int t = 0; t < 4; t++) {
    adapt(&c.scene, tolerance[t], &a);
    double *u = star_at_random(&c.scene, &a, EACH), error = 0;
    for (int i = 0; i < c.scene.n_triangle * EACH; i++)
      error = fmax(error, fabs(u[i] - exact[i]) / most);
    ck_assert_msg(error <= tolerance[t] && error <= a.bound && a.bound <= 30 * error,
                  "tolerance %g: true error %g, bound %g", tolerance[t], error, a.bound);
    free(u);
    rad_adaptive_free(&a);
  }
  free(exact);
  rad_case_free(&c);
  free(d);
}
END_TEST

/* The same goals with the hierarchical matrix. What compression does is in the bound. */
START_TEST(hierarchical) {
  static const struct {
    int scene; /* -1: blocker */
    double tolerance, reference;
  } run[] = {{0, 1e-6, 1e-7}, {1, 1e-3, 2e-5}, {8, 1e-3, 2e-5}, {9, 1e-2, 1e-3}, {-1, 1e-4, 3e-6}};
  enum { EACH = 200 };
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  struct rad_error e;
  struct rad_adaptive a;
  double most = 0, error = 0, tolerance = run[_i].tolerance;
  if (run[_i].scene < 0)
    blocker_scene(d);
  else
    adaptive_scene(run[_i].scene, d);
  ck_assert_int_eq(deck_prepare(d, &c, &e), RAD_OK);
  adapt(&c.scene, run[_i].reference, &a);
  double *exact = star_at_random(&c.scene, &a, EACH);
  rad_adaptive_free(&a);
  adapt_with(&c.scene, tolerance, RAD_MATRIX_HIERARCHICAL, &a);
  double *u = star_at_random(&c.scene, &a, EACH);
  for (int i = 0; i < c.scene.n_triangle * EACH; i++) {
    most = fmax(most, exact[i]);
    error = fmax(error, fabs(u[i] - exact[i]));
  }
  if (getenv("POLYRAD_TEST_VERBOSE"))
    printf("scene %d, hierarchical: %d unknowns, true error %.2e, bound %.2e, compression %.1e\n",
           run[_i].scene, a.mesh->n_point, error / most, a.bound, a.h2.error);
  ck_assert_msg(error <= tolerance * most && error <= (a.bound + run[_i].reference) * most,
                "true error %g, bound %g", error / most, a.bound);
  ck_assert(a.bound >= a.h2.error && a.h2.error <= 0.1 * tolerance);
  free(u);
  free(exact);
  rad_adaptive_free(&a);
  rad_case_free(&c);
  free(d);
}
END_TEST

/* A mesh by hand of any size has a bound, with what its compression does in it. */
START_TEST(bound_by_hand) {
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  struct rad_error e;
  struct rad_adaptive a;
  double *exact, *u, error = 0, most = 0;
  adaptive_scene(0, d);
  deck_add(d,
           "accuracy: {tolerance: 1e-2}\n"
           "method: {mesh: paper, elements: 9, degree: 1, matrix: hierarchical}\n");
  ck_assert_int_eq(deck_solve(d, &c, &e), RAD_OK);
  ck_assert(c.has_bound && c.mesh->n_point > 5000 && c.h2.error > 0);
  adapt(&c.scene, 1e-5, &a);
  int n = star(&c.scene, &a, &exact);
  struct rad_adaptive hand = {.mesh = c.mesh, .rules = c.rules, .u = c.u};
  star(&c.scene, &hand, &u);
  for (int i = 0; i < n; i++) {
    most = fmax(most, exact[i]);
    error = fmax(error, fabs(u[i] - exact[i]));
  }
  error /= most;
  ck_assert_msg(error <= c.adaptive.bound + 1e-5 && c.adaptive.bound <= 30 * error,
                "true error %g, bound %g", error, c.adaptive.bound);
  ck_assert_double_ge(c.adaptive.bound, c.h2.error);
  free(u);
  free(exact);
  rad_adaptive_free(&a);
  rad_case_free(&c);
  free(d);
}
END_TEST

/* Black faces have no rows, unlit ones no light: the rest is as before. */
START_TEST(black_and_unlit_faces) {
  static const double rho[3] = {0, 0.5, 0.5}, emission[3] = {1, 0, 0};
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case adaptive, paper;
  struct rad_error e;
  deck_begin(d);
  three_faces(d, face_s1, rho, emission);
  deck_polygon(d, "away", 3, (const double[3][3]){{5, 5, 5}, {6, 5, 5}, {5, 6, 5}}, 0.5, 0);
  int head = d->length;
  deck_add(d, "accuracy: {tolerance: 1e-5}\n");
  ck_assert_int_eq(deck_solve(d, &adaptive, &e), RAD_OK);
  d->length = head;
  deck_add(d, "method: {mesh: graded, grading: 3, degree: 7, elements: 1}\n");
  ck_assert_int_eq(deck_solve(d, &paper, &e), RAD_OK);
  ck_assert(adaptive.adaptive.layout.passive[0] && adaptive.adaptive.layout.passive[3]);
  static const char *const name[] = {"one", "two", "three", "away"};
  for (int f = 0; f < 4; f++)
    for (int h = 0; h < 2; h++)
      ck_assert_double_eq_tol(surface_mean(&adaptive, name[f], h), surface_mean(&paper, name[f], h),
                              1e-5);
  rad_case_free(&adaptive);
  rad_case_free(&paper);
  free(d);
}
END_TEST

/* A tolerance below what doubles allow, or memory: the best result, and the reason. */
START_TEST(unreachable) {
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  struct rad_error e;
  struct rad_adaptive a;
  adaptive_scene(0, d);
  ck_assert_int_eq(deck_prepare(d, &c, &e), RAD_OK);
  struct rad_goal memory = {.tolerance = 1e-9, .memory = 3e7};
  ck_assert_int_eq(rad_adapt(&c.scene, &memory, &a, &e), RAD_OK);
  ck_assert_msg(strstr(a.reason, "memory"), "reason: %s", a.reason);
  ck_assert(a.bound > 1e-9 && a.bound < 1e-2 && a.mesh->n_point > 100);
  rad_adaptive_free(&a);
  struct rad_goal rounding = {.tolerance = 1e-3, .quadrature_tolerance = 1e-2, .memory = 1e9};
  ck_assert_int_eq(rad_adapt(&c.scene, &rounding, &a, &e), RAD_OK);
  ck_assert_msg(strstr(a.reason, "inner tolerances"), "reason: %s", a.reason);
  rad_adaptive_free(&a);
  rad_case_free(&c);
  free(d);
}
END_TEST

int main(void) {
  Suite *s = suite_create("adaptive");
  TCase *c = tcase_create("adaptive");
  tcase_set_timeout(c, 1800);
  tcase_add_loop_test(c, meets_tolerances, 0, N_ADAPTIVE_SCENE);
  tcase_add_test(c, vertex_limit);
  tcase_add_test(c, edge_limit);
  tcase_add_test(c, shadows);
  tcase_add_test(c, black_and_unlit_faces);
  tcase_add_test(c, unreachable);
  suite_add_tcase(s, c);
  c = tcase_create("hierarchical");
  tcase_set_timeout(c, 1800);
  tcase_add_loop_test(c, hierarchical, 0, 5);
  tcase_add_test(c, bound_by_hand);
  suite_add_tcase(s, c);
  return run_suite(s);
}
