/* The picture obeys the bound at every stored point, edges and vertices included, and shows bright
 * spots. What is right is known: u = 1 in closed rooms with E = 1 - rho, and Lambert's formula. */
#include <check.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/picture.h"
#include "base/vec.h"
#include "scene_text.h"
#include "suite.h"

/* ---- random numbers, motions -------------------------------------------------------------------
 */

static uint64_t state;

static double uniform(double low, double high) {
  state = state * 6364136223846793005u + 1442695040888963407u;
  return low + (high - low) * (double)(state >> 11) * 0x1p-53;
}

struct turn {
  double axis[3][3], shift[3];
};

/* Any orientation by Gram and Schmidt; shift in each direction up to `far`. */
static struct turn random_turn(double size, double far) {
  struct turn t;
  for (int i = 0; i < 2; i++) {
    for (int d = 0; d < 3; d++)
      t.axis[i][d] = uniform(-1, 1);
    double along = i ? rad_dot(t.axis[1], t.axis[0]) : 0;
    for (int d = 0; d < 3 && i; d++)
      t.axis[1][d] -= along * t.axis[0][d];
    double length = rad_norm(t.axis[i]);
    for (int d = 0; d < 3; d++)
      t.axis[i][d] /= length;
  }
  rad_cross(t.axis[0], t.axis[1], t.axis[2]);
  for (int i = 0; i < 3; i++) {
    for (int d = 0; d < 3; d++)
      t.axis[i][d] *= size;
    t.shift[i] = uniform(-far, far);
  }
  return t;
}

static void move(const struct turn *t, const double x[3], double y[3]) {
  for (int d = 0; d < 3; d++)
    y[d] = t->shift[d] + x[0] * t->axis[0][d] + x[1] * t->axis[1][d] + x[2] * t->axis[2][d];
}

/* A triangle, moved, from any of its vertices. */
static void add_triangle(struct deck_text *deck, const struct turn *turn, const double *const v[3],
                         double rho, double emission) {
  double corner[3][3];
  int first = (int)uniform(0, 3);
  for (int i = 0; i < 3; i++)
    move(turn, v[(first + i) % 3], corner[i]);
  deck_polygon(deck, "room", 3, (const double(*)[3])corner, rho, emission);
}

/* A convex prism over a polygon of the plane z = 0, from inside; face f: 0 floor, 1 ceiling, then
 * the sides. Some of its triangles are black, if `black` says so; E = 1 - rho. */
static void add_prism(struct deck_text *deck, const struct turn *turn, int n,
                      const double (*polygon)[2], double height, double rho, double black) {
  double low[8][3], high[8][3];
  for (int i = 0; i < n; i++)
    for (int d = 0; d < 2; d++) {
      low[i][d] = high[i][d] = polygon[i][d];
      low[i][2] = 0;
      high[i][2] = height;
    }
  for (int i = 0; i < n; i++) {
    int j = (i + 1) % n;
    const double *const list[4][3] = {{low[i], low[j], high[j]},
                                      {low[i], high[j], high[i]},
                                      {low[0], low[i], low[j]},
                                      {high[0], high[j], high[i]}};
    for (int k = 0; k < (i > 0 && j > 0 ? 4 : 2); k++) {
      double reverse = uniform(0, 1) < black ? 0 : rho;
      const double *const inward[3] = {list[k][0], list[k][k < 2 ? 2 : 1], list[k][k < 2 ? 1 : 2]};
      add_triangle(deck, turn, inward, reverse, 1 - reverse);
    }
  }
}

/* ---- what is stored ----------------------------------------------------------------------------
 */

static void solve(const struct deck_text *d, struct rad_case *c, struct rad_result *r) {
  struct rad_error e;
  enum rad_code code = deck_solve(d, c, &e);
  if (!code)
    code = rad_case_result(c, "test", r, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
}

static void release(struct rad_case *c, struct rad_result *r) {
  rad_result_free(r);
  rad_case_free(c);
}

/* u = 1 within the bound of the run, and of the cell; h = 1 within as much over the least rho that
 * is not 0. */
static void expect_one(const struct rad_case *c, const struct rad_result *r, double rho,
                       const char *what) {
  const struct rad_picture *p = &r->picture;
  double limit = r->diagnostics.error_bound_limit;
  ck_assert_double_lt(limit, 10 * c->tolerance);
  ck_assert_int_gt(p->n_point, 0);
  for (int64_t k = 0; k < p->n_cell; k++)
    for (int64_t m = p->offset[k]; m < p->offset[k + 1]; m++) {
      int64_t i = p->connectivity[m];
      double error = fabs(p->radiosity[i] - 1), light = fabs(p->irradiance[i] - 1);
      ck_assert_msg(error <= limit, "%s: point %d: error %g, bound %g", what, (int)i, error, limit);
      ck_assert_msg(error <= p->bound[k] + DBL_EPSILON, "%s: point %d: error %g, bound of cell %g",
                    what, (int)i, error, p->bound[k]);
      ck_assert_msg(light <= limit / rho, "%s: point %d: irradiance off by %g, %g allowed", what,
                    (int)i, light, limit / rho);
    }
  for (int i = 0; i < c->deck.n_probe; i++) {
    double off = fabs(r->probe_irradiance[i] - 1);
    ck_assert_msg(fabs(r->probe_radiosity[i] - 1) <= limit, "%s: probe %d: %.12g", what, i,
                  r->probe_radiosity[i]);
    ck_assert_msg(off <= r->probe_error_irradiance[i],
                  "%s: probe %d: irradiance off by %g, said %g", what, i, off,
                  r->probe_error_irradiance[i]);
    ck_assert_double_le(r->probe_error_irradiance[i], limit / rho);
  }
}

/* ---- closed rooms ------------------------------------------------------------------------------
 */

/* The input that failed, with probes in the middles of its edges: 4e-5 off, the bound 6e-7. */
START_TEST(cube_that_failed) {
  static const double square[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  static const double middle[6][3] = {{.5, 0, 0}, {1, .5, 0}, {0, 0, .5},
                                      {1, 1, .5}, {.5, 1, 1}, {0, .5, 1}};
  struct turn turn = {.axis = {{0.7648421872844883, 0.6442176872376911, 0},
                               {-0.5933637833613874, 0.7044663052755918, 0.3894183423086505},
                               {0.2508701838500143, -0.2978435767000479, 0.9210609940028851}},
                      .shift = {.3, .3, .3}};
  struct deck_text deck;
  struct rad_case c;
  struct rad_result r;
  state = 1;
  deck_begin(&deck);
  add_prism(&deck, &turn, 4, square, 1, 0.9, 0);
  deck_add(&deck, "accuracy: {tolerance: 1e-6}\nprobes:\n");
  for (int i = 0; i < 6; i++) {
    double at[3];
    move(&turn, middle[i], at);
    deck_add(&deck, "  - {at: [%.17g, %.17g, %.17g]}\n", at[0], at[1], at[2]);
  }
  solve(&deck, &c, &r);
  expect_one(&c, &r, 0.9, "cube");
  release(&c, &r);
}
END_TEST

/* Boxes of any size and place, turned, with black faces among the others. */
START_TEST(closed_rooms) {
  double x, y, size, far, rho, black, tolerance;
  struct deck_text deck;
  struct rad_case c;
  struct rad_result r;
  char what[128];
  state = 1000 + (uint64_t)_i;
  size = pow(10, uniform(-3, 3));
  far = _i % 3 ? size * pow(10, uniform(-1, 3)) : 0;
  x = pow(10, uniform(-.5, .5));
  y = pow(10, uniform(-.5, .5));
  rho = uniform(0.2, 0.95);
  black = _i % 2 ? 0.3 : 0;
  tolerance = pow(10, uniform(-6, -3));
  const double floor[4][2] = {{0, 0}, {x, 0}, {x, y}, {0, y}};
  struct turn turn = random_turn(size, far);
  deck_begin(&deck);
  add_prism(&deck, &turn, 4, floor, 1, rho, black);
  deck_add(&deck, "accuracy: {tolerance: %g}\noutput: {sampling: %d, cells: %s}\n", tolerance,
           1 + (int)uniform(0, 6), _i % 5 ? "linear" : "lagrange");
  snprintf(what, sizeof what, "room %d, size %.2g, from 0 by %.2g, rho %.2f", _i, size, far, rho);
  solve(&deck, &c, &r);
  expect_one(&c, &r, rho, what);
  release(&c, &r);
}
END_TEST

/* A wedge of 4 degrees, and of 30, closed by a third side: the same at its sharp edge. */
START_TEST(wedges) {
  double half = (_i < 2 ? 4 : 30) * M_PI / 360;
  const double section[3][2] = {{0, 0}, {cos(half), -sin(half)}, {cos(half), sin(half)}};
  struct deck_text deck;
  struct rad_case c;
  struct rad_result r;
  state = 77 + (uint64_t)_i;
  struct turn turn = random_turn(1, _i % 2 ? 30 : 0);
  deck_begin(&deck);
  add_prism(&deck, &turn, 3, section, 0.5, 0.8, _i % 2 ? 0.3 : 0);
  deck_add(&deck, "accuracy: {tolerance: 1e-4}\n");
  solve(&deck, &c, &r);
  expect_one(&c, &r, 0.8, "wedge");
  release(&c, &r);
}
END_TEST

/* ---- Lambert's formula -------------------------------------------------------------------------
 */

/* Form factor of a triangle from x with normal n, the part above the horizon. */
static double lambert(const double (*v)[3], const double x[3], const double n[3]) {
  double corner[4][3], sum = 0;
  int count = 0;
  for (int i = 0; i < 3; i++) {
    double a[3], b[3];
    rad_sub(v[i], x, a);
    rad_sub(v[(i + 1) % 3], x, b);
    double ha = rad_dot(a, n), hb = rad_dot(b, n);
    if (ha >= 0)
      memcpy(corner[count++], a, sizeof a);
    if (ha * hb < 0) {
      for (int d = 0; d < 3; d++)
        corner[count][d] = a[d] + ha / (ha - hb) * (b[d] - a[d]);
      count++;
    }
  }
  for (int i = 0; i < count; i++) {
    double turn[3], *a = corner[i], *b = corner[(i + 1) % count];
    rad_cross(a, b, turn);
    double length = rad_norm(turn);
    if (length > 0)
      sum += atan2(length, rad_dot(a, b)) * rad_dot(turn, n) / length;
  }
  return fabs(sum) / (2 * M_PI);
}

/* The same of a triangle whose radiosity is linear, from its values at the vertices: quartered
 * `depth` times, then constant. */
static double lambert_linear(const double (*v)[3], const double u[3], const double x[3],
                             const double n[3], int depth) {
  double middle[3][3], at[3], sum = 0;
  if (depth == 0)
    return (u[0] + u[1] + u[2]) / 3 * lambert(v, x, n);
  for (int c = 0; c < 3; c++) {
    int next = (c + 1) % 3;
    at[c] = 0.5 * (u[c] + u[next]);
    for (int d = 0; d < 3; d++)
      middle[c][d] = 0.5 * (v[c][d] + v[next][d]);
  }
  for (int c = 0; c < 3; c++) {
    double part[3][3];
    const double values[3] = {u[c], at[c], at[(c + 2) % 3]};
    memcpy(part[0], v[c], sizeof part[0]);
    memcpy(part[1], middle[c], sizeof part[1]);
    memcpy(part[2], middle[(c + 2) % 3], sizeof part[2]);
    sum += lambert_linear((const double(*)[3])part, values, x, n, depth - 1);
  }
  return sum + lambert_linear((const double(*)[3])middle, at, x, n, depth - 1);
}

/* Nearest vertex of a triangle [m]. */
static double to_vertex(const struct rad_triangle *t, const double x[3]) {
  double least = INFINITY, to[3];
  for (int c = 0; c < 3; c++) {
    rad_sub(t->v[c], x, to);
    least = fmin(least, rad_norm(to));
  }
  return least;
}

/* One face of a black room shines: irradiance at all points but vertices, where it has none. The
 * limit at edges: 1e-9 inside. */
START_TEST(black_rooms) {
  static const double square[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  struct deck_text deck;
  struct rad_case c;
  struct rad_result r;
  struct rad_error e;
  state = 500 + (uint64_t)_i;
  struct turn turn = random_turn(1, _i % 2 ? 10 : 0);
  deck_begin(&deck);
  add_prism(&deck, &turn, 4, square, 1, 0, 0);
  deck_add(&deck, "accuracy: {tolerance: 1e-6}\n");
  ck_assert_int_eq(deck_prepare(&deck, &c, &e), RAD_OK);
  int lamp = (int)uniform(0, 12);
  for (int t = 0; t < c.scene.n_triangle; t++)
    for (int v = 0; v < 3; v++)
      c.scene.emission[3 * t + v] = t != lamp ? 0 : _i % 4 < 2 ? 1 : 1 + 0.5 * v;
  ck_assert_int_eq(rad_case_solve(&c, &e), RAD_OK);
  ck_assert_int_eq(rad_case_result(&c, "test", &r, &e), RAD_OK);
  const struct rad_picture *p = &r.picture;
  const struct rad_triangle *source = &c.scene.triangle[lamp];
  const double *emission = c.scene.emission + 3 * lamp;
  int is_constant = _i % 4 < 2, n = 0;
  for (int64_t k = 0; k < p->n_cell; k++)
    for (int64_t m = p->offset[k]; m < p->offset[k + 1]; m++) {
      int64_t i = p->connectivity[m];
      const struct rad_triangle *t = &c.scene.triangle[p->triangle[k]];
      double x[3], middle;
      if (to_vertex(t, p->point + 3 * i) < 1e-3 || (!is_constant && i % 7))
        continue;
      for (int d = 0; d < 3; d++) {
        middle = (t->v[0][d] + t->v[1][d] + t->v[2][d]) / 3;
        x[d] = p->point[3 * i + d] + 1e-9 * (middle - p->point[3 * i + d]);
      }
      int sees = rad_dot(t->normal, source->normal) < 1 - 1e-9;
      double right = 0, h = p->irradiance[i], allowed = is_constant ? 2e-6 : 5e-3;
      if (sees)
        right = is_constant ? lambert(source->v, x, t->normal)
                            : lambert_linear(source->v, emission, x, t->normal, 6);
      ck_assert_msg(fabs(h - right) <= allowed, "room %d: h = %.9g, not %.9g", _i, h, right);
      n++;
    }
  ck_assert_int_gt(n, 200);
  release(&c, &r);
}
END_TEST

/* ---- bright spots ------------------------------------------------------------------------------
 */

static const struct spot {
  double size, height, rho, tolerance;
} spots[] = {{0.01, 0.005, 0, 1e-8}, {0.01, 0.005, 0, 1e-2},  {0.003, 0.002, 0, 1e-3},
             {0.03, 0.1, 0, 1e-3},   {0.05, 0.01, 0.5, 1e-3}, {0.02, 0.01, 0.005, 1e-2},
             {0.1, 0.05, 0.3, 1e-2}, {0.001, 0.001, 0, 1e-4}};

/* A lamp over a floor that sees nothing else, anywhere: the stored values are right, the brightest
 * is as bright as the floor is anywhere, and cells show what is in their middles. */
START_TEST(bright_spot) {
  const struct spot *s = &spots[_i];
  const double floor[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  struct deck_text deck;
  struct rad_case c;
  struct rad_result r;
  state = 9 + (uint64_t)_i;
  double at[2] = {uniform(0.1, 0.4), uniform(0.1, 0.4)}, x[3] = {0}, up[3] = {0, 0, 1};
  const double lamp[3][3] = {{at[0], at[1], s->height},
                             {at[0], at[1] + s->size, s->height},
                             {at[0] + s->size, at[1], s->height}};
  deck_begin(&deck);
  deck_polygon(&deck, "floor", 3, floor, s->rho, 0);
  deck_polygon(&deck, "lamp", 3, lamp, 0, 1);
  deck_add(&deck, "accuracy: {tolerance: %g}\n", s->tolerance);
  solve(&deck, &c, &r);
  const struct rad_picture *p = &r.picture;
  double most = 0, shown = 0;
  for (int i = 0; i < 64 * 64; i++) {
    x[0] = at[0] + (i % 64 / 31.5 - 0.5) * s->size;
    x[1] = at[1] + (i / 64 / 31.5 - 0.5) * s->size;
    most = fmax(most, lambert(lamp, x, up));
  }
  for (int64_t k = 0; k < p->n_cell; k++) {
    double mean = 0, n = (double)(p->offset[k + 1] - p->offset[k]), middle[3] = {0};
    if (p->triangle[k] != 0)
      continue;
    for (int64_t m = p->offset[k]; m < p->offset[k + 1]; m++) {
      int64_t i = p->connectivity[m];
      const double *point = p->point + 3 * i;
      double right = lambert(lamp, point, up), h = p->irradiance[i];
      ck_assert_msg(fabs(h - right) <= s->tolerance, "spot %d: h = %.9g, not %.9g", _i, h, right);
      shown = fmax(shown, h);
      mean += h / n;
      for (int d = 0; d < 3; d++)
        middle[d] += point[d] / n;
    }
    double right = lambert(lamp, middle, up);
    ck_assert_msg(fabs(mean - right) <= 0.1 * most, "spot %d: middle %g, not %g of %g", _i, mean,
                  right, most);
  }
  ck_assert_msg(shown >= 0.9 * most, "spot %d: %g is the brightest, not %g", _i, shown, most);
  ck_assert_int_lt(p->n_cell, 20000);
  release(&c, &r);
}
END_TEST

/* What a mesh by hand is planned to take has room for the cells that halving adds. */
START_TEST(planned_memory) {
  const double floor[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const double lamp[3][3] = {{.3, .3, .001}, {.3, .302, .001}, {.302, .3, .001}};
  struct deck_text deck;
  struct rad_case c;
  struct rad_result r;
  deck_begin(&deck);
  deck_polygon(&deck, "floor", 3, floor, 0.5, 0);
  deck_polygon(&deck, "lamp", 3, lamp, 0, 1);
  deck_add(&deck,
           "accuracy: {tolerance: 1e-3}\noutput: {sampling: 1}\n"
           "method: {mesh: paper, elements: 1, degree: 0}\n");
  solve(&deck, &c, &r);
  const struct rad_picture *p = &r.picture;
  double of_point = sizeof(struct rad_dot) + (3 + 5) * sizeof(double);
  double of_cell = sizeof(struct rad_tile) + (4 + 1 + 2) * sizeof(double);
  double taken = (double)p->n_point * of_point + (double)p->n_cell * of_cell;
  ck_assert_double_ge((double)p->n_cell, 10 * c.mesh->n_element); /* else nothing is tested */
  ck_assert_double_ge(c.plan.rest_bytes, taken);
  release(&c, &r);
}
END_TEST

/* ---- probes ------------------------------------------------------------------------------------
 */

/* By what its mesh cannot show a probe is off by no more than it says; a black face has one too. */
START_TEST(probes_of_coarse_meshes) {
  static const double rho[6] = {0.5, 0, 0.9, 0.3, 0.7, 0.5}, emission[6] = {0, 0.2, 0, 3, 0, 0};
  static const char *const method[] = {"mesh: uniform, elements: 1, degree: 0",
                                       "mesh: uniform, elements: 3, degree: 0",
                                       "mesh: graded, grading: 3, elements: 1, degree: 2"};
  struct deck_text deck;
  struct rad_case fine, coarse;
  struct rad_result right, r;
  deck_begin(&deck);
  deck_cube(&deck, rho, emission);
  deck_add(&deck,
           "probes: [{at: [.3, .4, 0]}, {at: [.5, 0, 0]}, {at: [.02, .01, 0]}, "
           "{at: [.3, .4, 1]}, {surface: ceiling, at: [.5, 0, 1]}, {at: [0, .5, .5]}]\n");
  int head = deck.length;
  deck_add(&deck, "accuracy: {tolerance: 1e-7}\n");
  solve(&deck, &fine, &right);
  for (int k = 0; k < 3; k++) {
    deck.length = head;
    deck_add(&deck, "accuracy: {tolerance: 1e-3}\nmethod: {%s}\n", method[k]);
    solve(&deck, &coarse, &r);
    for (int i = 0; i < coarse.deck.n_probe; i++) {
      double off = fabs(r.probe_irradiance[i] - right.probe_irradiance[i]);
      double said = r.probe_error_irradiance[i];
      ck_assert_msg(off <= said + right.probe_error_irradiance[i],
                    "%s: probe %d: off by %g, not %g", method[k], i, off, said);
      int is_known = k == 2 || (i != 1 && i < 4); /* no limits at edges of uniform meshes */
      ck_assert_int_eq(isfinite(said) != 0, is_known);
      ck_assert_msg(!is_known || said <= 2 * r.diagnostics.error_bound,
                    "%s: probe %d: off by %g, not %g", method[k], i, off, said);
    }
    release(&coarse, &r);
  }
  for (int i = 0; i < fine.deck.n_probe; i++)
    ck_assert_double_le(right.probe_error_irradiance[i], 1e-5);
  deck.length = head;
  deck_add(&deck, "method: {%s}\n", method[0]);
  solve(&deck, &coarse, &r);
  for (int i = 0; i < coarse.deck.n_probe; i++) /* no tolerance, no bound: told as NaN */
    ck_assert(isnan(r.probe_error_irradiance[i]));
  release(&coarse, &r);
  release(&fine, &right);
}
END_TEST

int main(void) {
  Suite *suite = suite_create("picture");
  TCase *rooms = tcase_create("rooms"), *spot = tcase_create("spots");
  int full = getenv("POLYRAD_TEST_FULL") != NULL;
  tcase_set_timeout(rooms, 600);
  tcase_set_timeout(spot, 600);
  tcase_add_test(rooms, cube_that_failed);
  tcase_add_loop_test(rooms, closed_rooms, 0, full ? 200 : 12);
  tcase_add_loop_test(rooms, wedges, 0, 4);
  tcase_add_loop_test(rooms, black_rooms, 0, full ? 40 : 4);
  tcase_add_test(spot, planned_memory);
  tcase_add_test(rooms, probes_of_coarse_meshes);
  tcase_add_loop_test(spot, bright_spot, 0, sizeof spots / sizeof *spots);
  suite_add_tcase(suite, rooms);
  suite_add_tcase(suite, spot);
  return run_suite(suite);
}
