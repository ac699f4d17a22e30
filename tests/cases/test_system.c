/* The matrix: bits for any number of threads, row sums, products, the solvers against each other.
 */
#include <check.h>
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "scene_text.h"
#include "suite.h"

static const double rho[6] = {0.1, 0.9, 0.3, 0.5, 0.7, 0.2}, emission[6] = {0, 1, 0.2, 0, 3, 0.5};

static const char *const methods[] = {
    "{mesh: paper, elements: 3, grading: 2, degree: 1, quadrature_tolerance: 1e-9, solver: %s}",
    "{mesh: graded, elements: 1, grading: 3, degree: 5, quadrature_tolerance: 1e-9, solver: %s}",
    "{mesh: uniform, elements: 4, degree: 1, quadrature_tolerance: 1e-9, solver: %s}"};
enum { N_METHOD = sizeof methods / sizeof *methods };

static void solve(int method, const char *solver, struct rad_case *c) {
  struct deck_text *d = malloc(sizeof *d);
  struct rad_error e;
  deck_begin(d);
  deck_cube(d, rho, emission);
  deck_add(d, "method: ");
  char line[256];
  snprintf(line, sizeof line, methods[method], solver);
  deck_add(d, "%s\n", line);
  enum rad_code code = deck_solve(d, c, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
  free(d);
}

START_TEST(same_bits_for_any_threads) {
  struct rad_case first, other;
  static const int threads[] = {1, 2, 7};
  omp_set_num_threads(threads[0]);
  solve(_i, "gmres", &first);
  size_t n = (size_t)first.dense.n;
  for (int t = 1; t < 3; t++) {
    omp_set_num_threads(threads[t]);
    solve(_i, "gmres", &other);
    ck_assert_int_eq(memcmp(first.dense.k, other.dense.k, n * n * sizeof(double)), 0);
    ck_assert_int_eq(memcmp(first.u, other.u, n * sizeof(double)), 0);
    ck_assert_int_eq(first.dense.counters.kernel_values, other.dense.counters.kernel_values);
    rad_case_free(&other);
  }
  rad_case_free(&first);
}
END_TEST

/* Lambert's closed form of the whole triangle at a collocation point (theory 3.9). */
static double lambert(const struct rad_triangle *t, const double x[3], const double n[3]) {
  double sum = 0;
  for (int i = 0; i < 3; i++) {
    double r[3], next[3], side[3], g[3];
    rad_sub(t->v[i], x, r);
    rad_sub(t->v[(i + 1) % 3], x, next);
    rad_sub(t->v[(i + 1) % 3], t->v[i], side);
    rad_cross(r, side, g);
    double length = rad_norm(g);
    if (length > 0)
      sum += atan2(length, rad_dot(r, next)) * rad_dot(n, g) / length;
  }
  return fabs(sum) / (2 * M_PI);
}

/* Row sums per source triangle, to the quadrature tolerance (1e-9, and the few digits that Lambert
 * loses near edges). */
START_TEST(row_sums) {
  struct rad_case c;
  solve(_i, "gmres", &c);
  const struct rad_mesh *m = c.mesh;
  double worst = 0;
  for (int p = 0; p < m->n_point; p++) {
    const struct rad_triangle *target = &c.scene.triangle[rad_point_triangle(m, p)];
    double x[3];
    rad_point_position(m, p, x);
    for (int j = 0; j < c.scene.n_triangle; j++) {
      const struct rad_triangle *source = &c.scene.triangle[j];
      double sum = 0, towards[3];
      rad_sub(x, source->v[0], towards);
      for (int q = m->point_first[j]; q < m->point_first[j + 1]; q++)
        sum += c.dense.k[p + (size_t)c.dense.n * q];
      double exact =
          rad_dot(towards, source->normal) > 1e-12 ? lambert(source, x, target->normal) : 0;
      worst = fmax(worst, fabs(sum - exact));
    }
  }
  ck_assert_msg(worst < 2e-9, "worst row sum error %g", worst);
  rad_case_free(&c);
}
END_TEST

START_TEST(solvers_agree) {
  struct rad_case lu, gmres;
  solve(_i, "lu", &lu);
  solve(_i, "gmres", &gmres);
  double worst = 0;
  for (int p = 0; p < lu.mesh->n_point; p++)
    worst = fmax(worst, fabs(lu.u[p] - gmres.u[p]));
  ck_assert_msg(worst < 1e-10, "LU and GMRES differ by %g", worst);
  ck_assert_double_lt(lu.report.residual, 1e-12);
  ck_assert_double_lt(gmres.report.residual, 1e-11);
  ck_assert_double_eq_tol(lu.report.inverse_norm, gmres.report.inverse_norm, 1e-9);
  ck_assert_double_gt(lu.report.condition_estimate, 1);
  ck_assert_double_le(lu.report.inverse_norm, 1 / (1 - lu.report.kappa) + 1e-9);
  rad_case_free(&lu);
  rad_case_free(&gmres);
}
END_TEST

/* A corner of three faces in the positive octant, or its mirror image turned away from it. */
static void add_corner(struct deck_text *d, int mirrored, double bright) {
  static const int axis[3][2] = {{0, 1}, {1, 2}, {2, 0}};
  for (int f = 0; f < 3; f++) {
    double corner[3][3] = {{0}};
    char name[16];
    snprintf(name, sizeof name, "%c%d", mirrored ? 'b' : 'a', f);
    for (int v = 0; v < 2; v++)
      corner[1 + v][axis[f][mirrored ? 1 - v : v]] = mirrored ? -1 : 1;
    for (int i = 0; i < 9 && mirrored; i++)
      corner[i / 3][i % 3] -= 1;
    deck_polygon(d, name, 3, (const double(*)[3])corner, rho[f + 1], bright * emission[f + 1]);
  }
}

/* Two corners that do not see each other: each part is solved as if it were alone. */
START_TEST(independent_parts) {
  static const char method[] =
      "method: {mesh: graded, elements: 1, grading: 3, degree: 2, solver: ";
  struct rad_case c[3];
  struct rad_error e;
  for (int i = 0; i < 3; i++) { /* the left one, the right one, both */
    struct deck_text *d = malloc(sizeof *d);
    deck_begin(d);
    if (i != 1)
      add_corner(d, 0, 1);
    if (i != 0)
      add_corner(d, 1, 7);
    deck_add(d, "%s%s}\n", method, _i ? "gmres" : "lu");
    ck_assert_int_eq(deck_solve(d, &c[i], &e), RAD_OK);
    ck_assert_int_eq(c[i].report.n_part, i == 2 ? 2 : 1);
    free(d);
  }
  int n = c[0].mesh->n_point;
  ck_assert_int_eq(c[2].mesh->n_point, 2 * n);
  for (int p = 0; p < 2 * n; p++) {
    double alone = p < n ? c[0].u[p] : c[1].u[p - n];
    ck_assert_msg(fabs(c[2].u[p] - alone) <= 1e-11 * (_i ? 50 : 1), "point %d: %.17g and %.17g", p,
                  c[2].u[p], alone);
  }
  for (int i = 0; i < 3; i++)
    rad_case_free(&c[i]);
}
END_TEST

/* Two bands at once are the two bands one by one. */
START_TEST(bands) {
  static const char *const text =
      "bands: [red, blue]\nscene:\n  triangles:\n"
      "    - {name: a, rho: [0.5, 0.1], emission: [1, 2], vertices: [[0,0,0],[1,0,0],[0,1,0]]}\n"
      "    - {name: b, rho: [0.2, 0.9], emission: [0, 1], vertices: [[0,0,0],[0,1,0],[0,0,1]]}\n"
      "method: {elements: 2, solver: %s}\n";
  static const char *const single =
      "scene:\n  triangles:\n"
      "    - {name: a, rho: %g, emission: %g, vertices: [[0,0,0],[1,0,0],[0,1,0]]}\n"
      "    - {name: b, rho: %g, emission: %g, vertices: [[0,0,0],[0,1,0],[0,0,1]]}\n"
      "method: {elements: 2, solver: %s}\n";
  static const double value[2][4] = {{0.5, 1, 0.2, 0}, {0.1, 2, 0.9, 1}};
  const char *solver = _i ? "lu" : "gmres";
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case both, one;
  struct rad_error e;
  d->length = 0;
  deck_add(d, text, solver);
  enum rad_code code = deck_solve(d, &both, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
  for (int b = 0; b < 2; b++) {
    d->length = 0;
    deck_add(d, single, value[b][0], value[b][1], value[b][2], value[b][3], solver);
    code = deck_solve(d, &one, &e);
    ck_assert_msg(code == RAD_OK, "%s", e.text);
    for (int p = 0; p < one.mesh->n_point; p++)
      ck_assert_double_eq_tol(both.u[b * one.mesh->n_point + p], one.u[p], 1e-12);
    rad_case_free(&one);
  }
  rad_case_free(&both);
  free(d);
}
END_TEST

/* A point cannot see more than its hemisphere: a wrong entry is told, with its triangle. */
START_TEST(more_than_a_hemisphere) {
  struct rad_case c;
  struct rad_error e;
  struct rad_solve_report report;
  solve(0, "lu", &c);
  size_t n = (size_t)c.dense.n, row = n - 3;
  double *u = calloc(4 * n, sizeof(double)), *h = u + n, *r = h + n, *light = r + n;
  for (size_t i = 0; i < n; i++)
    r[i] = 0.5;
  light[0] = 1;
  struct rad_operator k = rad_operator_dense(&c.dense);
  struct rad_solve_options options = {.solver = RAD_SOLVER_LU, .quadrature = 1e-9};
  ck_assert_int_eq(rad_solve(&k, &options, 1, r, light, u, h, &report, &e), RAD_OK);
  c.dense.k[row + n * 5] += 2e-6;
  ck_assert_int_eq(rad_solve(&k, &options, 1, r, light, u, h, &report, &e), RAD_ENUMERIC);
  ck_assert_msg(strstr(e.text, "hemisphere") && strstr(e.text, "triangle 12 "), "%s", e.text);
  free(u);
  rad_case_free(&c);
}
END_TEST

int main(void) {
  Suite *s = suite_create("system");
  TCase *c = tcase_create("system");
  tcase_set_timeout(c, 300);
  tcase_add_loop_test(c, same_bits_for_any_threads, 0, N_METHOD);
  tcase_add_loop_test(c, row_sums, 0, N_METHOD);
  tcase_add_loop_test(c, solvers_agree, 0, N_METHOD);
  tcase_add_loop_test(c, bands, 0, 2);
  tcase_add_loop_test(c, independent_parts, 0, 2);
  tcase_add_test(c, more_than_a_hemisphere);
  suite_add_tcase(s, c);
  return run_suite(s);
}
