/* GMRES where light is lost slowly: narrow cavities, rho near 1; its coarse problem by itself. */
#include <check.h>
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene_text.h"
#include "suite.h"
#include "system/coarse.h"

/* Plain steps of the first cycle, and what the preconditioned ones may take. Plain GMRES(40) needs
 * hundreds here, or does not end. */
enum { PLAIN = 40, MORE = 25 };

/* A closed box seen from inside; one small face of it shines. rho and emission: text of a deck. */
static void add_box(struct deck_text *d, const double size[3], const char *rho, const char *light,
                    const char *dark) {
  static const int face[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                 {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
  deck_add(d, "scene:\n  triangles:\n");
  for (int t = 0; t < 12; t++) {
    deck_add(d, "    - {name: f%d, rho: %s, emission: %s, vertices: [", t / 2, rho,
             t < 2 ? light : dark);
    for (int v = 0; v < 3; v++) {
      int corner = face[t / 2][v ? v + t % 2 : 0];
      deck_add(d, "%s[%.17g, %.17g, %.17g]", v ? ", " : "", corner & 1 ? size[0] : 0,
               corner & 2 ? size[1] : 0, corner & 4 ? size[2] : 0);
    }
    deck_add(d, "]}\n");
  }
}

static void solve_with(const double size[3], const char *rho, const char *matrix,
                       const char *solver, int elements, double quadrature, struct rad_case *c) {
  struct deck_text *d = malloc(sizeof *d);
  struct rad_error e;
  deck_begin(d);
  d->length = 0;
  int bands = rho[0] == '[';
  if (bands)
    deck_add(d, "bands: [red, blue]\n");
  add_box(d, size, rho, bands ? "[1, 1]" : "1", bands ? "[0, 0]" : "0");
  deck_add(d,
           "method: {mesh: paper, elements: %d, degree: 1, quadrature_tolerance: %g, matrix: %s, "
           "solver: %s}\n",
           elements, quadrature, matrix, solver);
  enum rad_code code = deck_solve(d, c, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
  free(d);
}

static void solve(const double size[3], const char *rho, const char *matrix, const char *solver,
                  struct rad_case *c) {
  solve_with(size, rho, matrix, solver, 3, 1e-8, c);
}

static const struct {
  double size[3];
  const char *rho;
} scenes[] = {{{1, 1, 30}, "0.999"},
              {{1, 1, 1000}, "0.9999"},
              {{1, 0.01, 1}, "0.9999"},
              {{1, 1e-4, 1}, "0.9999"},
              {{1, 1, 1}, "0.999999"}};
enum { N_SCENE = sizeof scenes / sizeof *scenes };

static double largest(int n, const double *x) {
  double most = 0;
  for (int i = 0; i < n; i++)
    most = fmax(most, fabs(x[i]));
  return most;
}

/* Steps are bounded for any aspect ratio and rho, with either form of the matrix. The solution is
 * that of LU within |inverse| times what the residuals allow. */
START_TEST(steps_and_solution) {
  struct rad_case lu, gmres;
  solve(scenes[_i].size, scenes[_i].rho, "dense", "lu", &lu);
  for (int h2 = 0; h2 < 2; h2++) {
    solve(scenes[_i].size, scenes[_i].rho, h2 ? "hierarchical" : "dense", "gmres", &gmres);
    ck_assert_msg(gmres.report.iterations <= PLAIN + MORE, "%d steps", gmres.report.iterations);
    double scale = largest(lu.mesh->n_point, lu.u), most = 0;
    for (int p = 0; p < lu.mesh->n_point; p++)
      most = fmax(most, fabs(lu.u[p] - gmres.u[p]));
    double residual = gmres.report.residual + lu.report.residual;
    double matrix = h2 ? 3e-8 * scale : 0; /* the hierarchical one is another matrix */
    ck_assert_msg(gmres.report.residual <= 1.01e-12 * scale, "residual %g of %g",
                  gmres.report.residual, scale);
    ck_assert_msg(most <= 2 * lu.report.inverse_norm * (residual + matrix), "%g: %g apart, of %g",
                  (double)h2, most, scale);
    rad_case_free(&gmres);
  }
  rad_case_free(&lu);
}
END_TEST

static const struct {
  double size[3];
  int steps;
} many[] = {{{1, 1e-4, 1}, PLAIN + 80}, {{1, 1, 1000}, PLAIN + 140}, {{1, 0.01, 1}, PLAIN + 50}};

/* Four times as many unknowns. With E = 1 on all faces of a closed scene, w = 1/(1 - rho). */
START_TEST(many_unknowns) {
  const double rho = 0.9999;
  struct rad_case c;
  solve_with(many[_i].size, "0.9999", "hierarchical", "gmres", 6, 1e-6, &c);
  double scale = largest(c.mesh->n_point, c.u);
  ck_assert_msg(c.report.iterations <= many[_i].steps, "%d steps", c.report.iterations);
  ck_assert_msg(c.report.residual <= 1.01e-12 * scale, "residual %g of %g", c.report.residual,
                scale);
  ck_assert_double_eq_tol(c.report.inverse_norm * (1 - rho), 1, 0.01);
  rad_case_free(&c);
}
END_TEST

/* A slow band beside a quick one: each as if it were alone, to the last bit; so for any threads. */
START_TEST(bands_and_threads) {
  static const double size[3] = {1, 0.01, 1};
  static const char *const matrix[] = {"dense", "hierarchical"};
  struct rad_case both, one;
  omp_set_num_threads(2);
  solve(size, "[0.5, 0.9999]", matrix[_i], "gmres", &both);
  size_t n = (size_t)both.mesh->n_point;
  ck_assert_int_gt(both.report.iterations, PLAIN);
  for (int b = 0; b < 2; b++) {
    omp_set_num_threads(b ? 3 : 1);
    solve(size, b ? "0.9999" : "0.5", matrix[_i], "gmres", &one);
    ck_assert_int_eq(memcmp(both.u + n * (size_t)b, one.u, n * sizeof(double)), 0);
    rad_case_free(&one);
  }
  rad_case_free(&both);
}
END_TEST

/* Aggregates are ranges of one triangle's unknowns, with weights of sum 1. */
static void look_at_aggregates(const struct rad_tree *tree, const struct rad_aggregates *a,
                               int most) {
  ck_assert_int_le(a->n, most);
  ck_assert_int_eq(a->first[0], 0);
  ck_assert_int_eq(a->first[a->n], tree->mesh->n_point);
  for (int g = 0; g < a->n; g++) {
    double sum = 0;
    int triangle = rad_point_triangle(tree->mesh, tree->unknown[a->first[g]]);
    ck_assert_int_lt(a->first[g], a->first[g + 1]);
    for (int i = a->first[g]; i < a->first[g + 1]; i++) {
      sum += a->weight[i];
      ck_assert_int_eq(a->of[i], g);
      ck_assert_int_eq(rad_point_triangle(tree->mesh, tree->unknown[i]), triangle);
    }
    ck_assert_double_eq_tol(sum, 1, 1e-12);
  }
}

/* Column b of R K P is the mean of K times the indicator of aggregate b. */
static double column_error(const struct rad_operator *k, const struct rad_tree *tree,
                           const struct rad_aggregates *a, int b, const double *c, double *x,
                           double *y) {
  double most = 0;
  for (int i = 0; i < k->n; i++)
    x[tree->unknown[i]] = a->of[i] == b;
  rad_operator_apply(k, 1, (const double *const[]){x}, &y);
  for (int g = 0; g < a->n; g++) {
    double mean = 0;
    for (int i = a->first[g]; i < a->first[g + 1]; i++)
      mean += a->weight[i] * y[tree->unknown[i]];
    most = fmax(most, fabs(mean - c[(size_t)g + (size_t)a->n * (size_t)b]));
  }
  return most;
}

/* C against products, for aggregates larger than leaves down to single unknowns. */
START_TEST(coarse_matrix) {
  static const double size[3] = {1, 0.05, 2};
  static const int numbers[] = {12, 40, 300, 1500, 2592};
  struct rad_case c;
  struct rad_error e;
  solve(size, "0.5", _i ? "hierarchical" : "dense", "gmres", &c);
  struct rad_operator k = _i ? rad_operator_h2(&c.h2) : rad_operator_dense(&c.dense);
  struct rad_tree own = {0};
  ck_assert_int_eq(rad_tree_build(c.mesh, RAD_LEAF, &own, &e), RAD_OK);
  const struct rad_tree *tree = _i ? &c.h2.tree : &own;
  double *x = malloc(sizeof(double) * 2 * (size_t)k.n);
  int before = 0;
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
    struct rad_aggregates a;
    ck_assert_int_eq(rad_aggregates_build(tree, numbers[i], &a, &e), RAD_OK);
    look_at_aggregates(tree, &a, numbers[i]);
    ck_assert_int_gt(a.n, numbers[i] - 16); /* elements of the leaf that is divided next */
    ck_assert_int_gt(a.n, before);
    before = a.n;
    size_t n = (size_t)a.n;
    double *m = calloc(n * n, sizeof(double));
    ck_assert_int_eq(
        _i ? rad_coarse_h2(k.h2, &a, m, &e) : rad_coarse_dense(k.dense, tree, &a, m, &e), RAD_OK);
    for (int b = 0; b < a.n; b += 1 + a.n / 12)
      ck_assert_double_le(column_error(&k, tree, &a, b, m, x, x + k.n), 1e-13);
    free(m);
    rad_aggregates_free(&a);
  }
  free(x);
  rad_tree_free(&own);
  rad_case_free(&c);
}
END_TEST

/* As many aggregates as unknowns: A P A_c^(-1) R = I. */
START_TEST(exact_inverse) {
  struct rad_case c;
  struct rad_error e;
  struct deck_text *d = malloc(sizeof *d);
  static const double size[3] = {1, 1, 1};
  deck_begin(d);
  d->length = 0;
  add_box(d, size, "0.99", "1", "0");
  deck_add(d, "method: {mesh: uniform, elements: 4, degree: 0, solver: gmres}\n");
  ck_assert_int_eq(deck_solve(d, &c, &e), RAD_OK);
  struct rad_operator k = rad_operator_dense(&c.dense);
  struct rad_coarse coarse;
  ck_assert_int_eq(rad_coarse_build(&k, 1, (const double *const[]){c.rho}, &coarse, &e), RAD_OK);
  ck_assert_int_eq(coarse.aggregates.n, k.n);
  double *v = malloc(sizeof(double) * 5 * (size_t)k.n), *z = v + k.n, *y = z + k.n, *work = y + k.n;
  for (int i = 0; i < k.n; i++)
    v[i] = sin(1 + i);
  rad_coarse_solve(&coarse, c.rho, v, work);
  rad_coarse_spread(&coarse, work, z);
  rad_operator_apply(&k, 1, (const double *const[]){z}, &y);
  for (int i = 0; i < k.n; i++)
    ck_assert_double_eq_tol(z[i] - c.rho[i] * y[i], v[i], 1e-11);
  free(v);
  rad_coarse_free(&coarse);
  rad_coarse_free(&coarse);
  rad_case_free(&c);
  free(d);
}
END_TEST

int main(void) {
  Suite *s = suite_create("narrow");
  TCase *c = tcase_create("narrow");
  tcase_set_timeout(c, 300);
  tcase_add_loop_test(c, steps_and_solution, 0, N_SCENE);
  tcase_add_loop_test(c, many_unknowns, 0, sizeof many / sizeof *many);
  tcase_add_loop_test(c, bands_and_threads, 0, 2);
  tcase_add_loop_test(c, coarse_matrix, 0, 2);
  tcase_add_test(c, exact_inverse);
  suite_add_tcase(s, c);
  return run_suite(s);
}
