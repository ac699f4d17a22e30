/* Triangles merged to convex polygons: the shapes' corners, areas and chains, turned at random. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "scene_help.h"
#include "suite.h"
#include "visibility/bvh.h"
#include "visibility/occluder.h"

/* Vertices are rounded to 1e-16 of their distance from the origin, at most 6 sizes; so are areas.
 */
#define AREA 1e-12
/* A corner may be reflex by the rounding that merges: 1e-12 of the plane's size. */
#define CONVEX 3e-12

/* --- what always holds --- */

static const double *corner(const struct rad_occluders *o, const struct rad_occluder *k, int c) {
  return o->scene->vertex[o->corner[k->first + c % k->n]];
}

static double area_of(const struct rad_occluders *o, const struct rad_occluder *k) {
  double sum[3] = {0}, u[3], v[3], n[3];
  for (int c = 1; c + 1 < k->n; c++) {
    rad_sub(corner(o, k, c), corner(o, k, 0), u);
    rad_sub(corner(o, k, c + 1), corner(o, k, 0), v);
    rad_cross(u, v, n);
    for (int d = 0; d < 3; d++)
      sum[d] += n[d] / 2;
  }
  return rad_dot(sum, k->normal);
}

static void check_polygon(const struct rad_occluders *o, const struct rad_occluder *k) {
  double size = o->scene->size;
  ck_assert(k->n >= 3 && k->n <= RAD_MAX_OCCLUDER_CORNER);
  for (int c = 0; c < k->n; c++) {
    int side = k->first + c, from = o->corner[side], to = o->corner[k->first + (c + 1) % k->n];
    double r[3];
    for (int q = 0; q < k->n; q++) {
      rad_sub(corner(o, k, q), corner(o, k, c), r);
      ck_assert(rad_dot(r, o->inward[side]) >= -CONVEX * size);
      ck_assert(fabs(rad_dot(r, k->normal)) <= CONVEX * size);
    }
    for (int d = 0; d < 3; d++)
      ck_assert(corner(o, k, c)[d] >= k->low[d] && corner(o, k, c)[d] <= k->high[d]);
    ck_assert(rad_in_plane(o, k->plane, from) && rad_on_line(o, side, from));
    ck_assert(rad_on_line(o, side, to));
    for (int q = o->on_line_first[side]; q < o->on_line_first[side + 1]; q++) {
      ck_assert(q == o->on_line_first[side] || o->on_line[q] > o->on_line[q - 1]);
      ck_assert(rad_in_plane(o, k->plane, o->on_line[q]));
      rad_sub(o->scene->vertex[o->on_line[q]], corner(o, k, c), r);
      ck_assert(fabs(rad_dot(r, o->inward[side])) <= CONVEX * size);
    }
  }
}

/* Polygons are convex and plane, and have the areas of their planes' triangles, twins once. */
static void check_occluders(const struct rad_occluders *o, int twins) {
  double *area = calloc((size_t)o->n_plane, sizeof *area);
  ck_assert_ptr_nonnull(area);
  for (int t = 0; t < o->scene->n_triangle; t++) {
    area[o->plane[t]] += o->scene->triangle[t].area / (twins ? 2 : 1);
    for (int m = 0; m < 3; m++)
      ck_assert(rad_in_plane(o, o->plane[t], o->scene->triangle[t].vertex[m]));
  }
  for (int k = 0; k < o->n; k++) {
    check_polygon(o, &o->occluder[k]);
    area[o->occluder[k].plane] -= area_of(o, &o->occluder[k]);
  }
  for (int plane = 0; plane < o->n_plane; plane++)
    ck_assert_msg(fabs(area[plane]) <= AREA * o->scene->size * o->scene->size,
                  "plane %d: area off by %g, size %g, seed %llu", plane, area[plane],
                  o->scene->size, seed());
  free(area);
}

/* The deck's scene and its occluders; drop_both frees them. */
static struct rad_occluders occluders_of_scene(const struct rad_scene *scene, int twins) {
  struct rad_occluders o;
  struct rad_error error;
  ck_assert_int_eq(rad_occluders_build(scene, &o, &error), RAD_OK);
  check_occluders(&o, twins);
  return o;
}

static struct rad_occluders occluders_of(struct rad_deck *deck, struct rad_scene *scene,
                                         int twins) {
  *scene = build_scene(deck);
  return occluders_of_scene(scene, twins);
}

static void drop_both(struct rad_occluders *o, struct rad_scene *scene) {
  rad_occluders_free(o);
  rad_occluders_free(o);
  rad_scene_free(scene);
}

/* --- shapes in the plane z = 0 --- */

typedef double point[2];

static void add_flat(struct rad_deck *deck, const struct motion *motion, const point a,
                     const point b, const point c, enum rad_side side) {
  const double v[3][3] = {{a[0], a[1], 0}, {b[0], b[1], 0}, {c[0], c[1], 0}};
  add_moved(deck, motion, v, side);
}

/* n x n cells of [0, 3]^2, or those that `in` wants, cut by random diagonals. */
static void add_cells(struct rad_deck *deck, const struct motion *motion, int n,
                      int (*in)(double x, double y), enum rad_side side) {
  for (int cell = 0; cell < n * n; cell++) {
    double h = 3.0 / n;
    point p[4];
    for (int m = 0; m < 4; m++) {
      p[m][0] = h * (cell % n + SQUARE[m][0]);
      p[m][1] = h * (double)((int)(cell / n) + (int)SQUARE[m][1]);
    }
    int turn = uniform(0, 1) < 0.5;
    if (in(p[0][0] + h / 2, p[0][1] + h / 2)) {
      add_flat(deck, motion, p[turn], p[turn + 1], p[turn + 2], side);
      add_flat(deck, motion, p[turn], p[turn + 2], p[(turn + 3) % 4], side);
    }
  }
}

static int everywhere(double x, double y) {
  return x < 9 && y < 9;
}

static int in_ell(double x, double y) {
  return x < 1 || y < 1;
}

static int in_frame(double x, double y) {
  return x < 1 || x > 2 || y < 1 || y > 2;
}

/* Two squares that meet in a corner, and nothing else, and a third at the side of one. */
static int in_bow(double x, double y) {
  return (x < 1 && y < 1) || (x > 1 && x < 2 && y > 1);
}

static const struct {
  const char *name;
  int (*in)(double, double);
  int n_plane, n_most; /* polygons: at least 1, at most n_most */
} shapes[] = {{"square", everywhere, 1, 1},
              {"L", in_ell, 1, 2},
              {"frame", in_frame, 1, 6},
              {"bow", in_bow, 2, 2}};

/* Motions of 1e-6 to 1e9 times the size, shifted by up to 3 sizes. */
static struct motion any_motion(int k) {
  struct motion motion = random_motion(0);
  double scale = k % 3 ? pow(10, uniform(-6, 9)) : 1;
  motion.scale *= scale;
  for (int d = 0; d < 3; d++)
    motion.shift[d] *= scale;
  return motion;
}

START_TEST(cells_become_their_shape) {
  start_random();
  for (int k = 0; k < 160; k++) {
    int s = k % 4, n = 3 * (1 + k / 4 % 4), twins = k % 5 == 0;
    struct motion motion = any_motion(k);
    struct rad_deck deck = {0};
    struct rad_scene scene;
    add_cells(&deck, &motion, n, shapes[s].in, twins ? RAD_SIDE_BOTH : RAD_SIDE_FRONT);
    struct rad_occluders o = occluders_of(&deck, &scene, twins);
    ck_assert_msg(o.n_plane == shapes[s].n_plane && o.n <= shapes[s].n_most,
                  "%s, n %d: %d planes, %d polygons, step %d, seed %llu", shapes[s].name, n,
                  o.n_plane, o.n, k, seed());
    ck_assert_int_eq(o.bvh->n_node, 0); /* all in one plane */
    drop_both(&o, &scene);
  }
}
END_TEST

/* Six squares; on each side n + 1 vertices, all within. */
START_TEST(a_subdivided_cube_is_six_squares) {
  start_random();
  for (int k = 0; k < 24; k++) {
    int n = 1 + k % 6;
    struct motion motion = any_motion(k);
    struct rad_deck deck = {0};
    for (int wall = 0; wall < 6; wall++) {
      struct motion turned = motion;
      for (int d = 0; d < 3; d++) {
        double sign = wall < 3 ? 1 : -1;
        for (int axis = 0; axis < 3; axis++)
          turned.axis[d][axis] = motion.axis[d][axis];
        /* x, y, z of the wall become three of the cube's, from one of two corners */
        double u[3] = {0};
        u[wall % 3] = sign;
        turned.axis[d][0] =
            u[0] * motion.axis[d][0] + u[1] * motion.axis[d][1] + u[2] * motion.axis[d][2];
        u[wall % 3] = 0;
        u[(wall + 1) % 3] = sign;
        turned.axis[d][1] =
            u[0] * motion.axis[d][0] + u[1] * motion.axis[d][1] + u[2] * motion.axis[d][2];
        turned.shift[d] +=
            sign > 0
                ? 0
                : 3 * motion.scale * (motion.axis[d][0] + motion.axis[d][1] + motion.axis[d][2]);
      }
      add_cells(&deck, &turned, n, everywhere, RAD_SIDE_FRONT);
    }
    struct rad_scene scene;
    struct rad_occluders o = occluders_of(&deck, &scene, 0);
    ck_assert_msg(o.n == 6 && o.n_plane == 6, "n %d: %d planes, %d polygons, step %d, seed %llu", n,
                  o.n_plane, o.n, k, seed());
    ck_assert_int_eq(scene.n_vertex, 6 * n * n + 2);
    for (int side = 0; side < 24; side++)
      ck_assert_int_eq(o.on_line_first[side + 1] - o.on_line_first[side], n + 1);
    for (int plane = 0; plane < 6; plane++)
      ck_assert_int_eq(o.in_plane_first[plane + 1] - o.in_plane_first[plane], (n + 1) * (n + 1));
    ck_assert_int_eq(o.bvh->n_node, 0);
    drop_both(&o, &scene);
  }
}
END_TEST

/* A fan, or a ring with a hole, of 40 corners: 38 triangles in polygons of up to 6 each. */
START_TEST(discs_with_many_corners) {
  enum { N = 40 };
  start_random();
  for (int k = 0; k < 30; k++) {
    struct motion motion = any_motion(k);
    struct rad_deck deck = {0};
    const point center = {uniform(-0.5, 0.5), uniform(-0.5, 0.5)};
    for (int c = 0; c < N; c++) {
      const double a = 2 * 3.14159265358979 * c / N, b = 2 * 3.14159265358979 * ((c + 1) % N) / N;
      const point p = {cos(a), sin(a)}, q = {cos(b), sin(b)};
      const point r = {cos(a) / 2, sin(a) / 2}, s = {cos(b) / 2, sin(b) / 2};
      if (k % 2) {
        add_flat(&deck, &motion, center, p, q, RAD_SIDE_FRONT);
      } else {
        add_flat(&deck, &motion, r, p, q, RAD_SIDE_FRONT);
        add_flat(&deck, &motion, r, q, s, RAD_SIDE_FRONT);
      }
    }
    struct rad_scene scene;
    struct rad_occluders o = occluders_of(&deck, &scene, 0);
    ck_assert_int_eq(o.n_plane, 1);
    ck_assert_msg(k % 2 ? o.n >= 7 && o.n <= 12 : o.n <= N, "step %d: %d polygons, seed %llu", k,
                  o.n, seed());
    drop_both(&o, &scene);
  }
}
END_TEST

/* --- what must not break --- */

/* Whether two triangles of the plane have area in common: no side separates them. */
static int have_common_area(const point a[3], const point b[3]) {
  for (int m = 0; m < 6; m++) {
    const point *t = m < 3 ? a : b, *other = m < 3 ? b : a;
    const double *p = t[m % 3], *q = t[(m + 1) % 3];
    double most = 0;
    for (int o = 0; o < 3; o++)
      most =
          fmax(most, (q[0] - p[0]) * (other[o][1] - p[1]) - (q[1] - p[1]) * (other[o][0] - p[0]));
    if (most < 1e-9)
      return 0;
  }
  return 1;
}

enum { MOST_FOLDED = 23 };

/* The side on which triangle n overlaps none before it: 1, -1, or 0 if there is none. */
static int free_side(int n, point t[MOST_FOLDED][3], const int side[MOST_FOLDED]) {
  int taken[2] = {0, 0};
  for (int q = 0; q < n; q++)
    if (side[q] && have_common_area((const point *)t[q], (const point *)t[n]))
      taken[side[q] < 0] = 1;
  return !taken[0] ? 1 : !taken[1] ? -1 : 0;
}

/* Triangles that share edges and overlap, stay as they are or are merged where that is exact. A
 * scene has such triangles on two sides of a plane only: they are made so, and then turned. */
START_TEST(folded_triangles_keep_their_areas) {
  start_random();
  int n_back = 0;
  for (int k = 0; k < 400; k++) {
    struct motion motion = random_motion(3);
    struct rad_deck deck = {0};
    point p[7], t[MOST_FOLDED][3];
    int side[MOST_FOLDED], used[MOST_FOLDED], n = 0;
    for (int m = 0; m < 7; m++)
      p[m][0] = uniform(0, 1), p[m][1] = uniform(0, 1);
    for (int tried = 0; tried < 3 + k % 20; tried++) {
      int a = (int)uniform(0, 7), b = (int)uniform(0, 7), c = (int)uniform(0, 7), known = 0;
      used[n] = 1 << a | 1 << b | 1 << c;
      for (int q = 0; q < n; q++)
        known |= used[q] == used[n];
      double area =
          (p[b][0] - p[a][0]) * (p[c][1] - p[a][1]) - (p[b][1] - p[a][1]) * (p[c][0] - p[a][0]);
      memcpy(t[n][0], p[a], sizeof p[a]);
      memcpy(t[n][1], p[area > 0 ? b : c], sizeof p[a]);
      memcpy(t[n][2], p[area > 0 ? c : b], sizeof p[a]);
      if (known || fabs(area) < 1e-3 || !(side[n] = free_side(n, t, side)))
        continue;
      add_flat(&deck, &motion, t[n][0], t[n][1], t[n][2],
               side[n] > 0 ? RAD_SIDE_FRONT : RAD_SIDE_BACK);
      n_back += side[n] < 0;
      n++;
    }
    if (!deck.n_triangle)
      continue;
    struct rad_scene scene = build_scene(&deck);
    for (int q = 0; q < n; q++)
      for (int d = 0; d < 3; d++)
        scene.triangle[q].normal[d] *= side[q];
    struct rad_occluders o = occluders_of_scene(&scene, 0);
    drop_both(&o, &scene);
  }
  ck_assert_int_gt(n_back, 200);
}
END_TEST

/* Random points, and many on lines, triangulated by inserting one after the other: needles too. */
START_TEST(random_triangulations_of_a_square) {
  start_random();
  int n_more = 0;
  for (int k = 0; k < 60; k++) {
    enum { N = 60 };
    struct motion motion = any_motion(k);
    point p[N + 4];
    int t[2 * N + 2][3] = {{0, 1, 2}, {0, 2, 3}}, n = 2;
    memcpy(p, SQUARE, sizeof SQUARE);
    for (int v = 4; v < N + 4; v++) {
      int in = (int)uniform(0, n), *old = t[in];
      double a = uniform(0.01, 1), b = uniform(0.01, 1), c = k % 2 ? uniform(0.01, 1) : 1e-7;
      for (int d = 0; d < 2; d++)
        p[v][d] = (a * p[old[0]][d] + b * p[old[1]][d] + c * p[old[2]][d]) / (a + b + c);
      memcpy(t[n], ((int[3]){old[1], old[2], v}), sizeof t[n]);
      memcpy(t[n + 1], ((int[3]){old[2], old[0], v}), sizeof t[n]);
      double least = 1;
      for (int q = 0; q < 3; q++) {
        const double *x = p[old[q]], *y = p[old[(q + 1) % 3]];
        double dx = y[0] - x[0], dy = y[1] - x[1];
        least = fmin(least, ((p[v][1] - x[1]) * dx - (p[v][0] - x[0]) * dy) / (dx * dx + dy * dy));
        least = fmin(least, hypot(p[v][0] - x[0], p[v][1] - x[1]));
      }
      if (least < 1e-8) { /* refused or welded */
        v--;
        continue;
      }
      old[2] = v;
      n += 2;
    }
    struct rad_deck deck = {0};
    for (int q = 0; q < n; q++)
      add_flat(&deck, &motion, p[t[q][0]], p[t[q][1]], p[t[q][2]], RAD_SIDE_FRONT);
    struct rad_scene scene;
    struct rad_occluders o = occluders_of(&deck, &scene, 0);
    n_more += o.n - 1;
    drop_both(&o, &scene);
  }
  ck_assert_int_eq(n_more, 0);
}
END_TEST

/* A square of cells a million sizes away: coordinates are rounded to 1e-10. */
START_TEST(far_from_the_origin) {
  start_random();
  for (int k = 0; k < 10; k++) {
    struct motion motion = random_motion(0);
    for (int d = 0; d < 3; d++)
      motion.shift[d] = uniform(-1e6, 1e6);
    struct rad_deck deck = {0};
    add_cells(&deck, &motion, 6, k % 2 ? everywhere : in_frame, RAD_SIDE_FRONT);
    struct rad_scene scene = build_scene(&deck);
    struct rad_occluders o;
    struct rad_error error;
    ck_assert_int_eq(rad_occluders_build(&scene, &o, &error), RAD_OK);
    ck_assert_int_eq(o.n_plane, 1);
    ck_assert_int_le(o.n, k % 2 ? 1 : 6);
    double area = k % 2 ? -9 : -8;
    for (int q = 0; q < o.n; q++)
      area += area_of(&o, &o.occluder[q]);
    ck_assert(fabs(area) < 1e-8); /* sides of 3 times rounding */
    drop_both(&o, &scene);
  }
}
END_TEST

/* A floor at z = 0 and a slightly tilted one at its edge are two planes; walls cut the scene. */
START_TEST(planes_that_cut_the_scene_are_in_the_bvh) {
  start_random();
  for (int k = 0; k < 20; k++) {
    struct motion motion = random_motion(3);
    struct rad_deck deck = {0};
    add_prism(&deck, &motion, 6, ELL, 4, ELL_CAP, 0, 1, RAD_SIDE_BACK);
    struct rad_scene scene;
    struct rad_occluders o = occluders_of(&deck, &scene, 0);
    ck_assert_int_eq(o.n_plane, 8);
    ck_assert_int_eq(o.n, 10); /* both caps are two */
    ck_assert_int_eq(o.bvh->n_node, 1);
    ck_assert_int_eq(o.bvh->node[0].n, 2); /* the walls at the reflex edge */
    for (int q = 0; q < 2; q++)
      ck_assert(o.plane[4] == o.occluder[o.bvh->item[q]].plane ||
                o.plane[6] == o.occluder[o.bvh->item[q]].plane);
    drop_both(&o, &scene);
    const double tilt = 1e-9;
    add_moved(&deck, &motion, (double[3][3]){{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, RAD_SIDE_FRONT);
    add_moved(&deck, &motion, (double[3][3]){{1, 0, 0}, {1, 1, k % 2 ? tilt : 0}, {0, 1, 0}},
              RAD_SIDE_FRONT);
    o = occluders_of(&deck, &scene, 0);
    ck_assert_int_eq(o.n_plane, 1 + k % 2);
    ck_assert_int_eq(o.n, 1 + k % 2);
    drop_both(&o, &scene);
  }
}
END_TEST

/* Two squares back to back, each cut its own way, in one polygon. */
START_TEST(back_to_back) {
  start_random();
  for (int k = 0; k < 20; k++) {
    struct motion motion = any_motion(k);
    struct rad_deck deck = {0};
    struct rad_scene scene;
    for (int side = 0; side < 2; side++)
      for (int half = 0; half < 2; half++)
        add_flat(&deck, &motion, SQUARE[side], SQUARE[1 + side + half],
                 SQUARE[(2 + side + half) % 4], side ? RAD_SIDE_BACK : RAD_SIDE_FRONT);
    struct rad_occluders o = occluders_of(&deck, &scene, 1);
    ck_assert_int_eq(o.n, 1);
    ck_assert_int_eq(o.occluder[0].n, 4);
    drop_both(&o, &scene);
  }
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", seed());
  Suite *suite = suite_create("occluder");
  TCase *tests = tcase_create("occluder");
  tcase_add_test(tests, cells_become_their_shape);
  tcase_add_test(tests, a_subdivided_cube_is_six_squares);
  tcase_add_test(tests, discs_with_many_corners);
  tcase_add_test(tests, folded_triangles_keep_their_areas);
  tcase_add_test(tests, back_to_back);
  tcase_add_test(tests, random_triangulations_of_a_square);
  tcase_add_test(tests, far_from_the_origin);
  tcase_add_test(tests, planes_that_cut_the_scene_are_in_the_bvh);
  tcase_set_timeout(tests, 120);
  suite_add_tcase(suite, tests);
  return run_suite(suite);
}
