/* Lambert's form for many targets: against the oracle's, cut at horizons, on parts, at any scale.
 */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/simd_math.h"
#include "base/vec.h"
#include "integrate/constant.h"
#include "oracle.h"
#include "scene_help.h"
#include "suite.h"

/* --- atan2 --- */

/* Error bounds as in simd_math.h; libm's long double is right to 1e-19. */
START_TEST(angles) {
  start_random();
  for (int k = 0; k < 400000; k++) {
    double y = uniform(0, 1), x = uniform(-1, 1), small = pow(10, uniform(-150, 0));
    y *= k & 1 ? small : 1;
    x *= k & 2 ? small : 1;
    long double exact = atan2l(y, x);
    ck_assert_msg(fabsl(rad_atan2(y, x) - exact) <= 5e-16L * exact, "%g %g, seed %llu", y, x,
                  seed());
    double u = uniform(0, 0.1717);
    exact = atanl(sqrtl(u)) / sqrtl(u);
    ck_assert_msg(fabsl(rad_atan_ratio(u) - exact) <= 3e-16L * exact, "%g", u);
  }
  ck_assert_double_eq(rad_atan2(0, 1), 0);
  ck_assert_double_eq(rad_atan2(0, 0), 0);
  ck_assert_double_eq(rad_atan2(0, -1), M_PI);
  ck_assert_double_eq(rad_atan2(3, 0), M_PI / 2);
  ck_assert_double_eq(rad_atan2(3, 3), M_PI / 4);
}
END_TEST

/* --- one source, targets around it --- */

struct targets {
  double v[3][RAD_FACET_LANES], d[3][RAD_FACET_LANES], normal[3][RAD_FACET_LANES];
  struct oracle_point point[RAD_FACET_LANES];
  struct rad_facet_targets view;
};

/* A source triangle with corners moved, and a point x of a triangle v, v + e1, v + e2. */
static void set_source(const struct motion *m, const double v[3][3], struct rad_triangle *t) {
  *t = (struct rad_triangle){.area = 0};
  for (int c = 0; c < 3; c++)
    move(m, v[c], t->v[c]);
  measure_triangle(t);
}

static void set_target(struct targets *t, int i, const double v[3][3], double mu1, double mu2) {
  struct oracle_point *p = &t->point[i];
  struct rad_triangle triangle = {.area = 0};
  memcpy(triangle.v, v, sizeof triangle.v);
  measure_triangle(&triangle);
  memcpy(p->vertex, v[0], sizeof p->vertex);
  rad_sub(v[1], v[0], p->edge1);
  rad_sub(v[2], v[0], p->edge2);
  p->mu1 = mu1;
  p->mu2 = mu2;
  memcpy(p->normal, triangle.normal, sizeof p->normal);
  for (int d = 0; d < 3; d++) {
    t->v[d][i] = v[0][d];
    t->d[d][i] = mu1 * p->edge1[d] + mu2 * p->edge2[d];
    t->normal[d][i] = triangle.normal[d];
    t->view.v[d] = t->v[d];
    t->view.d[d] = t->d[d];
    t->view.normal[d] = t->normal[d];
  }
}

/* The value as an assembly makes it: by lanes, or where these are not sure cut and one by one. */
static double value_of(const struct rad_triangle *source, const struct targets *t, int i,
                       double tolerance, const double *lane) {
  struct rad_facet_source s;
  struct rad_polygon front;
  if (!isnan(lane[i]))
    return lane[i];
  rad_facet_source_set(source, &s);
  rad_facet_front(&s, &t->view, i, 1, &front);
  return rad_facet_part(&s, &t->view, i, &front, (struct rad_facet_error){tolerance, 0});
}

/* Compares all lanes; returns how many are left to the quadrature. */
static int compare(const struct rad_triangle *source, const struct targets *t, double tolerance,
                   const char *what) {
  struct rad_facet_source s;
  double lane[RAD_FACET_LANES];
  int given_up = 0;
  rad_facet_source_set(source, &s);
  int doubts = rad_facet_values(&s, &t->view, 0, (struct rad_facet_error){tolerance, 0}, lane),
      nans = 0;
  for (int i = 0; i < RAD_FACET_LANES; i++) {
    double value = value_of(source, t, i, tolerance, lane);
    long double exact = oracle_lambert(&t->point[i], 3, source->v, source->normal);
    nans |= isnan(lane[i]);
    given_up += isnan(value);
    ck_assert_msg(isnan(value) || fabsl(value - exact) <= tolerance * exact,
                  "%s: %.17g, exact %.17Lg, tolerance %g, seed %llu", what, value, exact, tolerance,
                  seed());
  }
  ck_assert_int_eq(doubts, nans);
  return given_up;
}

/* A triangle of a size about a place, seen from where it may. */
static void random_triangle(const double at[3], double size, double v[3][3]) {
  for (int c = 0; c < 3; c++) {
    double way[3];
    random_direction(way);
    for (int d = 0; d < 3; d++)
      v[c][d] = at[d] + size * way[d];
  }
}

/* Random targets all around, many behind, many cut. Relative rounding is distance over extent over
 * the cosines: mostly below 1e-10; wherever a tolerance is claimed, it is kept. */
START_TEST(random_pairs) {
  static const double tolerances[] = {1e-6, 1e-10, 1e-13};
  start_random();
  int given_up = 0, all = 0;
  for (int k = 0; k < 1500; k++) {
    double tolerance = tolerances[k % 3], at[3], v[3][3];
    struct motion m = random_motion(9);
    struct rad_triangle source;
    struct targets t;
    set_source(&m, UNIT, &source);
    for (int i = 0; i < RAD_FACET_LANES; i++) {
      double distance = pow(10, uniform(-2, 2)), moved[3][3];
      random_direction(at);
      for (int d = 0; d < 3; d++)
        at[d] *= distance;
      random_triangle(at, distance * pow(10, uniform(-3, 0)), v);
      for (int c = 0; c < 3; c++)
        move(&m, v[c], moved[c]);
      set_target(&t, i, (const double(*)[3])moved, 1.0 / 3, 1.0 / 3);
    }
    int lost = compare(&source, &t, tolerance, "random");
    given_up += tolerance > 1e-12 ? lost : 0;
    all += tolerance > 1e-12 ? RAD_FACET_LANES : 0;
  }
  ck_assert_msg(given_up * 200 < all, "%d of %d", given_up, all);
}
END_TEST

/* Targets that touch the source in an edge, of any size and angle, and needles: the vertex that a
 * point counts from is shared, so that smallness costs nothing. */
START_TEST(touching) {
  start_random();
  for (int k = 0; k < 600; k++) {
    struct motion m = random_motion(k & 1 ? 9 : 0);
    struct rad_triangle source;
    struct targets t;
    set_source(&m, UNIT, &source);
    for (int i = 0; i < RAD_FACET_LANES; i++) {
      double angle = uniform(0.1, 3), width = pow(10, uniform(-7, 0)), v[3][3];
      double third[3] = {uniform(0, 1), width * cos(angle), width * sin(angle)};
      memcpy(v[0], source.v[0], sizeof v[0]);
      memcpy(v[1], source.v[1], sizeof v[1]);
      move(&m, third, v[2]);
      if (k & 2) /* as small along the edge as across */
        for (int d = 0; d < 3; d++)
          v[1][d] = v[0][d] + width * (v[1][d] - v[0][d]);
      set_target(&t, i, (const double(*)[3])v, 1.0 / 3, 1.0 / 3);
      double away[3];
      rad_sub(source.v[0], source.v[2], away);
      for (int d = 0; rad_dot(t.point[i].normal, away) > 0 && d < 3; d++)
        t.normal[d][i] = -t.normal[d][i];
      for (int d = 0; d < 3; d++) /* the side that faces the source */
        t.point[i].normal[d] = t.normal[d][i];
    }
    compare(&source, &t, 1e-6, "touching");
  }
}
END_TEST

/* Points over, in and beside the triangle at heights down to 1e-9 of its size, facing it. */
START_TEST(near_the_plane) {
  start_random();
  for (int k = 0; k < 600; k++) {
    struct motion m = random_motion(0);
    struct rad_triangle source;
    struct targets t;
    set_source(&m, UNIT, &source);
    for (int i = 0; i < RAD_FACET_LANES; i++) {
      double height = pow(10, uniform(-9, 0)), x = uniform(-1, 2), y = uniform(-1, 2);
      double v[3][3] = {{x, y, height}, {x, y + 1, height}, {x + 1, y, height + uniform(-.5, .5)}};
      for (int c = 0; c < 3; c++) {
        double at[3] = {v[c][0], v[c][1], v[c][2]};
        move(&m, at, v[c]);
      }
      set_target(&t, i, (const double(*)[3])v, 0, 0);
    }
    compare(&source, &t, 1e-7, "near the plane");
  }
}
END_TEST

/* Far facets: the relative error grows only like distance over extent. */
START_TEST(far_away) {
  start_random();
  struct motion still = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .scale = 1};
  for (int k = 0; k < 200; k++) {
    struct rad_triangle source;
    struct targets t;
    double distance = pow(10, uniform(0.5, 4));
    set_source(&still, UNIT, &source);
    for (int i = 0; i < RAD_FACET_LANES; i++) {
      double x = uniform(-1, 1) * distance, y = uniform(-1, 1) * distance;
      double v[3][3] = {{x, y, distance}, {x, y + 1, distance}, {x + 1, y, distance}};
      set_target(&t, i, (const double(*)[3])v, 1.0 / 3, 1.0 / 3);
    }
    ck_assert_int_eq(compare(&source, &t, fmax(1e-13, 2e-14 * distance), "far"), 0);
  }
}
END_TEST

/* The place among the lanes, and the neighbours there, do not change a bit of near values. */
START_TEST(lanes_agree) {
  struct motion m = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .scale = 1};
  struct rad_triangle source;
  struct rad_facet_source s;
  struct targets t;
  double value[RAD_FACET_LANES];
  static const double v[3][3] = {{0, 0, 2}, {0, 1, 2}, {1, 0, 2.5}};
  set_source(&m, UNIT, &source);
  rad_facet_source_set(&source, &s);
  for (int i = 0; i < RAD_FACET_LANES; i++)
    set_target(&t, i, v, 0.25, 0.5);
  ck_assert_int_eq(rad_facet_values(&s, &t.view, 0, (struct rad_facet_error){1e-10, 0}, value), 0);
  for (int i = 1; i < RAD_FACET_LANES; i++)
    ck_assert_int_eq(memcmp(&value[i], &value[0], sizeof *value), 0);
}
END_TEST

/* The parts of a cut triangle add up to it; the vertices may run either way. */
START_TEST(parts_add_up) {
  start_random();
  for (int k = 0; k < 2000; k++) {
    struct motion m = random_motion(3);
    struct rad_triangle source;
    struct rad_facet_source s;
    struct targets t;
    double target[3][3] = {{0.1, 0.2, 1}, {0.1, 1.2, 1}, {1.1, 0.2, 1.4}};
    set_source(&m, UNIT, &source);
    for (int c = 0; c < 3; c++) {
      double at[3] = {target[c][0], target[c][1], target[c][2]};
      move(&m, at, target[c]);
    }
    set_target(&t, 0, (const double(*)[3])target, 0.3, 0.3);
    if (k & 1)
      for (int d = 0; d < 3; d++) {
        double swap = source.v[1][d];
        source.v[1][d] = source.v[2][d];
        source.v[2][d] = swap;
      }
    rad_facet_source_set(&source, &s);
    struct rad_polygon whole, left, right;
    rad_facet_front(&s, &t.view, 0, 0, &whole);
    left = right = whole;
    double c[3] = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    rad_clip(&left, c[0], c[1], c[2]);
    rad_clip(&right, -c[0], -c[1], -c[2]);
    double sum = rad_facet_part(&s, &t.view, 0, &left, (struct rad_facet_error){1, 0}) +
                 rad_facet_part(&s, &t.view, 0, &right, (struct rad_facet_error){1, 0});
    double all = rad_facet_part(&s, &t.view, 0, &whole, (struct rad_facet_error){1e-12, 0});
    ck_assert_msg(fabs(sum - all) < 2e-15, "%g, seed %llu", sum - all, seed());
    ck_assert_double_gt(all, 0.01);
  }
}
END_TEST

int main(void) {
  printf("seed %llu\n", seed());
  Suite *suite = suite_create("constant");
  TCase *tc = tcase_create("lambert");
  tcase_set_timeout(tc, 120);
  tcase_add_test(tc, angles);
  tcase_add_test(tc, random_pairs);
  tcase_add_test(tc, touching);
  tcase_add_test(tc, near_the_plane);
  tcase_add_test(tc, far_away);
  tcase_add_test(tc, lanes_agree);
  tcase_add_test(tc, parts_add_up);
  suite_add_tcase(suite, tc);
  return run_suite(suite);
}
