/* Rooms with shadows: closed ones, whose rows sum to 1, moved ones, threads, and adaptive runs. */
#include <check.h>
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "base/vec.h"
#include "estimate/adapt.h"
#include "estimate/iterate.h"
#include "rooms.h"
#include "suite.h"
#include "system/dense.h"

#define TOLERANCE 1e-10 /* of the quadrature */

static const struct motion still = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .scale = 1};

/* ---- row sums -------------------------------------------------------------------------------- */

/* Spots of all triangles: inside, and at distances from edges and vertices. */
static void add_all_spots(const struct room *room, const double *distance, int n, struct spots *s) {
  for (int t = 0; t < room->scene.n_triangle; t++) {
    add_spot(s, t, 0, 0.31, 0.27);
    add_spot(s, t, 1, 0.07, 0.85);
    for (int d = 0; d < n; d++)
      add_border_spots(s, t, distance[d]);
  }
}

/* Whether a spot counts: it is in the closed part of the scene. */
typedef int spot_filter(const double x[3]);

/* Distance of a spot from its triangle's border, over the triangle's size. */
static double from_border(const struct spots *s, int i) {
  const double *mu = s->mu[i];
  return fmin(fmin(mu[0], mu[1]), 1 - mu[0] - mu[1]);
}

/* Within `limit`, and `rounding` over the distance from the border. */
static void expect_sums_of_one(struct room *room, const struct rad_deck_method *method,
                               const struct spots *s, spot_filter *counts, double tolerance,
                               double limit, double rounding, const char *what) {
  int n = room->scene.n_triangle, n_counted = 0;
  double *got = receive(room, method, tolerance, s, 1), worst = 0;
  for (int i = 0; i < s->n; i++) {
    double sum = 0, x[3];
    spot_position(room, s, i, x);
    if (counts && !counts(x))
      continue;
    n_counted++;
    for (int j = 0; j < n; j++)
      sum += got[i * n + j];
    worst = fmax(worst, fabs(sum - 1));
    ck_assert_msg(fabs(sum - 1) <= limit + rounding / from_border(s, i),
                  "%s: triangle %d (base %d, mu %.17g %.17g), %g %g %g: sum - 1 = %.2g", what,
                  s->triangle[i], s->base[i], s->mu[i][0], s->mu[i][1], x[0], x[1], x[2], sum - 1);
  }
  printf("%s: %d points, %lld pairs in part, row sums within %.1e of 1\n", what, n_counted,
         (long long)room->visibility.n_partly, worst);
  fflush(stdout);
  free(got);
}

/* ---- convex ones ----------------------------------------------------------------------------- */

/* The convex hull of points on a sphere, seen from inside: triples with all others on one side. */
static void add_ball(struct rad_deck *deck, const struct motion *motion) {
  enum { N = 10 };
  double p[N][3];
  for (int c = 0; c < N; c++)
    random_direction(p[c]);
  for (int a = 0; a < N; a++)
    for (int b = a + 1; b < N; b++)
      for (int c = b + 1; c < N; c++) {
        double u[3], w[3], normal[3], low = 0, high = 0, v[3][3];
        rad_sub(p[b], p[a], u);
        rad_sub(p[c], p[a], w);
        rad_cross(u, w, normal);
        for (int q = 0; q < N; q++) {
          rad_sub(p[q], p[a], u);
          double h = q == a || q == b || q == c ? 0 : rad_dot(u, normal);
          low = fmin(low, h);
          high = fmax(high, h);
        }
        memcpy(v[0], p[a], sizeof v[0]);
        memcpy(v[1], p[low < 0 ? c : b], sizeof v[0]);
        memcpy(v[2], p[low < 0 ? b : c], sizeof v[0]);
        if (low == 0 || high == 0)
          add_moved(deck, motion, v, RAD_SIDE_FRONT);
      }
}

static void add_tetrahedron(struct rad_deck *deck, const struct motion *motion) {
  static const double corner[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  static const int face[4][3] = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  for (int t = 0; t < 4; t++) {
    double v[3][3];
    for (int m = 0; m < 3; m++)
      memcpy(v[m], corner[face[t][m]], sizeof v[m]);
    add_moved(deck, motion, v, RAD_SIDE_FRONT);
  }
}

/* A cube of n x n cells a face, seen from inside. */
static void add_cells(struct rad_deck *deck, const struct motion *motion, int n) {
  for (int cell = 0; cell < 6 * n * n; cell++) {
    int axis = cell % 3, far = cell / 3 % 2, x = cell / 6 % n, y = cell / 6 / n;
    for (int half = 0; half < 2; half++) {
      double v[3][3];
      for (int m = 0; m < 3; m++) {
        const double *p = SQUARE[SQUARE_CAP[half][far ? 2 - m : m]];
        v[m][axis] = far;
        v[m][(axis + 1) % 3] = (x + p[0]) / n;
        v[m][(axis + 2) % 3] = (y + p[1]) / n;
      }
      add_moved(deck, motion, v, RAD_SIDE_FRONT);
    }
  }
}

static void add_convex(struct rad_deck *deck, const struct motion *motion, int kind) {
  if (kind == 0)
    add_cube(deck, motion, RAD_SIDE_BACK);
  else if (kind == 1)
    add_tetrahedron(deck, motion);
  else if (kind == 2)
    add_ball(deck, motion);
  else
    add_cells(deck, motion, 2);
}
enum { N_CONVEX = 4 };

/* Alone; and with a triangle outside, seen by nobody inside, so that every face may cast shadows.
 */
START_TEST(convex_rooms) {
  static const double distance[] = {1e-2, 1e-5, 1e-8, 1e-12};
  static const double far[3][3] = {{30, 1, 1}, {30, 1.1, 1}, {30.1, 1, 1.1}};
  static const double cross[3][3] = {{-3, 0.5, 0.5}, {-3, 0.6, 0.5}, {-3.1, 0.5, 0.6}};
  struct spots *s = calloc(1, sizeof *s);
  start_random();
  for (int k = 0; k < 3; k++) {
    struct motion motion = k ? random_motion(k == 1 ? 0 : 5) : still;
    for (int with = 0; with < 2; with++) {
      struct rad_deck deck = {0};
      struct room room;
      add_convex(&deck, &motion, _i);
      int n = deck.n_triangle;
      if (with) {
        add_moved(&deck, &motion, far, RAD_SIDE_BOTH);
        add_moved(&deck, &motion, cross, RAD_SIDE_BOTH);
      }
      room_make(&deck, &room);
      int n_triangle = room.scene.n_triangle;
      for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
          ck_assert_int_ne(room.visibility.sight[i * n_triangle + j], RAD_PARTLY);
      ck_assert(with || room.visibility.n_partly == 0);
      s->n = 0;
      room.scene.n_triangle = n;
      add_all_spots(&room, distance, 4, s);
      room.scene.n_triangle = n_triangle;
      expect_sums_of_one(&room, k % 2 ? &method_paper : &method_graded, s, NULL, 1e-13, 1e-12, 0,
                         with ? "convex room with a triangle outside" : "convex room");
      room_free(&room);
    }
  }
  free(s);
}
END_TEST

/* ---- rooms with a box inside ----------------------------------------------------------------- */

/* The floor of a unit room around the foot low .. high of a box, sharing vertices with both. */
static void add_floor_around(struct rad_deck *deck, const double low[2], const double high[2]) {
  for (int k = 0; k < 8; k++) {
    double v[3][3] = {{0}}, p[4][2];
    int a = k / 2, b = (a + 1) % 4;
    for (int d = 0; d < 2; d++) {
      p[0][d] = SQUARE[a][d];
      p[1][d] = SQUARE[b][d];
      p[2][d] = SQUARE[b][d] > 0 ? high[d] : low[d];
      p[3][d] = SQUARE[a][d] > 0 ? high[d] : low[d];
    }
    for (int m = 0; m < 3; m++)
      memcpy(v[m], p[SQUARE_CAP[k % 2][m]], sizeof p[0]);
    add_moved(deck, &still, v, RAD_SIDE_FRONT);
  }
}

/* Drop triangles of the deck that lie in z = 0 and do not belong there. */
static void drop_floor(struct rad_deck *deck) {
  int n = 0;
  for (int t = 0; t < deck->n_triangle; t++) {
    const double(*v)[3] = (const double(*)[3])deck->triangle[t].vertex;
    if (v[0][2] != 0 || v[1][2] != 0 || v[2][2] != 0)
      deck->triangle[n++] = deck->triangle[t];
  }
  deck->n_triangle = n;
}

enum { FLOATING, STANDING, LEANING, EDGE_ON, PIERCING, N_BOX };
static const char *const box_name[] = {"floating box", "standing box", "box against a wall",
                                       "box on its edge", "box through a wall"};

static const double box_low[N_BOX][3] = {
    {0.3, 0.4, 0.35}, {0.25, 0.4, 0}, {0, 0.3, 0.4}, {0.3, 0.25, 0}, {0.6, 0.3, 0.2}};
static const double box_high[N_BOX][3] = {
    {0.6, 0.7, 0.6}, {0.5, 0.7, 0.6}, {0.4, 0.6, 0.7}, {0.7, 0.5, 0.25}, {1.3, 0.55, 0.45}};

static void add_room_with(struct rad_deck *deck, int kind) {
  static const double diamond[4][2] = {{0.25, 0}, {0.5, 0.25}, {0.25, 0.5}, {0, 0.25}};
  const double *low = box_low[kind], *high = box_high[kind];
  add_cube(deck, &still, RAD_SIDE_BACK);
  if (kind == EDGE_ON) { /* a prism along x over a diamond that touches floor and wall */
    struct motion turned = {.axis = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, .scale = 1};
    add_prism(deck, &turned, 4, diamond, 2, SQUARE_CAP, 0.3, 0.7, RAD_SIDE_FRONT);
    return;
  }
  add_box(deck, &still, low, high, RAD_SIDE_FRONT);
  if (kind == STANDING) {
    drop_floor(deck);
    add_floor_around(deck, low, high);
  }
}

/* Which box the filter asks about. */
static int box_kind;

/* In the room, not within the box, and more than 1e-6 from where the two meet without common
 * vertices: there nothing but coordinates says on which side of the other's plane a point is. */
static int in_the_open(const double x[3]) {
  const double *low = box_low[box_kind], *high = box_high[box_kind];
  int inside = box_kind != STANDING && box_kind != EDGE_ON, in_room = 1;
  for (int d = 0; d < 3; d++) {
    inside &= x[d] > low[d] - 1e-6 && x[d] < high[d] + 1e-6;
    in_room &= x[d] >= 0 && x[d] <= 1;
  }
  return in_room && !inside;
}

/* Where box and room meet without common vertices, cuts may pass by a point that are known to 1e-16
 * of the scene only. */
START_TEST(boxes_in_a_room) {
  static const double distance[] = {0.1, 1e-3, 1e-6, 1e-9, 1e-12};
  static const struct rad_deck_method *const method[] = {&method_graded, &method_paper,
                                                         &method_constant};
  struct spots *s = calloc(1, sizeof *s);
  struct rad_deck deck = {0};
  struct room room;
  int conforming = _i == FLOATING || _i == STANDING;
  box_kind = _i;
  add_room_with(&deck, _i);
  room_make(&deck, &room);
  for (int m = 0; m < 3; m++) {
    s->n = 0;
    add_all_spots(&room, distance, m == 2 ? 2 : conforming ? 5 : 4, s);
    expect_sums_of_one(&room, method[m], s, in_the_open, TOLERANCE, 10 * TOLERANCE,
                       conforming ? 0 : 2e-15, box_name[_i]);
  }
  ck_assert_int_gt(room.visibility.n_partly, 40);
  room_free(&room);
  free(s);
}
END_TEST

START_TEST(rooms_with_a_reflex_edge) {
  static const double distance[] = {0.1, 1e-3, 1e-6, 1e-9, 1e-12};
  struct spots *s = calloc(1, sizeof *s);
  start_random();
  for (int k = 0; k < 3; k++) {
    struct motion motion = k ? random_motion(k == 1 ? 0 : 5) : still;
    struct rad_deck deck = {0};
    struct room room;
    add_prism(&deck, &motion, 6, ELL, 4, ELL_CAP, 0, 1, RAD_SIDE_BACK);
    room_make(&deck, &room);
    s->n = 0;
    add_all_spots(&room, distance, 5, s);
    expect_sums_of_one(&room, k % 2 ? &method_paper : &method_graded, s, NULL, TOLERANCE,
                       10 * TOLERANCE, 0, "L");
    ck_assert_int_gt(room.visibility.n_partly, 20);
    room_free(&room);
  }
  free(s);
}
END_TEST

/* ---- moved ones ------------------------------------------------------------------------------ */

/* Unit squares z = 0 and z = 1 that see each other, and between them, z = 1/2, a black one. */
static void add_squares(struct rad_deck *deck, const struct motion *motion) {
  for (int k = 0; k < 6; k++) {
    double v[3][3];
    for (int m = 0; m < 3; m++)
      for (int d = 0; d < 3; d++) {
        double p = d < 2 ? SQUARE[SQUARE_CAP[k % 2][m]][d] : 0;
        v[m][d] = k < 4 ? (d < 2 ? p : k / 2) : d < 2 ? 0.25 + p / 2 : 0.5;
      }
    add_moved(deck, motion, v, k / 2 == 1 ? RAD_SIDE_BACK : RAD_SIDE_FRONT);
    struct rad_deck_optics *o = &deck->triangle[deck->n_triangle - 1].optics;
    o->rho[0] = k < 4 ? 0.5 : 0;
    for (int m = 0; m < 3; m++)
      o->emission[m][0] = k < 2;
  }
}

/* The matrix of the squares after a motion: owned [n, n]. */
static double *matrix_of_squares(const struct motion *motion, const struct rad_deck_method *method,
                                 int *n) {
  struct rad_deck deck = {0};
  struct room room;
  struct rad_mesh mesh;
  struct rad_dense dense;
  add_squares(&deck, motion);
  room_make(&deck, &room);
  ck_assert_int_eq(room.visibility.n_partly, 4);
  assemble(&room, method, 1e-13, &mesh, &dense);
  *n = dense.n;
  size_t bytes = sizeof(double) * (size_t)*n * (size_t)*n;
  double *k = malloc(bytes);
  memcpy(k, dense.k, bytes);
  rad_dense_free(&dense);
  rad_mesh_free(&mesh);
  room_free(&room);
  return k;
}

/* Coordinates that move by eta move the border of what is seen by at most 4 eta (the blocker is
 * half way), and entries by that times its length, 4, the kernel, 4/pi, and the trial function, up
 * to 5 at the element's ends: 100 eta. To that comes the quadrature. A scale of 2^20 changes no
 * digit. */
START_TEST(moved_shadows) {
  static const struct rad_deck_method *const method[] = {&method_constant, &method_folded,
                                                         &method_paper, &method_graded};
  start_random();
  int n, n_moved;
  double *still_k = matrix_of_squares(&still, method[_i], &n);
  for (int k = 0; k < 6; k++) {
    struct motion motion = k < 2 ? still : random_motion(0);
    motion.scale = k == 0 ? 0x1p20 : k == 1 ? 0x1p-20 : k == 3 ? 1e-6 : k == 4 ? 1e6 : 1;
    for (int d = 0; d < 3; d++)
      motion.shift[d] = k == 2 ? uniform(-1, 1) : k == 5 ? 1e6 * uniform(-1, 1) : 0;
    double eta = k < 2 ? 0 : k == 5 ? 2e-10 : 1e-15, most = 0;
    double *moved = matrix_of_squares(&motion, method[_i], &n_moved);
    ck_assert_int_eq(n, n_moved);
    for (size_t i = 0; i < (size_t)n * (size_t)n; i++)
      most = fmax(most, fabs(moved[i] - still_k[i]));
    printf("method %d, motion %d: entries change by %.1e\n", _i, k, most);
    ck_assert_msg(most <= 100 * eta + (k < 2 ? 0 : 2e-13), "motion %d changes entries by %g", k,
                  most);
    free(moved);
  }
  free(still_k);
}
END_TEST

/* ---- threads --------------------------------------------------------------------------------- */

START_TEST(same_bits) {
  static const struct rad_deck_method *const method[] = {&method_constant, &method_graded};
  static const int threads[] = {1, 2, 7};
  static const struct motion beside = {
      .axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .shift = {2}, .scale = 1};
  int before = omp_get_max_threads();
  for (int m = 0; m < 2; m++) {
    double *first = NULL;
    for (int t = 0; t < 3; t++) {
      struct rad_deck deck = {0};
      struct room room;
      struct rad_mesh mesh;
      struct rad_dense dense;
      omp_set_num_threads(threads[t]);
      if (m == 0)
        add_cells(&deck, &beside, 2);
      add_room_with(&deck, STANDING);
      room_make(&deck, &room);
      assemble(&room, method[m], 1e-6, &mesh, &dense);
      size_t bytes = sizeof(double) * (size_t)dense.n * (size_t)dense.n;
      if (!first) {
        first = malloc(bytes);
        memcpy(first, dense.k, bytes);
      }
      ck_assert_msg(!memcmp(first, dense.k, bytes), "method %d, %d threads", m, threads[t]);
      rad_dense_free(&dense);
      rad_mesh_free(&mesh);
      room_free(&room);
    }
    free(first);
  }
  omp_set_num_threads(before);
}
END_TEST

/* ---- adaptive runs --------------------------------------------------------------------------- */

/* u* at the spots. */
static double *adapted(const struct room *room, double tolerance, const struct spots *s,
                       double *bound) {
  struct rad_goal goal = {.tolerance = tolerance, .memory = rad_memory_available()};
  struct rad_adaptive a;
  struct rad_error e;
  struct rad_point_list list = {s->n, s->triangle, s->base, s->mu};
  double start = rad_seconds(), *u = malloc(sizeof(double) * (size_t)s->n);
  enum rad_code code = rad_adapt(&room->scene, &goal, &a, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
  ck_assert_msg(!a.reason[0], "tolerance %g not reached: %s", tolerance, a.reason);
  code = rad_irradiance_at(a.mesh, &a.rules, &list, 1, a.u, u, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
  rad_iterated(&room->scene, &list, u, u);
  *bound = a.bound;
  printf("tolerance %g: %d unknowns, bound %.2e, %.1f s\n", tolerance, a.mesh->n_point, a.bound,
         rad_seconds() - start);
  fflush(stdout);
  rad_adaptive_free(&a);
  return u;
}

START_TEST(adaptive_run) {
  static const double tolerance[] = {1e-2, 1e-3, 1e-4}, reference = 1e-6;
  struct spots *s = calloc(1, sizeof *s);
  struct rad_deck deck = {0};
  struct room room;
  double bound, most = 0;
  add_squares(&deck, &still);
  room_make(&deck, &room);
  for (int t = 0; t < 4; t++) {
    for (int a = 0; a < 40; a++)
      for (int b = 0; a + b < 40; b++)
        add_spot(s, t, 0, (a + 0.3) / 40, (b + 0.3) / 40);
    add_border_spots(s, t, 1e-3);
    add_border_spots(s, t, 1e-6);
  }
  double *exact = adapted(&room, reference, s, &bound);
  for (int i = 0; i < s->n; i++)
    most = fmax(most, fabs(exact[i]));
  for (int k = 0; k < 3; k++) {
    double *u = adapted(&room, tolerance[k], s, &bound), error = 0;
    for (int i = 0; i < s->n; i++)
      error = fmax(error, fabs(u[i] - exact[i]) / most);
    printf("tolerance %g: true error %.2e\n", tolerance[k], error);
    ck_assert_msg(error <= bound + reference && bound <= tolerance[k], "error %g, bound %g", error,
                  bound);
    ck_assert_msg(bound <= 30 * error + reference, "error %g, bound %g", error, bound);
    free(u);
  }
  free(exact);
  room_free(&room);
  free(s);
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", seed());
  Suite *suite = suite_create("shadow_rooms");
  TCase *c = tcase_create("rooms");
  tcase_set_timeout(c, 300);
  tcase_add_loop_test(c, convex_rooms, 0, N_CONVEX);
  tcase_add_loop_test(c, boxes_in_a_room, 0, N_BOX);
  tcase_add_test(c, rooms_with_a_reflex_edge);
  tcase_add_loop_test(c, moved_shadows, 0, 4);
  tcase_add_test(c, same_bits);
  tcase_add_test(c, adaptive_run);
  suite_add_tcase(suite, c);
  return run_suite(suite);
}
