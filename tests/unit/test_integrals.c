/* The integrator against the quadruple-precision oracle, near and far, cut and whole. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "integrate/element.h"
#include "integrate/near.h"
#include "integrate/strips.h"
#include "oracle.h"
#include "suite.h"

/* Two triangles with whole-number corners: all differences, halves and thirds are exact. */
struct pair {
  const char *name;
  double target[3][3], source[3][3]; /* equal corners are shared vertices */
};

static const struct pair pairs[] = {
    {"right angle", {{0, 0, 0}, {6, 0, 0}, {0, 6, 0}}, {{0, 0, 0}, {0, 6, 0}, {0, 0, 6}}},
    {"edge, far corner first",
     {{6, 0, 0}, {0, 12, 0}, {0, 0, 0}},
     {{0, 0, 6}, {0, 0, 0}, {6, 0, 0}}},
    {"sharp edge", {{0, 0, 0}, {12, 0, 0}, {0, 12, 0}}, {{0, 0, 0}, {12, 0, 0}, {6, 12, 2}}},
    {"flat edge", {{0, 0, 0}, {12, 0, 0}, {0, 12, 0}}, {{0, 0, 0}, {12, 0, 0}, {6, -12, 2}}},
    {"vertex", {{0, 0, 0}, {6, 0, 0}, {6, 6, 0}}, {{0, 0, 0}, {-6, 6, 6}, {-6, 0, 6}}},
    {"apart", {{0, 0, 0}, {6, 0, 0}, {0, 6, 0}}, {{0, 0, 6}, {0, 6, 12}, {6, 0, 6}}},
    {"close plates",
     {{0, 0, 0}, {6, 0, 0}, {0, 6, 0}},
     {{0, 0, 0.0009765625}, {6, 0, 0.0009765625}, {0, 6, 0.0009765625}}},
    {"across the horizon",
     {{0, 0, 0}, {6, 0, 0}, {0, 6, 0}},
     {{-6, 0, -6}, {-6, 6, -6}, {-6, 0, 12}}},
    {"needle", {{0, 0, 0}, {60, 0, 0}, {60, 6, 0}}, {{0, 0, 0}, {60, 0, 0}, {54, 0, 6}}},
};
enum { N_PAIR = sizeof pairs / sizeof *pairs };

static int same(const double a[3], const double b[3]) {
  return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* Each triangle's normal points to the other's side. */
static void set_normal(struct rad_triangle *t, const struct rad_triangle *other) {
  double f1[3], f2[3], n[3], towards[3], side = 0;
  rad_sub(t->v[1], t->v[0], f1);
  rad_sub(t->v[2], t->v[0], f2);
  rad_cross(f1, f2, n);
  t->area = 0.5 * rad_norm(n);
  for (int c = 0; c < 3; c++) {
    rad_sub(other->v[c], t->v[0], towards);
    double s = rad_dot(n, towards);
    side = fabs(s) > fabs(side) ? s : side;
  }
  for (int d = 0; d < 3; d++)
    t->normal[d] = n[d] / rad_norm(n) * (side < 0 ? -1 : 1);
}

static void set_scene(const struct pair *p, struct rad_triangle tri[2], struct rad_scene *scene) {
  memset(tri, 0, 2 * sizeof *tri);
  memcpy(tri[0].v, p->target, sizeof p->target);
  memcpy(tri[1].v, p->source, sizeof p->source);
  for (int c = 0; c < 3; c++) {
    tri[0].vertex[c] = c;
    tri[1].vertex[c] = 3 + c;
    for (int o = 0; o < 3; o++)
      if (same(tri[1].v[c], tri[0].v[o]))
        tri[1].vertex[c] = o;
  }
  set_normal(&tri[0], &tri[1]);
  set_normal(&tri[1], &tri[0]);
  *scene = (struct rad_scene){.n_triangle = 2, .n_vertex = 6, .n_band = 1, .triangle = tri};
}

static struct oracle_point to_point(const struct rad_triangle *t, int base, const double mu[2]) {
  struct oracle_point x = {.mu1 = mu[0], .mu2 = mu[1]};
  for (int d = 0; d < 3; d++) {
    x.vertex[d] = t->v[base][d];
    x.edge1[d] = t->v[(base + 1) % 3][d] - t->v[base][d];
    x.edge2[d] = t->v[(base + 2) % 3][d] - t->v[base][d];
    x.normal[d] = t->normal[d];
  }
  return x;
}

/* The oracle's element, formed from the triangle's corners and not from the mesh's patch. */
static struct oracle_element to_element(const struct rad_triangle *t, const struct rad_element *e,
                                        int sub, int polar) {
  struct oracle_element o = {
      .polar = polar, .p_phi = e->p_phi, .p_r = e->p_r, .k_phi = e->k_phi, .k_r = e->k_r};
  int edge = sub / 2, from = sub % 2 ? (edge + 1) % 3 : edge, to = sub % 2 ? edge : (edge + 1) % 3;
  for (int d = 0; d < 3; d++) {
    double v = t->v[from][d], w = t->v[to][d];
    o.v[d] = v;
    o.a[d] = (w - v) / 2;
    o.b[d] = (2 * (t->v[0][d] + t->v[1][d] + t->v[2][d]) - 3 * (v + w)) / 6;
    o.normal[d] = t->normal[d];
  }
  memcpy(o.sigma, e->sigma, sizeof o.sigma);
  memcpy(o.tau, e->tau, sizeof o.tau);
  return o;
}

/* The oracle's integrals, which are those of Gauss points, for functions on the points that the
 * mesh has: L'_a = sum_b L'_a(z_b) L_b. */
static void to_nodes(const struct rad_mesh *mesh, int k, long double *exact) {
  long double z[16], w[16], value[16][16], half[16 * 16], out[16 * 16];
  const double *at = rad_nodes_at(&mesh->nodes, k);
  oracle_gauss(k, z, w);
  for (int a = 0; a < k; a++)
    for (int b = 0; b < k; b++) {
      value[a][b] = 1;
      for (int m = 0; m < k; m++)
        value[a][b] *= m == a ? 1 : (z[b] - at[m]) / ((long double)at[a] - at[m]);
    }
  for (int c = 0; c < k; c++)
    for (int a = 0; a < k; a++) {
      half[a + k * c] = 0;
      for (int b = 0; b < k; b++)
        half[a + k * c] += value[a][b] * exact[b + k * c];
    }
  for (int c = 0; c < k; c++)
    for (int a = 0; a < k; a++) {
      out[a + k * c] = 0;
      for (int b = 0; b < k; b++)
        out[a + k * c] += value[c][b] * half[a + k * b];
    }
  memcpy(exact, out, sizeof *out * (size_t)(k * k));
}

/* Largest error of any integral of one point, over the row sum of the source triangle. */
static double point_error(const struct rad_mesh *mesh, double tolerance, int base,
                          const double mu[2]) {
  const struct rad_scene *scene = mesh->scene;
  struct rad_error err;
  struct rad_rules rules;
  struct rad_scratch scratch;
  ck_assert_int_eq(rad_rules_build(mesh, tolerance, &rules, &err), RAD_OK);
  ck_assert_int_eq(rad_scratch_init(mesh, &scratch, &err), RAD_OK);
  double *row = calloc((size_t)mesh->n_point, sizeof *row);
  struct rad_targets targets = {0, 1, &base, (const double(*)[2])mu, NULL};
  struct oracle_point x = to_point(&scene->triangle[0], base, mu);
  double worst = 0, sum = (double)oracle_lambert(&x, 3, (const double(*)[3])scene->triangle[1].v,
                                                 scene->triangle[1].normal);
  for (int p = mesh->patch_first[1]; p < mesh->patch_first[2]; p++) {
    rad_patch_block(mesh, &rules, &targets, p, NULL, row, 1, &scratch);
    for (int i = mesh->element_first[p]; i < mesh->element_first[p + 1]; i++) {
      const struct rad_element *e = &mesh->element[i];
      struct oracle_element o = to_element(&scene->triangle[1], e, p - mesh->patch_first[1],
                                           mesh->patch[p].angle == RAD_ANGLE_POLAR);
      long double exact[16 * 16];
      ck_assert_int_ge(oracle_integrate(&x, &o, exact), 0);
      to_nodes(mesh, e->k_phi, exact);
      for (int b = 0; b < e->n_function; b++)
        worst = fmax(worst, fabs((double)(row[e->first + b] - exact[b])));
    }
  }
  free(row);
  rad_scratch_free(&scratch);
  rad_rules_free(&rules);
  return worst / sum;
}

struct method {
  enum rad_mesh_kind mesh;
  int elements;
  double grading;
  int degree;
  enum rad_angle angle;
  struct rad_node_choice nodes;
};

static const struct method methods[] = {
    {RAD_MESH_PAPER, 1, 1, 0, RAD_ANGLE_POLAR, {0}},
    {RAD_MESH_PAPER, 2, 2, 1, RAD_ANGLE_POLAR, {0}},
    {RAD_MESH_PAPER, 2, 1.5, 3, RAD_ANGLE_DUFFY, {0}},
    {RAD_MESH_GRADED, 1, 2, 5, RAD_ANGLE_POLAR, {0}},
    {RAD_MESH_GRADED, 1, 3, 9, RAD_ANGLE_POLAR, {0}},
    {RAD_MESH_GRADED, 2, 4, 7, RAD_ANGLE_DUFFY, {0}},
    {RAD_MESH_GRADED, 1, 5, 11, RAD_ANGLE_POLAR, {0}},
};
enum { N_METHOD = sizeof methods / sizeof *methods };

/* Other nodes than Gauss points: their functions are up to 600 in size, their errors no larger. */
static const struct method laboratory[] = {
    {RAD_MESH_GEOMETRIC, 3, 1, 1, RAD_ANGLE_POLAR, {.kind = RAD_NODES_BIASED}},
    {RAD_MESH_GEOMETRIC, 2, 1, 4, RAD_ANGLE_DUFFY, {.kind = RAD_NODES_EQUIDISTANT}},
    {RAD_MESH_GRADED, 1, 3, 11, RAD_ANGLE_POLAR, {.kind = RAD_NODES_EQUIDISTANT}},
    {RAD_MESH_PAPER, 2, 2, 2, RAD_ANGLE_POLAR, {.kind = RAD_NODES_VERTEX}},
    {RAD_MESH_GRADED, 1, 2, 2, RAD_ANGLE_POLAR, {RAD_NODES_LIST, 3, {0.6, 0.8, 1}}},
};
enum { N_LABORATORY = sizeof laboratory / sizeof *laboratory };

static void build(const struct pair *p, const struct method *m, struct rad_triangle tri[2],
                  struct rad_scene *scene, struct rad_mesh *mesh) {
  struct rad_error e;
  struct rad_deck_method method = {.mesh = m->mesh,
                                   .elements = m->elements,
                                   .grading = m->grading,
                                   .degree = m->degree,
                                   .angle = m->angle,
                                   .ratio = 0.15,
                                   .nodes = m->nodes};
  set_scene(p, tri, scene);
  ck_assert_int_eq(rad_mesh_build(scene, &method, mesh, &e), RAD_OK);
}

/* Points of interest: inside, and at a distance from the first edge or from a vertex. */
static void place(int kind, double distance, int *base, double mu[2]) {
  static const double inside[2][2] = {{0.3, 0.2}, {0.11, 0.83}};
  *base = kind % 3;
  if (kind < 2)
    memcpy(mu, inside[kind], sizeof inside[kind]);
  else if (kind == 2 || kind == 3) { /* near an edge */
    mu[0] = kind == 2 ? 0.37 : distance;
    mu[1] = kind == 2 ? distance : 0.24;
  } else { /* near a vertex */
    mu[0] = 0.6 * distance;
    mu[1] = 0.3 * distance;
  }
}
enum { N_PLACE = 7 };

static void hold(int i_pair, const struct method *method, int kind, double distance,
                 double tolerance, double limit) {
  struct rad_triangle tri[2];
  struct rad_scene scene;
  struct rad_mesh mesh;
  int base;
  double mu[2];
  build(&pairs[i_pair], method, tri, &scene, &mesh);
  place(kind, distance, &base, mu);
  double error = point_error(&mesh, tolerance, base, mu);
  ck_assert_msg(
      error <= limit,
      "%s, degree %d, place %d, distance %g, tolerance %g: error %g over the row sum, limit %g",
      pairs[i_pair].name, method->degree, kind, distance, tolerance, error, limit);
  if (getenv("POLYRAD_TEST_VERBOSE"))
    printf("%-24s degree %d place %d distance %-6g tolerance %-6g error %.2e\n", pairs[i_pair].name,
           method->degree, kind, distance, tolerance, error);
  rad_mesh_free(&mesh);
}

START_TEST(inside_at_every_tolerance) {
  static const double tolerance[] = {1e-3, 1e-6, 1e-9, 1e-13};
  for (int m = 0; m < N_METHOD; m++)
    for (int k = 0; k < 2; k++)
      for (int t = 0; t < 4; t++)
        hold(_i, &methods[m], k, 1, tolerance[t], 2 * tolerance[t]);
}
END_TEST

START_TEST(near_edges_and_vertices) {
  static const double distance[] = {1e-2, 1e-4, 1e-6, 1e-8, 1e-10};
  for (int m = 0; m < N_METHOD; m++)
    for (int k = 2; k < N_PLACE; k++)
      for (int d = 0; d < 5; d++) {
        if ((m + k + d + _i) % 4) /* a quarter of all combinations each */
          continue;
        hold(_i, &methods[m], k, distance[d], 1e-13, 2e-13);
        hold(_i, &methods[m], k, distance[d], 1e-6, 2e-6);
      }
}
END_TEST

START_TEST(other_nodes) {
  static const double distance[] = {1e-2, 1e-6, 1e-10};
  for (int m = 0; m < N_LABORATORY; m++) {
    hold(_i, &laboratory[m], 0, 1, 1e-6, 2e-6);
    hold(_i, &laboratory[m], 1, 1, 1e-10, 2e-10);
    for (int k = 2; k < N_PLACE; k++)
      if ((m + k + _i) % 4 == 0)
        hold(_i, &laboratory[m], k, distance[(m + k) % 3], 1e-10, 2e-10);
  }
}
END_TEST

/* ---- strips ---------------------------------------------------------------------------------- */

/* A point above an element of one patch, looking straight down. */
struct above {
  struct rad_patch patch;
  struct rad_element element;
  double x[3];
};

/* int G over one strip by the near integrator: the sum over the trial functions. */
static double over_strip(const struct above *a, const struct rad_strip *strip) {
  int k = a->element.k_phi;
  double to_lagrange[16 * 16], out[16 * 16], sum = 0;
  struct rad_gauss gauss;
  struct rad_error e;
  ck_assert_int_eq(rad_gauss_init(&gauss, &e), RAD_OK);
  rad_lagrange_from_legendre(&gauss, k, to_lagrange);
  struct rad_near w = {.gauss = &gauss,
                       .patch = &a->patch,
                       .element = &a->element,
                       .to_lagrange_phi = to_lagrange,
                       .to_lagrange_r = to_lagrange,
                       .digits = log(100 / 1e-13),
                       .n0 = a->x[2],
                       .x = {a->x[0], a->x[1], a->x[2]}};
  rad_near(&w, strip, 1, out);
  for (int b = 0; b < k * k; b++)
    sum += out[b];
  rad_gauss_free(&gauss);
  return sum;
}

/* The same by Lambert's form. */
static double over_corners(const struct above *a, const struct rad_strip *strip) {
  static const double up[3] = {0, 0, 1};
  const struct rad_side_line *side[4] = {&strip->upper, &strip->upper, &strip->lower,
                                         &strip->lower};
  struct oracle_point x = {.edge1 = {1, 0, 0}, .edge2 = {0, 1, 0}, .normal = {0, 0, -1}};
  double y[4][3];
  for (int c = 0; c < 4; c++) {
    double sigma = strip->sigma[c == 0 || c == 3];
    double t = rad_angle_t(a->patch.angle, pow(sigma, a->element.p_phi));
    double r = side[c]->g / (side[c]->c1 + side[c]->c2 * t);
    y[c][0] = r * (a->patch.a1 + t * a->patch.b1);
    y[c][1] = r * t * a->patch.b2;
    y[c][2] = 0;
  }
  memcpy(x.vertex, a->x, sizeof x.vertex);
  return (double)oracle_lambert(&x, 4, (const double(*)[3])y, up);
}

/* A border of a shadow close to x and almost along a ray. The range is mapped around that side's
 * pole, and the image of the other pole on the second sheet of sinh is nearer than its first. */
START_TEST(strip_past_two_poles) {
  const struct above a = {
      .patch = {.a1 = 0.00479507, .b1 = -0.000918521, .b2 = 0.00226974},
      .element = {.sigma = {0, 1}, .tau = {0, 1}, .p_phi = 3, .p_r = 3, .k_phi = 6, .k_r = 6},
      .x = {0.00145103464, 0.000190595970, 7.36382143e-06}};
  double end = 0.26203897435460671;
  const struct rad_strip strip = {{0, 0.65943989477755804},
                                  {-8.3186975985416467e-06, -end, 0.99996825396825395},
                                  {end, end, 0}};
  double got = over_strip(&a, &strip), expected = over_corners(&a, &strip);
  ck_assert_double_gt(expected, 0.1);
  ck_assert_msg(fabs(got - expected) < 1e-9, "%.12f, expected %.12f", got, expected);
}
END_TEST

/* A side along a ray but for rounding has its pole on the real axis. */
START_TEST(strip_with_a_radial_side) {
  static const double g[] = {1e-16, 1e-17, 1e-20, 1e-40, 1e-300}, off[] = {0, 3e-10, 3e-7, 0.1};
  for (int k = 0; k < 20; k++) {
    double x = 1 + off[k % 4];
    const struct above a = {
        .patch = {.a1 = 0.5, .b1 = -1. / 6, .b2 = 2. / 3},
        .element =
            {.sigma = {0.5, 0.75}, .tau = {0, 0.25}, .p_phi = 1, .p_r = 1, .k_phi = 6, .k_r = 6},
        .x = {x, x, 1}};
    const struct rad_strip strip = {
        {0.63688684502897142, 0.75}, {-g[k / 4], 0.15, -0.25}, {0.25, 1, 0}};
    double got = over_strip(&a, &strip), expected = over_corners(&a, &strip);
    ck_assert_msg(fabs(got - expected) < 1e-12, "%g: %.15g, expected %.15g", g[k / 4], got,
                  expected);
  }
}
END_TEST

/* An element without its tip, whose corners are good to 1e-16 and so their angles to 1e-4: strips
 * go all the way between the angles of the far corners. */
START_TEST(strips_of_a_cut_tip) {
  const struct rad_patch patch = {.a1 = 1, .b1 = -0.3, .b2 = 0.8};
  const struct rad_element e = {.sigma = {0.5, 0.75}, .tau = {0, 0.25}, .p_phi = 1, .p_r = 1};
  struct rad_polygon polygon;
  struct rad_strip strip[RAD_MAX_CORNER];
  rad_element_polygon(&patch, &e, &polygon);
  ck_assert_int_eq(polygon.n, 3);
  for (int k = 0; k < 2; k++) {
    double at = k ? 1.18e-12 : 3e-14, *far[2] = {polygon.corner[1], polygon.corner[2]};
    struct rad_polygon cut = {.n = 4};
    for (int d = 0; d < 2; d++) {
      cut.corner[0][d] = at * far[0][d] + d * 1e-17;
      cut.corner[1][d] = far[0][d];
      cut.corner[2][d] = far[1][d];
      cut.corner[3][d] = 1.1 * at * far[1][d] - d * 2e-17;
    }
    ck_assert_int_eq(rad_strips(&patch, &e, &cut, strip), 1);
    ck_assert_double_eq_tol(strip[0].sigma[0], 0.5, 1e-14);
    ck_assert_double_eq_tol(strip[0].sigma[1], 0.75, 1e-14);
  }
}
END_TEST

int main(void) {
  Suite *s = suite_create("integrals");
  TCase *c = tcase_create("oracle");
  tcase_set_timeout(c, 600);
  tcase_add_loop_test(c, inside_at_every_tolerance, 0, N_PAIR);
  tcase_add_loop_test(c, near_edges_and_vertices, 0, N_PAIR);
  suite_add_tcase(s, c);
  TCase *nodes = tcase_create("nodes");
  tcase_set_timeout(nodes, 600);
  tcase_add_loop_test(nodes, other_nodes, 0, N_PAIR);
  suite_add_tcase(s, nodes);
  TCase *strips = tcase_create("strips");
  tcase_add_test(strips, strip_past_two_poles);
  tcase_add_test(strips, strip_with_a_radial_side);
  tcase_add_test(strips, strips_of_a_cut_tip);
  suite_add_tcase(s, strips);
  return run_suite(s);
}
