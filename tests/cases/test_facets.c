/* Scenes of many facets, one constant each: closed boxes, the general path, bits, steps. */
#include <check.h>
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "app/case.h"
#include "scene_text.h"
#include "suite.h"
#include "system/facets.h"
#include "visibility/facing.h"

static const char *const method =
    "method: {mesh: uniform, elements: 1, degree: 0, solver: %s, quadrature_tolerance: %g}\n";

/* A box [low, low + size] of 12 n^2 facets; turned: seen from outside. */
struct box {
  int n, turned;
  const double *low, *size;
};

/* A corner of square (i, j) of n x n on a face. */
static void put_corner(FILE *f, const struct box *b, int face, int i, int j, const char *end) {
  int axis = face / 2, back = (face + b->turned) % 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
  double x[3];
  x[axis] = b->low[axis] + (face % 2 ? b->size[axis] : 0);
  x[u] = b->low[u] + b->size[u] * (back ? j : i) / b->n;
  x[v] = b->low[v] + b->size[v] * (back ? i : j) / b->n;
  fprintf(f, "[%.17g, %.17g, %.17g]%s", x[0], x[1], x[2], end);
}

/* rho and E differ by face, or are 0.5 and 1. */
static void put_box(FILE *f, const struct box *b, int varied) {
  static const int step[2][3][2] = {{{0, 0}, {1, 0}, {1, 1}}, {{0, 0}, {1, 1}, {0, 1}}};
  int n = b->n;
  for (int k = 0; k < 12 * n * n; k++) {
    int face = k / (2 * n * n), i = k / (2 * n) % n, j = k / 2 % n;
    fprintf(f, "    - {name: f%d, rho: %g, emission: %d, vertices: [", face,
            varied ? 0.2 + 0.1 * face : 0.5, varied ? face % 3 : 1);
    for (int v = 0; v < 3; v++)
      put_corner(f, b, face, i + step[k % 2][v][0], j + step[k % 2][v][1], v < 2 ? ", " : "]}\n");
  }
}

static void solve_boxes(int n_box, const struct box *box, int varied, double tolerance,
                        struct rad_case *c) {
  char path[] = "/tmp/polyrad_facets_XXXXXX";
  int file = mkstemp(path);
  FILE *f = file < 0 ? NULL : fdopen(file, "w");
  ck_assert_ptr_nonnull(f);
  fprintf(f, "scene:\n  triangles:\n");
  for (int b = 0; b < n_box; b++)
    put_box(f, &box[b], varied);
  fprintf(f, method, "gmres", tolerance);
  fclose(f);
  struct rad_error e;
  enum rad_code code = rad_case_prepare(path, 0, NULL, NULL, c, &e);
  unlink(path);
  code = code ? code : rad_case_solve(c, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
  ck_assert(rad_mesh_is_facets(c->mesh));
}

static void solve_box(int n, const double size[3], int varied, double tolerance,
                      struct rad_case *c) {
  static const double origin[3] = {0, 0, 0};
  solve_boxes(1, &(struct box){n, 0, origin, size}, varied, tolerance, c);
}

static const double cube[3] = {1, 1, 1}, slab[3] = {1e-3, 2, 0.7}, dust[3] = {1e-9, 1e-9, 3e-9};

/* In a closed box every row sums to 1, whatever its size, and entries are none below zero. */
START_TEST(row_sums) {
  const double *size[] = {cube, slab, dust};
  struct rad_case c;
  solve_box(5, size[_i], 1, 1e-10, &c);
  int n = c.dense.n;
  for (int i = 0; i < n; i++) {
    double sum = 0;
    for (int j = 0; j < n; j++) {
      ck_assert_double_ge(c.dense.k[i + (size_t)n * j], 0);
      sum += c.dense.k[i + (size_t)n * j];
    }
    ck_assert_double_eq_tol(sum, 1, 1e-12);
  }
  rad_case_free(&c);
}
END_TEST

/* A closed box with a box in it: a row sums to 1 if every shadow is right, to rounding. */
START_TEST(box_in_a_box) {
  static const double origin[3] = {0, 0, 0}, low[3] = {0.3, 0.21, 0.35}, size[3] = {0.4, 0.5, 0.3};
  const struct box box[2] = {{8, 0, origin, cube}, {6, 1, low, size}};
  struct rad_case c;
  solve_boxes(2, box, 1, 1e-10, &c);
  int n = c.dense.n;
  ck_assert_int_eq(n, 1200);
  ck_assert_int_gt((int)c.visibility.n_partly, 10000);
  for (int i = 0; i < n; i++) {
    double sum = 0;
    for (int j = 0; j < n; j++)
      sum += c.dense.k[i + (size_t)n * j];
    ck_assert_msg(fabs(sum - 1) <= 1e-11, "row %d: 1 + %g", i, sum - 1);
  }
  rad_case_free(&c);
}
END_TEST

/* Every entry against rad_patch_block at 1e-12: to the tolerance of itself. */
static double worst_entry(const struct rad_case *c) {
  struct rad_rules fine;
  struct rad_scratch scratch;
  struct rad_error e;
  double worst = 0;
  int n = c->dense.n;
  ck_assert_int_eq(rad_rules_build(c->mesh, 1e-12, &fine, &e), RAD_OK);
  ck_assert_int_eq(rad_scratch_init(c->mesh, &scratch, &e), RAD_OK);
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      struct rad_targets target = {i, 1, c->mesh->point_base + i,
                                   (const double(*)[2])c->mesh->point_mu + i, NULL};
      double exact = 0, value = c->dense.k[i + (size_t)n * j];
      if (c->dense.sees[(size_t)n * i + j])
        rad_patch_block(c->mesh, &fine, &target, j, NULL, &exact, 0, &scratch);
      if (exact == 0)
        ck_assert_double_eq(value, 0);
      else
        worst = fmax(worst, fabs(value / exact - 1));
    }
  rad_scratch_free(&scratch);
  rad_rules_free(&fine);
  return worst;
}

START_TEST(agrees_with_the_general_path) {
  const double *size[] = {cube, slab, dust};
  static const double tolerance[] = {1e-6, 1e-10, 1e-12};
  struct rad_case c;
  solve_box(3, size[_i], 1, tolerance[_i], &c);
  double worst = worst_entry(&c);
  ck_assert_msg(worst < tolerance[_i] + 1e-12, "%g", worst);
  ck_assert_int_eq(c.dense.counters.near + c.dense.counters.far + c.dense.pairs_skipped,
                   (int64_t)c.dense.n * c.dense.n);
  rad_case_free(&c);
}
END_TEST

/* The plane of each triangle cuts the other. */
START_TEST(across_horizons) {
  struct rad_case c;
  struct rad_error e;
  for (int k = 0; k < 16; k++) {
    struct deck_text *d = malloc(sizeof *d);
    double a = 0.02 * k, b = 0.05 * k;
    deck_begin(d);
    deck_add(d,
             "    - {name: a, rho: 0.5, emission: 1, vertices: [[0,0,0], [1,0,0], [0,1,0]]}\n"
             "    - {name: b, rho: 0.5, emission: 0, vertices: "
             "[[%g,-0.5,-0.5], [0.4,-1.5,%g], [%g,-0.6,0.9]]}\n",
             0.3 + a, 0.1 + b, 0.5 - a);
    deck_add(d, method, "lu", 1e-10);
    ck_assert_msg(deck_solve(d, &c, &e) == RAD_OK, "%s", e.text);
    const struct rad_triangle *t = c.scene.triangle;
    ck_assert(rad_mesh_is_facets(c.mesh));
    ck_assert_int_eq(rad_side_of(&t[0], &t[1]), RAD_ACROSS);
    ck_assert_int_eq(rad_side_of(&t[1], &t[0]), RAD_ACROSS);
    ck_assert_int_eq(c.dense.counters.far, 2);
    double worst = worst_entry(&c);
    ck_assert_msg(worst < 2e-10, "%d: %g", k, worst);
    rad_case_free(&c);
    free(d);
  }
}
END_TEST

START_TEST(same_bits_for_any_threads) {
  static const int threads[] = {1, 2, 7};
  struct rad_case first, other;
  omp_set_num_threads(threads[0]);
  solve_box(7, cube, 1, 1e-10, &first);
  size_t n = (size_t)first.dense.n;
  for (int t = 1; t < 3; t++) {
    omp_set_num_threads(threads[t]);
    solve_box(7, cube, 1, 1e-10, &other);
    ck_assert_int_eq(memcmp(first.dense.k, other.dense.k, n * n * sizeof(double)), 0);
    ck_assert_int_eq(memcmp(first.u, other.u, n * sizeof(double)), 0);
    rad_case_free(&other);
  }
  rad_case_free(&first);
}
END_TEST

/* K 1 = 1, so one step finds u = E / (1 - rho). The basis must be orthogonal to the last digits for
 * that: with dot products added one by one it took 15 steps. */
START_TEST(constant_solution_in_one_step) {
  struct rad_case c;
  solve_box(13, cube, 0, 1e-10, &c);
  for (int i = 0; i < c.dense.n; i++)
    ck_assert_double_eq_tol(c.u[i], 2, 1e-11);
  ck_assert_int_le(c.report.iterations, 2);
  rad_case_free(&c);
}
END_TEST

int main(void) {
  Suite *suite = suite_create("facets");
  TCase *tc = tcase_create("boxes");
  tcase_set_timeout(tc, 120);
  tcase_add_test(tc, box_in_a_box);
  tcase_add_loop_test(tc, row_sums, 0, 3);
  tcase_add_loop_test(tc, agrees_with_the_general_path, 0, 3);
  tcase_add_test(tc, across_horizons);
  tcase_add_test(tc, same_bits_for_any_threads);
  tcase_add_test(tc, constant_solution_in_one_step);
  suite_add_tcase(suite, tc);
  return run_suite(suite);
}
