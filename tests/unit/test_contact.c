/* What is said of triangles that meet other than in a vertex or a whole edge. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/vec.h"
#include "scene/check.h"
#include "scene/contact.h"
#include "scene_help.h"
#include "suite.h"

/* The corners of a cube, and twelve triangles whose right-hand normals point inwards. */
static const double CUBE[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                  {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
static const int CUBE_TRIANGLE[12][3] = {{0, 1, 2}, {0, 2, 3}, {4, 6, 5}, {4, 7, 6},
                                         {0, 4, 5}, {0, 5, 1}, {3, 2, 6}, {3, 6, 7},
                                         {0, 3, 7}, {0, 7, 4}, {1, 5, 6}, {1, 6, 2}};

/* What is said of two triangles, or what depends on their sides: of one plane. */
enum outcome { SILENT, TOUCHES, CROSSES, REFUSED, ONE_PLANE };

static const char *const OUTCOME[] = {"silent", "touches", "crosses", "refused"};

static enum outcome outcome_of(const struct built *b) {
  if (b->code == RAD_EINPUT && strstr(b->error.text, "facing the same way"))
    return REFUSED;
  ck_assert_msg(b->code == RAD_OK && b->notes.n <= 1, "%s", b->error.text);
  return b->notes.n == 0 ? SILENT : strstr(b->notes.text[0], ") touches ") ? TOUCHES : CROSSES;
}

/* Of one plane: refused if they face the same way; opposite faces see each other through a gap. */
static enum outcome by_sides(const double a[3][3], const double b[3][3]) {
  struct rad_triangle t[2] = {0};
  memcpy(t[0].v, a, sizeof t[0].v);
  memcpy(t[1].v, b, sizeof t[1].v);
  measure_triangle(&t[0]);
  measure_triangle(&t[1]);
  double above = 0;
  for (int m = 0; m < 3; m++) {
    double r[3];
    rad_sub(b[m], a[0], r);
    above = fmax(above, rad_dot(t[0].normal, r));
  }
  return rad_dot(t[0].normal, t[1].normal) > 0 ? REFUSED : above > 1e-10 ? TOUCHES : SILENT;
}

/* Two triangles, moved and with their vertices and themselves in any order. */
static void expect_contact(const char *what, const double a[3][3], const double b[3][3],
                           enum outcome expected) {
  for (int k = 0; k < 72; k++) {
    struct motion motion = random_motion(0);
    double moved[2][3][3];
    for (int m = 0; m < 3; m++) {
      int step = k % 2 ? 2 : 1;
      move(&motion, a[(k / 2 + step * m) % 3], moved[k / 36][m]);
      move(&motion, b[(k / 6 + m) % 3], moved[1 - k / 36][m]);
    }
    struct rad_deck deck = {0};
    add(&deck, "a", moved[0]);
    add(&deck, "b", moved[1]);
    struct built built = build(&deck);
    enum outcome wanted =
        expected == ONE_PLANE ? by_sides(moved[k / 36], moved[1 - k / 36]) : expected;
    enum outcome is = outcome_of(&built);
    ck_assert_msg(is == wanted, "%s: %s, expected %s (seed %llu, step %d)", what, OUTCOME[is],
                  OUTCOME[wanted], seed(), k);
    drop(&built, &deck);
  }
}

START_TEST(warns_of_contacts) {
  static const struct {
    const char *what;
    double b[3][3];
    enum outcome expected;
  } cases[] = {
      {"far", {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}, SILENT},
      {"vertex in the face", {{0.2, 0.3, 0}, {1, 0, 1}, {0, 1, 1}}, TOUCHES},
      {"vertex in an edge", {{0.4, 0.6, 0}, {1, 1, 1}, {1, 1, 0}}, TOUCHES},
      {"edge through the face", {{0.2, 0.3, -1}, {0.2, 0.3, 1}, {3, 3, 0}}, CROSSES},
      {"edge through the face, past the edge", {{0.6, 0.6, -1}, {0.6, 0.6, 1}, {3, 3, 0}}, SILENT},
      {"own edge through its face", {{-1, 0.3, -1}, {2, 0.3, -1}, {0.3, 0.3, 1}}, CROSSES},
      {"edges cross", {{0.5, -1, 0}, {0.5, 1, 1e-3}, {0.5, -1, -1}}, CROSSES},
      {"edges cross in one plane", {{0.5, -1, 0}, {0.6, 1, 0}, {0.7, -1, 0}}, ONE_PLANE},
      {"inside, in one plane", {{0.2, 0.2, 0}, {0.3, 0.2, 0}, {0.2, 0.3, 0}}, ONE_PLANE},
      {"around, in one plane", {{-9, -9, 0}, {20, -9, 0}, {-9, 20, 0}}, ONE_PLANE},
      {"beside, in one plane", {{0.6, 0.5, 0}, {1, 1, 0}, {0.5, 0.6, 0}}, SILENT},
      {"just above", {{0, 0, 1e-7}, {1, 0, 1e-7}, {0, 1, 1e-7}}, SILENT},
      {"barely above", {{0, 0, 5e-10}, {1, 0, 5e-10}, {0, 1, 5e-10}}, ONE_PLANE},
      {"part of an edge", {{0, 0, 0}, {0.5, 0, 0}, {0, -1, 0.5}}, TOUCHES},
      {"one vertex, crossing", {{0, 0, 0}, {0.3, 0.3, 1}, {0.3, 0.3, -1}}, CROSSES},
      {"one vertex, crossing beyond", {{0, 0, 0}, {2, 2, 1}, {2, 2, -1}}, CROSSES},
      {"one vertex, overlapping in one plane", {{0, 0, 0}, {2, 0.5, 0}, {0.5, 2, 0}}, ONE_PLANE},
      {"one vertex, beside in one plane", {{0, 0, 0}, {2, -0.1, 0}, {2, -1, 0}}, SILENT},
      {"one vertex, above", {{0, 0, 0}, {0.3, 0.3, 1}, {0.3, 0.4, 1}}, SILENT},
      {"one vertex, in the other's edge", {{0, 0, 0}, {0.5, 0.5, 0}, {0.5, 0.5, 1}}, TOUCHES},
      {"one edge, square", {{1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, SILENT},
      {"one edge, folded", {{1, 0, 0}, {0, 1, 0}, {-2, 0.3, 0}}, ONE_PLANE},
      {"one edge, folded inside", {{1, 0, 0}, {0, 1, 0}, {0.2, 0.3, 0}}, ONE_PLANE},
      {"one edge, sharp wedge", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1e-5}}, SILENT},
      {"one edge, narrow strip folded",
       {{1, 0, 0}, {0, 1, 0}, {0.49999, 0.49999, 5e-10}},
       ONE_PLANE},
      {"one vertex, tiny and above", {{0, 0, 0}, {0, 0, 1e-9}, {-1e-9, 0, 1e-9}}, SILENT},
      {"one edge, upright", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, SILENT},
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
    for (int i = 0; i < 2; i++)
      measure_triangle(&t[i]);
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
                  seed(), k, !expected);
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
    struct motion motion = random_motion(0);
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
    ck_assert_msg(b.notes.n == 0, "seed %llu, step %d: %s", seed(), k,
                  b.notes.n ? b.notes.text[0] : "");
    drop(&b, &deck);
  }
}
END_TEST

/* Thirty plates with blades, every second of which goes through its plate: these come first. */
START_TEST(names_pairs_and_counts_the_rest) {
  struct rad_deck deck = {0};
  for (int k = 0; k < 30; k++)
    for (int pair = 0; pair < 2; pair++) {
      const double other[3][3] = {{0.2, 0.2, k % 2 ? -1 : 0}, {0.2, 0.2, 1}, {0.4, 0.2, 1}};
      double v[3][3];
      memcpy(v, pair ? other : UNIT, sizeof v);
      for (int m = 0; m < 3; m++)
        v[m][0] -= 2 * k; /* the sweep meets the last first */
      struct rad_deck_triangle *t = add(&deck, pair ? "blade" : "plate", v);
      t->optics.side = k == 1 ? RAD_SIDE_BOTH : RAD_SIDE_FRONT; /* twins warn once */
    }
  struct built b = build_well(&deck);
  ck_assert_int_eq(b.notes.n, RAD_MAX_CONTACT_NOTES + 1);
  for (int note = 0; note < RAD_MAX_CONTACT_NOTES; note++) {
    char expected[300];
    int crosses = note < 15, k = crosses ? 2 * note + 1 : 2 * (note - 15);
    snprintf(expected, sizeof expected,
             "room.yml:%d: warning: triangle %d (blade) %s triangle %d (plate)%s", 11 + 2 * k,
             2 * k + 2, crosses ? "crosses" : "touches", 2 * k + 1,
             crosses ? ", where the radiosity jumps inside both; cut them along their common line "
                       "(tools/convert --conform)"
                     : " other than in a vertex or a whole edge; divide them so that they share "
                       "vertices and edges");
    ck_assert_str_eq(b.notes.text[note], expected);
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
  ck_assert_ptr_nonnull(strstr(b.notes.text[0], "triangle 202 (fin) crosses triangle 1 (needle)"));
  drop(&b, &deck);
}
END_TEST

/* A hilly field of 10368 triangles, one of which is then torn off its neighbours by 1e-8. */
START_TEST(checks_ten_thousand_triangles) {
  enum { N = 72 };
  start_random();
  struct motion motion = random_motion(0);
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
  printf("seed %llu (set RAD_TEST_SEED to change)\n", seed());
  Suite *suite = suite_create("contact");
  TCase *warns = tcase_create("warns");
  tcase_add_test(warns, warns_of_contacts);
  tcase_add_test(warns, agrees_with_signs_of_volumes);
  tcase_add_test(warns, never_warns_of_convex_neighbours);
  tcase_add_test(warns, names_pairs_and_counts_the_rest);
  tcase_add_test(warns, finds_a_contact_at_the_end_of_the_sweep);
  tcase_add_test(warns, checks_ten_thousand_triangles);
  tcase_set_timeout(warns, 120);
  suite_add_tcase(suite, warns);
  return run_suite(suite);
}
