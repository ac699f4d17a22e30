/* Scenes from decks: sides, optics, welding, areas, refusals, and warnings of touching triangles.
 */
#include <check.h>
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "scene/check.h"
#include "scene/scene.h"

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

struct motion {
  double rotation[3][3], shift[3];
};

static struct motion random_motion(void) {
  struct motion m;
  double q[4], norm = 0;
  do {
    norm = 0;
    for (int i = 0; i < 4; i++) {
      q[i] = uniform(-1, 1);
      norm += q[i] * q[i];
    }
  } while (norm > 1 || norm < 0.01);
  double w = q[0], x = q[1], y = q[2], z = q[3], s = 2 / norm;
  double r[3][3] = {{1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)},
                    {s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)},
                    {s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)}};
  memcpy(m.rotation, r, sizeof r);
  for (int i = 0; i < 3; i++)
    m.shift[i] = uniform(-3, 3);
  return m;
}

static void move(const struct motion *m, const double x[3], double y[3]) {
  for (int i = 0; i < 3; i++)
    y[i] = rad_dot(m->rotation[i], x) + m->shift[i];
}

/* --- decks --- */

/* Append a triangle with rho 0.5 and emission 1, in line 10, 11, ... */
static struct rad_deck_triangle *add(struct rad_deck *deck, const char *name,
                                     const double v[3][3]) {
  deck->path = "room.yml";
  deck->n_band = 1;
  deck->band[0] = "all";
  size_t n = (size_t)deck->n_triangle + 1;
  if (n == 1 || (n & (n - 1)) == 0)
    deck->triangle = realloc(deck->triangle, 2 * n * sizeof *deck->triangle);
  ck_assert_ptr_nonnull(deck->triangle);
  struct rad_deck_triangle *t = &deck->triangle[deck->n_triangle++];
  *t = (struct rad_deck_triangle){.name = (char *)name, .line = 9 + deck->n_triangle};
  memcpy(t->vertex, v, sizeof t->vertex);
  t->optics.has_rho = t->optics.has_emission = true;
  t->optics.rho[0] = 0.5;
  for (int m = 0; m < 3; m++)
    t->optics.emission[m][0] = 1;
  return t;
}

static const double UNIT[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
static const double RAISED[3][3] = {{0, 0, 2}, {3, 0, 2}, {0, 4, 2}};

/* The corners of a cube, and twelve triangles whose right-hand normals point inwards. */
static const double CUBE[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                  {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
static const int CUBE_TRIANGLE[12][3] = {{0, 1, 2}, {0, 2, 3}, {4, 6, 5}, {4, 7, 6},
                                         {0, 4, 5}, {0, 5, 1}, {3, 2, 6}, {3, 6, 7},
                                         {0, 3, 7}, {0, 7, 4}, {1, 5, 6}, {1, 6, 2}};

struct built {
  struct rad_scene scene;
  struct rad_notes notes;
  struct rad_error error;
  enum rad_code code;
};

static struct built build(struct rad_deck *deck) {
  struct built b = {0};
  b.code = rad_scene_build(deck, &b.scene, &b.notes, &b.error);
  return b;
}

static struct built build_well(struct rad_deck *deck) {
  struct built b = build(deck);
  ck_assert_msg(b.code == RAD_OK, "refused: %s", b.error.text);
  return b;
}

static void drop(struct built *b, struct rad_deck *deck) {
  rad_scene_free(&b->scene);
  rad_scene_free(&b->scene);
  rad_notes_free(&b->notes);
  free(deck->triangle);
  *deck = (struct rad_deck){0};
}

/* Build, expect a refusal with exactly this text, and free everything. */
static void refused(struct rad_deck *deck, const char *text) {
  struct built b = build(deck);
  ck_assert_int_eq(b.code, RAD_EINPUT);
  ck_assert_str_eq(b.error.text, text);
  drop(&b, deck);
}

/* --- what a scene holds --- */

START_TEST(copies_a_triangle) {
  struct rad_deck deck = {0};
  struct rad_deck_triangle *t = add(&deck, "floor", RAISED);
  t->n_grading = 3;
  t->grading[2] = 2.5;
  t->n_elements = 1;
  t->elements[0] = 7;
  t->optics.emission[2][0] = 3;
  struct built b = build_well(&deck);
  const struct rad_scene *s = &b.scene;
  ck_assert_int_eq(s->n_triangle, 1);
  ck_assert_int_eq(s->n_vertex, 3);
  ck_assert_int_eq(s->n_surface, 1);
  ck_assert_int_eq(s->n_band, 1);
  ck_assert_str_eq(s->surface_name[0], "floor");
  ck_assert_str_eq(s->band[0], "all");
  ck_assert(s->size == 5 && s->triangle[0].area == 6);
  const double up[3] = {0, 0, 1};
  ck_assert_mem_eq(s->triangle[0].normal, up, sizeof up);
  ck_assert_mem_eq(s->triangle[0].v, RAISED, sizeof RAISED);
  ck_assert(s->triangle[0].n_grading == 3 && s->triangle[0].grading[2] == 2.5);
  ck_assert(s->triangle[0].n_elements == 1 && s->triangle[0].elements[0] == 7);
  ck_assert_int_eq(s->triangle[0].line, 10);
  ck_assert(s->rho[0] == 0.5 && s->emission[0] == 1 && s->emission[2] == 3);
  ck_assert_int_eq(b.notes.n, 0);
  drop(&b, &deck);
}
END_TEST

START_TEST(turns_normals_by_side) {
  struct rad_deck deck = {0};
  static const enum rad_side side[5] = {RAD_SIDE_UNSET, RAD_SIDE_FRONT, RAD_SIDE_BACK,
                                        RAD_SIDE_NORMAL, RAD_SIDE_NORMAL};
  static const double expected[5] = {1, 1, -1, 1, -1};
  for (int k = 0; k < 5; k++) {
    double v[3][3];
    memcpy(v, UNIT, sizeof v);
    for (int m = 0; m < 3; m++)
      v[m][2] = k;
    struct rad_deck_triangle *t = add(&deck, "plate", v);
    t->optics.side = side[k];
    t->optics.normal[2] = k == 3 ? 1e-200 : -1e200; /* any length */
  }
  struct built b = build_well(&deck);
  for (int k = 0; k < 5; k++) {
    const double normal[3] = {0, 0, expected[k]};
    ck_assert_mem_eq(b.scene.triangle[k].normal, normal, sizeof normal); /* no -0 either */
  }
  drop(&b, &deck);
}
END_TEST

START_TEST(makes_twins_of_both_sides) {
  struct rad_deck deck = {0};
  add(&deck, "floor", RAISED);
  struct rad_deck_triangle *t = add(&deck, "fin", UNIT);
  t->optics.side = RAD_SIDE_BOTH;
  t->optics.rho[0] = 0.25;
  t->optics.emission[1][0] = 9;
  add(&deck, "floor", (double[3][3]){{5, 0, 0}, {6, 0, 0}, {5, 1, 0}});
  struct built b = build_well(&deck);
  const struct rad_triangle *front = &b.scene.triangle[1], *back = &b.scene.triangle[2];
  ck_assert_int_eq(b.scene.n_triangle, 4);
  ck_assert_int_eq(b.scene.n_vertex, 9);
  ck_assert(front->normal[2] == 1 && back->normal[2] == -1);
  ck_assert_mem_eq(front->vertex, back->vertex, sizeof front->vertex);
  ck_assert_mem_eq(front->v, back->v, sizeof front->v);
  ck_assert(b.scene.rho[1] == 0.25 && b.scene.rho[2] == 0.25 && b.scene.rho[3] == 0.5);
  ck_assert(b.scene.emission[4] == 9 && b.scene.emission[7] == 9);
  ck_assert(b.scene.triangle[3].surface == 0 && back->surface == 1);
  ck_assert_int_eq(b.notes.n, 0);
  drop(&b, &deck);
}
END_TEST

START_TEST(own_optics_win_over_the_surface) {
  struct rad_deck deck = {0};
  double high[3][3];
  memcpy(high, RAISED, sizeof high);
  for (int m = 0; m < 3; m++)
    high[m][2] = 5;
  struct rad_deck_triangle *own = add(&deck, "lamp", UNIT);
  own->optics.rho[1] = 0.125;
  own->optics.has_emission = false;
  own->optics.side = RAD_SIDE_FRONT;
  add(&deck, "wall", high)->optics.emission[0][1] = 7;
  struct rad_deck_triangle *shared = add(&deck, "lamp", RAISED);
  shared->optics.has_rho = shared->optics.has_emission = false;
  struct rad_deck_surface lamp = {.name = "lamp", .line = 30};
  lamp.optics.has_rho = lamp.optics.has_emission = true;
  lamp.optics.rho[0] = 0.75;
  lamp.optics.emission[1][1] = 12;
  lamp.optics.side = RAD_SIDE_BACK;
  deck.n_surface = 1;
  deck.surface = &lamp;
  deck.n_band = 2;
  deck.band[1] = "infrared";
  struct built b = build_well(&deck);
  const struct rad_scene *s = &b.scene;
  ck_assert_int_eq(s->n_surface, 2);
  ck_assert_str_eq(s->surface_name[1], "wall");
  ck_assert_str_eq(s->band[1], "infrared");
  ck_assert(s->rho[0] == 0.5 && s->rho[1] == 0.125); /* [triangle, band] */
  ck_assert(s->rho[4] == 0.75 && s->rho[5] == 0);
  ck_assert(s->emission[0] == 0 && s->emission[3] == 12); /* [triangle, vertex, band] */
  ck_assert(s->emission[6 + 1] == 7 && s->emission[12 + 3] == 12);
  ck_assert(s->triangle[0].normal[2] == 1 && s->triangle[2].normal[2] == -1);
  drop(&b, &deck);
}
END_TEST

/* Height 2^-27 * (1 + ...) over an edge of length sqrt(2): the plain cross product of the edges
 * from the first vertex is wrong in its fourth digit. Exactly: (1 + a)(1 - a + b) - 1 = b - a^2 + a
 * b. */
START_TEST(area_of_a_thin_triangle_is_accurate) {
  const double a = 0x1p-27, b = 0x1p-43, area = (b - a * a + a * b) / 2;
  for (int first = 0; first < 3; first++) {
    const double corner[3][3] = {{0, 0, 0}, {1 + a, 1, 0}, {1, 1 - a + b, 0}};
    double v[3][3];
    for (int m = 0; m < 3; m++)
      memcpy(v[m], corner[(first + m) % 3], sizeof v[m]);
    struct rad_deck deck = {0};
    add(&deck, "sliver", v);
    struct built built = build_well(&deck);
    ck_assert_double_eq_tol(built.scene.triangle[0].area, area, 4 * DBL_EPSILON * area);
    ck_assert(built.scene.triangle[0].normal[2] == 1);
    drop(&built, &deck);
  }
}
END_TEST

/* Copies of a random mesh's vertices, each moved by less than half the welding distance, become one
 * vertex each with equal bits; vertices three welding distances apart stay two. */
START_TEST(welds_close_vertices) {
  enum { N_POINT = 200, N_TRIANGLE = 600 };
  start_random();
  struct rad_deck deck = {0};
  double point[N_POINT][3], size = sqrt(3.0); /* of the box; the first two points span it */
  int corner[N_TRIANGLE][3], met[N_POINT];
  for (int p = 0; p < N_POINT; p++)
    for (int m = 0; m < 3; m++) {
      point[p][m] = p < 2 ? p : uniform(0.001, 0.999);
      met[p] = -1;
    }
  for (int m = 0; m < 3; m++) /* two that must not weld */
    point[3][m] = point[2][m] + (m == 1 ? 3e-10 * size : 0);
  for (int t = 0; t < N_TRIANGLE; t++) {
    double v[3][3];
    for (int m = 0; m < 3; m++) {
      corner[t][m] = 4 + (t * 3 + m * (1 + t % 60)) % (N_POINT - 4);
      if (m == 0 && t < 8)
        corner[t][m] = t % 4;
      for (int d = 0; d < 3; d++)
        v[m][d] = point[corner[t][m]][d] + uniform(-0.28e-10, 0.28e-10) * size;
    }
    add(&deck, "cloud", v);
  }
  struct built b = build_well(&deck);
  int n_met = 0;
  for (int t = 0; t < N_TRIANGLE; t++)
    for (int m = 0; m < 3; m++) {
      int *number = &met[corner[t][m]], got = b.scene.triangle[t].vertex[m];
      if (*number < 0) {
        n_met++;
        *number = got;
      }
      ck_assert_msg(*number == got, "triangle %d corner %d: vertex %d, not %d", t, m, got, *number);
      ck_assert_mem_eq(b.scene.triangle[t].v[m], b.scene.vertex[got], 3 * sizeof(double));
      for (int d = 0; d < 3; d++)
        ck_assert(fabs(b.scene.vertex[got][d] - point[corner[t][m]][d]) < 0.3e-10 * size);
    }
  ck_assert_int_eq(b.scene.n_vertex, n_met);
  ck_assert_int_eq(n_met, N_POINT);
  ck_assert_int_ne(met[2], met[3]);
  drop(&b, &deck);
}
END_TEST

/* Both sides of the limit, in all directions and places relative to the grid of the welding. */
START_TEST(welds_up_to_the_limit) {
  start_random();
  for (int k = 0; k < 500; k++) {
    double direction[3], shift[3];
    for (int m = 0; m < 3; m++) {
      direction[m] = uniform(-1, 1);
      shift[m] = uniform(0.2, 0.8);
    }
    double length = rad_norm(direction), limit = 1e-10 * sqrt(3.0);
    double gap = limit * (k % 2 ? 0.999 : 1.001);
    double far[3][3] = {{0, 0, 0}, {0, 0, 1}, {1, 1, 1}}, a[3][3], b[3][3];
    for (int m = 0; m < 3; m++)
      for (int d = 0; d < 3; d++) {
        a[m][d] = shift[d] + (m && m - 1 == d ? 0.1 : 0);
        b[m][d] = m ? a[m][d] - 0.2 * (m - 1 == d) : a[0][d] + gap * direction[d] / length;
      }
    struct rad_deck deck = {0};
    add(&deck, "far", far);
    add(&deck, "a", a);
    add(&deck, "b", b);
    struct built built = build_well(&deck);
    ck_assert_msg(built.scene.n_vertex == (k % 2 ? 8 : 9), "gap %g limits: %d vertices",
                  gap / limit, built.scene.n_vertex);
    drop(&built, &deck);
  }
}
END_TEST

/* --- refusals --- */

START_TEST(refuses_a_deck_without_triangles) {
  struct rad_deck deck = {.path = "room.yml", .mesh_file = "room.obj", .n_band = 1};
  refused(&deck,
          "room.yml: error: reading scene.mesh from OBJ is not available in this version; "
          "give scene.triangles");
  deck = (struct rad_deck){.path = "room.yml", .n_band = 1};
  refused(&deck, "room.yml: error: the scene is empty; give scene.triangles");
}
END_TEST

START_TEST(refuses_missing_optics) {
  struct rad_deck deck = {0};
  add(&deck, "floor", UNIT);
  add(&deck, "lid", RAISED)->optics.has_rho = false;
  refused(&deck,
          "room.yml:11: error: triangle 2 (lid): no rho; give rho here or in "
          "scene.surfaces.lid");
  add(&deck, "floor", UNIT)->optics.has_emission = false;
  refused(&deck,
          "room.yml:10: error: triangle 1 (floor): no emission; give emission here or in "
          "scene.surfaces.floor");
}
END_TEST

START_TEST(refuses_an_unused_surface) {
  struct rad_deck deck = {0};
  struct rad_deck_surface surface[2] = {{.name = "lamp", .line = 30}, {.name = "flor", .line = 31}};
  add(&deck, "ceiling", UNIT);
  add(&deck, "floor", RAISED);
  add(&deck, "lamp", (double[3][3]){{5, 0, 0}, {6, 0, 0}, {5, 1, 0}});
  deck.n_surface = 2;
  deck.surface = surface;
  refused(&deck,
          "room.yml:31: error: scene.surfaces.flor: no triangle has this name; did you mean "
          "'floor'? rename or remove it");
}
END_TEST

START_TEST(refuses_bad_numbers) {
  struct rad_deck deck = {0};
  add(&deck, "floor", UNIT);
  add(&deck, "lid", RAISED)->vertex[1][2] = NAN;
  refused(&deck,
          "room.yml:11: error: triangle 2 (lid): vertex 2 has a coordinate that is not "
          "finite; correct it");
  add(&deck, "floor", UNIT)->optics.rho[0] = 1.5;
  refused(&deck,
          "room.yml:10: error: triangle 1 (floor): rho is 1.5 in band all; give a number "
          "from 0 to 1");
  add(&deck, "floor", UNIT)->optics.rho[0] = NAN;
  refused(&deck,
          "room.yml:10: error: triangle 1 (floor): rho is nan in band all; give a number "
          "from 0 to 1");
  struct rad_deck_triangle *t = add(&deck, "floor", UNIT);
  t->optics.emission[2][0] = INFINITY;
  t->line = 0;
  refused(&deck,
          "room.yml: error: triangle 1 (floor): emission is not finite in band all; "
          "correct it");
  add(&deck, "floor", UNIT)->vertex[1][0] = 1e200;
  refused(&deck,
          "room.yml: error: the bounding box of scene.triangles has diameter 1e+200; give "
          "lengths in a unit that makes it 1e-60 to 1e+60");
}
END_TEST

START_TEST(refuses_degenerate_triangles) {
  struct rad_deck deck = {0};
  double v[3][3] = {{0, 0, 0}, {1, 0, 0}, {0.5, 1.9e-14, 0}};
  add(&deck, "floor", RAISED);
  add(&deck, "line", v);
  refused(&deck,
          "room.yml:11: error: triangle 2 (line): degenerate: its vertices lie on a line "
          "(area 9.5e-15, longest edge 1); move one or delete the triangle");
  v[2][1] = 2.1e-14;
  add(&deck, "thin", v);
  struct built b = build_well(&deck);
  drop(&b, &deck);
  v[2][0] = 1 + 4e-10; /* welds with its neighbour: the scene's size is 5 */
  add(&deck, "floor", RAISED);
  add(&deck, "line", v);
  refused(&deck,
          "room.yml:11: error: triangle 2 (line): degenerate: vertices 2 and 3 are equal to "
          "1e-10 of the scene's size; move one or delete the triangle");
}
END_TEST

START_TEST(refuses_normals_that_are_not_perpendicular) {
  struct rad_deck deck = {0};
  for (int k = 0; k < 4; k++) { /* tilted along x, y, up and down */
    for (int allowed = 0; allowed < 2; allowed++) {
      struct rad_deck_triangle *t = add(&deck, "floor", UNIT);
      t->optics.side = RAD_SIDE_NORMAL;
      t->optics.normal[k % 2] = 3 * (allowed ? 0.99e-6 : 1.01e-6);
      t->optics.normal[2] = k < 2 ? 3 : -3;
      struct built b = build(&deck);
      ck_assert_int_eq(b.code, allowed ? RAD_OK : RAD_EINPUT);
      if (allowed) /* exactly the geometric normal */
        ck_assert(b.scene.triangle[0].normal[2] == (k < 2 ? 1 : -1) &&
                  b.scene.triangle[0].normal[k % 2] == 0);
      drop(&b, &deck);
    }
  }
  struct rad_deck_triangle *t = add(&deck, "floor", UNIT);
  t->optics.side = RAD_SIDE_NORMAL;
  t->optics.normal[1] = t->optics.normal[2] = -1;
  refused(&deck,
          "room.yml:10: error: triangle 1 (floor): normal [0, -1, -1] is 45 degrees off the "
          "perpendicular; give [0, 0, -1], or side: front or back");
  add(&deck, "floor", UNIT)->optics.side = RAD_SIDE_NORMAL;
  refused(&deck,
          "room.yml:10: error: triangle 1 (floor): normal [0, 0, 0] has no direction; give "
          "three finite numbers that are not all zero, or side: front or back");
  t = add(&deck, "floor", UNIT);
  t->optics.side = RAD_SIDE_NORMAL;
  t->optics.normal[0] = NAN;
  t->optics.normal[2] = 1;
  refused(&deck,
          "room.yml:10: error: triangle 1 (floor): normal [nan, 0, 1] has no direction; give "
          "three finite numbers that are not all zero, or side: front or back");
}
END_TEST

START_TEST(refuses_duplicates_and_allows_slits) {
  const double turned[3][3] = {{0, 1, 0}, {0, 0, 0}, {1, 0, 0}};
  const double mirrored[3][3] = {{1, 0, 0}, {0, 0, 0}, {0, 1, 0}};
  struct rad_deck deck = {0};
  add(&deck, "floor", UNIT);
  add(&deck, "lid", RAISED);
  add(&deck, "copy", turned);
  refused(&deck,
          "room.yml:12: error: triangle 3 (copy): same vertices and same normal as triangle "
          "1 (floor); delete one of them, or give them opposite normals to make a slit");
  add(&deck, "floor", UNIT);
  add(&deck, "under", mirrored);
  struct built b = build_well(&deck);
  ck_assert_int_eq(b.notes.n, 0);
  drop(&b, &deck);
  add(&deck, "floor", UNIT);
  add(&deck, "copy", mirrored)->optics.side = RAD_SIDE_BACK;
  refused(&deck,
          "room.yml:11: error: triangle 2 (copy): same vertices and same normal as triangle "
          "1 (floor); delete one of them, or give them opposite normals to make a slit");
  add(&deck, "floor", UNIT);
  add(&deck, "under", mirrored);
  add(&deck, "copy", turned);
  refused(&deck,
          "room.yml:12: error: triangle 3 (copy): same vertices and same normal as triangle "
          "1 (floor); delete one of them, or give them opposite normals to make a slit");
  add(&deck, "slit", UNIT)->optics.side = RAD_SIDE_BOTH;
  add(&deck, "copy", mirrored);
  refused(&deck,
          "room.yml:11: error: triangle 2 (copy): same vertices and same normal as triangle "
          "1 (slit); delete one of them, or give them opposite normals to make a slit");
}
END_TEST

/* --- warnings --- */

/* Notes for two triangles, moved and with their vertices and themselves in any order. */
static void expect_contact(const char *what, const double a[3][3], const double b[3][3],
                           int expected) {
  for (int k = 0; k < 72; k++) {
    struct motion motion = random_motion();
    double moved[2][3][3];
    for (int m = 0; m < 3; m++) {
      int step = k % 2 ? 2 : 1;
      move(&motion, a[(k / 2 + step * m) % 3], moved[k / 36][m]);
      move(&motion, b[(k / 6 + m) % 3], moved[1 - k / 36][m]);
    }
    struct rad_deck deck = {0};
    add(&deck, "a", moved[0]);
    add(&deck, "b", moved[1]);
    struct built built = build_well(&deck);
    ck_assert_msg(built.notes.n == expected, "%s: %d warnings, expected %d (seed %llu, step %d)",
                  what, built.notes.n, expected, (unsigned long long)seed(), k);
    drop(&built, &deck);
  }
}

START_TEST(warns_of_contacts) {
  static const struct {
    const char *what;
    double b[3][3];
    int expected;
  } cases[] = {
      {"far", {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}, 0},
      {"vertex in the face", {{0.2, 0.3, 0}, {1, 0, 1}, {0, 1, 1}}, 1},
      {"vertex in an edge", {{0.4, 0.6, 0}, {1, 1, 1}, {1, 1, 0}}, 1},
      {"edge through the face", {{0.2, 0.3, -1}, {0.2, 0.3, 1}, {3, 3, 0}}, 1},
      {"edge through the face, past the edge", {{0.6, 0.6, -1}, {0.6, 0.6, 1}, {3, 3, 0}}, 0},
      {"own edge through its face", {{-1, 0.3, -1}, {2, 0.3, -1}, {0.3, 0.3, 1}}, 1},
      {"edges cross", {{0.5, -1, 0}, {0.5, 1, 1e-3}, {0.5, -1, -1}}, 1},
      {"edges cross in one plane", {{0.5, -1, 0}, {0.6, 1, 0}, {0.7, -1, 0}}, 1},
      {"inside, in one plane", {{0.2, 0.2, 0}, {0.3, 0.2, 0}, {0.2, 0.3, 0}}, 1},
      {"around, in one plane", {{-9, -9, 0}, {20, -9, 0}, {-9, 20, 0}}, 1},
      {"beside, in one plane", {{0.6, 0.5, 0}, {1, 1, 0}, {0.5, 0.6, 0}}, 0},
      {"just above", {{0, 0, 1e-7}, {1, 0, 1e-7}, {0, 1, 1e-7}}, 0},
      {"barely above", {{0, 0, 5e-10}, {1, 0, 5e-10}, {0, 1, 5e-10}}, 1},
      {"part of an edge", {{0, 0, 0}, {0.5, 0, 0}, {0, -1, 0.5}}, 1},
      {"one vertex, crossing", {{0, 0, 0}, {0.3, 0.3, 1}, {0.3, 0.3, -1}}, 1},
      {"one vertex, crossing beyond", {{0, 0, 0}, {2, 2, 1}, {2, 2, -1}}, 1},
      {"one vertex, overlapping in one plane", {{0, 0, 0}, {2, 0.5, 0}, {0.5, 2, 0}}, 1},
      {"one vertex, beside in one plane", {{0, 0, 0}, {2, -0.1, 0}, {2, -1, 0}}, 0},
      {"one vertex, above", {{0, 0, 0}, {0.3, 0.3, 1}, {0.3, 0.4, 1}}, 0},
      {"one vertex, in the other's edge", {{0, 0, 0}, {0.5, 0.5, 0}, {0.5, 0.5, 1}}, 1},
      {"one edge, square", {{1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, 0},
      {"one edge, folded", {{1, 0, 0}, {0, 1, 0}, {-2, 0.3, 0}}, 1},
      {"one edge, folded inside", {{1, 0, 0}, {0, 1, 0}, {0.2, 0.3, 0}}, 1},
      {"one edge, sharp wedge", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1e-5}}, 0},
      {"one edge, narrow strip folded", {{1, 0, 0}, {0, 1, 0}, {0.49999, 0.49999, 5e-10}}, 1},
      {"one vertex, tiny and above", {{0, 0, 0}, {0, 0, 1e-9}, {-1e-9, 0, 1e-9}}, 0},
      {"one edge, upright", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 0},
  };
  start_random();
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
    expect_contact(cases[k].what, UNIT, cases[k].b, cases[k].expected);
}
END_TEST

static double volume(const double a[3], const double b[3], const double c[3], const double d[3]) {
  double p[3], q[3], r[3], n[3];
  rad_sub(b, a, p);
  rad_sub(c, a, q);
  rad_sub(d, a, r);
  rad_cross(p, q, n);
  return rad_dot(n, r);
}

/* Oracle by signs of volumes: 1 if segment p q crosses t, 0 if not, -1 if too close to tell. */
static int crosses(const double p[3], const double q[3], const struct rad_triangle *t) {
  double side[5] = {volume(t->v[0], t->v[1], t->v[2], p), volume(t->v[0], t->v[1], t->v[2], q),
                    volume(p, q, t->v[0], t->v[1]), volume(p, q, t->v[1], t->v[2]),
                    volume(p, q, t->v[2], t->v[0])};
  for (int k = 0; k < 5; k++)
    if (fabs(side[k]) < 1e-5)
      return -1;
  return side[0] * side[1] < 0 && side[2] * side[3] > 0 && side[3] * side[4] > 0;
}

START_TEST(agrees_with_signs_of_volumes) {
  start_random();
  int n_touch = 0, n_clear = 0;
  for (int k = 0; k < 20000; k++) {
    struct rad_triangle t[2] = {0};
    int n_shared = k % 2;
    for (int m = 0; m < 6; m++) {
      t[m / 3].vertex[m % 3] = m;
      for (int d = 0; d < 3; d++)
        t[m / 3].v[m % 3][d] = uniform(0, 1);
    }
    if (n_shared) {
      memcpy(t[1].v[k / 2 % 3], t[0].v[k / 6 % 3], sizeof t[0].v[0]);
      t[1].vertex[k / 2 % 3] = t[0].vertex[k / 6 % 3];
    }
    for (int i = 0; i < 2; i++) {
      double u[3], v[3], n[3];
      rad_sub(t[i].v[1], t[i].v[0], u);
      rad_sub(t[i].v[2], t[i].v[0], v);
      rad_cross(u, v, n);
      t[i].area = rad_norm(n) / 2;
      for (int d = 0; d < 3; d++)
        t[i].normal[d] = n[d] / rad_norm(n);
    }
    int expected = 0, known = 1;
    for (int i = 0; i < 2; i++)
      for (int m = 0; m < 3; m++) {
        int next = (m + 1) % 3, corner = i ? k / 2 % 3 : k / 6 % 3;
        if (n_shared && (m == corner || next == corner))
          continue;
        int crossing = crosses(t[i].v[m], t[i].v[next], &t[1 - i]);
        known &= crossing >= 0;
        expected |= crossing == 1;
      }
    if (!known)
      continue;
    ck_assert_msg(rad_triangles_touch(&t[0], &t[1], 1e-9) == expected, "seed %llu, pair %d: %d",
                  (unsigned long long)seed(), k, !expected);
    n_touch += expected;
    n_clear += !expected;
  }
  ck_assert(n_touch > 1000 && n_clear > 1000);
}
END_TEST

/* Cubes, boxes as flat as 1e-3 and tetrahedra, with both diagonals, turned at random. */
START_TEST(never_warns_of_convex_neighbours) {
  start_random();
  for (int k = 0; k < 200; k++) {
    struct motion motion = random_motion();
    struct rad_deck deck = {0};
    double corner[8][3], scale[3];
    for (int d = 0; d < 3; d++)
      scale[d] = pow(10, uniform(-1.5, 1.5));
    for (int v = 0; v < 8; v++) {
      double x[3];
      for (int d = 0; d < 3; d++)
        x[d] = CUBE[v][d] * scale[d];
      move(&motion, x, corner[v]);
    }
    static const int tetrahedron[4][3] = {{0, 1, 3}, {0, 4, 1}, {0, 3, 4}, {1, 4, 3}};
    for (int t = 0; t < (k % 2 ? 12 : 4); t++) {
      const int *number = k % 2 ? CUBE_TRIANGLE[t] : tetrahedron[t];
      double v[3][3];
      for (int m = 0; m < 3; m++)
        memcpy(v[m], corner[number[m]], sizeof v[m]);
      add(&deck, "wall", v)->optics.side = k % 4 < 2 ? RAD_SIDE_BOTH : RAD_SIDE_FRONT;
    }
    struct built b = build_well(&deck);
    ck_assert_int_eq(b.scene.n_vertex, k % 2 ? 8 : 4);
    ck_assert_msg(b.notes.n == 0, "seed %llu, step %d: %s", (unsigned long long)seed(), k,
                  b.notes.n ? b.notes.text[0] : "");
    drop(&b, &deck);
  }
}
END_TEST

START_TEST(names_pairs_and_counts_the_rest) {
  struct rad_deck deck = {0};
  const double other[3][3] = {{0.2, 0.2, -1}, {0.2, 0.2, 1}, {0.4, 0.2, 1}};
  for (int k = 0; k < 30; k++)
    for (int pair = 0; pair < 2; pair++) {
      double v[3][3];
      memcpy(v, pair ? other : UNIT, sizeof v);
      for (int m = 0; m < 3; m++)
        v[m][0] -= 2 * k; /* the sweep meets the last first */
      struct rad_deck_triangle *t = add(&deck, pair ? "blade" : "plate", v);
      t->optics.side = k == 1 ? RAD_SIDE_BOTH : RAD_SIDE_FRONT; /* twins warn once */
    }
  struct built b = build_well(&deck);
  ck_assert_int_eq(b.notes.n, RAD_MAX_CONTACT_NOTES + 1);
  for (int k = 0; k < RAD_MAX_CONTACT_NOTES; k++) {
    char expected[300];
    snprintf(expected, sizeof expected,
             "room.yml:%d: warning: triangle %d (blade) touches triangle %d (plate) other than in "
             "a vertex or a whole edge; divide them so that they share vertices and edges",
             11 + 2 * k, 2 * k + 2, 2 * k + 1);
    ck_assert_str_eq(b.notes.text[k], expected);
  }
  ck_assert_str_eq(b.notes.text[RAD_MAX_CONTACT_NOTES],
                   "room.yml: warning: and 10 more pairs of triangles touch other than in a vertex "
                   "or a whole edge");
  drop(&b, &deck);
}
END_TEST

/* A needle that passes 200 triangles and pierces only the last. */
START_TEST(finds_a_contact_at_the_end_of_the_sweep) {
  struct rad_deck deck = {0};
  add(&deck, "needle", (double[3][3]){{-1, 0.1, 5}, {-1, 0.3, 5}, {400, 0.2, 0}});
  for (int k = 0; k <= 200; k++) {
    double z = k < 200 ? 0 : 1.5, x = k < 200 ? k : 300; /* it is at z = 1.25 there */
    add(&deck, "fin", (double[3][3]){{x, -1, z - 0.5}, {x, 1, z - 0.5}, {x, 0.2, z + 0.5}});
  }
  struct built b = build_well(&deck);
  ck_assert_int_eq(b.notes.n, 1);
  ck_assert_ptr_nonnull(strstr(b.notes.text[0], "triangle 202 (fin) touches triangle 1 (needle)"));
  drop(&b, &deck);
}
END_TEST

/* A hilly field of 10368 triangles, one of which is then torn off its neighbours by 1e-8. */
START_TEST(checks_ten_thousand_triangles) {
  enum { N = 72 };
  start_random();
  struct motion motion = random_motion();
  for (int torn = 0; torn < 2; torn++) {
    struct rad_deck deck = {0};
    for (int cell = 0; cell < N * N; cell++)
      for (int half = 0; half < 2; half++) {
        double v[3][3];
        for (int m = 0; m < 3; m++) {
          int x = cell % N + (half ? m != 1 : m == 1), y = cell / N + (half ? m != 0 : m == 2);
          const double at[3] = {x, y, 3 * sin(0.2 * x) * cos(0.3 * y)};
          move(&motion, at, v[m]);
        }
        add(&deck, "field", v);
      }
    deck.triangle[5000].vertex[0][0] += torn ? 5e-8 : 0; /* 5e-10 of the size, more than a weld */
    struct built b = build_well(&deck);
    ck_assert_int_eq(b.scene.n_vertex, (N + 1) * (N + 1) + torn);
    ck_assert_int_eq(b.notes.n > 0, torn);
    drop(&b, &deck);
  }
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", (unsigned long long)seed());
  Suite *suite = suite_create("scene");
  TCase *holds = tcase_create("holds"), *refuses = tcase_create("refuses"),
        *warns = tcase_create("warns");
  tcase_add_test(holds, copies_a_triangle);
  tcase_add_test(holds, turns_normals_by_side);
  tcase_add_test(holds, makes_twins_of_both_sides);
  tcase_add_test(holds, own_optics_win_over_the_surface);
  tcase_add_test(holds, area_of_a_thin_triangle_is_accurate);
  tcase_add_test(holds, welds_close_vertices);
  tcase_add_test(holds, welds_up_to_the_limit);
  tcase_add_test(refuses, refuses_a_deck_without_triangles);
  tcase_add_test(refuses, refuses_missing_optics);
  tcase_add_test(refuses, refuses_an_unused_surface);
  tcase_add_test(refuses, refuses_bad_numbers);
  tcase_add_test(refuses, refuses_degenerate_triangles);
  tcase_add_test(refuses, refuses_normals_that_are_not_perpendicular);
  tcase_add_test(refuses, refuses_duplicates_and_allows_slits);
  tcase_add_test(warns, warns_of_contacts);
  tcase_add_test(warns, agrees_with_signs_of_volumes);
  tcase_add_test(warns, never_warns_of_convex_neighbours);
  tcase_add_test(warns, names_pairs_and_counts_the_rest);
  tcase_add_test(warns, finds_a_contact_at_the_end_of_the_sweep);
  tcase_add_test(warns, checks_ten_thousand_triangles);
  tcase_set_timeout(warns, 120);
  tcase_set_timeout(holds, 120);
  suite_add_tcase(suite, holds);
  suite_add_tcase(suite, refuses);
  suite_add_tcase(suite, warns);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed != 0;
}
