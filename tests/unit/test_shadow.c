/* Shadows seen from next to the edge or the vertex that casts them: known ones, and against an
 * oracle in quadruple precision. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "scene_help.h"
#include "shadow_help.h"
#include "suite.h"

/* Rounding is a few 1e-16 over the sine of the angle at which the plane of x and a side meets the
 * source: 1e-12 leaves room for 1e-3. */
#define TOLERANCE 1e-12

/* --- known shadows --- */

/* From x below a triangle at height 1, its shadow at height 2 is twice as large. */
START_TEST(a_triangle_between_two) {
  static const double target[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  static const double blocker[3][3] = {{1, 1, 1}, {2, 1, 1}, {1, 2, 1}};
  static const double source[3][3] = {{0, 0, 2}, {8, 0, 2}, {0, 8, 2}};
  struct rad_deck deck = {0};
  add(&deck, "target", target);
  add(&deck, "source", source);
  add(&deck, "blocker", blocker);
  struct rad_scene scene = build_scene(&deck);
  struct rad_occluders o = occluders_by_hand(&scene);
  struct rad_shadow_frame frame;
  struct rad_shadow shadow;
  const double mu[2] = {0.25, 0.125};
  /* corners (2 q - x) / 8 of the shadow in units of the source's sides */
  const double corner[3][2] = {{1.75, 1.875}, {3.75, 1.875}, {1.75, 3.875}};
  rad_shadow_frame_set(&o, 0, 1, 2, &frame);
  ck_assert_int_eq(frame.n, 3);
  rad_shadow_cast(&frame, 0, mu, &shadow);
  ck_assert_int_eq(shadow.n, 3); /* the source is beyond, all of it */
  for (int s = 0; s < 3; s++) {
    int n_zero = 0;
    for (int c = 0; c < 3; c++) {
      double b1 = corner[c][0] / 8, b2 = corner[c][1] / 8;
      const double *f = shadow.value[s];
      double at = (1 - b1 - b2) * f[0] + b1 * f[1] + b2 * f[2];
      n_zero += fabs(at) < 1e-14;
      ck_assert_double_ge(at, -1e-14);
    }
    ck_assert_int_eq(n_zero, 2);
  }
  rad_shadow_frame_set(&o, 1, 0, 2, &frame); /* and back, from a corner: covered */
  rad_shadow_cast(&frame, 0, (double[2]){0.25, 0.25}, &shadow);
  ck_assert_int_gt(shadow.n, 0);
  rad_shadow_frame_set(&o, 2, 1, 0, &frame); /* the target is behind x */
  rad_shadow_cast(&frame, 0, mu, &shadow);
  ck_assert_int_eq(shadow.n, 0);
  rad_shadow_frame_set(&o, 0, 2, 1, &frame); /* the source is beyond */
  rad_shadow_cast(&frame, 0, mu, &shadow);
  ck_assert_int_eq(shadow.n, 0);
  for (int k = 0; k < 2; k++) {
    rad_shadow_frame_set(&o, 0, 1, k, &frame);
    ck_assert_int_eq(frame.n, 0);
  }
  rad_occluders_free(&o);
  rad_scene_free(&scene);
}
END_TEST

/* Target A M C, wall A B T with M on its side AB by topology: heights and volumes of M vanish even
 * if M is off that line by more than it ever is. */
START_TEST(topology_goes_before_rounding) {
  static const double target[3][3] = {{0, 0, 0}, {1, 1e-9, 1e-9}, {1, -1, 0}};
  static const double source[3][3] = {{0, 5, 1}, {1, 5, 1}, {0, 5, 2}};
  static const double wall[3][3] = {{0, 0, 0}, {3, 0, 0}, {1, 0, 3}};
  static const int vertices[8] = {0, 1, 2, 3, 4, 5, 6, 7}; /* A M C, source, B T */
  static const int on_line[] = {0, 1, 1, 2, 0, 2, 3, 4, 4, 5, 3, 5, 0, 1, 6, 6, 7, 0, 7};
  static const int on_line_first[] = {0, 2, 4, 6, 8, 10, 12, 15, 17, 19};
  static const int in_plane[] = {0, 1, 2, 3, 4, 5, 0, 1, 6, 7};
  struct rad_deck deck = {0};
  add(&deck, "target", target);
  add(&deck, "source", source);
  add(&deck, "wall", wall);
  struct rad_scene scene = build_scene(&deck);
  ck_assert_int_eq(scene.n_vertex, 8);
  ck_assert_mem_eq(scene.triangle[0].vertex, vertices, 3 * sizeof *vertices);
  struct rad_occluders o = occluders_by_hand(&scene);
  o.on_line = realloc(o.on_line, sizeof on_line);
  o.in_plane = realloc(o.in_plane, sizeof in_plane);
  memcpy(o.on_line, on_line, sizeof on_line);
  memcpy(o.on_line_first, on_line_first, sizeof on_line_first);
  memcpy(o.in_plane, in_plane, sizeof in_plane);
  o.in_plane_first[3] = 10;
  struct rad_shadow_frame frame;
  rad_shadow_frame_set(&o, 0, 1, 2, &frame);
  ck_assert(frame.height[0] == 0 && frame.height[1] == 0 && frame.height[2] != 0);
  for (int m = 0; m < 3; m++) {
    ck_assert(frame.side[0][0][m] == 0 && frame.side[0][1][m] == 0);
    ck_assert_double_gt(frame.side[0][2][m] * frame.height[2], 0);
  }
  rad_occluders_free(&o);
  rad_scene_free(&scene);
}
END_TEST

/* --- against the oracle --- */

static void random_point(double size, double v[3]) {
  for (int d = 0; d < 3; d++)
    v[d] = size * uniform(-1, 1);
}

/* Compare looks[r] of `exact`, by the oracle, with the same of `scene`, by hand-made and by merged
 * occluders. */
static void compare(const struct rad_scene *exact, const struct rad_scene *scene, int n,
                    const struct look *look, double tolerance, const char *what,
                    struct tally *tally) {
  struct rad_occluders o[2] = {occluders_by_hand(scene), occluders_merged(scene)};
  for (int r = 0; r < n; r++) {
    double expected = oracle_fraction(exact, &look[r]);
    expect_fraction(visible_fraction(&o[0], &look[r]), expected, tolerance, &look[r], what, tally);
    expect_fraction(visible_fraction(&o[1], &look[r]), expected, tolerance, &look[r], what, tally);
  }
  rad_occluders_free(&o[0]);
  rad_occluders_free(&o[1]);
}

/* Target ABC and blocker ABD at any dihedral angle, x at 1e-1 .. 1e-12 of AB; the source apart, or
 * with the vertex A or D, or a third page ABE. */
START_TEST(next_to_a_shared_edge) {
  struct tally tally[4] = {0};
  start_random();
  for (int k = 0; k < 1500; k++) {
    double p[8][3];
    for (int c = 0; c < 8; c++)
      random_point(c < 4 ? 1 : 2, p[c]);
    int kind = k % 4;
    if (kind == 1 || kind == 3)
      memcpy(p[4], p[0], sizeof p[0]);
    if (kind == 2)
      memcpy(p[4], p[3], sizeof p[0]);
    if (kind == 3)
      memcpy(p[5], p[1], sizeof p[0]);
    static const int triangle[3][3] = {{0, 1, 2}, {1, 0, 3}, {4, 5, 6}};
    struct rad_deck deck = {0};
    double flattest = 1, size = 1e9;
    for (int t = 0; t < 3; t++) {
      double v[3][3];
      for (int m = 0; m < 3; m++)
        memcpy(v[m], p[triangle[t][m]], sizeof v[m]);
      add(&deck, "page", v);
      struct rad_triangle shape;
      memcpy(shape.v, v, sizeof v);
      measure_triangle(&shape);
      size = fmin(size, shape.area);
    }
    struct rad_scene scene = build_scene(&deck);
    const struct rad_triangle *t = scene.triangle;
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < a; b++)
        flattest = fmin(flattest, 1 - fabs(rad_dot(t[a].normal, t[b].normal)));
    struct look look[24];
    for (int r = 0; r < 24; r++) {
      double t1 = uniform(0.05, 0.5), t2 = pow(10, -1 - r / 2) * uniform(0.3, 1);
      look[r] =
          (struct look){.target = 0, .source = 2, .base = r % 2, .shrink = 1, .corner = k % 3};
      look[r].mu[r % 2] = t1; /* along AB or BA */
      look[r].mu[!(r % 2)] = t2;
    }
    if (flattest > 1e-3 && size > 1e-2)
      compare(&scene, &scene, 24, look, TOLERANCE, "shared edge", &tally[kind]);
    rad_scene_free(&scene);
  }
  for (int kind = 0; kind < 4; kind++) {
    print_tally("shared edge", &tally[kind]);
    ck_assert_int_gt(tally[kind].n_part, kind == 3 ? 0 : 500);
    ck_assert_int_gt(tally[kind].n_free, 500);
    ck_assert_int_gt(tally[kind].n_hidden, kind == 3 ? 500 : 50);
  }
}
END_TEST

/* Triangles around the origin, three pages on the first spoke, and a few apart: x at 1e-1 .. 1e-12
 * of the origin sees them, and, of those around it, their parts at 2^-3 .. 2^-40 of it. */
START_TEST(next_to_the_vertex_of_a_fan) {
  enum { N_SPOKE = 7, N_FAN = N_SPOKE + 2, N = N_FAN + 4 };
  struct tally far = {0}, close = {0};
  start_random();
  for (int k = 0; k < 300; k++) {
    double spoke[N_SPOKE + 2][3];
    struct rad_deck deck = {0};
    for (int s = 0; s < N_SPOKE + 2; s++)
      random_point(1, spoke[s]);
    for (int t = 0; t < N; t++) {
      double v[3][3] = {{0, 0, 0}};
      const double *a = spoke[t < N_SPOKE ? t : 0];
      const double *b = spoke[t < N_SPOKE ? (t + 1) % N_SPOKE : t % (N_SPOKE + 2)];
      memcpy(v[1], a, sizeof v[1]);
      memcpy(v[2], b, sizeof v[2]);
      for (int m = 0; t >= N_FAN && m < 3; m++)
        random_point(1.5, v[m]);
      add(&deck, "fan", v);
    }
    struct rad_scene scene = build_scene(&deck);
    struct look look[24], near[24];
    int n = 0;
    for (int r = 0; r < 24; r++) {
      double t = pow(10, -1 - r / 2);
      look[n] = random_look(N);
      look[n].target %= N_FAN;
      look[n].base = 0;
      look[n].mu[0] *= t;
      look[n].mu[1] *= t;
      near[n] = look[n];
      near[n].source %= N_FAN;
      near[n].corner = 0;
      near[n].shrink = ldexp(1, -(int)ceil(-log2(t)));
      n += look[n].source != look[n].target && near[n].source != near[n].target;
    }
    compare(&scene, &scene, n, look, TOLERANCE, "fan", &far);
    compare(&scene, &scene, n, near, TOLERANCE, "fan, close", &close);
    rad_scene_free(&scene);
  }
  print_tally("fan", &far);
  print_tally("fan, close", &close);
  ck_assert_int_gt(far.n_part, 1000);
  ck_assert_int_gt(close.n_part, 1000);
}
END_TEST

static void scale_point(double factor, const double p[3], double v[3]) {
  for (int d = 0; d < 3; d++)
    v[d] = factor * p[d];
}

/* A wall over the side AB, on which the origin M lies: as a vertex of the two triangles that make
 * the wall (kinds 0 to 3), or by geometry only. The target has M, and in every other kind lies
 * along AB too; so does the source, for kinds 2, 3, 6, 7. */
static struct rad_scene wall_scene(const struct motion *motion, int kind, const double p[6][3]) {
  int split = kind < 4;
  double a[3], b[3], along[2][3], zero[3] = {0, 0, 0}, v[3][3];
  const double *top = p[5];
  scale_point(-2, p[0], a);
  scale_point(1, p[0], b);
  scale_point(split ? -2 : -0.5, p[0], along[0]);
  scale_point(split ? 1 : 0.25, p[0], along[1]);
  const double *triangle[4][3] = {{zero, kind & 1 ? along[0] : p[1], p[2]},
                                  {zero, kind & 2 ? along[1] : p[3], p[4]},
                                  {a, split ? zero : b, top},
                                  {zero, b, top}};
  struct rad_deck deck = {0};
  for (int t = 0; t < (split ? 4 : 3); t++) {
    for (int m = 0; m < 3; m++)
      memcpy(v[m], triangle[t][m], sizeof v[m]);
    add_moved(&deck, motion, v, RAD_SIDE_FRONT);
  }
  return build_scene(&deck);
}

static const struct motion STILL = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .scale = 1};

/* Merged, the wall's side has M between its ends; turned, M is off its line by rounding. The part
 * of the source at M is looked at from as near. */
START_TEST(next_to_a_vertex_within_a_side) {
  enum { N_LOOK = 24 };
  struct tally tally[8] = {0};
  start_random();
  for (int k = 0; k < 800; k++) {
    int kind = k % 8;
    double p[6][3];
    struct motion motion = random_motion(6);
    for (int c = 0; c < 6; c++)
      do
        random_point(1, p[c]);
      while (rad_norm(p[c]) < 0.3);
    struct rad_scene exact = wall_scene(&STILL, kind, p), scene = wall_scene(&motion, kind, p);
    struct look look[N_LOOK];
    for (int r = 0; r < N_LOOK; r++) {
      double t = pow(10, -1 - r / 2);
      look[r] = random_look(2);
      look[r].base = look[r].corner = 0;
      look[r].mu[0] *= t;
      look[r].mu[1] *= t;
      look[r].shrink = r % 2 ? ldexp(1, (int)log2(t)) : 1;
    }
    compare(&exact, &scene, N_LOOK, look, TOLERANCE, "within a side", &tally[kind]);
    rad_scene_free(&exact);
    rad_scene_free(&scene);
  }
  for (int kind = 0; kind < 8; kind++) {
    print_tally("within a side", &tally[kind]);
    ck_assert_int_gt(tally[kind].n_free, 500);
    ck_assert_int_gt(tally[kind].n_part, (kind & 3) == 3 ? -1 : 300);
    ck_assert_int_gt(tally[kind].n_hidden, (kind & 3) == 3 ? 300 : 30);
  }
}
END_TEST

/* --- blocks --- */

static void add_block(struct rad_deck *deck, const struct motion *motion, double x, double y,
                      double z) {
  struct motion at = *motion;
  double low[3] = {x, y, z};
  move(motion, low, at.shift);
  add_cube(deck, &at, RAD_SIDE_FRONT);
}

/* An axis-parallel rectangle normal to `axis` as two triangles. */
static void add_plate(struct rad_deck *deck, const struct motion *motion, int axis,
                      const double low[3], double width, enum rad_side side) {
  for (int t = 0; t < 2; t++) {
    double v[3][3];
    for (int m = 0; m < 3; m++) {
      const double *p = SQUARE[SQUARE_CAP[t][m]];
      memcpy(v[m], low, sizeof v[m]);
      v[m][(axis + 1) % 3] += width * p[0];
      v[m][(axis + 2) % 3] += width * p[1];
    }
    add_moved(deck, motion, v, side);
  }
}

/* The floor, with a hole that shares vertices with the middle cube. */
static void add_ring(struct rad_deck *deck, const struct motion *motion) {
  static const double outer[4][3] = {{-2, -2, 0}, {6, -2, 0}, {6, 6, 0}, {-2, 6, 0}};
  static const double inner[4][3] = {{1, 1, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}};
  for (int k = 0; k < 8; k++) {
    int c = k / 2, next = (c + 1) % 4;
    const double *corner[3] = {outer[c], k % 2 ? inner[next] : outer[next],
                               k % 2 ? inner[c] : inner[next]};
    double v[3][3];
    for (int m = 0; m < 3; m++)
      memcpy(v[m], corner[m], sizeof v[m]);
    add_moved(deck, motion, v, RAD_SIDE_FRONT);
  }
}

enum { FOOT_CUBE = 1 << 2, MIDDLE_CUBE = 1 << 4 };

/* Cubes on a floor under a ceiling: next to one another (whole faces touch), in a second layer that
 * is shifted by a half (parts of faces touch, edges end within edges), and slits: `side: both`. The
 * cubes rest on the floor by geometry only, or, `ring`, the middle one by topology. */
static struct rad_scene block_scene(const struct motion *motion, unsigned cubes, int plates,
                                    int ring) {
  static const double floor[3] = {-2, -2, 0}, ceiling[3] = {-2, -2, 4};
  static const double slit[2][3] = {{0.75, 1, 0}, {1, 1, 2.5}}; /* on no block's face */
  struct rad_deck deck = {0};
  if (ring)
    add_ring(&deck, motion);
  else
    add_plate(&deck, motion, 2, floor, 8, RAD_SIDE_FRONT);
  add_plate(&deck, motion, 2, ceiling, 8, RAD_SIDE_BACK);
  for (int c = 0; c < 9; c++)
    if (cubes >> c & 1)
      add_block(&deck, motion, c % 3, (double)(c / 3), 0);
  for (int c = 0; c < 4; c++)
    if (cubes >> (9 + c) & 1)
      add_block(&deck, motion, c % 2 + 0.5, c / 2 + 0.5, 1);
  for (int s = 0; s < plates; s++)
    add_plate(&deck, motion, s ? 2 : 0, slit[s], 2, RAD_SIDE_BOTH);
  return build_scene(&deck);
}

static int parallel(const struct rad_scene *scene, const struct look *look) {
  const struct rad_triangle *i = &scene->triangle[look->target],
                            *j = &scene->triangle[look->source];
  double r[3];
  rad_sub(i->v[0], j->v[0], r);
  return fabs(rad_dot(i->normal, j->normal)) > 0.5 && rad_dot(j->normal, r) == 0;
}

/* From within the floor's first triangle, (8, 0) and (8, 8) from (-2, -2), next to the foot of the
 * cube at (2, 0), outside it or under it; not next to its corners, as the rounding of those shows
 * there. */
static void look_from_foot(int r, struct look *look) {
  double away = (r % 4 < 2 ? 1 : -1) * pow(10, -1 - r % 12), along = uniform(4.2, 4.8);
  look->target = look->base = 0;
  if (r % 3) /* the ceiling */
    look->source = 1 + r % 3;
  look->mu[1] = (2 - away) / 8;
  look->mu[0] = along / 8 - look->mu[1];
}

/* Seen from anywhere, from next to edges, from next to vertices, and from next to where a cube
 * rests on the floor. The oracle has the blocks as they are, the solver turned ones with rounded
 * corners.
 */
START_TEST(blocks_that_touch) {
  enum { N_LOOK = 60 };
  struct tally straight = {0}, turned = {0};
  start_random();
  for (int k = 0; k < 24; k++) {
    unsigned cubes = (unsigned)uniform(1, 1 << 13) & (unsigned)uniform(1, 1 << 13);
    struct motion motion = random_motion(6);
    cubes |= k % 2 ? MIDDLE_CUBE : FOOT_CUBE;
    struct rad_scene exact = block_scene(&STILL, cubes, k % 3, k % 2);
    struct rad_scene scene = block_scene(&motion, cubes, k % 3, k % 2);
    ck_assert_int_eq(exact.n_triangle, scene.n_triangle);
    struct look look[N_LOOK];
    for (int r = 0; r < N_LOOK;) {
      double t = pow(10, -1 - r % 12);
      look[r] = random_look(exact.n_triangle);
      look[r].mu[0] *= r % 3 == 1 ? t : 1;
      look[r].mu[1] *= r % 3 ? t : 1;
      if (k % 2 == 0 && r % 2)
        look_from_foot(r / 2, &look[r]);
      r += !parallel(&exact, &look[r]);
    }
    compare(&exact, &exact, N_LOOK, look, TOLERANCE, "blocks", &straight);
    compare(&exact, &scene, N_LOOK, look, TOLERANCE, "turned blocks", &turned);
    rad_scene_free(&exact);
    rad_scene_free(&scene);
  }
  print_tally("blocks", &straight);
  print_tally("turned blocks", &turned);
  ck_assert_int_gt(turned.n_part, 200);
  ck_assert_int_gt(turned.n_free, 200);
  ck_assert_int_gt(turned.n_hidden, 200);
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", seed());
  Suite *suite = suite_create("shadow");
  TCase *tests = tcase_create("shadow");
  tcase_add_test(tests, a_triangle_between_two);
  tcase_add_test(tests, topology_goes_before_rounding);
  tcase_add_test(tests, next_to_a_shared_edge);
  tcase_add_test(tests, next_to_the_vertex_of_a_fan);
  tcase_add_test(tests, next_to_a_vertex_within_a_side);
  tcase_add_test(tests, blocks_that_touch);
  tcase_set_timeout(tests, 120);
  suite_add_tcase(suite, tests);
  return run_suite(suite);
}
