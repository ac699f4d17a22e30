/* Which triangles face each other, and which scenes have shadows: known scenes, turned at random;
 * hulls that a triangle touches or enters; and random segments as an independent oracle. */
#include <check.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "scene/scene.h"
#include "visibility/facing.h"

/* --- random numbers and motions; RAD_TEST_SEED in the environment changes the seed --- */

static uint64_t state;

static uint64_t seed(void) {
  const char *given = getenv("RAD_TEST_SEED");
  return given ? strtoull(given, NULL, 10) : 2003;
}

static double uniform(double low, double high) {
  state += 0x9E3779B97F4A7C15u; /* splitmix64 */
  uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return low + (high - low) * (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static void start_random(void) {
  state = seed();
}

static void random_direction(double d[3]) {
  double length;
  do {
    for (int m = 0; m < 3; m++)
      d[m] = uniform(-1, 1);
    length = rad_norm(d);
  } while (length > 1 || length < 0.1);
  for (int m = 0; m < 3; m++)
    d[m] /= length;
}

struct motion {
  double axis[3][3], shift[3], scale;
};

static struct motion random_motion(void) {
  struct motion m;
  double other[3];
  random_direction(m.axis[0]);
  do {
    random_direction(other);
    rad_cross(m.axis[0], other, m.axis[1]);
  } while (rad_norm(m.axis[1]) < 0.1);
  double length = rad_norm(m.axis[1]);
  for (int d = 0; d < 3; d++)
    m.axis[1][d] /= length;
  rad_cross(m.axis[0], m.axis[1], m.axis[2]);
  m.scale = pow(10, uniform(-3, 3));
  for (int d = 0; d < 3; d++)
    m.shift[d] = m.scale * uniform(-3, 3);
  return m;
}

static void move(const struct motion *m, const double x[3], double y[3]) {
  for (int d = 0; d < 3; d++)
    y[d] = m->scale * rad_dot(m->axis[d], x) + m->shift[d];
}

/* --- scenes --- */

static void add(struct rad_deck *deck, const struct motion *motion, const double v[3][3],
                enum rad_side side) {
  deck->path = "room.yml";
  deck->n_band = 1;
  deck->band[0] = "all";
  size_t n = (size_t)deck->n_triangle + 1;
  if (n == 1 || (n & (n - 1)) == 0)
    deck->triangle = realloc(deck->triangle, 2 * n * sizeof *deck->triangle);
  ck_assert_ptr_nonnull(deck->triangle);
  struct rad_deck_triangle *t = &deck->triangle[deck->n_triangle++];
  *t = (struct rad_deck_triangle){.name = "wall", .line = deck->n_triangle};
  for (int m = 0; m < 3; m++)
    move(motion, v[m], t->vertex[m]);
  t->optics.has_rho = t->optics.has_emission = true;
  t->optics.side = side;
}

static struct rad_scene build(struct rad_deck *deck) {
  struct rad_scene scene;
  struct rad_notes notes = {0};
  struct rad_error error;
  enum rad_code code = rad_scene_build(deck, &scene, &notes, &error);
  ck_assert_msg(code == RAD_OK, "refused: %s", error.text);
  rad_notes_free(&notes);
  free(deck->triangle);
  *deck = (struct rad_deck){0};
  return scene;
}

/* The deck's scene has a shadow or not, as expected; into found which. */
static void expect_shadow(struct rad_deck *deck, int expected, int found[3], const char *what) {
  struct rad_scene scene = build(deck);
  for (int m = 0; m < 3; m++)
    found[m] = -7;
  int got = rad_find_shadow(&scene, found);
  ck_assert_msg(got == expected, "%s: found %d (%d %d %d), seed %llu", what, got, found[0],
                found[1], found[2], (unsigned long long)seed());
  if (!got)
    ck_assert(found[0] == -7 && found[1] == -7 && found[2] == -7);
  rad_scene_free(&scene);
}

/* A prism over a polygon in x, y, cut into triangles; its right-hand normals point outwards. */
static void add_prism(struct rad_deck *deck, const struct motion *motion, int n,
                      const double (*polygon)[2], int n_cap, const int (*cap)[3], double low,
                      double high, enum rad_side side) {
  for (int k = 0; k < n; k++) {
    const double *p = polygon[k], *q = polygon[(k + 1) % n];
    const double c[4][3] = {
        {p[0], p[1], low}, {q[0], q[1], low}, {q[0], q[1], high}, {p[0], p[1], high}};
    const int half[2][2][3] = {{{0, 1, 2}, {0, 2, 3}}, {{0, 1, 3}, {1, 2, 3}}};
    for (int h = 0; h < 2; h++) {
      double v[3][3];
      for (int m = 0; m < 3; m++)
        memcpy(v[m], c[half[k % 2][h][m]], sizeof v[m]);
      add(deck, motion, v, side);
    }
  }
  for (int k = 0; k < 2 * n_cap; k++) {
    double v[3][3];
    for (int m = 0; m < 3; m++) {
      const double *p = polygon[cap[k / 2][k % 2 ? m : 2 - m]];
      v[m][0] = p[0];
      v[m][1] = p[1];
      v[m][2] = k % 2 ? high : low;
    }
    add(deck, motion, v, side);
  }
}

static const double SQUARE[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
static const int SQUARE_CAP[2][3] = {{0, 1, 2}, {0, 2, 3}};
static const double ELL[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
static const int ELL_CAP[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}};

static void add_cube(struct rad_deck *deck, const struct motion *motion, enum rad_side side) {
  add_prism(deck, motion, 4, SQUARE, 2, SQUARE_CAP, 0, 1, side);
}

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
    struct motion motion = random_motion();
    struct rad_deck deck = {0};
    add(&deck, &motion, floor, RAD_SIDE_FRONT);
    add(&deck, &motion, cases[c].v, RAD_SIDE_FRONT);
    struct rad_scene scene = build(&deck);
    enum rad_side_of_plane got = rad_side_of(&scene.triangle[0], &scene.triangle[1]);
    ck_assert_msg(got == cases[c].side, "case %zu: %d, seed %llu", c, (int)got,
                  (unsigned long long)seed());
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
    struct motion motion = random_motion();
    struct rad_deck deck = {0};
    add(&deck, &motion, low, k & 1 ? RAD_SIDE_BACK : RAD_SIDE_FRONT);
    add(&deck, &motion, high, k & 2 ? RAD_SIDE_BACK : RAD_SIDE_FRONT);
    struct rad_scene scene = build(&deck);
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
    struct motion motion = random_motion();
    struct rad_deck deck = {0};
    for (int cell = 0; cell < N * N; cell++) {
      double x = cell % N, y = cell / N;
      add(&deck, &motion, (double[3][3]){{x, y, 0}, {x + 1, y, 0}, {x, y + 1, 0}}, RAD_SIDE_BOTH);
      add(&deck, &motion, (double[3][3]){{x + 1, y, 0}, {x + 1, y + 1, 0}, {x, y + 1, 0}},
          RAD_SIDE_BOTH);
    }
    struct rad_scene scene = build(&deck);
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
    struct motion motion = random_motion();
    struct rad_deck deck = {0};
    add_cube(&deck, &motion, inside ? RAD_SIDE_BACK : RAD_SIDE_FRONT);
    struct rad_scene scene = build(&deck);
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

START_TEST(convex_scenes_have_no_shadow) {
  static const double corner[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  static const int tetrahedron[4][3] = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  static const enum rad_side side[3] = {RAD_SIDE_FRONT, RAD_SIDE_BACK, RAD_SIDE_BOTH};
  int found[3];
  start_random();
  for (int k = 0; k < 150; k++) {
    struct motion motion = random_motion();
    struct rad_deck deck = {0};
    add_cube(&deck, &motion, side[k % 3]);
    expect_shadow(&deck, 0, found, "cube");
    for (int t = 0; t < 4; t++) {
      double v[3][3];
      for (int m = 0; m < 3; m++)
        memcpy(v[m], corner[tetrahedron[t][m]], sizeof v[m]);
      add(&deck, &motion, v, side[k % 3]);
    }
    expect_shadow(&deck, 0, found, "tetrahedron");
    double gon[12][2];
    int cap[10][3];
    for (int c = 0; c < 12; c++) {
      gon[c][0] = cos(0.5235987755982988 * c);
      gon[c][1] = sin(0.5235987755982988 * c);
      if (c < 10)
        memcpy(cap[c], ((int[3]){0, c + 1, c + 2}), sizeof cap[c]);
    }
    add_prism(&deck, &motion, 12, gon, 10, cap, 0, pow(10, uniform(-2, 2)), side[k % 3]);
    expect_shadow(&deck, 0, found, "drum");
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
  int found[3];
  start_random();
  for (int k = 0; k < 200; k++) {
    struct motion motion = random_motion();
    struct rad_deck deck = {0};
    for (int t = 0; t < 3; t++) /* the right-hand normals are the paper's */
      add(&deck, &motion, surface[k % 2][t], RAD_SIDE_FRONT);
    expect_shadow(&deck, 0, found, k % 2 ? "S2" : "S1");
  }
}
END_TEST

/* Planes of one body cut the other, so that every triangle is tried: but whatever a body's face
 * sees, the body is behind it. Likewise the two walls in the notch of an L seen from outside. */
START_TEST(bodies_seen_from_outside_have_no_shadow) {
  int found[3];
  start_random();
  for (int k = 0; k < 100; k++) {
    struct motion motion = random_motion(), other = random_motion();
    double gap = uniform(1.8, 3), direction[3]; /* the cubes' diameters are 1.73 and less */
    random_direction(direction);
    other.scale = motion.scale * uniform(0.1, 1);
    for (int d = 0; d < 3; d++)
      other.shift[d] = motion.shift[d] + 2 * gap * motion.scale * direction[d];
    struct rad_deck deck = {0};
    add_cube(&deck, &motion, RAD_SIDE_FRONT);
    add_cube(&deck, &other, RAD_SIDE_FRONT);
    expect_shadow(&deck, 0, found, "two cubes");
    add_prism(&deck, &motion, 6, ELL, 4, ELL_CAP, 0, 1, RAD_SIDE_FRONT);
    expect_shadow(&deck, 0, found, "L from outside");
  }
}
END_TEST

/* --- scenes with a shadow --- */

static void add_squares(struct rad_deck *deck, const struct motion *motion, enum rad_side floor) {
  for (int k = 0; k < 4; k++) {
    double v[3][3];
    for (int m = 0; m < 3; m++) {
      const double *p = SQUARE[SQUARE_CAP[k % 2][m]];
      memcpy(v[m], ((double[3]){p[0], p[1], k / 2}), sizeof v[m]);
    }
    add(deck, motion, v, k / 2 ? RAD_SIDE_BACK : floor);
  }
}

/* The blocker's edge reaches by 1e-6 into the space between the squares, or misses it by that. */
START_TEST(parallel_squares_with_a_blocker) {
  int found[3];
  start_random();
  for (int k = 0; k < 100; k++) {
    struct motion motion = random_motion();
    struct rad_deck deck = {0};
    enum rad_side floor = k % 3 ? RAD_SIDE_FRONT : RAD_SIDE_BOTH;
    add_squares(&deck, &motion, floor);
    expect_shadow(&deck, 0, found, "squares");
    for (int n = 0; n < 3; n++) {
      double x = n == 0 ? 0.3 : n == 1 ? 1 - 1e-6 : 1 + 1e-6;
      const double tip[3][3] = {{x, 0.4, 0.5}, {3, 0.2, 0.6}, {3, 0.7, 0.4}};
      const double edge[3][3] = {{x, 0.2, 0.4}, {x, 0.7, 0.5}, {3, 0.5, 0.5}};
      add_squares(&deck, &motion, floor);
      add(&deck, &motion, k % 2 ? tip : edge, k % 4 < 2 ? RAD_SIDE_FRONT : RAD_SIDE_BOTH);
      expect_shadow(&deck, n < 2, found, "squares and a blocker");
      if (n < 2)
        ck_assert_int_ge(found[2], floor == RAD_SIDE_BOTH ? 6 : 4);
    }
  }
}
END_TEST

START_TEST(non_convex_rooms_have_shadows) {
  int found[3];
  start_random();
  for (int k = 0; k < 50; k++) {
    struct motion motion = random_motion();
    struct rad_deck deck = {0};
    add_prism(&deck, &motion, 6, ELL, 4, ELL_CAP, 0, 1, RAD_SIDE_BACK);
    expect_shadow(&deck, 1, found, "L from inside");
    /* the walls at the reflex edge are those of polygon edges 2 and 3: triangles 4 to 7 */
    ck_assert(found[2] >= 4 && found[2] <= 7);
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
  int found[3];
  start_random();
  for (int k = 0; k < 100; k++) {
    int over_ground = k % 2, with_riser = k % 4 < 2;
    struct motion motion = random_motion();
    struct rad_deck deck = {0};
    add(&deck, &motion, ground, RAD_SIDE_NORMAL);
    add(&deck, &motion, lamp[over_ground], RAD_SIDE_NORMAL);
    add(&deck, &motion, tread, RAD_SIDE_NORMAL);
    if (with_riser)
      add(&deck, &motion, riser, RAD_SIDE_NORMAL);
    for (int t = 0; t < deck.n_triangle; t++)
      for (int d = 0; d < 3; d++)
        deck.triangle[t].optics.normal[d] = rad_dot(motion.axis[d], normal[t]);
    expect_shadow(&deck, !over_ground, found, over_ground ? "over the ground" : "over the tread");
    if (!over_ground)
      ck_assert(found[0] == 0 && found[1] == 1 && found[2] == 2);
  }
}
END_TEST

/* --- hulls that a third triangle touches or enters --- */

/* Corners of t's part in front of a plane through `at`. */
static int cut_front(const struct rad_triangle *t, const double at[3], const double normal[3],
                     double (*corner)[3]) {
  int n = 0;
  double h[3];
  for (int m = 0; m < 3; m++) {
    double r[3];
    rad_sub(t->v[m], at, r);
    h[m] = rad_dot(normal, r);
    if (h[m] >= 0)
      memcpy(corner[n++], t->v[m], sizeof *corner);
  }
  for (int m = 0; m < 3; m++) {
    int o = (m + 1) % 3;
    if (h[m] * h[o] < 0) {
      for (int d = 0; d < 3; d++)
        corner[n][d] = (t->v[m][d] * h[o] - t->v[o][d] * h[m]) / (h[o] - h[m]);
      n++;
    }
  }
  return n;
}

/* Two random triangles that face each other well, as the first two of a scene of three. */
struct pair {
  struct rad_triangle t[3];
  double corner[2][4][3]; /* of the cut triangles */
  int n[2];
};

static void set_triangle(struct rad_triangle *t, int number) {
  double u[3], v[3], n[3];
  rad_sub(t->v[1], t->v[0], u);
  rad_sub(t->v[2], t->v[0], v);
  rad_cross(u, v, n);
  for (int d = 0; d < 3; d++) {
    t->normal[d] = n[d] / rad_norm(n);
    t->vertex[d] = 3 * number + d;
  }
  t->area = rad_norm(n) / 2;
}

static double depth(const double (*corner)[3], int n, const struct rad_triangle *t) {
  double most = 0;
  for (int c = 0; c < n; c++) {
    double r[3];
    rad_sub(corner[c], t->v[0], r);
    most = fmax(most, rad_dot(r, t->normal));
  }
  return most;
}

static void random_pair(struct pair *p) {
  do {
    *p = (struct pair){0};
    for (int i = 0; i < 2; i++) {
      do {
        for (int m = 0; m < 9; m++)
          p->t[i].v[m / 3][m % 3] = uniform(0, 1);
        set_triangle(&p->t[i], i);
      } while (p->t[i].area < 0.02);
    }
    for (int i = 0; i < 2; i++)
      p->n[i] = cut_front(&p->t[i], p->t[1 - i].v[0], p->t[1 - i].normal, p->corner[i]);
  } while (!p->n[0] || !p->n[1] || depth(p->corner[0], p->n[0], &p->t[1]) < 0.05 ||
           depth(p->corner[1], p->n[1], &p->t[0]) < 0.05);
}

/* Whether t[2] is reported to shadow t[0] and t[1]; that pair comes first in rad_find_shadow. */
static int third_shadows(struct pair *p) {
  double vertex[9][3];
  for (int m = 0; m < 9; m++)
    memcpy(vertex[m], p->t[m / 3].v[m % 3], sizeof vertex[m]);
  struct rad_scene scene = {.n_triangle = 3, .n_vertex = 9, .triangle = p->t, .size = 1.7};
  scene.vertex = vertex;
  int found[3] = {-1, -1, -1};
  return rad_find_shadow(&scene, found) && found[0] == 0 && found[1] == 1 && found[2] == 2;
}

/* The greatest value of direction . x on the hull, and where. */
static double support(const struct pair *p, const double direction[3], const double **at) {
  double most = -INFINITY;
  for (int i = 0; i < 2; i++)
    for (int c = 0; c < p->n[i]; c++)
      if (rad_dot(direction, p->corner[i][c]) > most) {
        most = rad_dot(direction, p->corner[i][c]);
        *at = p->corner[i][c];
      }
  return most;
}

/* Make t[2] a triangle around `at` beyond the plane through it with this normal, touching the
 * plane with 1, 2 or 3 vertices, shifted along the normal. */
static void lean(struct pair *p, const double at[3], const double normal[3], int n_touching,
                 double shift) {
  double u[3], w[3];
  rad_cross(normal, fabs(normal[0]) < 0.6 ? (double[3]){1, 0, 0} : (double[3]){0, 1, 0}, u);
  double length = rad_norm(u), start = uniform(0, 6.3);
  for (int d = 0; d < 3; d++)
    u[d] /= length;
  rad_cross(normal, u, w);
  for (int m = 0; m < 3; m++) {
    double angle = start + 2.1 * m, reach = uniform(0.1, 1);
    double up = shift + (m < n_touching ? 0 : uniform(0.05, 1));
    int at_point = m == 0 && n_touching == 1;
    for (int d = 0; d < 3; d++)
      p->t[2].v[m][d] =
          at[d] + up * normal[d] + (at_point ? 0 : reach * (cos(angle) * u[d] + sin(angle) * w[d]));
  }
  set_triangle(&p->t[2], 2);
}

/* A vertex, an edge or the face of the third triangle on a corner of the hull, in any direction: no
 * shadow, and one as soon as it is pushed 1e-4 inwards by its vertex or its face. */
START_TEST(touching_the_hull_is_no_shadow) {
  start_random();
  for (int k = 0; k < 5000; k++) {
    struct pair p;
    random_pair(&p);
    double direction[3];
    const double *at = NULL;
    random_direction(direction);
    support(&p, direction, &at);
    lean(&p, at, direction, 1 + k % 3, 0);
    ck_assert_msg(!third_shadows(&p), "step %d, seed %llu", k, (unsigned long long)seed());
    lean(&p, at, direction, 3, -1e-4); /* at is well inside the triangle: it cuts the corner off */
    ck_assert_msg(third_shadows(&p), "step %d pushed in, seed %llu", k, (unsigned long long)seed());
  }
}
END_TEST

/* The same on the faces of the hull, spanned by three of its corners. */
START_TEST(lying_on_the_hull_is_no_shadow) {
  start_random();
  int n_face = 0;
  for (int k = 0; k < 3000; k++) {
    struct pair p;
    random_pair(&p);
    int i = k % 2, first = k % p.n[i], second = (k + 1) % p.n[i], third = k % p.n[1 - i];
    const double *a = p.corner[i][first], *b = p.corner[i][second], *c = p.corner[1 - i][third],
                 *at;
    double u[3], v[3], normal[3], center[3];
    rad_sub(b, a, u);
    rad_sub(c, a, v);
    rad_cross(u, v, normal);
    double length = rad_norm(normal);
    if (length < 0.05)
      continue;
    for (int flip = 0; flip < 2; flip++) {
      for (int d = 0; d < 3; d++) {
        normal[d] *= (flip ? -1 : 1 / length);
        center[d] = (a[d] + b[d] + c[d]) / 3;
      }
      if (support(&p, normal, &at) > rad_dot(normal, a) + 1e-12)
        continue; /* not a face */
      n_face++;
      for (int n = 1; n <= 3; n++) {
        lean(&p, center, normal, n, 0);
        ck_assert_msg(!third_shadows(&p), "step %d, seed %llu", k, (unsigned long long)seed());
        lean(&p, center, normal, n, -1e-7);
        ck_assert_msg(n == 2 || third_shadows(&p), "step %d pushed in, seed %llu", k,
                      (unsigned long long)seed());
      }
    }
  }
  ck_assert_int_gt(n_face, 300);
}
END_TEST

/* --- random segments --- */

static void random_point(const struct rad_triangle *t, double x[3]) {
  double a = uniform(0, 1), b = uniform(0, 1);
  if (a + b > 1) {
    a = 1 - a;
    b = 1 - b;
  }
  for (int d = 0; d < 3; d++)
    x[d] = t->v[0][d] + a * (t->v[1][d] - t->v[0][d]) + b * (t->v[2][d] - t->v[0][d]);
}

/* Solve x + s (y - x) = v0 + a (v1 - v0) + b (v2 - v0) by Cramer's rule; a margin of 1e-6. */
static int hits(const double x[3], const double y[3], const struct rad_triangle *t) {
  double r[3], u[3], v[3], w[3], vw[3], ru[3];
  rad_sub(y, x, r);
  rad_sub(t->v[1], t->v[0], u);
  rad_sub(t->v[2], t->v[0], v);
  rad_sub(x, t->v[0], w);
  rad_cross(r, v, vw);
  double det = rad_dot(u, vw);
  if (fabs(det) < 1e-9)
    return 0;
  double a = rad_dot(w, vw) / det;
  rad_cross(w, u, ru);
  double b = rad_dot(r, ru) / det, s = rad_dot(v, ru) / det, margin = 1e-6;
  return a > margin && b > margin && a + b < 1 - margin && s > margin && s < 1 - margin;
}

/* Segments between points that face each other; if any is hit there must be a shadow. */
static int sampled_shadow(const struct rad_scene *scene, int n_sample) {
  for (int k = 0; k < n_sample; k++) {
    int i = (int)uniform(0, scene->n_triangle), j = (int)uniform(0, scene->n_triangle);
    const struct rad_triangle *t = scene->triangle;
    double x[3], y[3], r[3];
    random_point(&t[i], x);
    random_point(&t[j], y);
    rad_sub(y, x, r);
    if (i == j || rad_dot(r, t[i].normal) < 1e-6 || rad_dot(r, t[j].normal) > -1e-6)
      continue;
    ck_assert_msg(rad_faces(&t[i], &t[j]), "%d and %d face, seed %llu", i, j,
                  (unsigned long long)seed());
    for (int o = 0; o < scene->n_triangle; o++)
      if (o != i && o != j && hits(x, y, &t[o]))
        return 1;
  }
  return 0;
}

START_TEST(agrees_with_random_segments) {
  start_random();
  int n_shadow = 0, n_sampled = 0, n_clear = 0;
  for (int k = 0; k < 1000; k++) {
    struct rad_triangle t[6] = {0};
    double vertex[18][3];
    int n = 3 + k % 4;
    double reach = uniform(0.2, 1);
    for (int i = 0; i < n; i++) {
      double center[3];
      for (int d = 0; d < 3; d++)
        center[d] = uniform(0, 1);
      do {
        for (int m = 0; m < 9; m++)
          t[i].v[m / 3][m % 3] = center[m % 3] + reach * uniform(-1, 1);
        set_triangle(&t[i], i);
      } while (t[i].area < 0.01 * reach * reach);
      memcpy(vertex[3 * i], t[i].v, sizeof t[i].v);
    }
    struct rad_scene scene = {.n_triangle = n, .n_vertex = 3 * n, .triangle = t, .size = 2};
    scene.vertex = vertex;
    int found[3];
    int shadow = rad_find_shadow(&scene, found), sampled = sampled_shadow(&scene, 2000);
    ck_assert_msg(shadow || !sampled, "step %d: missed, seed %llu", k, (unsigned long long)seed());
    n_shadow += shadow;
    n_sampled += sampled;
    n_clear += !shadow;
  }
  printf("random scenes: %d with a shadow, %d of them seen by segments, %d without\n", n_shadow,
         n_sampled, n_clear);
  ck_assert(n_sampled > 200 && n_clear > 100);
}
END_TEST

/* The oracle itself sees the shadows in the L and none in the cube. */
START_TEST(segments_agree_on_known_scenes) {
  start_random();
  struct motion motion = random_motion();
  motion.scale = 1;
  for (int convex = 0; convex < 2; convex++) {
    struct rad_deck deck = {0};
    if (convex)
      add_cube(&deck, &motion, RAD_SIDE_BACK);
    else
      add_prism(&deck, &motion, 6, ELL, 4, ELL_CAP, 0, 1, RAD_SIDE_BACK);
    struct rad_scene scene = build(&deck);
    ck_assert_int_eq(sampled_shadow(&scene, 50000), !convex);
    rad_scene_free(&scene);
  }
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", (unsigned long long)seed());
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
  tcase_add_test(tests, touching_the_hull_is_no_shadow);
  tcase_add_test(tests, lying_on_the_hull_is_no_shadow);
  tcase_add_test(tests, agrees_with_random_segments);
  tcase_add_test(tests, segments_agree_on_known_scenes);
  tcase_set_timeout(tests, 120);
  suite_add_tcase(suite, tests);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed != 0;
}
