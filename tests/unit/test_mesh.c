/* Meshes: unknown counts of the paper, coverage, trial functions, grading per edge and
 * sub-triangle. */
#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/grade.h"
#include "mesh/mesh.h"
#include "suite.h"
#include "surface_s1.h"

static int unknowns(const struct rad_scene *scene, struct rad_deck_method m) {
  struct rad_mesh mesh;
  struct rad_error e;
  enum rad_code code = rad_mesh_build(scene, &m, &mesh, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
  int n = mesh.n_point;
  double elements;
  ck_assert_double_eq(rad_mesh_count(scene, &m, &elements), n);
  ck_assert_double_eq(elements, mesh.n_element);
  rad_mesh_free(&mesh);
  return n;
}

START_TEST(paper_counts) {
  struct rad_triangle tri[3];
  struct rad_scene s;
  make_s1(tri, &s);
  static const int p1[] = {72, 288, 1152, 4608, 18432, 73728}, p2[] = {72, 576, 3168, 16272, 77760};
  for (int i = 0; i < 6; i++)
    ck_assert_int_eq(
        unknowns(&s, (struct rad_deck_method){.elements = 1 << i, .grading = 1, .degree = 1}),
        p1[i]);
  for (int i = 0; i < 5; i++)
    ck_assert_int_eq(
        unknowns(&s, (struct rad_deck_method){.elements = 1 << i, .grading = 2, .degree = 1}),
        p2[i]);
}
END_TEST

START_TEST(other_counts) {
  struct rad_triangle tri[3];
  struct rad_scene s;
  make_s1(tri, &s);
  struct rad_deck_method graded = {
      .mesh = RAD_MESH_GRADED, .elements = 2, .grading = 3, .degree = 5};
  ck_assert_int_eq(unknowns(&s, graded), 2592);
  struct rad_deck_method uniform = {.mesh = RAD_MESH_UNIFORM, .elements = 4, .degree = 0};
  ck_assert_int_eq(unknowns(&s, uniform), 48);
  uniform.degree = 1;
  ck_assert_int_eq(unknowns(&s, uniform), 144);
  /* i* = 1, p = 2, N = 2: layers i < 1^(1/3) 2^(2/3) = 1.59, so both carry constants */
  struct rad_deck_method modified = {
      .elements = 2, .grading = 2, .degree = 1, .constant_layers = 1};
  ck_assert_int_eq(unknowns(&s, modified), 18 * 8);
  modified.elements = 4; /* 4^(2/3) = 2.52: layers 0, 1, 2 of 4 */
  ck_assert_int_eq(unknowns(&s, modified), 18 * ((int)rad_grade_count(4, 2) - 1 + 4));
}
END_TEST

START_TEST(own_grading_and_elements) {
  struct rad_triangle tri[3];
  struct rad_scene s;
  make_s1(tri, &s);
  struct rad_deck_method m = {.elements = 4, .grading = 1, .degree = 0};
  tri[0].n_grading = 3; /* edge v0v1 with p = 2: two sub-triangles */
  tri[0].grading[0] = 2;
  tri[0].grading[1] = tri[0].grading[2] = 1;
  ck_assert_int_eq(unknowns(&s, m), (int)(16 * rad_grade_count(4, 1) + 2 * rad_grade_count(4, 2)));
  tri[0].n_grading = 6;
  for (int i = 0; i < 6; i++)
    tri[0].grading[i] = i == 5 ? 2 : 1;
  ck_assert_int_eq(unknowns(&s, m), (int)(17 * rad_grade_count(4, 1) + rad_grade_count(4, 2)));
  tri[1].n_elements = 1;
  tri[1].elements[0] = 1;
  ck_assert_int_eq(unknowns(&s, m), (int)(11 * rad_grade_count(4, 1) + rad_grade_count(4, 2) + 6));
}
END_TEST

/* The rectangles of P(N,p) cover the unit square once: total area, and one owner of random points.
 */
START_TEST(partition_covers) {
  struct rad_rectangle q[4096];
  static const double p[] = {1, 1.5, 2, 3, 6};
  srand(1);
  for (int i = 0; i < 5; i++)
    for (int n = 1; n <= 5; n++) {
      int count = (int)rad_grade_count(n, p[i]);
      ck_assert_int_le(count, 4096 * 8);
      if (count > 4096)
        continue;
      rad_grade_fill(n, p[i], q);
      double area = 0;
      for (int k = 0; k < count; k++)
        area += (q[k].phi[1] - q[k].phi[0]) * (q[k].r[1] - q[k].r[0]);
      ck_assert_double_eq_tol(area, 1, 1e-13);
      for (int trial = 0; trial < 100; trial++) {
        double x = rand() / (RAND_MAX + 1.0), y = rand() / (RAND_MAX + 1.0);
        int owners = 0;
        for (int k = 0; k < count; k++)
          owners += x >= q[k].phi[0] && x < q[k].phi[1] && y >= q[k].r[0] && y < q[k].r[1];
        ck_assert_int_eq(owners, 1);
      }
    }
}
END_TEST

static const struct rad_deck_method kinds[] = {
    {.elements = 3, .grading = 2, .degree = 1},
    {.elements = 2, .grading = 1, .degree = 3, .angle = RAD_ANGLE_DUFFY},
    {.mesh = RAD_MESH_GRADED, .elements = 2, .grading = 3, .degree = 11},
    {.mesh = RAD_MESH_UNIFORM, .elements = 3, .degree = 1},
    {.mesh = RAD_MESH_UNIFORM, .elements = 3, .degree = 0},
    {.mesh = RAD_MESH_GEOMETRIC,
     .elements = 3,
     .ratio = 0.15,
     .degree = 4,
     .nodes = {.kind = RAD_NODES_EQUIDISTANT}},
    {.mesh = RAD_MESH_GRADED,
     .elements = 2,
     .grading = 3,
     .degree = 2,
     .nodes = {.kind = RAD_NODES_LIST, .n = 3, .at = {0.2, 0.3, 0.9}}}};
enum { N_KIND = sizeof kinds / sizeof *kinds };

/* Trial functions are 1 at their own point and 0 at the element's others; every point of an element
 * lies in it, and positions agree with the triangle's plane. */
START_TEST(functions_interpolate) {
  struct rad_triangle tri[3];
  struct rad_scene s;
  struct rad_mesh mesh;
  struct rad_error e;
  make_s1(tri, &s);
  ck_assert_int_eq(rad_mesh_build(&s, &kinds[_i], &mesh, &e), RAD_OK);
  for (int i = 0; i < mesh.n_element; i++) {
    const struct rad_element *el = &mesh.element[i];
    for (int b = 0; b < el->n_function; b++) {
      double phi, r, value[256];
      int p = el->first + b;
      int found = rad_patch_locate(&mesh.patch[el->patch], 1, mesh.point_base[p], mesh.point_mu[p],
                                   &phi, &r);
      ck_assert_int_eq(found, 0);
      ck_assert_int_eq(rad_mesh_locate(&mesh, el->patch, phi, r), i);
      rad_element_basis(&mesh, i, phi, r, value);
      for (int f = 0; f < el->n_function; f++)
        ck_assert_double_eq_tol(value[f], f == b, 1e-11);
    }
  }
  rad_mesh_free(&mesh);
}
END_TEST

/* u_h of a function that the space holds exactly is that function: linear in the plane for the
 * uniform mesh, a constant for all. */
START_TEST(evaluates) {
  struct rad_triangle tri[3];
  struct rad_scene s;
  struct rad_mesh mesh;
  struct rad_error e;
  make_s1(tri, &s);
  ck_assert_int_eq(rad_mesh_build(&s, &kinds[_i], &mesh, &e), RAD_OK);
  int linear = kinds[_i].mesh == RAD_MESH_UNIFORM && kinds[_i].degree == 1;
  double *u = malloc(sizeof *u * (size_t)mesh.n_point), x[3];
  for (int p = 0; p < mesh.n_point; p++) {
    rad_point_position(&mesh, p, x);
    u[p] = linear ? 2 + x[0] - 3 * x[1] + 5 * x[2] : 7;
  }
  for (int patch = 0; patch < mesh.n_patch; patch++)
    for (int k = 0; k < 9; k++) {
      double phi = 0.1 + 0.4 * (k % 3), r = 0.05 + 0.45 * (k / 3), mu[2];
      rad_patch_mu(&mesh.patch[patch], phi, r, mu);
      rad_triangle_point(&tri[mesh.patch[patch].triangle], mesh.patch[patch].base, mu, x);
      double exact = linear ? 2 + x[0] - 3 * x[1] + 5 * x[2] : 7;
      ck_assert_double_eq_tol(rad_mesh_evaluate(&mesh, u, patch, phi, r), exact, 1e-12);
    }
  free(u);
  rad_mesh_free(&mesh);
}
END_TEST

/* (phi, r) of the points of an element whose patch has the corner 0 and t = phi. */
static void local_of(const struct rad_mesh *mesh, int point, double *phi, double *r) {
  const double *mu = mesh->point_mu[point], x = 2 * mu[0], y = 3 * mu[1]; /* r (1 - t/3), r t */
  *r = x + y / 3;
  *phi = y / *r;
}

/* Points of one element by nodes: sub-triangle v0 -> v1, layer 0, both directions. */
START_TEST(nodes_are_where_they_are_said_to_be) {
  static const struct {
    struct rad_node_choice nodes;
    int degree;
    double at[3];
  } c[] = {{{.kind = RAD_NODES_BIASED}, 1, {0.9, 1}},
           {{.kind = RAD_NODES_EQUIDISTANT}, 2, {1. / 6, 0.5, 5. / 6}},
           {{.kind = RAD_NODES_VERTEX}, 2, {RAD_LIMIT, 0.5, 1}},
           {{.kind = RAD_NODES_LIST, .n = 3, .at = {0.6, 0.8, 1}}, 2, {0.6, 0.8, 1}},
           {{.kind = RAD_NODES_VERTEX}, 0, {0.5}},
           {{.kind = RAD_NODES_GAUSS}, 0, {0.5}}};
  struct rad_triangle tri[3];
  struct rad_scene s;
  make_s1(tri, &s);
  for (int i = 0; i < 6; i++) {
    struct rad_mesh mesh;
    struct rad_error e;
    int k = c[i].degree + 1;
    struct rad_deck_method m = {.mesh = RAD_MESH_GRADED,
                                .elements = 1,
                                .grading = 1,
                                .degree = c[i].degree,
                                .angle = RAD_ANGLE_DUFFY,
                                .nodes = c[i].nodes};
    ck_assert_int_eq(rad_mesh_build(&s, &m, &mesh, &e), RAD_OK);
    for (int b = 0; b < k * k; b++) {
      double phi, r;
      local_of(&mesh, b, &phi, &r);
      ck_assert_double_eq_tol(phi / c[i].at[b % k], 1, 1e-14); /* limits keep their digits */
      ck_assert_double_eq_tol(r / c[i].at[b / k], 1, 1e-14);
    }
    rad_mesh_free(&mesh);
  }
}
END_TEST

/* Layers shrink by the ratio towards phi = 0 and r = 0. */
START_TEST(geometric_layers) {
  static const double border[] = {0, 0.04, 0.2, 1};
  struct rad_triangle tri[3];
  struct rad_scene s;
  struct rad_mesh mesh;
  struct rad_error e;
  make_s1(tri, &s);
  struct rad_deck_method m = {
      .mesh = RAD_MESH_GEOMETRIC, .elements = 3, .ratio = 0.2, .grading = 4, .degree = 1};
  ck_assert_int_eq(rad_mesh_build(&s, &m, &mesh, &e), RAD_OK);
  ck_assert_int_eq(mesh.n_point, 3 * 6 * 9 * 4);
  for (int i = 0; i < 9; i++)
    for (int side = 0; side < 2; side++) {
      ck_assert_double_eq_tol(mesh.element[i].sigma[side], border[i % 3 + side], 1e-15);
      ck_assert_double_eq_tol(mesh.element[i].tau[side], border[i / 3 + side], 1e-15);
      ck_assert(mesh.element[i].p_phi == 1 && mesh.element[i].p_r == 1);
    }
  rad_mesh_free(&mesh);
}
END_TEST

/* A triangle of the uniform mesh as the estimate sees it, with more than its one point: Gauss
 * points, as in any other patch. */
START_TEST(points_of_a_small_triangle) {
  static const double corner[3][2] = {{0, 0}, {0.5, 0}, {0, 0.5}};
  struct rad_triangle tri[3];
  struct rad_scene s;
  struct rad_mesh mesh;
  struct rad_error e;
  struct rad_patch patch;
  make_s1(tri, &s);
  ck_assert_int_eq(rad_mesh_begin(&s, NULL, &mesh, &e), RAD_OK);
  rad_patch_plain(&s, 0, corner, &patch);
  rad_mesh_add_patch(&mesh, &patch);
  rad_mesh_add_element(
      &mesh, (struct rad_element){
                 .sigma = {0, 1}, .tau = {0, 1}, .p_phi = 1, .p_r = 1, .k_phi = 3, .k_r = 3});
  ck_assert_int_eq(rad_mesh_finish(&mesh, &e), RAD_OK);
  for (int b = 0; b < 9; b++) {
    double x = 0.5 * (1 + rad_gauss_node(&mesh.gauss, 3)[b % 3]);
    double y = 0.5 * (1 + rad_gauss_node(&mesh.gauss, 3)[b / 3]);
    ck_assert_double_eq_tol(mesh.point_mu[b][0], 0.5 * y * (1 - x), 1e-15);
    ck_assert_double_eq_tol(mesh.point_mu[b][1], 0.5 * y * x, 1e-15);
  }
  rad_mesh_free(&mesh);
}
END_TEST

START_TEST(uniform_degree_is_refused) {
  struct rad_triangle tri[3];
  struct rad_scene s;
  struct rad_mesh mesh;
  struct rad_error e;
  make_s1(tri, &s);
  struct rad_deck_method m = {.mesh = RAD_MESH_UNIFORM, .elements = 2, .degree = 2};
  ck_assert_int_eq(rad_mesh_build(&s, &m, &mesh, &e), RAD_EINPUT);
  ck_assert_ptr_nonnull(strstr(e.text, "method.degree"));
  rad_mesh_free(&mesh);
  rad_mesh_free(&mesh); /* safe twice */
}
END_TEST

int main(void) {
  Suite *s = suite_create("mesh");
  TCase *c = tcase_create("mesh");
  tcase_set_timeout(c, 60);
  tcase_add_test(c, paper_counts);
  tcase_add_test(c, other_counts);
  tcase_add_test(c, own_grading_and_elements);
  tcase_add_test(c, partition_covers);
  tcase_add_loop_test(c, functions_interpolate, 0, N_KIND);
  tcase_add_loop_test(c, evaluates, 0, N_KIND);
  tcase_add_test(c, nodes_are_where_they_are_said_to_be);
  tcase_add_test(c, geometric_layers);
  tcase_add_test(c, points_of_a_small_triangle);
  tcase_add_test(c, uniform_degree_is_refused);
  suite_add_tcase(s, c);
  return run_suite(s);
}
