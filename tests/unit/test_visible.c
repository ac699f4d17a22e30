/* What a point sees of a triangle among others: random soups against an oracle; and the cutting of
 * polygons by itself. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "scene_help.h"
#include "shadow_help.h"
#include "suite.h"

/* --- cutting by itself --- */

static const struct rad_polygon UNIT_SQUARE = {.n = 4, .corner = {{0, 0}, {1, 0}, {1, 1}, {0, 1}}};

static struct rad_half_planes box(double x0, double y0, double x1, double y1) {
  return (struct rad_half_planes){4, {{-x0, 1, 0}, {x1, -1, 0}, {-y0, 0, 1}, {y1, 0, -1}}};
}

START_TEST(boxes_on_a_square) {
  static const struct {
    int n;
    double at[3][4], area;
    int sight;
  } cases[] = {{1, {{2, 2, 3, 3}}, 1, RAD_FREE},
               {1, {{1, 0, 2, 1}}, 1, RAD_FREE}, /* touches */
               {1, {{0, 0, 1, 1}}, 0, RAD_HIDDEN},
               {1, {{-1, -1, 2, 2}}, 0, RAD_HIDDEN},
               {1, {{0.25, 0.25, 0.75, 0.75}}, 0.75, RAD_PARTLY},
               {2, {{0, 0, 0.5, 1}, {0.5, 0, 1, 1}}, 0, RAD_HIDDEN},
               {2, {{0, 0, 0.5, 1}, {0.25, 0.5, 1, 1}}, 0.25, RAD_PARTLY},
               {3, {{0, 0, 0.75, 0.75}, {0, 0, 0.75, 0.75}, {0.25, 0.25, 1, 1}}, 0.125, RAD_PARTLY},
               {3, {{-1, 0.25, 2, 0.5}, {0.25, -1, 0.5, 2}, {5, 5, 6, 6}}, 0.5625, RAD_PARTLY}};
  struct rad_parts parts = {0};
  for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
    struct rad_half_planes shadow[3];
    for (int s = 0; s < cases[c].n; s++)
      shadow[s] = box(cases[c].at[s][0], cases[c].at[s][1], cases[c].at[s][2], cases[c].at[s][3]);
    int sight = rad_visible(&UNIT_SQUARE, cases[c].n, shadow, &parts);
    ck_assert_msg(sight == cases[c].sight, "case %zu: %d", c, sight);
    ck_assert_double_eq(rad_parts_area(&parts), cases[c].area); /* all numbers are dyadic */
    if (cases[c].n == 1)
      ck_assert_int_eq(rad_shadow_over(&UNIT_SQUARE, shadow), sight);
  }
  const struct rad_polygon flat = {.n = 3, .corner = {{0, 0}, {1, 1}, {2, 2}}};
  ck_assert_int_eq(rad_visible(&flat, 0, NULL, &parts), RAD_HIDDEN);
  ck_assert_int_eq(parts.n, 0);
  rad_parts_free(&parts);
  rad_parts_free(&parts);
}
END_TEST

static double on(const double c[3], const double p[2]) {
  return c[0] + c[1] * p[0] + c[2] * p[1];
}

static int contains(const struct rad_polygon *polygon, const double p[2]) {
  int above = 0, below = 0;
  for (int a = 0; a < polygon->n; a++) {
    const double *q = polygon->corner[a], *r = polygon->corner[(a + 1) % polygon->n];
    double side = (r[0] - q[0]) * (p[1] - q[1]) - (r[1] - q[1]) * (p[0] - q[0]);
    above |= side > 0;
    below |= side < 0;
  }
  return above != below;
}

/* Regular polygons of up to RAD_MAX_CORNER corners, under random shadows of up to
 * RAD_MAX_SHADOW_SIDE sides: a random point is in one part, or in a shadow and in none; also tiny
 * and huge ones, and halves that make many corners. */
START_TEST(points_are_in_one_part_or_in_shadow) {
  enum { N_SHADOW = 12 };
  struct rad_parts parts = {0};
  int n_seen = 0, n_hidden = 0, most_corners = 0;
  start_random();
  for (int k = 0; k < 2000; k++) {
    double scale = pow(10, uniform(-12, 9)), about[2] = {uniform(-2, 2), uniform(-2, 2)};
    struct rad_polygon polygon = {.n = 3 + k % (RAD_MAX_CORNER - 2)};
    for (int a = 0; a < polygon.n; a++) {
      double angle = (k % 2 ? 2 : -2) * M_PI * a / polygon.n;
      polygon.corner[a][0] = scale * (about[0] + cos(angle));
      polygon.corner[a][1] = scale * (about[1] + sin(angle));
    }
    struct rad_half_planes shadow[N_SHADOW];
    int n_shadow = (int)uniform(0, N_SHADOW + 1);
    for (int s = 0; s < n_shadow; s++) {
      shadow[s].n = (int)uniform(1, RAD_MAX_SHADOW_SIDE + 1);
      double size = uniform(0.1, 1), at[2] = {about[0] + uniform(-1, 1), about[1] + uniform(-1, 1)};
      for (int e = 0; e < shadow[s].n; e++) {
        double angle = uniform(0, 2 * M_PI), *c = shadow[s].c[e], weight = pow(10, uniform(-9, 9));
        c[1] = weight * cos(angle) / scale;
        c[2] = weight * sin(angle) / scale;
        c[0] = weight * size * uniform(0.5, 1) - (c[1] * at[0] + c[2] * at[1]) * scale;
      }
    }
    int sight = rad_visible(&polygon, n_shadow, shadow, &parts);
    ck_assert_int_ge(sight, 0);
    ck_assert((sight == RAD_HIDDEN) == (parts.n == 0));
    for (int p = 0; p < parts.n; p++)
      most_corners = parts.part[p].n > most_corners ? parts.part[p].n : most_corners;
    for (int r = 0; r < 30; r++) {
      double p[2] = {scale * (about[0] + uniform(-1, 1)), scale * (about[1] + uniform(-1, 1))};
      if (!contains(&polygon, p))
        continue;
      int hidden = 0, n_in = 0;
      for (int s = 0; s < n_shadow; s++) {
        int in = 1;
        for (int e = 0; e < shadow[s].n; e++)
          in &= on(shadow[s].c[e], p) > 0;
        hidden |= in;
      }
      for (int a = 0; a < parts.n; a++)
        n_in += contains(&parts.part[a], p);
      ck_assert_msg(n_in == !hidden, "case %d: in %d parts, hidden %d, seed %llu", k, n_in, hidden,
                    seed());
      n_seen += !hidden;
      n_hidden += hidden;
    }
  }
  printf("parts: %d points seen, %d hidden, up to %d corners\n", n_seen, n_hidden, most_corners);
  ck_assert_int_gt(n_seen, 5000);
  ck_assert_int_gt(n_hidden, 5000);
  rad_parts_free(&parts);
}
END_TEST

/* A disc of RAD_MAX_CORNER corners and half-planes that cut off one corner each, so that the piece
 * left keeps getting more: area against the sum of the parts cut off. */
START_TEST(many_corners_are_split) {
  struct rad_polygon disc = {.n = RAD_MAX_CORNER};
  struct rad_half_planes shadow[RAD_MAX_CORNER];
  for (int a = 0; a < disc.n; a++) {
    double angle = 2 * M_PI * a / disc.n;
    disc.corner[a][0] = cos(angle);
    disc.corner[a][1] = sin(angle);
    shadow[a] = (struct rad_half_planes){1, {{-0.999, cos(angle), sin(angle)}}};
  }
  /* a corner of angle pi - 2 pi/n, cut at 0.001 from its tip */
  double cut = 1e-6 / tan(M_PI / disc.n);
  struct rad_parts parts = {0};
  for (int turn = 0; turn < 3; turn++) { /* memory is used again */
    ck_assert_int_eq(rad_visible(&disc, disc.n, shadow, &parts), RAD_PARTLY);
    ck_assert_double_eq_tol(rad_parts_area(&parts), rad_polygon_area(&disc) - disc.n * cut, 1e-14);
  }
  rad_parts_free(&parts);
}
END_TEST

/* --- soups --- */

enum { MAX_SOUP = 60 };
typedef double soup[MAX_SOUP][3][3];

/* Triangles of about `size` in the unit cube, which may cut through each other; some are needles of
 * 0.1 degree. */
static void random_soup(int n, double size, int with_needles, soup v) {
  for (int k = 0; k < n; k++) {
    double at[3], along[3], across[3];
    for (int d = 0; d < 3; d++)
      at[d] = uniform(0, 1);
    random_direction(along);
    random_direction(across);
    double width = with_needles && k % 4 == 3 ? 8.7e-4 : uniform(0.3, 1);
    for (int d = 0; d < 3; d++) {
      v[k][0][d] = at[d];
      v[k][1][d] = at[d] + size * along[d];
      v[k][2][d] = at[d] + size * (0.5 * along[d] + width * across[d]);
    }
  }
}

static struct rad_scene soup_scene(int n, soup v, const struct motion *motion) {
  struct rad_deck deck = {0};
  for (int k = 0; k < n; k++)
    if (motion)
      add_moved(&deck, motion, v[k], RAD_SIDE_FRONT);
    else
      add(&deck, "soup", v[k])->optics.side = RAD_SIDE_FRONT;
  return build_scene(&deck);
}

/* A point's distance from a plane, relative to the distance from its triangle's first vertex: how
 * far rounding is magnified. */
static double steepness(const struct rad_scene *scene, const struct look *look) {
  double x[3], r[3];
  const struct rad_triangle *i = &scene->triangle[look->target],
                            *j = &scene->triangle[look->source];
  for (int d = 0; d < 3; d++)
    x[d] = i->v[look->base][d] +
           look->mu[0] * (i->v[(look->base + 1) % 3][d] - i->v[look->base][d]) +
           look->mu[1] * (i->v[(look->base + 2) % 3][d] - i->v[look->base][d]);
  rad_sub(x, j->v[0], r);
  return fabs(rad_dot(j->normal, r)) / rad_norm(r);
}

/* Rounding of the plane through x and a side is 1e-16 over the angles between x, side and source:
 * 1e-12 leaves room for 1e-4. */
#define TOLERANCE 1e-12

START_TEST(soups_agree_with_the_oracle) {
  static soup v;
  struct tally tally = {0};
  start_random();
  for (int k = 0; tally.n < 10000; k++) {
    int n = (int)(5 * pow(12, uniform(0, 1)));
    random_soup(n, uniform(0.2, 1.2), k % 2, v);
    struct rad_scene scene = soup_scene(n, v, NULL);
    struct rad_occluders o = occluders_by_hand(&scene);
    for (int r = 0; r < 50; r++) {
      struct look look = random_look(n);
      if (steepness(&scene, &look) < 1e-3)
        continue;
      expect_fraction(visible_fraction(&o, &look), oracle_fraction(&scene, &look), TOLERANCE, &look,
                      "soup", &tally);
    }
    rad_occluders_free(&o);
    rad_scene_free(&scene);
  }
  print_tally("soups", &tally);
  ck_assert_int_gt(tally.n_free, 1000);
  ck_assert_int_gt(tally.n_hidden, 500);
  ck_assert_int_gt(tally.n_part, 3000);
}
END_TEST

/* Turned and scaled, coordinates are rounded anew by 1e-16 of the shift, at most 3 scales; moved
 * away by an offset, by 1e-16 of that. */
START_TEST(motions_change_nothing) {
  static soup v;
  static const double scales[3] = {1, 1e-6, 1e9};
  struct tally moved = {0}, offset = {0};
  start_random();
  for (int k = 0; k < 60; k++) {
    int n = 20;
    random_soup(n, uniform(0.4, 1), 0, v);
    struct motion motion = random_motion(0);
    for (int d = 0; d < 3; d++)
      motion.shift[d] *= scales[k % 3];
    motion.scale = scales[k % 3];
    struct motion away = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .scale = 1};
    for (int d = 0; d < 3; d++)
      away.shift[d] = uniform(-1e6, 1e6);
    struct rad_scene scene[3] = {soup_scene(n, v, NULL), soup_scene(n, v, &motion),
                                 soup_scene(n, v, &away)};
    struct rad_occluders o[3];
    for (int s = 0; s < 3; s++)
      o[s] = occluders_by_hand(&scene[s]);
    for (int r = 0; r < 40; r++) {
      struct look look = random_look(n);
      if (steepness(&scene[0], &look) < 0.03)
        continue;
      double whole = visible_fraction(&o[0], &look);
      expect_fraction(visible_fraction(&o[1], &look), whole, TOLERANCE, &look, "moved", &moved);
      expect_fraction(visible_fraction(&o[2], &look), whole, 1e6 * TOLERANCE, &look, "offset",
                      &offset);
      double there = oracle_fraction(&scene[2], &look); /* the rounded coordinates' own */
      expect_fraction(visible_fraction(&o[2], &look), there, TOLERANCE, &look, "offset", &moved);
    }
    for (int s = 0; s < 3; s++) {
      rad_occluders_free(&o[s]);
      rad_scene_free(&scene[s]);
    }
  }
  print_tally("moved", &moved);
  print_tally("offset", &offset);
  ck_assert_int_gt(moved.n_part, 500);
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", seed());
  Suite *suite = suite_create("visible");
  TCase *tests = tcase_create("visible");
  tcase_add_test(tests, boxes_on_a_square);
  tcase_add_test(tests, points_are_in_one_part_or_in_shadow);
  tcase_add_test(tests, many_corners_are_split);
  tcase_add_test(tests, soups_agree_with_the_oracle);
  tcase_add_test(tests, motions_change_nothing);
  tcase_set_timeout(tests, 120);
  suite_add_tcase(suite, tests);
  return run_suite(suite);
}
