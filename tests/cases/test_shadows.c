/* What points receive past blockers: against the closed form of the visible part, against brute
 * force, and against rays. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "integrate/element.h"
#include "rooms.h"
#include "shadow_oracle.h"
#include "suite.h"
#include "system/dense.h"

#define TOLERANCE 1e-13 /* of the quadrature */

static const struct rad_deck_method *const method[] = {&method_constant, &method_folded,
                                                       &method_paper, &method_graded};
enum { N_METHOD = sizeof method / sizeof *method };

static const struct motion still = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .scale = 1};

/* ---- the closed form ------------------------------------------------------------------------- */

static int in_plane_of(const struct rad_triangle *t, const struct rad_triangle *k) {
  double r[3], most = 0;
  for (int m = 0; m < 3; m++) {
    rad_sub(k->v[m], t->v[0], r);
    most = fmax(most, fabs(rad_dot(r, t->normal)));
  }
  return most < 1e-12 * sqrt(t->area + k->area);
}

static int same_vertices(const struct rad_triangle *a, const struct rad_triangle *b) {
  int n = 0;
  for (int m = 0; m < 9; m++)
    n += a->vertex[m / 3] == b->vertex[m % 3];
  return n == 3;
}

/* What stands between triangles i and j: all others, back-to-back ones once. */
static int list_blockers(const struct rad_scene *s, int i, int j, double (*blocker)[3][3]) {
  const struct rad_triangle *t = s->triangle;
  int n = 0;
  for (int k = 0; k < s->n_triangle; k++)
    if (!in_plane_of(&t[i], &t[k]) && !in_plane_of(&t[j], &t[k]) &&
        (k == 0 || !same_vertices(&t[k], &t[k - 1])))
      memcpy(blocker[n++], t[k].v, sizeof *blocker);
  return n;
}

static struct eye eye_of(const struct rad_scene *scene, const struct spots *s, int i) {
  const struct rad_triangle *t = &scene->triangle[s->triangle[i]];
  return eye_at(t->v, s->base[i], s->mu[i], t->normal);
}

/* What a spot receives of triangle j. */
static double exact(const struct rad_scene *scene, const struct spots *s, int i, int j) {
  double blocker[scene->n_triangle][3][3];
  const struct rad_triangle *t = &scene->triangle[j];
  int target = s->triangle[i];
  if (in_plane_of(&scene->triangle[target], t))
    return 0;
  struct eye eye = eye_of(scene, s, i);
  int n = list_blockers(scene, target, j, blocker);
  return (double)shadow_form_factor(&eye, t->v, t->normal, n, (const double(*)[3][3])blocker);
}

struct tally {
  int n, n_hidden, n_part;
  double worst;
};

/* Every spot against the closed form, and between nothing and what it gets without shadows. */
static void compare(struct room *room, const struct rad_deck_method *m, const struct spots *s,
                    double limit, const char *what, struct tally *tally) {
  int n = room->scene.n_triangle;
  double *got = receive(room, m, TOLERANCE, s, 1), *open = receive(room, m, TOLERANCE, s, 0);
  for (int i = 0; i < s->n; i++)
    for (int j = 0; j < n; j++) {
      double value = got[i * n + j], most = open[i * n + j],
             expected = exact(&room->scene, s, i, j);
      tally->n++;
      tally->n_hidden += expected < 1e-12 && most > 1e-6;
      tally->n_part += expected >= 1e-12 && expected < most - 1e-9;
      tally->worst = fmax(tally->worst, fabs(value - expected));
      ck_assert_msg(fabs(value - expected) <= limit,
                    "%s: triangle %d (base %d, mu %.17g %.17g) gets of %d %.15g, expected %.15g, "
                    "difference %.2g; seed %llu",
                    what, s->triangle[i], s->base[i], s->mu[i][0], s->mu[i][1], j, value, expected,
                    value - expected, seed());
      ck_assert_msg(value >= -TOLERANCE && value <= most + limit,
                    "%s: %d of %d: %g is not within 0..%g", what, i, j, value, most);
    }
  free(got);
  free(open);
}

static void print_tally(const char *what, const struct tally *t) {
  printf("%s: %d pairs of a point and a triangle, %d hidden, %d in part; worst %.1e\n", what, t->n,
         t->n_hidden, t->n_part, t->worst);
  fflush(stdout);
}

/* ---- squares and a blocker ------------------------------------------------------------------- */

/* Unit squares z = 0 and z = 1 that see each other, and between them a square low .. high at a
 * height. */
static void add_squares(struct rad_deck *deck, double low, double high, double height) {
  for (int k = 0; k < 6; k++) {
    double v[3][3];
    for (int m = 0; m < 3; m++)
      for (int d = 0; d < 3; d++) {
        double p = d < 2 ? SQUARE[SQUARE_CAP[k % 2][m]][d] : 0;
        v[m][d] = k < 4 ? (d < 2 ? p : k / 2) : d < 2 ? low + p * (high - low) : height;
      }
    add_moved(deck, &still, v, k / 2 == 1 ? RAD_SIDE_BACK : RAD_SIDE_FRONT);
  }
}

/* Over the floor, some of them in full view, some in the umbra of a triangle, most in part. */
static void add_grid(struct spots *s, int triangle, int n) {
  for (int a = 0; a < n; a++)
    for (int b = 0; a + b < n; b++)
      add_spot(s, triangle, 0, (a + 0.31) / n, (b + 0.27) / n);
}

START_TEST(parallel_squares) {
  static const double height[] = {0.5, 0.01, 0.9};
  struct tally tally = {0};
  struct spots *s = calloc(1, sizeof *s);
  for (int triangle = 0; triangle < 2; triangle++) {
    add_grid(s, triangle, 7);
    add_border_spots(s, triangle, 1e-3);
    add_border_spots(s, triangle, 1e-10);
  }
  for (int h = 0; h < 3; h++) {
    struct rad_deck deck = {0};
    struct room room;
    add_squares(&deck, 0.25, 0.75, height[h]);
    room_make(&deck, &room);
    compare(&room, method[_i], s, 1e-12, "squares", &tally);
    room_free(&room);
  }
  print_tally("parallel squares", &tally);
  ck_assert(tally.n_hidden > 20 && tally.n_part > 200);
  free(s);
}
END_TEST

/* ---- single trial functions ------------------------------------------------------------------ */

/* Integrals of G and an element's trial functions over polygons, with a Gauss rule in (sigma, tau)
 * between the rays through their corners. */
struct moments {
  const struct eye *eye;
  const struct rad_mesh *mesh;
  int element;
  double value[RAD_GAUSS_MAX];
};

/* (r, r t) of a corner in the patch's own coordinates. */
static void to_patch(const struct rad_patch *p, const long double y[3], double at[2]) {
  double r[3];
  for (int d = 0; d < 3; d++)
    r[d] = (double)(y[d] - p->v[d]);
  at[1] = rad_dot(r, p->e2) / p->b2;
  at[0] = (rad_dot(r, p->e1) - at[1] * p->b1) / p->a1;
}

/* Where the ray t enters and leaves a convex polygon; 0 if it misses. */
static int range_on_ray(int n, const double (*corner)[2], double t, double range[2]) {
  range[0] = INFINITY;
  range[1] = -INFINITY;
  for (int c = 0; c < n; c++) {
    const double *p = corner[c], *q = corner[(c + 1) % n];
    double fp = p[1] - t * p[0], fq = q[1] - t * q[0];
    if ((fp > 0) == (fq > 0))
      continue;
    double r = p[0] + fp / (fp - fq) * (q[0] - p[0]);
    range[0] = fmin(range[0], r);
    range[1] = fmax(range[1], r);
  }
  return range[1] > range[0];
}

/* The kernel at (phi, r) times dS / (dphi dr). */
static double kernel_at(const struct moments *m, const struct rad_patch *p, double t, double r) {
  const double *normal = m->mesh->scene->triangle[p->triangle].normal;
  double w[3], n[3];
  for (int d = 0; d < 3; d++) {
    w[d] = p->v[d] + r * (p->a[d] + t * p->b[d]) - (double)m->eye->x[d];
    n[d] = (double)m->eye->normal[d];
  }
  double w2 = rad_dot(w, w);
  return -rad_dot(n, w) * rad_dot(normal, w) / (M_PI * w2 * w2) * p->a1 * p->b2 * r *
         rad_angle_dt(p->angle, t);
}

static void add_between(struct moments *m, int n, const double (*corner)[2], double t0, double t1,
                        int sign) {
  enum { N = 40 };
  const struct rad_element *e = &m->mesh->element[m->element];
  const struct rad_patch *p = &m->mesh->patch[e->patch];
  const double *x = rad_gauss_node(&m->mesh->gauss, N), *w = rad_gauss_weight(&m->mesh->gauss, N);
  double s0 = rad_ungraded(rad_angle_phi(p->angle, t0), e->p_phi);
  double s1 = rad_ungraded(rad_angle_phi(p->angle, t1), e->p_phi), basis[RAD_GAUSS_MAX], range[2];
  for (int i = 0; i < N; i++) {
    double s = 0.5 * (s0 + s1 + x[i] * (s1 - s0)), phi = rad_graded(s, e->p_phi);
    double t = rad_angle_t(p->angle, phi);
    double outer = sign * w[i] * 0.5 * (s1 - s0) * e->p_phi * pow(s, e->p_phi - 1);
    if (!range_on_ray(n, corner, t, range))
      continue;
    double a = rad_ungraded(fmax(range[0], 0), e->p_r), b = rad_ungraded(range[1], e->p_r);
    for (int k = 0; k < N; k++) {
      double tau = 0.5 * (a + b + x[k] * (b - a)), r = rad_graded(tau, e->p_r);
      double f = outer * w[k] * 0.5 * (b - a) * e->p_r * pow(tau, e->p_r - 1);
      f *= kernel_at(m, p, t, r);
      rad_element_basis(m->mesh, m->element, phi, r, basis);
      for (int q = 0; q < e->n_function; q++)
        m->value[q] += f * basis[q];
    }
  }
}

static int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static void add_moments(void *context, const struct flat *polygon, int sign) {
  struct moments *m = context;
  const struct rad_patch *p = &m->mesh->patch[m->mesh->element[m->element].patch];
  double corner[MOST_CORNER][2], t[MOST_CORNER];
  int n_t = 0;
  for (int c = 0; c < polygon->n; c++) {
    to_patch(p, polygon->corner[c], corner[c]);
    if (corner[c][0] > 1e-14)
      t[n_t++] = fmin(fmax(corner[c][1] / corner[c][0], 0), 1);
  }
  qsort(t, (size_t)n_t, sizeof *t, ascending);
  for (int i = 0; i + 1 < n_t; i++)
    if (t[i + 1] > t[i])
      add_between(m, polygon->n, (const double(*)[2])corner, t[i], t[i + 1], sign);
}

/* The element's corners in space. */
static struct flat element_in_space(const struct rad_mesh *mesh, int element) {
  const struct rad_element *e = &mesh->element[element];
  const struct rad_patch *p = &mesh->patch[e->patch];
  double t[2], r[2];
  struct flat f = {.n = 0};
  for (int i = 0; i < 2; i++) {
    t[i] = rad_angle_t(p->angle, rad_graded(e->sigma[i], e->p_phi));
    r[i] = rad_graded(e->tau[i], e->p_r);
  }
  for (int c = r[0] > 0 ? 0 : 1; c < 4; c++, f.n++) /* around: r0 t0, r0 t1, r1 t1, r1 t0 */
    for (int d = 0; d < 3; d++)
      f.corner[f.n][d] = p->v[d] + (long double)(c < 2 ? r[0] : r[1]) *
                                       (p->a[d] + (long double)t[c == 1 || c == 2] * p->b[d]);
  return f;
}

/* All trial functions of triangle j for one spot. */
static double worst_moment(const struct rad_mesh *mesh, const struct rad_rules *rules,
                           const struct spots *s, int i, int j, struct rad_scratch *scratch) {
  const struct rad_scene *scene = mesh->scene;
  double blocker[scene->n_triangle][3][3], *row = calloc((size_t)mesh->n_point, sizeof *row);
  int n = list_blockers(scene, s->triangle[i], j, blocker);
  struct eye eye = eye_of(scene, s, i);
  struct rad_targets target = {s->triangle[i], 1, &s->base[i], &s->mu[i], NULL};
  double worst = 0, x[3];
  for (int d = 0; d < 3; d++)
    x[d] = (double)eye.x[d] - scene->triangle[j].v[0][d];
  int in_front = rad_dot(x, scene->triangle[j].normal) > 0;
  for (int p = mesh->patch_first[j]; p < mesh->patch_first[j + 1]; p++) {
    rad_patch_block(mesh, rules, &target, p, NULL, row, 1, scratch);
    for (int e = mesh->element_first[p]; e < mesh->element_first[p + 1]; e++) {
      struct moments m = {.eye = &eye, .mesh = mesh, .element = e};
      struct flat whole = element_in_space(mesh, e);
      if (in_front)
        shadow_visit(&eye, &whole, n, (const double(*)[3][3])blocker, add_moments, &m);
      for (int q = 0; q < mesh->element[e].n_function; q++)
        worst = fmax(worst, fabs(m.value[q] - row[mesh->element[e].first + q]));
    }
  }
  free(row);
  return worst;
}

START_TEST(trial_functions) {
  static const double at[][2] = {{0.31, 0.27}, {0.05, 0.9}, {0.62, 0.33}, {0.03, 0.04}};
  struct spots *s = calloc(1, sizeof *s);
  struct rad_deck deck = {0};
  struct room room;
  struct rad_mesh mesh;
  struct rad_rules rules;
  struct rad_scratch scratch;
  struct rad_error e;
  double worst = 0, cut[3][3] = {{0.2, 0.1, 0.8}, {1.3, 0.2, 0.6}, {0.7, 0.9, 0.7}};
  add_squares(&deck, 0.25, 0.75, 0.5);
  add_moved(&deck, &still, cut, RAD_SIDE_FRONT);
  room_make(&deck, &room);
  ck_assert_int_eq(rad_mesh_build(&room.scene, method[_i], &mesh, &e), RAD_OK);
  ck_assert_int_eq(rad_rules_build(&mesh, TOLERANCE, &rules, &e), RAD_OK);
  ck_assert_int_eq(rad_scratch_init(&mesh, &scratch, &e), RAD_OK);
  for (int i = 0; i < 8; i++) {
    add_spot(s, i % 2, i % 3, at[i / 2][0], at[i / 2][1]);
    for (int j = 2; j < 4; j++) {
      double error = worst_moment(&mesh, &rules, s, i, j, &scratch);
      worst = fmax(worst, error);
      ck_assert_msg(error <= 1e-11, "spot %d, triangle %d: worst of its trial functions %g", i, j,
                    error);
    }
  }
  printf("trial functions of method %d: worst %.1e\n", _i, worst);
  rad_scratch_free(&scratch);
  rad_rules_free(&rules);
  rad_mesh_free(&mesh);
  room_free(&room);
  free(s);
}
END_TEST

/* ---- triangles in general position ----------------------------------------------------------- */

static void add_random(struct rad_deck *deck, const struct motion *motion, double reach,
                       enum rad_side side) {
  double v[3][3], center[3];
  struct rad_triangle t;
  for (int d = 0; d < 3; d++)
    center[d] = uniform(0, 1);
  do {
    for (int m = 0; m < 9; m++)
      t.v[m / 3][m % 3] = v[m / 3][m % 3] = center[m % 3] + reach * uniform(-1, 1);
    measure_triangle(&t);
  } while (t.area < 0.05 * reach * reach);
  add_moved(deck, motion, v, side);
}

static void add_random_spot(struct spots *s, int triangle) {
  double mu[2] = {uniform(0, 1), uniform(0, 1)};
  int flip = mu[0] + mu[1] > 1;
  add_spot(s, triangle, (int)uniform(0, 3), flip ? 1 - mu[0] : mu[0], flip ? 1 - mu[1] : mu[1]);
}

/* Triangles that cross one another: rounding of coordinates, 1e-16, moves the borders of what is
 * seen by that over the distance to the blocker's, which may be small. */
START_TEST(few_triangles) {
  struct tally tally = {0};
  struct spots *s = calloc(1, sizeof *s);
  start_random();
  for (int k = 0; k < 60; k++) {
    struct motion motion = random_motion(k % 2 ? 6 : 0);
    struct rad_deck deck = {0};
    struct room room;
    int n = 3 + k % 3;
    for (int t = 0; t < n; t++)
      add_random(&deck, &motion, t < 2 ? 1 : 0.5, k % 5 ? RAD_SIDE_BOTH : RAD_SIDE_FRONT);
    room_make(&deck, &room);
    s->n = 0;
    for (int i = 0; i < 8; i++)
      add_random_spot(s, i % room.scene.n_triangle);
    compare(&room, method[k % N_METHOD], s, 2e-12, "few", &tally);
    room_free(&room);
  }
  print_tally("few triangles", &tally);
  ck_assert(tally.n_hidden > 10 && tally.n_part > 200);
  free(s);
}
END_TEST

static void needle(struct rad_deck *deck, const struct motion *motion) {
  double at[3], along[3], across[3], other[3], v[3][3];
  random_direction(along);
  random_direction(other);
  rad_cross(along, other, across);
  for (int d = 0; d < 3; d++) {
    at[d] = uniform(0, 1);
    v[0][d] = at[d] - along[d];
    v[1][d] = at[d] + along[d];
    v[2][d] = at[d] + along[d] + 2 * across[d] / rad_norm(across) * M_PI / 1800;
  }
  add_moved(deck, motion, v, RAD_SIDE_BOTH);
}

/* A fan of triangles around one vertex, slits, and needles of 0.1 degree. Plain patches know places
 * near edges to 1e-16 only; sub-triangles have a patch for every edge and vertex. Borders of
 * shadows are known to 1e-16 of the patch: 1e-4 from an edge of 1 degree that is 1e-10. */
START_TEST(fans_slits_and_needles) {
  struct tally tally = {0};
  struct spots *s = calloc(1, sizeof *s);
  start_random();
  for (int k = 0; k < 24; k++) {
    struct motion motion = random_motion(k % 2 ? 3 : 0);
    struct rad_deck deck = {0};
    struct room room;
    double p[6][3];
    for (int m = 0; m < 18; m++)
      p[m / 3][m % 3] = uniform(0, 1);
    for (int m = 1; m < 6 && k % 3 == 0; m++) {
      double v[3][3];
      memcpy(v[0], p[0], sizeof v[0]);
      memcpy(v[1], p[m], sizeof v[1]);
      memcpy(v[2], p[m % 5 + 1], sizeof v[2]);
      add_moved(&deck, &motion, v, m % 2 ? RAD_SIDE_BOTH : RAD_SIDE_FRONT);
    }
    for (int m = 0; m < 3 && k % 3; m++)
      add_random(&deck, &motion, 1, RAD_SIDE_BOTH);
    for (int m = 0; m < 4 && k % 3 == 2; m++)
      needle(&deck, &motion);
    room_make(&deck, &room);
    s->n = 0;
    for (int i = 0; i < room.scene.n_triangle; i++) {
      add_random_spot(s, i);
      if (i % 3 == 0)
        add_border_spots(s, i, k % N_METHOD < 2 ? 0.01 : 1e-4);
    }
    compare(&room, method[k % N_METHOD], s, 1e-10, "fans", &tally);
    room_free(&room);
  }
  print_tally("fans, slits and needles", &tally);
  ck_assert(tally.n_hidden > 20 && tally.n_part > 200);
  free(s);
}
END_TEST

/* ---- a wall on a floor ----------------------------------------------------------------------- */

/* A wall that stands on the middle of a floor triangle, whose part behind the wall's plane is cut
 * off right at the foot of the wall's points: the near integrator once ignored the pole of that
 * side. Nothing but coordinates, good to 1e-16, tells the height of a point above the floor. */
START_TEST(wall_on_a_floor) {
  static const double floor[3][3] = {{-1, -0.9, 0}, {1.2, -0.7, 0}, {-0.1, 1, 0}};
  static const double wall[2][3][3] = {{{0.3, -0.2, 0}, {-0.4, 0.1, 0}, {-0.1, 0, 0.6}},
                                       {{-0.4, 0.1, 0}, {0.3, -0.2, 0}, {0, -0.1, 0.7}}};
  struct spots *s = calloc(1, sizeof *s);
  double worst = 0;
  for (int side = 0; side < 2; side++) {
    struct rad_deck deck = {0};
    struct room room;
    add_moved(&deck, &still, floor, RAD_SIDE_FRONT);
    add_moved(&deck, &still, wall[side], RAD_SIDE_FRONT);
    room_make(&deck, &room);
    s->n = 0;
    for (int k = 0; k < 40; k++)
      add_spot(s, 1, 0, 0.1 + 0.08 * (k % 10), pow(10, -1 - k / 10));
    double *got = receive(&room, method[_i], 1e-10, s, 1);
    for (int i = 0; i < s->n; i++) {
      double expected = exact(&room.scene, s, i, 0), error = fabs(got[2 * i] - expected);
      worst = fmax(worst, error);
      ck_assert_msg(error <= 1e-9 + 1e-15 / s->mu[i][1],
                    "%g above the floor: %.12f, expected %.12f", s->mu[i][1], got[2 * i], expected);
      ck_assert_double_gt(expected, 0.3);
    }
    free(got);
    room_free(&room);
  }
  printf("wall on a floor, method %d: worst %.1e\n", _i, worst);
  free(s);
}
END_TEST

/* ---- soups ----------------------------------------------------------------------------------- */

/* s > 0 where x + s r meets t, or INFINITY. */
static double meets(const struct rad_triangle *t, const double x[3], const double r[3]) {
  double u[3], v[3], w[3], rv[3], wu[3];
  rad_sub(t->v[1], t->v[0], u);
  rad_sub(t->v[2], t->v[0], v);
  rad_sub(x, t->v[0], w);
  rad_cross(r, v, rv);
  rad_cross(w, u, wu);
  double det = rad_dot(u, rv), a = rad_dot(w, rv) / det, b = rad_dot(r, wu) / det;
  double s = rad_dot(v, wu) / det;
  return a >= 0 && b >= 0 && a + b <= 1 && s > 1e-9 ? s : INFINITY;
}

/* Count where rays from a spot end, in front of triangles: cosine-weighted, brute force. */
static void shoot(const struct rad_scene *scene, const struct spots *s, int i, int n_ray,
                  int *count) {
  const struct rad_triangle *t = scene->triangle, *own = &t[s->triangle[i]];
  double x[3], u[3], w[3];
  rad_triangle_point(own, s->base[i], s->mu[i], x);
  rad_sub(own->v[1], own->v[0], u);
  double length = rad_norm(u);
  rad_cross(own->normal, u, w);
  memset(count, 0, sizeof(int) * (size_t)scene->n_triangle);
  for (int ray = 0; ray < n_ray; ray++) {
    double angle = uniform(0, 2 * M_PI), sine2 = uniform(0, 1), r[3], nearest = INFINITY;
    int hit = -1;
    for (int d = 0; d < 3; d++)
      r[d] = sqrt(sine2) * (cos(angle) * u[d] + sin(angle) * w[d]) / length +
             sqrt(1 - sine2) * own->normal[d];
    for (int k = 0; k < scene->n_triangle; k++) {
      double at = k == s->triangle[i] ? INFINITY : meets(&t[k], x, r);
      int faces = rad_dot(t[k].normal, r) < 0;
      if (at < nearest || (at == nearest && faces)) {
        nearest = at;
        hit = isfinite(at) && faces ? k : -1;
      }
    }
    if (hit >= 0)
      count[hit]++;
  }
}

/* 5 sigma, and that of a few rays for what is hardly seen. */
static void compare_with_rays(struct room *room, const struct rad_deck_method *m,
                              const struct spots *s) {
  enum { N_RAY = 100000 };
  int n = room->scene.n_triangle;
  int *count = malloc(sizeof(int) * (size_t)n);
  double *got = receive(room, m, 1e-10, s, 1);
  for (int i = 0; i < s->n; i++) {
    shoot(&room->scene, s, i, N_RAY, count);
    for (int j = 0; j < n; j++) {
      double p = got[i * n + j], rays = (double)count[j] / N_RAY;
      ck_assert_msg(fabs(p - rays) <= 5 * sqrt(p / N_RAY) + 5.0 / N_RAY,
                    "triangle %d gets of %d %.6f, by rays %.6f; seed %llu", s->triangle[i], j, p,
                    rays, seed());
    }
  }
  free(got);
  free(count);
}

START_TEST(soups) {
  static const int size[] = {5, 8, 13, 25, 40, 60};
  struct tally tally = {0};
  struct spots *s = calloc(1, sizeof *s);
  start_random();
  for (int k = 0; k < 6; k++) {
    struct motion motion = random_motion(0);
    struct rad_deck deck = {0};
    struct room room;
    for (int t = 0; t < size[k]; t++)
      add_random(&deck, &motion, size[k] > 20 ? 0.25 : 0.8, RAD_SIDE_FRONT);
    room_make(&deck, &room);
    s->n = 0;
    for (int i = 0; i < 6; i++)
      add_random_spot(s, (int)uniform(0, room.scene.n_triangle));
    compare_with_rays(&room, method[k % N_METHOD], s);
    s->n = 0;
    for (int i = 0; i < room.scene.n_triangle; i++)
      add_random_spot(s, i);
    compare(&room, method[(k + 1) % N_METHOD], s, 1e-11, "soups", &tally);
    room_free(&room);
  }
  print_tally("soups", &tally);
  ck_assert(tally.n_hidden > 100 && tally.n_part > 300);
  free(s);
}
END_TEST

/* The matrix of a scene of facets: each entry against the closed form. */
START_TEST(facets) {
  struct rad_deck deck = {0};
  struct room room;
  struct rad_mesh mesh;
  struct rad_dense dense;
  struct spots *s = calloc(1, sizeof *s);
  start_random();
  for (int t = 0; t < 40; t++)
    add_random(&deck, &still, 0.3, t % 2 ? RAD_SIDE_BOTH : RAD_SIDE_FRONT);
  room_make(&deck, &room);
  assemble(&room, &method_constant, TOLERANCE, &mesh, &dense);
  for (int i = 0; i < dense.n; i++)
    add_spot(s, i, mesh.point_base[i], mesh.point_mu[i][0], mesh.point_mu[i][1]);
  for (int i = 0; i < dense.n; i++)
    for (int j = 0; j < dense.n; j++) {
      double got = dense.k[i + (size_t)dense.n * (size_t)j], expected = exact(&room.scene, s, i, j);
      ck_assert_msg(fabs(got - expected) <= 1e-12, "K(%d, %d) = %.15g, expected %.15g", i, j, got,
                    expected);
    }
  ck_assert_int_gt(room.visibility.n_partly, 100);
  rad_dense_free(&dense);
  rad_mesh_free(&mesh);
  room_free(&room);
  free(s);
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", seed());
  Suite *suite = suite_create("shadows");
  TCase *c = tcase_create("pointwise");
  tcase_set_timeout(c, 300);
  tcase_add_loop_test(c, parallel_squares, 0, N_METHOD);
  tcase_add_loop_test(c, trial_functions, 1, N_METHOD);
  tcase_add_test(c, few_triangles);
  tcase_add_test(c, fans_slits_and_needles);
  tcase_add_loop_test(c, wall_on_a_floor, 0, N_METHOD);
  tcase_add_test(c, soups);
  tcase_add_test(c, facets);
  suite_add_tcase(suite, c);
  return run_suite(suite);
}
