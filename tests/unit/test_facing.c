/* Which triangles face each other, and which scenes have shadows: known scenes, turned at random.
 */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "scene_help.h"
#include "suite.h"
#include "visibility/facing.h"
#include "visibility/visibility.h"

/* --- facing --- */

START_TEST(sides_of_planes) {
  static const struct {
    double v[3][3];
    enum rad_side_of_plane side;
  } cases[] = {{{{0, 0, 1}, {1, 0, 2}, {0, 1, 3}}, RAD_IN_FRONT},
               {{{0, 0, -1}, {1, 0, -2}, {0, 1, -3}}, RAD_BEHIND},
               {{{0, 0, -1}, {1, 0, -2}, {0, 1, 3}}, RAD_ACROSS},
               {{{0, 0, 0}, {1, 0, 0}, {0, 1, 3}}, RAD_IN_FRONT},
               {{{0, 0, 0}, {1, 0, 0}, {0, 1, -3}}, RAD_BEHIND},
               {{{0, 0, 0}, {-1, 0, 1}, {0, -1, -1}}, RAD_ACROSS},
               {{{5, 0, 0}, {6, 0, 0}, {5, 1, 0}}, RAD_BEHIND},
               {{{5, 0, 0}, {6, 0, 0}, {5, 1, 1e-9}}, RAD_IN_FRONT},
               {{{5, 0, 0}, {6, 0, 0}, {5, 1, -1e-9}}, RAD_BEHIND},
               {{{5, 0, 1e-9}, {6, 0, 0}, {5, 1, -1e-9}}, RAD_ACROSS}};
  static const double floor[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  start_random();
  for (size_t k = 0; k < 50 * sizeof cases / sizeof *cases; k++) {
    size_t c = k / 50;
    struct motion motion = random_motion(3);
    struct rad_deck deck = {0};
    add_moved(&deck, &motion, floor, RAD_SIDE_FRONT);
    add_moved(&deck, &motion, cases[c].v, RAD_SIDE_FRONT);
    struct rad_scene scene = build_scene(&deck);
    enum rad_side_of_plane got = rad_side_of(&scene.triangle[0], &scene.triangle[1]);
    ck_assert_msg(got == cases[c].side, "case %zu: %d, seed %llu", c, (int)got, seed());
    rad_scene_free(&scene);
  }
}
END_TEST

/* A stack of two plates: the lower sees the upper's back only if that radiates. */
START_TEST(facing_takes_both) {
  static const double low[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  static const double high[3][3] = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  start_random();
  for (int k = 0; k < 40; k++) {
    struct motion motion = random_motion(3);
    struct rad_deck deck = {0};
    add_moved(&deck, &motion, low, k & 1 ? RAD_SIDE_BACK : RAD_SIDE_FRONT);
    add_moved(&deck, &motion, high, k & 2 ? RAD_SIDE_BACK : RAD_SIDE_FRONT);
    struct rad_scene scene = build_scene(&deck);
    int expected = !(k & 1) && (k & 2);
    ck_assert_int_eq(rad_faces(&scene.triangle[0], &scene.triangle[1]), expected);
    ck_assert_int_eq(rad_faces(&scene.triangle[1], &scene.triangle[0]), expected);
    rad_scene_free(&scene);
  }
}
END_TEST

/* Even if rounding tilts the normal of i more than it ever does. */
START_TEST(shared_vertices_lie_in_the_plane) {
  for (int k = 0; k < 9; k++) {
    struct rad_triangle i = {
        .v = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .normal = {1e-9, 1e-9, 1}, .vertex = {3, 4, 5}};
    int kept = k % 3, place = k / 3; /* j's vertex in that place is i's kept one */
    struct rad_triangle j = {.v = {{0, 0, -1}, {1, 0, -1}, {0, 1, -1}}, .vertex = {6, 7, 8}};
    memcpy(j.v[place], i.v[kept], sizeof j.v[0]);
    j.vertex[place] = i.vertex[kept];
    ck_assert_int_eq(rad_side_of(&i, &j), RAD_BEHIND);
    i.normal[0] = i.normal[1] = -1e-9;
    i.normal[2] = -1;
    ck_assert_int_eq(rad_side_of(&i, &j), RAD_IN_FRONT);
  }
}
END_TEST

/* A wall of small triangles, turned: coordinates are rounded, and yet no two face each other. */
START_TEST(a_flat_wall_does_not_face_itself) {
  enum { N = 15 };
  start_random();
  for (int k = 0; k < 4; k++) {
    struct motion motion = random_motion(3);
    struct rad_deck deck = {0};
    for (int cell = 0; cell < N * N; cell++) {
      double x = cell % N, y = cell / N;
      add_moved(&deck, &motion, (double[3][3]){{x, y, 0}, {x + 1, y, 0}, {x, y + 1, 0}},
                RAD_SIDE_BOTH);
      add_moved(&deck, &motion, (double[3][3]){{x + 1, y, 0}, {x + 1, y + 1, 0}, {x, y + 1, 0}},
                RAD_SIDE_BOTH);
    }
    struct rad_scene scene = build_scene(&deck);
    ck_assert_int_eq(scene.n_triangle, 4 * N * N);
    for (int i = 0; i < scene.n_triangle; i++)
      for (int j = 0; j < scene.n_triangle; j++)
        ck_assert(i == j || !rad_faces(&scene.triangle[i], &scene.triangle[j]));
    rad_scene_free(&scene);
  }
}
END_TEST

START_TEST(cube_walls_face_the_other_five) {
  start_random();
  for (int inside = 0; inside < 2; inside++) {
    struct motion motion = random_motion(3);
    struct rad_deck deck = {0};
    add_cube(&deck, &motion, inside ? RAD_SIDE_BACK : RAD_SIDE_FRONT);
    struct rad_scene scene = build_scene(&deck);
    for (int i = 0; i < 12; i++) {
      int n = 0;
      for (int j = 0; j < 12; j++)
        if (j != i) {
          int faces = rad_faces(&scene.triangle[i], &scene.triangle[j]);
          ck_assert_int_eq(faces, rad_faces(&scene.triangle[j], &scene.triangle[i]));
          n += faces;
        }
      ck_assert_int_eq(n, inside ? 10 : 0);
    }
    rad_scene_free(&scene);
  }
}
END_TEST

/* --- scenes without a shadow --- */

/* A deck's scene, and the first pair that sees less of each other than all. */
struct shadow {
  struct rad_scene scene;
  struct rad_visibility visibility;
  int i, j;     /* -1 if there is none */
  int n, *list; /* occluders that may stand between, if they see one another in part */
};

static struct shadow *look_for_shadow(struct rad_deck *deck) {
  struct shadow *s = calloc(1, sizeof *s);
  struct rad_error e;
  ck_assert_ptr_nonnull(s);
  s->scene = build_scene(deck);
  ck_assert_int_eq(rad_visibility_build(&s->scene, &s->visibility, &e), RAD_OK);
  s->list = malloc(sizeof(int) * (size_t)s->visibility.occluders.n);
  int n = s->scene.n_triangle;
  for (s->i = 0; s->i < n; s->i++)
    for (s->j = s->i + 1; s->j < n; s->j++)
      if (rad_faces(&s->scene.triangle[s->i], &s->scene.triangle[s->j]) &&
          s->visibility.sight[s->i * n + s->j] != RAD_FREE) {
        rad_sight_between(&s->visibility.occluders, s->i, s->j, s->list, &s->n);
        return s;
      }
  ck_assert_int_eq(s->visibility.n_partly, 0);
  s->i = s->j = -1;
  return s;
}

/* Whether the plane of triangles first .. last may cast that shadow. */
static int blocks(const struct shadow *s, int first, int last) {
  const struct rad_occluders *o = &s->visibility.occluders;
  int found = 0;
  for (int k = 0; k < s->n; k++)
    for (int t = first; t <= last; t++)
      found |= o->occluder[s->list[k]].plane == o->plane[t];
  return found;
}

static void free_shadow(struct shadow *s) {
  rad_visibility_free(&s->visibility);
  rad_scene_free(&s->scene);
  free(s->list);
  free(s);
}

/* Every pair that faces one another is free. */
static void expect_no_shadow(struct rad_deck *deck, const char *what) {
  struct shadow *s = look_for_shadow(deck);
  ck_assert_msg(s->i < 0, "%s: something is between %d and %d, seed %llu", what, s->i, s->j,
                seed());
  free_shadow(s);
}

/* To be freed with free_shadow. */
static struct shadow *expect_shadow(struct rad_deck *deck, const char *what) {
  struct shadow *s = look_for_shadow(deck);
  ck_assert_msg(s->i >= 0, "%s: no shadow, seed %llu", what, seed());
  return s;
}

START_TEST(convex_scenes_have_no_shadow) {
  static const double corner[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  static const int tetrahedron[4][3] = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  static const enum rad_side side[3] = {RAD_SIDE_FRONT, RAD_SIDE_BACK, RAD_SIDE_BOTH};
  start_random();
  for (int k = 0; k < 150; k++) {
    struct motion motion = random_motion(3);
    struct rad_deck deck = {0};
    add_cube(&deck, &motion, side[k % 3]);
    expect_no_shadow(&deck, "cube");
    for (int t = 0; t < 4; t++) {
      double v[3][3];
      for (int m = 0; m < 3; m++)
        memcpy(v[m], corner[tetrahedron[t][m]], sizeof v[m]);
      add_moved(&deck, &motion, v, side[k % 3]);
    }
    expect_no_shadow(&deck, "tetrahedron");
    double gon[12][2];
    int cap[10][3];
    for (int c = 0; c < 12; c++) {
      gon[c][0] = cos(0.5235987755982988 * c);
      gon[c][1] = sin(0.5235987755982988 * c);
      if (c < 10)
        memcpy(cap[c], ((int[3]){0, c + 1, c + 2}), sizeof cap[c]);
    }
    add_prism(&deck, &motion, 12, gon, 10, cap, 0, pow(10, uniform(-2, 2)), side[k % 3]);
    expect_no_shadow(&deck, "drum");
  }
}
END_TEST

/* The two surfaces of the paper; /work/shared/reference/paper.json, tables 4.1 and 4.4. */
START_TEST(surfaces_of_the_paper_have_no_shadow) {
  static const double surface[2][3][3][3] = {{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                                              {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                              {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}}},
                                             {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                                              {{0, 0, 0}, {0, 1, 0}, {1, 1, 1}},
                                              {{0, 0, 0}, {1, 1, 1}, {1, 0, 0}}}};
  start_random();
  for (int k = 0; k < 200; k++) {
    struct motion motion = random_motion(3);
    struct rad_deck deck = {0};
    for (int t = 0; t < 3; t++) /* the right-hand normals are the paper's */
      add_moved(&deck, &motion, surface[k % 2][t], RAD_SIDE_FRONT);
    expect_no_shadow(&deck, k % 2 ? "S2" : "S1");
  }
}
END_TEST

/* Planes of one body cut the other, so that every triangle is tried: but whatever a body's face
 * sees, the body is behind it. Likewise the two walls in the notch of an L seen from outside. */
START_TEST(bodies_seen_from_outside_have_no_shadow) {
  start_random();
  for (int k = 0; k < 100; k++) {
    struct motion motion = random_motion(3), other = random_motion(3);
    double gap = uniform(1.8, 3), direction[3]; /* the cubes' diameters are 1.73 and less */
    random_direction(direction);
    other.scale = motion.scale * uniform(0.1, 1);
    for (int d = 0; d < 3; d++)
      other.shift[d] = motion.shift[d] + 2 * gap * motion.scale * direction[d];
    struct rad_deck deck = {0};
    add_cube(&deck, &motion, RAD_SIDE_FRONT);
    add_cube(&deck, &other, RAD_SIDE_FRONT);
    expect_no_shadow(&deck, "two cubes");
    add_prism(&deck, &motion, 6, ELL, 4, ELL_CAP, 0, 1, RAD_SIDE_FRONT);
    expect_no_shadow(&deck, "L from outside");
  }
}
END_TEST

/* --- scenes with a shadow --- */

/* A floor and a ceiling. */
static void add_squares(struct rad_deck *deck, const struct motion *motion, enum rad_side floor) {
  for (int k = 0; k < 4; k++) {
    double v[3][3];
    for (int m = 0; m < 3; m++) {
      const double *p = SQUARE[SQUARE_CAP[k % 2][m]];
      memcpy(v[m], ((double[3]){p[0], p[1], k / 2}), sizeof v[m]);
    }
    add_moved(deck, motion, v, k / 2 ? RAD_SIDE_BACK : floor);
  }
}

/* The blocker's edge reaches by 1e-6 into the space between the squares, or misses it by that. */
START_TEST(parallel_squares_with_a_blocker) {
  start_random();
  for (int k = 0; k < 100; k++) {
    struct motion motion = random_motion(3);
    struct rad_deck deck = {0};
    enum rad_side floor = k % 3 ? RAD_SIDE_FRONT : RAD_SIDE_BOTH;
    add_squares(&deck, &motion, floor);
    expect_no_shadow(&deck, "squares");
    for (int n = 0; n < 3; n++) {
      double x = n == 0 ? 0.3 : n == 1 ? 1 - 1e-6 : 1 + 1e-6;
      const double tip[3][3] = {{x, 0.4, 0.5}, {3, 0.2, 0.6}, {3, 0.7, 0.4}};
      const double edge[3][3] = {{x, 0.2, 0.4}, {x, 0.7, 0.5}, {3, 0.5, 0.5}};
      add_squares(&deck, &motion, floor);
      add_moved(&deck, &motion, k % 2 ? tip : edge, k % 4 < 2 ? RAD_SIDE_FRONT : RAD_SIDE_BOTH);
      if (n == 2) {
        expect_no_shadow(&deck, "squares and a blocker beside");
        continue;
      }
      struct shadow *s = expect_shadow(&deck, "squares and a blocker");
      ck_assert(blocks(s, floor == RAD_SIDE_BOTH ? 6 : 4, s->scene.n_triangle - 1));
      free_shadow(s);
    }
  }
}
END_TEST

START_TEST(non_convex_rooms_have_shadows) {
  start_random();
  for (int k = 0; k < 50; k++) {
    struct motion motion = random_motion(3);
    struct rad_deck deck = {0};
    add_prism(&deck, &motion, 6, ELL, 4, ELL_CAP, 0, 1, RAD_SIDE_BACK);
    struct shadow *s = expect_shadow(&deck, "L from inside");
    /* the walls at the reflex edge are those of polygon edges 2 and 3: triangles 4 to 7 */
    ck_assert(blocks(s, 4, 7));
    free_shadow(s);
  }
}
END_TEST

/* A step: tread z = 0, x < 0 and riser x = 0, z < 0 meet at 270 degrees. From the ground z = -1,
 * x > 0 a lamp over the tread is hidden in part; a lamp over the ground is not, nor do tread and
 * riser face each other. */
START_TEST(a_reflex_edge_shadows_some_pairs) {
  static const double tread[3][3] = {{0, -3, 0}, {0, 3, 0}, {-3, 0, 0}};
  static const double riser[3][3] = {{0, -3, 0}, {0, 0, -1}, {0, 3, 0}};
  static const double ground[3][3] = {{0, 0, -1}, {2, -1, -1}, {2, 1, -1}};
  static const double lamp[2][3][3] = {{{0, -1, 1}, {0, 1, 1}, {-2, 0, 1}},
                                       {{0, -1, 1}, {2, 0, 1}, {0, 1, 1}}};
  static const double normal[4][3] = {{0, 0, 1}, {0, 0, -1}, {0, 0, 1}, {1, 0, 0}};
  start_random();
  for (int k = 0; k < 100; k++) {
    int over_ground = k % 2, with_riser = k % 4 < 2;
    struct motion motion = random_motion(3);
    struct rad_deck deck = {0};
    add_moved(&deck, &motion, ground, RAD_SIDE_NORMAL);
    add_moved(&deck, &motion, lamp[over_ground], RAD_SIDE_NORMAL);
    add_moved(&deck, &motion, tread, RAD_SIDE_NORMAL);
    if (with_riser)
      add_moved(&deck, &motion, riser, RAD_SIDE_NORMAL);
    for (int t = 0; t < deck.n_triangle; t++)
      for (int d = 0; d < 3; d++)
        deck.triangle[t].optics.normal[d] = rad_dot(motion.axis[d], normal[t]);
    if (over_ground) {
      expect_no_shadow(&deck, "over the ground");
      continue;
    }
    struct shadow *s = expect_shadow(&deck, "over the tread");
    ck_assert(s->i == 0 && s->j == 1 && blocks(s, 2, 2));
    free_shadow(s);
  }
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", seed());
  Suite *suite = suite_create("facing");
  TCase *tests = tcase_create("facing");
  tcase_add_test(tests, sides_of_planes);
  tcase_add_test(tests, facing_takes_both);
  tcase_add_test(tests, shared_vertices_lie_in_the_plane);
  tcase_add_test(tests, a_flat_wall_does_not_face_itself);
  tcase_add_test(tests, cube_walls_face_the_other_five);
  tcase_add_test(tests, convex_scenes_have_no_shadow);
  tcase_add_test(tests, surfaces_of_the_paper_have_no_shadow);
  tcase_add_test(tests, bodies_seen_from_outside_have_no_shadow);
  tcase_add_test(tests, parallel_squares_with_a_blocker);
  tcase_add_test(tests, non_convex_rooms_have_shadows);
  tcase_add_test(tests, a_reflex_edge_shadows_some_pairs);
  tcase_set_timeout(tests, 120);
  suite_add_tcase(suite, tests);
  return run_suite(suite);
}
