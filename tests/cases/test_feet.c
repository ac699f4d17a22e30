/* Something small close to a large face: the bound holds, and runs reach their tolerance.
 *
 * True error: against the same scene with its floor cut into a grid that is fine below the object,
 * a mesh for which nothing is small, at a far smaller tolerance; at points around the feet and on
 * the object. POLYRAD_TEST_FULL=1: a survey of many random scenes. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec.h"
#include "estimate/adapt.h"
#include "scene_text.h"
#include "suite.h"

/* ---- scenes ---------------------------------------------------------------------------------- */

/* A parallelogram over the floor, its first corner at a height, and what the surfaces are. */
struct object {
  double at[2], height, side[2][3];
  double rho, emission, floor_rho, floor_emission;
  int ceiling; /* a reflecting square at .5 as well */
};

static void corner_of(const struct object *o, int i, double x[3]) {
  static const int first[4] = {0, 1, 1, 0}, second[4] = {0, 0, 1, 1};
  for (int d = 0; d < 3; d++)
    x[d] = (d < 2 ? o->at[d] : o->height) + first[i] * o->side[0][d] + second[i] * o->side[1][d];
}

static int by_size(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

enum { LINES = 40 };

/* Lines of the floor's grid in one direction: around the object at distances that grow from its
 * height on, and through it. */
static int lines(const struct object *o, int d, double line[LINES]) {
  double low = 1, high = 0, x[3];
  int n = 0, kept = 0;
  for (int i = 0; i < 4; i++) {
    corner_of(o, i, x);
    low = fmin(low, x[d]);
    high = fmax(high, x[d]);
  }
  line[n++] = 0;
  line[n++] = 1;
  line[n++] = 0.5 * (low + high);
  for (double step = 0; step < 1; step = step > 0 ? 8 * step : 0.7 * o->height) {
    line[n++] = low - step;
    line[n++] = high + step;
  }
  qsort(line, (size_t)n, sizeof *line, by_size);
  for (int i = 0; i < n; i++)
    if (line[i] >= 0 && line[i] <= 1 && (!kept || line[i] > line[kept - 1] + 1e-9))
      line[kept++] = line[i];
  return kept;
}

static void add_scene(struct deck_text *d, const struct object *o, int cut) {
  static const double up[4][3] = {{0, 0, 0.5}, {0, 1, 0.5}, {1, 1, 0.5}, {1, 0, 0.5}};
  double x[LINES] = {0, 1}, y[LINES] = {0, 1}, object[4][3];
  int nx = cut ? lines(o, 0, x) : 2, ny = cut ? lines(o, 1, y) : 2;
  deck_begin(d);
  for (int j = 0; j + 1 < ny; j++)
    for (int i = 0; i + 1 < nx; i++) {
      double c[4][3] = {
          {x[i], y[j], 0}, {x[i + 1], y[j], 0}, {x[i + 1], y[j + 1], 0}, {x[i], y[j + 1], 0}};
      deck_polygon(d, "floor", 4, (const double(*)[3])c, o->floor_rho, o->floor_emission);
    }
  for (int i = 0; i < 4; i++)
    corner_of(o, i, object[i]);
  deck_polygon(d, "object", 4, (const double(*)[3])object, o->rho, o->emission);
  if (o->ceiling)
    deck_polygon(d, "ceiling", 4, up, 0.9, 0);
}

/* ---- errors ---------------------------------------------------------------------------------- */

enum { POINTS = 160 };

static unsigned state;

static double uniform(double low, double high) {
  state = state * 1664525u + 1013904223u;
  return low + (high - low) * (state / 4294967296.0);
}

/* Points below the object and around, as wide as it is high, and on the object. */
static void set_points(const struct object *o, double x[POINTS][3]) {
  for (int k = 0; k < POINTS; k++) {
    double s = k % 5 ? uniform(0.001, 0.999) : k % 2, t = k % 7 ? uniform(0.001, 0.999) : k % 3 > 1;
    double spread = pow(10, uniform(-1, 1)) * o->height * (k % 4 > 0);
    for (int d = 0; d < 3; d++)
      x[k][d] = (d < 2 ? o->at[d] : o->height) + s * o->side[0][d] + t * o->side[1][d];
    if (k % 3 == 0 && o->rho > 0 && k % 5 && k % 7)
      continue;
    for (int d = 0; d < 2; d++)
      x[k][d] = fmin(fmax(x[k][d] + spread * uniform(-1, 1), 1e-6), 1 - 1e-6);
    x[k][2] = 0;
  }
}

static void star(const struct rad_case *c, const struct rad_adaptive *a, double x[POINTS][3],
                 double *u) {
  int triangle[POINTS], base[POINTS];
  double mu[POINTS][2];
  struct rad_error e;
  for (int k = 0; k < POINTS; k++) {
    struct rad_place best = {.off = INFINITY};
    for (int t = 0; t < c->scene.n_triangle; t++) {
      struct rad_place p = rad_place_in(&c->scene, t, x[k]);
      best = p.off < best.off ? p : best;
    }
    triangle[k] = best.triangle;
    base[k] = best.base;
    memcpy(mu[k], best.mu, sizeof mu[k]);
  }
  struct rad_point_list list = {POINTS, triangle, base, (const double(*)[2])mu};
  ck_assert_int_eq(rad_irradiance_at(a->mesh, &a->rules, &list, 1, a->u, u, &e), RAD_OK);
  rad_iterated(&c->scene, &list, u, u);
}

/* Run and evaluate; returns max |u*|. */
static double run(const struct object *o, int cut, double tolerance, double x[POINTS][3], double *u,
                  struct rad_adaptive *a) {
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  struct rad_error e;
  struct rad_goal goal = {.tolerance = tolerance, .memory = rad_memory_available()};
  add_scene(d, o, cut);
  enum rad_code code = deck_prepare(d, &c, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
  code = rad_adapt(&c.scene, &goal, a, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
  star(&c, a, x, u);
  double scale = rad_indicator_scale(&a->indicator, 1);
  rad_case_free(&c);
  free(d);
  return scale;
}

/* The worst of error - bound and of error - tolerance, both to be below 0. */
static void hold_one(const char *name, const struct object *o, double tolerance, double reference,
                     double scale, double x[POINTS][3], const double *exact) {
  struct rad_adaptive a;
  double u[POINTS], error = 0;
  run(o, 0, tolerance, x, u, &a);
  for (int k = 0; k < POINTS; k++)
    error = fmax(error, fabs(u[k] - exact[k]) / scale);
  if (getenv("POLYRAD_TEST_VERBOSE"))
    printf("%-14s height %-6g tolerance %-6g levels %d unknowns %5d  error %.2e  bound %.2e\n",
           name, o->height, tolerance, a.levels, a.mesh->n_point, error, a.bound);
  ck_assert_msg(a.reason[0] == 0, "%s, height %g: %s", name, o->height, a.reason);
  ck_assert_msg(error <= a.bound + reference && error <= tolerance,
                "%s, height %g: error %g, bound %g", name, o->height, error, a.bound);
  rad_adaptive_free(&a);
}

static void hold(const char *name, const struct object *o, int cut, double reference, int n,
                 const double *tolerance) {
  struct rad_adaptive fine;
  double x[POINTS][3], exact[POINTS];
  set_points(o, x);
  double scale = run(o, cut, reference, x, exact, &fine);
  ck_assert_msg(fine.reason[0] == 0, "%s: reference: %s", name, fine.reason);
  for (int i = 0; i < n; i++)
    hold_one(name, o, tolerance[i], reference, scale, x, exact);
  rad_adaptive_free(&fine);
}

static const double height[] = {0.1, 0.03, 0.01, 0.003, 0.001};

static const struct {
  const char *name;
  struct object object;
  int cut, wide; /* cut: the reference has a grid; a strip that lies across has none */
} scene[] = {
    {"lamp", {{0.37, 0.42}, 0, {{0, 0.01, 0}, {0.01, 0, 0}}, 0.9, 1, 0.9, 0, 0}, 1, 0},
    {"reflector", {{0.61, 0.3}, 0, {{0, 0.02, 0}, {0.015, 0, 0}}, 0.9, 0, 0.5, 1, 0}, 1, 0},
    {"black lamp", {{0.2, 0.7}, 0, {{0, 0.03, 0}, {0.02, 0.01, 0}}, 0, 1, 0.8, 0, 1}, 1, 0},
    {"tilted lamp", {{0.5, 0.5}, 0, {{0, 0.03, 0.01}, {0.02, 0, 0.03}}, 0.7, 1, 0.8, 0, 0}, 1, 0},
    {"plate", {{0.3, 0.35}, 0, {{0, 0.3, 0}, {0.4, 0, 0}}, 0.8, 1, 0.8, 0, 0}, 1, 1},
    {"strip", {{0.2, 0.3}, 0, {{0.01, 0.02, 0}, {0.4, -0.2, 0}}, 0.8, 1, 0.8, 0, 0}, 0, 1},
};

enum { N_HEIGHT = sizeof height / sizeof *height, N_SCENE = sizeof scene / sizeof *scene };

START_TEST(close_objects) {
  struct object o = scene[_i / N_HEIGHT].object;
  int wide = scene[_i / N_HEIGHT].wide; /* needs thousands of unknowns when it is close */
  double lowest = wide ? 0.03 : _i < N_HEIGHT ? 0.001 : 0.003; /* that does not take long */
  o.height = height[_i % N_HEIGHT];
  if (o.height < lowest && !getenv("POLYRAD_TEST_FULL"))
    return;
  state = 2003;
  double reference = wide ? 1e-4 : 3e-5;
  hold(scene[_i / N_HEIGHT].name, &o, scene[_i / N_HEIGHT].cut, reference, 2,
       (const double[]){1e-2, 1e-3});
}
END_TEST

/* A mesh by hand that has no points near the foot: its bound knows. */
START_TEST(by_hand) {
  struct object o = scene[0].object;
  struct deck_text *d = malloc(sizeof *d);
  struct rad_adaptive fine;
  struct rad_case c;
  struct rad_error e;
  double x[POINTS][3], exact[POINTS], u[POINTS], error = 0;
  o.height = height[_i];
  state = 2003;
  set_points(&o, x);
  double scale = run(&o, 1, 1e-4, x, exact, &fine);
  add_scene(d, &o, 0);
  deck_add(d, "accuracy: {tolerance: 1e-2}\nmethod: {mesh: paper, elements: 3, degree: 1}\n");
  ck_assert_int_eq(deck_solve(d, &c, &e), RAD_OK);
  struct rad_adaptive hand = {.mesh = c.mesh, .rules = c.rules, .u = c.u};
  star(&c, &hand, x, u);
  for (int k = 0; k < POINTS; k++)
    error = fmax(error, fabs(u[k] - exact[k]) / scale);
  if (getenv("POLYRAD_TEST_VERBOSE"))
    printf("by hand, height %g: error %.2e, bound %.2e\n", o.height, error, c.adaptive.bound);
  ck_assert_msg(error <= c.adaptive.bound + 1e-4, "height %g: error %g, bound %g", o.height, error,
                c.adaptive.bound);
  rad_adaptive_free(&fine);
  rad_case_free(&c);
  free(d);
}
END_TEST

/* Scenes of the survey in which bounds were too small before, or are near their errors. */
static const int chosen[] = {2, 3, 11, 20, 35, 50, 70, 88};

/* Any object, anywhere, at any height and tolerance. */
START_TEST(survey) {
  int k = getenv("POLYRAD_TEST_FULL") ? _i : chosen[_i];
  state = (unsigned)(2003 + 7919 * k);
  uniform(0, 1);
  struct object o = {.at = {uniform(0.1, 0.85), uniform(0.1, 0.85)},
                     .height = pow(10, uniform(-3, -1)),
                     .rho = uniform(0, 0.95),
                     .emission = k % 3 ? 1 : 0,
                     .floor_rho = uniform(0.1, 0.95),
                     .floor_emission = k % 3 ? 0 : 1,
                     .ceiling = k % 4 == 1};
  double size = pow(10, uniform(-2.5, -1)), turn = uniform(0, 2 * M_PI), ratio = uniform(0.3, 1);
  double tilt = k % 2 ? uniform(0, 1) * size : 0;
  double side[2][3] = {{size * sin(turn), size * cos(turn), 0},
                       {ratio * size * cos(turn), -ratio * size * sin(turn), tilt}};
  char name[16];
  snprintf(name, sizeof name, "survey %d", k);
  memcpy(o.side, side, sizeof side);
  double tolerance = pow(10, uniform(-3, -1.5));
  hold(name, &o, 1, 1e-4, 1, &tolerance);
}
END_TEST

int main(void) {
  Suite *s = suite_create("feet");
  TCase *c = tcase_create("close"), *random = tcase_create("survey");
  tcase_set_timeout(c, 3600);
  tcase_set_timeout(random, 3600);
  tcase_add_loop_test(c, close_objects, 0, N_HEIGHT * N_SCENE);
  tcase_add_loop_test(c, by_hand, 1, N_HEIGHT);
  tcase_add_loop_test(random, survey, 0,
                      getenv("POLYRAD_TEST_FULL") ? 400 : (int)(sizeof chosen / sizeof *chosen));
  suite_add_tcase(s, c);
  suite_add_tcase(s, random);
  return run_suite(s);
}
