/* What triangles receive: closed boxes, closed forms behind a blocker, brute force; the points of
 * elements; where the integrand is smooth; balances. */
#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "estimate/balance.h"
#include "estimate/received.h"
#include "estimate/smooth.h"
#include "scene_text.h"
#include "suite.h"

static const char *const meshes[] = {"method: {mesh: uniform, elements: 1, degree: 0}\n",
                                     "method: {mesh: graded, elements: 1, grading: 3, degree: 3}\n",
                                     "method: {mesh: paper, elements: 2, degree: 1}\n"};
enum { N_MESH = sizeof meshes / sizeof *meshes };

static const double black[6] = {0, 0, 0, 0, 0, 0}, dark[6] = {0, 0, 0, 0, 0, 0};

static void prepare(struct deck_text *d, int mesh, struct rad_case *c) {
  struct rad_error e;
  deck_add(d, "%s", meshes[mesh]);
  enum rad_code code = deck_prepare(d, c, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
  ck_assert_ptr_nonnull(c->scene.visibility);
}

static void receive(const struct rad_case *c, const double *w, double tolerance,
                    struct rad_received *r) {
  struct rad_weights weights = {.mesh = c->mesh, .n = 1, .w = {w}};
  struct rad_error e;
  enum rad_code code = rad_receive(&weights, &c->scene, 0, &tolerance, r, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
}

/* w = 1 on the triangles of a surface, or on all; owned. */
static double *ones(const struct rad_case *c, const char *surface) {
  double *w = calloc((size_t)c->mesh->n_point, sizeof *w);
  for (int t = 0; t < c->scene.n_triangle; t++)
    for (int p = c->mesh->point_first[t]; p < c->mesh->point_first[t + 1]; p++)
      w[p] = !surface || !strcmp(c->scene.surface_name[c->scene.triangle[t].surface], surface);
  return w;
}

/* A box [low, low + size], seen from inside or from outside. */
static void add_box(struct deck_text *d, double low, const double size[3], int outside) {
  static const int face[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                 {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
  for (int f = 0; f < 6; f++) {
    double corner[4][3];
    for (int k = 0; k < 4; k++)
      for (int a = 0; a < 3; a++)
        corner[k][a] = low + (face[f][outside ? 3 - k : k] >> a & 1 ? size[a] : 0);
    deck_polygon(d, outside ? "body" : "wall", 4, (const double(*)[3])corner, 0, 0);
  }
}

/* Each triangle of a closed box receives 1 where all send 1, however thin the box. */
START_TEST(closed_boxes) {
  static const double size[][3] = {{1, 1, 1}, {1, 1, 1000}, {1, 1e-3, 1}, {2, 0.7, 1e-5}};
  static const double tolerance[] = {1e-2, 1e-4, 1e-6};
  for (int s = 0; s < 4; s++) {
    struct deck_text *d = malloc(sizeof *d);
    struct rad_case c;
    deck_begin(d);
    add_box(d, 0, size[s], 0);
    prepare(d, _i, &c);
    double *w = ones(&c, NULL);
    for (int k = 0; k < 3 - (s == 3); k++) { /* strips of 1e-5 take more points than there may be */
      struct rad_received r;
      receive(&c, w, tolerance[k], &r);
      for (int t = 0; t < c.scene.n_triangle; t++) {
        double area = c.scene.triangle[t].area, off = fabs(r.value[t] / area - 1);
        ck_assert_msg(off <= r.error[t] / area + 1e-13, "box %d, triangle %d: off %g, stated %g", s,
                      t, off, r.error[t] / area);
        ck_assert_msg(r.error[t] <= tolerance[k] * area, "box %d, triangle %d: %g at %g", s, t,
                      r.error[t] / area, tolerance[k]);
      }
      rad_received_free(&r);
    }
    free(w);
    free(d);
    rad_case_free(&c);
  }
}
END_TEST

static void square(struct deck_text *d, const char *name, double low, double high, double z, int up,
                   double emission) {
  double c[4][3] = {{low, low, z}, {high, low, z}, {high, high, z}, {low, high, z}};
  for (int d1 = 0; d1 < 3 && !up; d1++) {
    double other = c[1][d1];
    c[1][d1] = c[3][d1];
    c[3][d1] = other;
  }
  deck_polygon(d, name, 4, (const double(*)[3])c, 0, emission);
}

static double surface_sum(const struct rad_case *c, const char *name, const double *x) {
  double sum = 0;
  for (int t = 0; t < c->scene.n_triangle; t++)
    if (!strcmp(c->scene.surface_name[c->scene.triangle[t].surface], name))
      sum += x[t];
  return sum;
}

/* Squares with a square between them: the factor is closed; of x it is half of that, by symmetry.
 */
START_TEST(behind_a_blocker) {
  const double exact = 0.09950629459898;
  static const double tolerance[] = {1e-2, 1e-3, 1e-4, 1e-5};
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  deck_begin(d);
  square(d, "lower", 0, 1, 0, 1, 0);
  square(d, "upper", 0, 1, 1, 0, 0);
  square(d, "blocker", 0.25, 0.75, 0.5, 1, 0);
  deck_add(d, "  surfaces: {blocker: {side: both}}\n");
  prepare(d, _i, &c);
  double *w = ones(&c, "lower");
  for (int linear = 0; linear < 2; linear++) {
    for (int t = 0; t < c.scene.n_triangle && linear; t++)
      for (int p = c.mesh->point_first[t]; p < c.mesh->point_first[t + 1]; p++) {
        double x[3];
        rad_triangle_point(&c.scene.triangle[t], c.mesh->point_base[p], c.mesh->point_mu[p], x);
        w[p] *= x[0];
      }
    for (int k = 0; k < 4 && !(linear && _i == 0); k++) {
      struct rad_received r;
      receive(&c, w, tolerance[k], &r);
      double value = surface_sum(&c, "upper", r.value), error = surface_sum(&c, "upper", r.error);
      double right = linear ? exact / 2 : exact;
      ck_assert_msg(error <= 3 * tolerance[k], "%g at %g", error, tolerance[k]);
      /* a linear function is one of the graded variables too, but to interpolation only */
      ck_assert_msg(fabs(value - right) <= error + (linear ? 2e-3 : 1e-13), "off %g, stated %g",
                    value - right, error);
      rad_received_free(&r);
    }
  }
  free(w);
  free(d);
  rad_case_free(&c);
}
END_TEST

/* int_T K w by Gauss points on both triangles, for a w that the mesh has: far apart, so exact. */
static double brute_force(const struct rad_weights *w, int from, int to) {
  const struct rad_mesh *m = w->mesh;
  const struct rad_triangle *t = &m->scene->triangle[to], *s = &m->scene->triangle[from];
  double sum = 0;
  for (int p = m->patch_first[from]; p < m->patch_first[from + 1]; p++)
    for (int i = m->element_first[p]; i < m->element_first[p + 1]; i++) {
      struct rad_light light;
      struct rad_light_cell cell = rad_light_cell_whole(m, i);
      rad_light_set(w, &cell, 14, &light);
      for (int q = 0; q < light.senders.n; q++) {
        double y[3];
        rad_triangle_point(s, light.senders.base[q], light.senders.mu[q], y);
        for (int k = 0; k < 14 * 14; k++) {
          const double *node = rad_gauss_node(&m->gauss, 14), *g = rad_gauss_weight(&m->gauss, 14);
          double a = 0.5 * (1 + node[k % 14]), b = 0.5 * (1 + node[k / 14]), x[3], way[3];
          for (int e = 0; e < 3; e++)
            x[e] = t->v[0][e] + a * (t->v[1][e] - t->v[0][e] + b * (t->v[2][e] - t->v[1][e]));
          rad_sub(y, x, way);
          double d2 = rad_dot(way, way);
          sum += light.flux[0][q] * g[k % 14] * g[k / 14] * 0.25 * a * 2 * t->area *
                 rad_dot(way, t->normal) * -rad_dot(way, s->normal) / (M_PI * d2 * d2);
        }
      }
    }
  return sum;
}

START_TEST(brute_forces) {
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  deck_begin(d);
  square(d, "lower", 0, 1, 0, 1, 0);
  square(d, "upper", 0.4, 1.7, 1.3, 0, 0);
  prepare(d, _i, &c);
  double *w = ones(&c, "lower");
  for (int p = 0; p < c.mesh->n_point; p++)
    w[p] *= 1 + cos(5.0 * p);
  struct rad_weights weights = {.mesh = c.mesh, .n = 1, .w = {w}};
  struct rad_received r;
  receive(&c, w, 1e-9, &r);
  for (int t = 0; t < c.scene.n_triangle; t++) {
    double right = t < 2 ? 0 : brute_force(&weights, 0, t) + brute_force(&weights, 1, t);
    ck_assert_msg(fabs(r.value[t] - right) <= r.error[t] + 1e-11, "triangle %d: %g, not %g", t,
                  r.value[t], right);
    ck_assert_double_le(r.error[t], 1e-9 * c.scene.triangle[t].area);
  }
  rad_received_free(&r);
  free(w);
  free(d);
  rad_case_free(&c);
}
END_TEST

/* Copies of a lattice integrate w over an element, each by chance, all together without bias. */
START_TEST(lattices) {
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  deck_begin(d);
  deck_cube(d, black, dark);
  prepare(d, _i, &c);
  int n_light = 0;
  for (int l = 0; l < RAD_N_LATTICE; l++)
    n_light += RAD_REPLICATES / rad_lattice[l].at_once;
  ck_assert_int_eq(n_light, RAD_SCATTERED);
  double *w = ones(&c, NULL), mean_miss[RAD_N_LATTICE] = {0};
  for (int p = 0; p < c.mesh->n_point; p++)
    w[p] += 0.3 * cos(3.0 * p);
  struct rad_weights weights = {.mesh = c.mesh, .n = 1, .w = {w}};
  for (int i = 0; i < c.mesh->n_element; i++) {
    struct rad_light_cell cell = rad_light_cell_whole(c.mesh, i);
    static struct rad_light exact, light;
    double right = 0;
    rad_light_set(&weights, &cell, 12, &exact);
    for (int q = 0; q < exact.senders.n; q++)
      right += exact.flux[0][q];
    ck_assert_double_eq_tol(exact.area, rad_element_area(c.mesh, i), 1e-9);
    for (int l = 0; l < RAD_N_LATTICE; l++) {
      double sum = 0, square = 0;
      const struct rad_lattice *lattice = &rad_lattice[l];
      ck_assert_int_eq(RAD_REPLICATES % lattice->at_once, 0);
      for (int first = 0; first < RAD_REPLICATES; first += lattice->at_once) {
        rad_light_scatter(&weights, &cell, lattice, first, &light);
        ck_assert_int_eq(light.senders.n, lattice->n * lattice->at_once);
        for (int k = 0; k < lattice->at_once; k++) {
          double one = 0;
          for (int q = k * lattice->n; q < (k + 1) * lattice->n; q++)
            one += light.flux[0][q];
          sum += one;
          square += one * one;
        }
      }
      double mean = sum / RAD_REPLICATES;
      double spread = sqrt(fmax(square / RAD_REPLICATES - mean * mean, 0) / (RAD_REPLICATES - 1));
      ck_assert_msg(fabs(mean - right) <= 6 * spread + 1e-14, "element %d, lattice %d: %g of %g", i,
                    l, mean - right, spread);
      mean_miss[l] += spread / right / c.mesh->n_element;
    }
  }
  ck_assert_msg(mean_miss[3] < 0.1 * mean_miss[1] || mean_miss[3] < 1e-6, "%g and %g", mean_miss[1],
                mean_miss[3]);
  free(w);
  free(d);
  rad_case_free(&c);
}
END_TEST

/* Half axes of ellipses by hand. */
START_TEST(smoothness) {
  struct rad_cell_shape cell = {
      .corner = {{0, 0, 0}, {1, 0, 0}, {0, 4, 0}, {1, 4, 0}}, .centre = {0.5, 2, 0}, .vertex = -1};
  struct rad_singular s = {.n_point = 1, .point = {{0.5, 0, 0.3}}, .point_vertex = {7}};
  double axis[2];
  rad_smoothness(&cell, &s, axis);
  ck_assert_double_eq_tol(axis[0], sqrt(1 + 0.36), 1e-14); /* z = 0.6 i of the side at y = 0 */
  /* z = -1 + 0.15 i of the middle line along y */
  ck_assert_double_eq_tol(axis[1], 0.5 * (0.15 + hypot(2, 0.15)), 1e-14);
  /* a line across, above the middle of the long side; it is none of T's beside its ends */
  s = (struct rad_singular){
      .n_line = 1, .line = {{{-5, 2, 1}, {5, 2, 1}}}, .line_vertex = {{7, 8}}};
  rad_smoothness(&cell, &s, axis);
  ck_assert(isinf(axis[0]));
  ck_assert_double_eq_tol(axis[1], sqrt(1 + 0.25), 1e-14);
  s.line[0][0][0] = 3;
  rad_smoothness(&cell, &s, axis);
  ck_assert(isinf(axis[0]) && isinf(axis[1]));
  /* what touches the cell where it begins counts across only */
  cell.vertex = 7;
  s = (struct rad_singular){.n_point = 1, .point = {{0, 0, 0}}, .point_vertex = {7}};
  rad_smoothness(&cell, &s, axis);
  ck_assert_double_eq_tol(axis[0], 1, 1e-14);
  ck_assert(isinf(axis[1]));
}
END_TEST

static void solve(struct deck_text *d, struct rad_case *c) {
  struct rad_error e;
  deck_add(d, "accuracy: {tolerance: 1e-4}\n");
  enum rad_code code = deck_solve(d, c, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
}

/* A lid one way up, one unit above a lamp: its front or its back gets the factor of two squares. */
START_TEST(backs) {
  const double exact = 0.1998248956983874;
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  deck_begin(d);
  square(d, "lid", 0, 1, 1, _i, 0);
  square(d, "lamp", 0, 1, 0, 1, 3);
  solve(d, &c);
  ck_assert(!c.means.is_enclosed);
  struct rad_balance b;
  struct rad_error e;
  ck_assert_int_eq(rad_balance_make(&c.scene, &c.means, &b, &e), RAD_OK);
  double on_front = _i ? 0 : 3 * exact, on_back = _i ? 3 * exact : 0;
  ck_assert_double_eq_tol(b.emitted[0], 3, 1e-14);
  ck_assert_double_le(fabs(b.absorbed[0] - on_front), b.error[0] + 1e-14);
  ck_assert_double_le(fabs(b.rest[0] - (3 - on_front)), b.error[0] + 1e-14);
  ck_assert_double_le(fabs(b.on_backs[0] - on_back), b.backs_error[0] + 1e-14);
  ck_assert_double_le(b.error[0] + b.backs_error[0], 6e-4);
  free(d);
  rad_case_free(&c);
}
END_TEST

/* Enclosed: a room, also with a body in it, or with a square sheet of one side or two; not so a
 * room without one face, nor a body from outside. */
START_TEST(enclosures) {
  static const struct {
    int skip, body, sides, enclosed;
  } room[] = {{-1, 0, 0, 1}, {-1, 1, 0, 1}, {5, 0, 0, 0}, {0, 1, 0, 0},
              {-1, 0, 1, 1}, {-1, 0, 2, 1}, {5, 0, 2, 0}};
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  struct rad_error e;
  deck_begin(d);
  static const double shine[6] = {1, 0, 0, 0, 0, 0};
  struct deck_text *whole = malloc(sizeof *whole);
  deck_begin(whole);
  deck_cube(whole, black, shine);
  int face = 0, line = 0;
  for (char *at = strstr(whole->text, "    - "); at; at = strstr(at + 1, "    - ")) {
    char *end = strchr(at, '\n');
    face = line++ / 2;
    if (face != room[_i].skip)
      deck_add(d, "%.*s\n", (int)(end - at), at);
  }
  ck_assert_int_eq(line, 12);
  if (room[_i].body)
    add_box(d, 0.3, (const double[3]){0.3, 0.2, 0.1}, 1);
  for (int side = 0; side < room[_i].sides; side++)
    square(d, side ? "under" : "over", 0.2, 0.6, 0.5, !side, 0.2);
  solve(d, &c);
  ck_assert_int_eq(c.means.is_enclosed, room[_i].enclosed);
  struct rad_balance b;
  ck_assert_int_eq(rad_balance_make(&c.scene, &c.means, &b, &e), RAD_OK);
  if (room[_i].enclosed)
    ck_assert_double_le(fabs(b.rest[0] - b.on_backs[0]), b.error[0] + b.backs_error[0] + 1e-12);
  if (room[_i].enclosed)
    ck_assert_int_eq(b.on_backs[0] > 0.01, room[_i].sides == 1);
  /* the check itself: a mean that is wrong by more than its error */
  c.means.irradiance[2] += 2 * (b.error[0] + b.backs_error[0] + 1e-9) / c.scene.triangle[2].area;
  ck_assert_int_eq(rad_balance_make(&c.scene, &c.means, &b, &e),
                   room[_i].enclosed ? RAD_ENUMERIC : RAD_OK);
  free(whole);
  free(d);
  rad_case_free(&c);
}
END_TEST

int main(void) {
  Suite *s = suite_create("means");
  TCase *c = tcase_create("means");
  tcase_set_timeout(c, 300);
  tcase_add_loop_test(c, closed_boxes, 0, N_MESH);
  tcase_add_loop_test(c, behind_a_blocker, 0, N_MESH);
  tcase_add_loop_test(c, brute_forces, 0, N_MESH);
  tcase_add_loop_test(c, lattices, 0, N_MESH);
  tcase_add_test(c, smoothness);
  tcase_add_loop_test(c, backs, 0, 2);
  tcase_add_loop_test(c, enclosures, 0, 7);
  suite_add_tcase(s, c);
  return run_suite(s);
}
