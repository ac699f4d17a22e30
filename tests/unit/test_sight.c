/* What triangles see of one another, against random segments and against separating axes. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "scene_help.h"
#include "suite.h"
#include "visibility/bvh.h"
#include "visibility/facing.h"
#include "visibility/hull.h"
#include "visibility/visibility.h"

#define MARGIN 1e-6 /* of a triangle, or the scene: a hit nearer to a border is no evidence */

/* A scene with its occluders, and what its pairs came to. */
struct view {
  struct rad_scene scene;
  struct rad_occluders o;
  int n_pair[3], n_listed, n_seen; /* pairs by sight; occluders in lists; those that were hit */
};

static struct view view_of(struct rad_deck *deck) {
  struct view v = {.scene = build_scene(deck)};
  return v;
}

static void prepare(struct view *v) {
  struct rad_error error;
  ck_assert_int_eq(rad_occluders_build(&v->scene, &v->o, &error), RAD_OK);
}

static void drop_view(struct view *v) {
  rad_occluders_free(&v->o);
  rad_scene_free(&v->scene);
}

/* --- the oracle: segments --- */

static void random_point(const struct rad_triangle *t, double x[3]) {
  double a = uniform(0, 1), b = uniform(0, 1);
  if (a + b > 1) {
    a = 1 - a;
    b = 1 - b;
  }
  for (int d = 0; d < 3; d++)
    x[d] = t->v[0][d] + a * (t->v[1][d] - t->v[0][d]) + b * (t->v[2][d] - t->v[0][d]);
}

/* Whether the open segment x y hits t: x + s (y - x) = v0 + a (v1 - v0) + b (v2 - v0) by Cramer's
 * rule, all within their bounds by `margin`. */
static int hits(const double x[3], const double y[3], const struct rad_triangle *t, double margin) {
  double r[3], u[3], v[3], w[3], rv[3], wu[3];
  rad_sub(y, x, r);
  rad_sub(t->v[1], t->v[0], u);
  rad_sub(t->v[2], t->v[0], v);
  rad_sub(x, t->v[0], w);
  rad_cross(r, v, rv);
  double det = rad_dot(u, rv);
  if (fabs(det) <= 1e-9 * rad_norm(r) * t->area)
    return 0;
  double a = rad_dot(w, rv) / det;
  rad_cross(w, u, wu);
  double b = rad_dot(r, wu) / det, s = rad_dot(v, wu) / det;
  return a > margin && b > margin && a + b < 1 - margin && s > fabs(margin) && s < 1 - fabs(margin);
}

static int polygon_hit(const struct rad_occluders *o, int k, const double x[3], const double y[3]) {
  const struct rad_occluder *p = &o->occluder[k];
  for (int c = 1; c + 1 < p->n; c++) {
    struct rad_triangle t;
    for (int m = 0; m < 3; m++)
      memcpy(t.v[m], o->scene->vertex[o->corner[p->first + (m ? c + m - 1 : 0)]], sizeof t.v[m]);
    measure_triangle(&t);
    if (hits(x, y, &t, MARGIN))
      return 1;
  }
  return 0;
}

static int is_listed(const int *list, int n, int k) {
  while (n > 0 && *list != k) {
    list++;
    n--;
  }
  return n > 0;
}

/* Segments between points in front of each other agree with what was said of the pair. */
static void try_segments(struct view *v, int i, int j, enum rad_sight sight, const int *list, int n,
                         int n_segment) {
  const struct rad_triangle *t = v->scene.triangle;
  char *seen = calloc((size_t)v->o.n, 1);
  for (int k = 0; k < n_segment; k++) {
    double x[3], y[3], r[3];
    random_point(&t[i], x);
    random_point(&t[j], y);
    rad_sub(y, x, r);
    double least = MARGIN * v->scene.size;
    if (rad_dot(r, t[i].normal) < least || rad_dot(r, t[j].normal) > -least)
      continue;
    int n_hit = 0, n_grazed = 0;
    for (int q = 0; q < v->scene.n_triangle; q++) {
      n_hit += q != i && q != j && hits(x, y, &t[q], MARGIN);
      n_grazed += q != i && q != j && hits(x, y, &t[q], -1e-9);
    }
    ck_assert_msg(sight != RAD_FREE || !n_hit, "free %d %d: hit, seed %llu", i, j, seed());
    ck_assert_msg(sight != RAD_HIDDEN || n_grazed, "hidden %d %d: open, seed %llu", i, j, seed());
    for (int q = 0; sight == RAD_PARTLY && q < v->o.n; q++)
      if (v->o.occluder[q].plane != v->o.plane[i] && v->o.occluder[q].plane != v->o.plane[j] &&
          polygon_hit(&v->o, q, x, y)) {
        ck_assert_msg(is_listed(list, n, q), "partly %d %d: %d not listed, seed %llu", i, j, q,
                      seed());
        seen[q] = 1;
      }
  }
  for (int q = 0; q < v->o.n; q++)
    v->n_seen += seen[q];
  v->n_listed += n;
  free(seen);
}

/* --- the other oracle: separating axes in space --- */

/* Whether a polygon that is in front of both stands in the hull of the pair. */
static int may_block(const struct rad_occluders *o, int i, int j, const struct rad_hull *hull,
                     int k) {
  const struct rad_triangle *t = o->scene->triangle;
  const struct rad_occluder *p = &o->occluder[k];
  double corner[RAD_MAX_OCCLUDER_CORNER][3], r[3];
  int front_i = 0, front_j = 0;
  if (p->plane == o->plane[i] || p->plane == o->plane[j])
    return 0;
  for (int c = 0; c < p->n; c++) {
    memcpy(corner[c], o->scene->vertex[o->corner[p->first + c]], sizeof corner[c]);
    rad_sub(corner[c], t[i].v[0], r);
    front_i |= rad_dot(r, t[i].normal) > o->slack;
    rad_sub(corner[c], t[j].v[0], r);
    front_j |= rad_dot(r, t[j].normal) > o->slack;
  }
  return front_i && front_j && !rad_hull_separated(hull, o->slack, p->normal, p->n, corner);
}

/* --- all pairs --- */

static void check_pair(struct view *v, int i, int j, int n_segment) {
  const struct rad_occluders *o = &v->o;
  int *list = calloc(2 * (size_t)o->n, sizeof *list), n = -1, back = -1;
  ck_assert_ptr_nonnull(list);
  enum rad_sight sight = rad_sight_between(o, i, j, list, &n);
  ck_assert_int_eq(sight, rad_sight_between(o, j, i, list + o->n, &back));
  ck_assert(n == back && !memcmp(list, list + o->n, (size_t)n * sizeof *list));
  ck_assert_int_eq(n > 0, sight == RAD_PARTLY);
  struct rad_hull hull;
  int faces = i != j && rad_faces(&v->scene.triangle[i], &v->scene.triangle[j]);
  ck_assert(faces || sight == RAD_HIDDEN);
  if (faces) {
    ck_assert(rad_hull_make(&hull, &v->scene.triangle[i], &v->scene.triangle[j]));
    int n_blocker = 0;
    for (int k = 0; k < o->n; k++) {
      int may = may_block(o, i, j, &hull, k);
      n_blocker += may;
      ck_assert_msg(sight == RAD_HIDDEN || may == is_listed(list, n, k),
                    "%d %d: %d may %d, seed %llu", i, j, k, may, seed());
    }
    ck_assert(sight != RAD_HIDDEN || n_blocker);
    v->n_pair[sight]++;
    try_segments(v, i, j, sight, list, n, n_segment);
  }
  for (int k = 1; k < n; k++)
    ck_assert_int_gt(list[k], list[k - 1]);
  free(list);
}

/* The matrix and the stored lists, of which there is room for `most` numbers, say the same. */
static void check_stored(const struct view *v, int64_t most) {
  int n = v->scene.n_triangle, n_list, n_stored;
  struct rad_visibility all = {.occluders = v->o, .row = calloc((size_t)n, sizeof *all.row)};
  all.sight = rad_sight_matrix(&v->o, most, all.row);
  int *list = calloc((size_t)v->o.n, sizeof *list), *other = calloc((size_t)v->o.n, sizeof *other);
  ck_assert(all.sight && all.row && list && other);
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      enum rad_sight sight = rad_sight_between(&v->o, i, j, list, &n_list);
      ck_assert_int_eq(all.sight[i * n + j], sight);
      if (sight != RAD_PARTLY)
        continue;
      const int *stored = rad_blockers(&all, i, j, other, &n_stored);
      ck_assert_int_eq(n_stored, n_list);
      ck_assert(!memcmp(stored, list, sizeof *list * (size_t)n_list));
    }
  for (int i = 0; i < n; i++)
    free(all.row[i].data);
  free(all.row);
  free(all.sight);
  free(list);
  free(other);
}

/* Every pair, and that what is stored says the same. */
static void check_view(struct view *v, int n_segment) {
  int n = v->scene.n_triangle;
  prepare(v);
  check_stored(v, 1 << 20);
  check_stored(v, 30);
  for (int i = 0; i < n; i++)
    for (int j = i; j < n; j++)
      check_pair(v, i, j, n_segment);
}

static void add_counts(struct view *sum, const struct view *v) {
  for (int s = 0; s < 3; s++)
    sum->n_pair[s] += v->n_pair[s];
  sum->n_listed += v->n_listed;
  sum->n_seen += v->n_seen;
}

static void print_counts(const char *what, const struct view *v) {
  printf("%s: %d hidden, %d free, %d partly; %d listed, %d of them hit\n", what,
         v->n_pair[RAD_HIDDEN], v->n_pair[RAD_FREE], v->n_pair[RAD_PARTLY], v->n_listed, v->n_seen);
  fflush(stdout);
}

/* --- random triangles --- */

static void add_random(struct rad_deck *deck, const struct motion *motion, double reach) {
  double v[3][3], center[3];
  struct rad_triangle t;
  for (int d = 0; d < 3; d++)
    center[d] = uniform(0, 1);
  do {
    for (int m = 0; m < 9; m++)
      t.v[m / 3][m % 3] = v[m / 3][m % 3] = center[m % 3] + reach * uniform(-1, 1);
    measure_triangle(&t);
  } while (t.area < 0.05 * reach * reach);
  add_moved(deck, motion, v, uniform(0, 1) < 0.3 ? RAD_SIDE_BOTH : RAD_SIDE_FRONT);
}

START_TEST(random_triangles) {
  start_random();
  struct view sum = {0};
  for (int k = 0; k < 14; k++) {
    struct motion motion = random_motion(k % 2 ? 6 : 0);
    struct rad_deck deck = {0};
    int n = 5 + k * k * 55 / 169;
    for (int t = 0; t < n; t++)
      add_random(&deck, &motion, t % 3 ? 0.15 : 1);
    struct view v = view_of(&deck);
    check_view(&v, 25);
    add_counts(&sum, &v);
    drop_view(&v);
  }
  print_counts("random", &sum);
  ck_assert(sum.n_pair[RAD_HIDDEN] > 50 && sum.n_pair[RAD_FREE] > 200 &&
            sum.n_pair[RAD_PARTLY] > 1000);
  ck_assert_int_gt(3 * sum.n_seen, sum.n_listed);
}
END_TEST

/* Triangles around common vertices, and slits: what touches in a vertex or an edge only. */
START_TEST(fans_and_slits) {
  start_random();
  struct view sum = {0};
  for (int k = 0; k < 30; k++) {
    struct motion motion = random_motion(k % 2 ? 6 : 0);
    struct rad_deck deck = {0};
    double p[7][3];
    for (int m = 0; m < 21; m++)
      p[m / 3][m % 3] = uniform(0, 1);
    int used[35] = {0}, n = 0;
    while (n < 16) {
      int a = (int)uniform(0, 7), b = (int)uniform(0, 7), c = k % 3 ? (int)uniform(0, 7) : 0;
      int bits = 1 << a | 1 << b | 1 << c, known = a == b || b == c || c == a;
      for (int q = 0; q < n; q++)
        known |= used[q] == bits;
      if (known && uniform(0, 1) < 0.9)
        continue;
      if (!known) {
        double v[3][3];
        memcpy(v[0], p[a], sizeof v[0]);
        memcpy(v[1], p[b], sizeof v[1]);
        memcpy(v[2], p[c], sizeof v[2]);
        add_moved(&deck, &motion, v, n % 2 ? RAD_SIDE_BOTH : RAD_SIDE_FRONT);
      }
      used[n++] = bits;
    }
    struct view v = view_of(&deck);
    check_view(&v, 25);
    add_counts(&sum, &v);
    drop_view(&v);
  }
  print_counts("fans and slits", &sum);
  ck_assert(sum.n_pair[RAD_FREE] > 60 && sum.n_pair[RAD_PARTLY] > 500);
}
END_TEST

/* --- rooms --- */

/* A room with blocks that stand on the floor without sharing vertices with it. */
START_TEST(blocks_in_a_room) {
  start_random();
  struct view sum = {0};
  for (int k = 0; k < 6; k++) {
    struct motion motion = random_motion(k % 2 ? 6 : 0), room = motion;
    for (int d = 0; d < 3; d++)
      room.shift[d] -= motion.scale * (motion.axis[d][0] + motion.axis[d][1]);
    room.scale *= 4;
    struct rad_deck deck = {0};
    add_cube(&deck, &room, RAD_SIDE_BACK);
    add_prism(&deck, &motion, 4, SQUARE, 2, SQUARE_CAP, 0, 1 + k % 3, RAD_SIDE_FRONT);
    if (k > 2)
      for (int d = 0; d < 3; d++)
        motion.shift[d] += motion.scale * motion.axis[d][0];
    if (k > 2) /* an L that leans with a wall against the square's */
      add_prism(&deck, &motion, 6, ELL, 4, ELL_CAP, 0, 0.5 + k % 2, RAD_SIDE_FRONT);
    struct view v = view_of(&deck);
    check_view(&v, 50);
    add_counts(&sum, &v);
    drop_view(&v);
  }
  print_counts("blocks", &sum);
  ck_assert(sum.n_pair[RAD_HIDDEN] > 0 && sum.n_pair[RAD_FREE] > 300 &&
            sum.n_pair[RAD_PARTLY] > 300);
}
END_TEST

/* A wall across a room, sharing vertices with it: all is hidden from the other side. */
START_TEST(a_wall_hides_the_next_room) {
  start_random();
  for (int k = 0; k < 20; k++) {
    struct motion motion = random_motion(3), other = motion;
    for (int d = 0; d < 3; d++)
      other.shift[d] += motion.scale * motion.axis[d][0];
    struct rad_deck deck = {0};
    add_cube(&deck, &motion, RAD_SIDE_BACK);
    add_cube(&deck, &other, RAD_SIDE_BACK);
    struct view v = view_of(&deck);
    prepare(&v);
    int list[12], n, n_faces = 0;
    for (int i = 0; i < 12; i++)
      for (int j = 12; j < 24; j++) {
        n_faces += rad_faces(&v.scene.triangle[i], &v.scene.triangle[j]);
        ck_assert_msg(rad_sight_between(&v.o, i, j, list, &n) == RAD_HIDDEN,
                      "%d %d, step %d, seed %llu", i, j, k, seed());
      }
    ck_assert_int_gt(n_faces, 10);
    for (int i = 0; i < 12; i++)
      for (int j = 0; j < i; j++)
        ck_assert_int_eq(rad_sight_between(&v.o, i, j, list, &n) == RAD_FREE,
                         rad_faces(&v.scene.triangle[i], &v.scene.triangle[j]));
    drop_view(&v);
  }
}
END_TEST

/* --- convex scenes --- */

/* All that faces is free, and nothing was tried. */
static void check_convex(struct rad_deck *deck, const char *what) {
  struct view v = view_of(deck);
  prepare(&v);
  ck_assert_msg(v.o.bvh->n_node == 0, "%s: %d nodes, seed %llu", what, v.o.bvh->n_node, seed());
  int n = v.scene.n_triangle, n_faces = 0;
  struct rad_sight_row *row = calloc((size_t)v.o.scene->n_triangle, sizeof *row);
  unsigned char *matrix = rad_sight_matrix(&v.o, 1 << 20, row);
  ck_assert_ptr_nonnull(matrix);
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      int faces = i != j && rad_faces(&v.scene.triangle[i], &v.scene.triangle[j]);
      n_faces += faces;
      ck_assert_int_eq(matrix[i * n + j], faces ? RAD_FREE : RAD_HIDDEN);
    }
  ck_assert_int_gt(n_faces, 6);
  free(matrix);
  free(row);
  drop_view(&v);
}

/* The convex hull of points on a sphere: triples with all others on one side. */
static void add_ball(struct rad_deck *deck, const struct motion *motion) {
  enum { N = 14 };
  double p[N][3];
  for (int c = 0; c < N; c++)
    random_direction(p[c]);
  for (int a = 0; a < N; a++)
    for (int b = a + 1; b < N; b++)
      for (int c = b + 1; c < N; c++) {
        double u[3], w[3], normal[3], low = 0, high = 0;
        rad_sub(p[b], p[a], u);
        rad_sub(p[c], p[a], w);
        rad_cross(u, w, normal);
        for (int q = 0; q < N; q++) {
          rad_sub(p[q], p[a], u);
          double h = q == a || q == b || q == c ? 0 : rad_dot(u, normal);
          low = fmin(low, h);
          high = fmax(high, h);
        }
        double v[3][3];
        memcpy(v[0], p[a], sizeof v[0]);
        memcpy(v[1], p[low < 0 ? c : b], sizeof v[0]); /* the normal points inwards */
        memcpy(v[2], p[low < 0 ? b : c], sizeof v[0]);
        if (low == 0 || high == 0)
          add_moved(deck, motion, v, RAD_SIDE_FRONT);
      }
}

START_TEST(convex_scenes_are_free) {
  static const double corner[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  static const int tetrahedron[4][3] = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  enum { N = 3 };
  start_random();
  for (int k = 0; k < 30; k++) {
    struct motion motion = random_motion(5);
    struct rad_deck deck = {0};
    add_cube(&deck, &motion, RAD_SIDE_BACK);
    check_convex(&deck, "cube");
    for (int cell = 0; cell < 6 * N * N; cell++) { /* its walls cut in N x N */
      int axis = cell % 3, far = cell / 3 % 2, x = cell / 6 % N, y = cell / 6 / N;
      double p[4][3];
      for (int c = 0; c < 4; c++) {
        p[c][axis] = far;
        p[c][(axis + 1) % 3] = (x + SQUARE[c][0]) / N;
        p[c][(axis + 2) % 3] = (y + SQUARE[c][1]) / N;
      }
      for (int half = 0; half < 2; half++) {
        double v[3][3];
        for (int m = 0; m < 3; m++)
          memcpy(v[m], p[SQUARE_CAP[half][far ? 2 - m : m]], sizeof v[m]);
        add_moved(&deck, &motion, v, RAD_SIDE_FRONT);
      }
    }
    check_convex(&deck, "cells");
    for (int t = 0; t < 4; t++) {
      double v[3][3];
      for (int m = 0; m < 3; m++)
        memcpy(v[m], corner[tetrahedron[t][m]], sizeof v[m]);
      add_moved(&deck, &motion, v, RAD_SIDE_FRONT);
    }
    check_convex(&deck, "tetrahedron");
    add_ball(&deck, &motion);
    check_convex(&deck, "ball");
  }
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", seed());
  Suite *suite = suite_create("sight");
  TCase *tests = tcase_create("sight");
  tcase_add_test(tests, random_triangles);
  tcase_add_test(tests, fans_and_slits);
  tcase_add_test(tests, blocks_in_a_room);
  tcase_add_test(tests, a_wall_hides_the_next_room);
  tcase_add_test(tests, convex_scenes_are_free);
  tcase_set_timeout(tests, 120);
  suite_add_tcase(suite, tests);
  return run_suite(suite);
}
