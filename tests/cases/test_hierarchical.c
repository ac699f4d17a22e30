/* The hierarchical matrix against the dense one: products, solutions, bits, its own estimate. */
#include <check.h>
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene_text.h"
#include "suite.h"

static const double rho[6] = {0.1, 0.9, 0.3, 0.5, 0.7, 0.2}, emission[6] = {0, 1, 0.2, 0, 3, 0.5};

/* --- scenes --- */

static void square(struct deck_text *d, const char *name, const double corner[4][3], double e) {
  deck_polygon(d, name, 4, corner, 0.6, e);
}

static void corner_scene(struct deck_text *d) { /* the paper's S1 */
  static const double face[3][3][3] = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                                       {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                       {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}}};
  for (int f = 0; f < 3; f++)
    deck_polygon(d, "face", 3, face[f], 0.5, 0.3 + f);
}

static void wedge_scene(struct deck_text *d) { /* sharp angles, rho = 1 on one face: like S2 */
  static const double face[3][3][3] = {{{0, 0, 0}, {1, 0, 0}, {0.5, 0.5, 0}},
                                       {{0, 0, 0}, {0.5, 0.5, 0}, {0.5, 0, 0.5}},
                                       {{0, 0, 0}, {0.5, 0, 0.5}, {1, 0, 0}}};
  for (int f = 0; f < 3; f++)
    deck_polygon(d, "face", 3, face[f], f ? 0.25 * f : 1, 1 + f);
}

static void cube_scene(struct deck_text *d) {
  deck_cube(d, rho, emission);
}

/* A plate that stands on edge over a floor: its plane cuts the floor, and the roof's cuts both. */
static void horizon_scene(struct deck_text *d) {
  static const double floor[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  static const double plate[4][3] = {
      {0.45, 0.1, 0.3}, {0.45, 0.9, 0.3}, {0.45, 0.9, 0.9}, {0.45, 0.1, 0.9}};
  square(d, "floor", floor, 0.2);
  square(d, "plate", plate, 1);
}

/* Two plates with a smaller one between them that casts shadows both ways. */
static void shadow_scene(struct deck_text *d) {
  static const double low[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  static const double high[4][3] = {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}};
  static const double between[4][3] = {
      {0.3, 0.3, 0.5}, {0.8, 0.3, 0.5}, {0.8, 0.8, 0.5}, {0.3, 0.8, 0.5}};
  square(d, "low", low, 0);
  square(d, "high", high, 1);
  square(d, "between", between, 0.5);
}

/* A box on the floor of a room. */
static void box_scene(struct deck_text *d) {
  static const double low[3] = {0.3, 0.35, 0}, high[3] = {0.6, 0.7, 0.4};
  static const int face[5][4] = {
      {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  deck_cube(d, rho, emission);
  for (int f = 0; f < 5; f++) {
    double corner[4][3];
    for (int c = 0; c < 4; c++)
      for (int k = 0; k < 3; k++)
        corner[c][k] = face[f][c] >> k & 1 ? high[k] : low[k];
    square(d, "box", (const double(*)[3])corner, 0);
  }
}

/* S1 with a plate before its vertex, which shades some of the fans there. */
static void plate_scene(struct deck_text *d) {
  static const double plate[3][3] = {{0.03, 0.02, 0.02}, {0.02, 0.05, 0.04}, {0.3, 0.2, 0.4}};
  corner_scene(d);
  deck_polygon(d, "plate", 3, plate, 0.3, 0);
}

struct problem {
  const char *name;
  void (*scene)(struct deck_text *);
  const char *mesh;
  double tolerance;
};

static const struct problem problems[] = {
    {"S1, P(6,1), degree 1", corner_scene, "mesh: paper, elements: 6, degree: 1", 1e-6},
    {"S1, P(12,1), degree 0", corner_scene, "mesh: paper, elements: 12, degree: 0", 1e-4},
    {"S1, P(4,2), degree 1", corner_scene, "mesh: paper, elements: 4, grading: 2, degree: 1", 1e-8},
    {"S1, graded, degree 5", corner_scene, "mesh: graded, elements: 2, grading: 3, degree: 5",
     1e-7},
    {"S1, degree 2", corner_scene, "mesh: paper, elements: 4, degree: 2", 1e-10},
    {"S2, degree 3", wedge_scene, "mesh: paper, elements: 3, degree: 3", 1e-6},
    {"S2, degree 4", wedge_scene, "mesh: graded, elements: 3, grading: 2, degree: 4", 1e-5},
    {"S2, uniform, degree 1", wedge_scene, "mesh: uniform, elements: 16, degree: 1", 1e-6},
    {"cube, degree 1", cube_scene, "mesh: paper, elements: 3, degree: 1", 1e-6},
    {"cube, uniform, degree 0", cube_scene, "mesh: uniform, elements: 16, degree: 0", 1e-4},
    {"horizon", horizon_scene, "mesh: paper, elements: 6, degree: 1", 1e-6},
    {"shadow", shadow_scene, "mesh: uniform, elements: 12, degree: 1", 1e-5},
    {"box in a room", box_scene, "mesh: uniform, elements: 14, degree: 0", 1e-4},
    {"S1, P(6,2), degree 1", corner_scene, "mesh: paper, elements: 6, grading: 2", 1e-7},
    {"S2, P(9,2), degree 0", wedge_scene, "mesh: paper, elements: 9, grading: 2, degree: 0", 1e-5},
    {"S2, P(4,2), degree 2", wedge_scene, "mesh: paper, elements: 4, grading: 2, degree: 2", 1e-8},
    {"S1 with a plate, P(5,2)", plate_scene, "mesh: paper, elements: 5, grading: 2, angle: duffy",
     1e-6},
};
enum { FANS = 13 }; /* from this one on there are sector blocks */
enum { N_PROBLEM = sizeof problems / sizeof *problems };

/* Scene, mesh and rules; quadrature is ten times finer than the compression. */
static void prepare(const struct problem *p, struct rad_case *c) {
  struct deck_text *d = malloc(sizeof *d);
  struct rad_error e;
  deck_begin(d);
  p->scene(d);
  deck_add(d, "method: {%s, matrix: dense}\n", p->mesh);
  ck_assert_msg(deck_prepare(d, c, &e) == RAD_OK, "%s", e.text);
  ck_assert_int_eq(rad_rules_build(c->mesh, 0.1 * p->tolerance, &c->rules, &e), RAD_OK);
  free(d);
}

static void compress(struct rad_case *c, double tolerance) {
  struct rad_error e;
  ck_assert_msg(rad_h2_build(c->mesh, &c->rules, tolerance, &c->h2, &e) == RAD_OK, "%s", e.text);
}

static unsigned next_random(unsigned *state) { /* xorshift32 */
  *state ^= *state << 13;
  *state ^= *state >> 17;
  *state ^= *state << 5;
  return *state;
}

static const unsigned seed = 20261124;

/* Vectors with |z| <= 1: constant, two waves, random signs and random numbers. */
enum { N_VECTOR = 5 };
static double *make_vectors(const struct rad_mesh *mesh) {
  int n = mesh->n_point;
  double *z = malloc(sizeof *z * N_VECTOR * (size_t)n);
  unsigned state = seed;
  for (int i = 0; i < n; i++) {
    double x[3];
    rad_point_position(mesh, i, x);
    z[i] = 1;
    z[n + i] = cos(3 * x[0] + 2 * x[1] - 5 * x[2]);
    z[2 * n + i] = sin(1 - 9 * x[0] + 7 * x[1] + 4 * x[2]);
    z[3 * n + i] = next_random(&state) & 64 ? 1 : -1;
    z[4 * n + i] = 2.0 * next_random(&state) / 4294967295.0 - 1;
  }
  return z;
}

static void pointers(double *x, int n, double **list) {
  for (int v = 0; v < N_VECTOR; v++)
    list[v] = x + (size_t)v * (size_t)n;
}

/* K z and K_H z in every row; what the matrix says of its own error is neither a tenth of the
 * largest difference nor more than twice the tolerance; its size is as predicted. */
START_TEST(products) {
  const struct problem *p = &problems[_i];
  struct rad_case c;
  struct rad_error e;
  prepare(p, &c);
  int n = c.mesh->n_point;
  ck_assert_int_eq(rad_dense_assemble(c.mesh, &c.rules, NULL, &c.dense, &e), RAD_OK);
  compress(&c, p->tolerance);
  ck_assert_int_eq(rad_h2_check(&c.h2, &c.rules, &e), RAD_OK);
  double *z = make_vectors(c.mesh), *exact = malloc(sizeof *z * N_VECTOR * (size_t)n);
  double *y = malloc(sizeof *z * N_VECTOR * (size_t)n), worst = 0;
  double *in[N_VECTOR], *out[N_VECTOR];
  pointers(z, n, in);
  pointers(exact, n, out);
  rad_dense_apply(&c.dense, N_VECTOR, (const double *const *)in, out);
  pointers(y, n, out);
  rad_h2_apply(&c.h2, N_VECTOR, (const double *const *)in, out);
  for (int i = 0; i < N_VECTOR * n; i++)
    worst = fmax(worst, fabs(y[i] - exact[i]));
  if (getenv("POLYRAD_TEST_VERBOSE"))
    printf(
        "%-24s n %5d: error %.2g of the tolerance, estimate %.2g; %.3g of dense; far %zu, "
        "sectors %zu\n",
        p->name, n, worst / p->tolerance, c.h2.error / p->tolerance, c.h2.bytes / (8.0 * n * n),
        c.h2.blocks.far.first[c.h2.tree.n_cluster], c.h2.blocks.sector.first[c.h2.tree.n_cluster]);
  ck_assert_int_eq(c.h2.blocks.sector.first[c.h2.tree.n_cluster] > 0, _i >= FANS);
  ck_assert_msg(worst <= 2 * p->tolerance, "%s: error %g, seed %u", p->name, worst, seed);
  ck_assert_msg(c.h2.error <= 2 * p->tolerance, "%s: estimate %g", p->name, c.h2.error);
  ck_assert_msg(worst <= 10 * c.h2.error, "%s: error %g, estimate %g", p->name, worst, c.h2.error);
  struct rad_h2_plan plan;
  ck_assert_int_eq(rad_h2_predict(c.mesh, p->tolerance, &plan, &e), RAD_OK);
  ck_assert_msg(plan.bytes < 1.5 * c.h2.bytes && c.h2.bytes < 1.5 * plan.bytes,
                "%s: predicted %g bytes, has %g", p->name, plan.bytes, c.h2.bytes);
  free(z);
  free(exact);
  free(y);
  rad_case_free(&c);
}
END_TEST

/* y [N_VECTOR] += K z of rows first .. first + n of a triangle, the rows integrated anew. */
static void add_rows(const struct rad_case *c, int triangle, int first, int n, const double *z,
                     double *y, struct rad_scratch *scratch) {
  const struct rad_mesh *mesh = c->mesh;
  struct rad_targets targets = {triangle, n, mesh->point_base + first,
                                (const double(*)[2])mesh->point_mu + first, NULL};
  for (int p = 0; p < mesh->n_patch; p++) {
    int from = mesh->element[mesh->element_first[p]].first;
    int to =
        p + 1 < mesh->n_patch ? mesh->element[mesh->element_first[p + 1]].first : mesh->n_point;
    if (!mesh->scene->visibility
             ->sight[triangle * mesh->scene->n_triangle + mesh->patch[p].triangle])
      continue;
    double *k = malloc(sizeof *k * (size_t)n * (size_t)(to - from));
    rad_patch_block(mesh, &c->rules, &targets, p, NULL, k - (ptrdiff_t)n * from, n, scratch);
    for (int v = 0; v < N_VECTOR; v++)
      for (int j = from; j < to; j++)
        for (int i = 0; i < n; i++)
          y[v * mesh->n_point + first + i] +=
              k[(ptrdiff_t)n * (j - from) + i] * z[v * mesh->n_point + j];
    free(k);
  }
}

/* K z in every row, without a dense matrix. */
static void multiply_rows(const struct rad_case *c, const double *z, double *y) {
  const struct rad_mesh *mesh = c->mesh;
#pragma omp parallel default(none) shared(c, z, y, mesh)
  {
    struct rad_scratch scratch;
    struct rad_error e;
    rad_scratch_init(mesh, &scratch, &e);
    for (int t = 0; t < mesh->scene->n_triangle; t++)
#pragma omp for schedule(dynamic) nowait
      for (int first = mesh->point_first[t]; first < mesh->point_first[t + 1]; first += RAD_BATCH) {
        int rest = mesh->point_first[t + 1] - first;
        add_rows(c, t, first, rest < RAD_BATCH ? rest : RAD_BATCH, z, y, &scratch);
      }
    rad_scratch_free(&scratch);
  }
}

/* The paper's P(8,2): K_H z within the tolerance in all 16 272 rows. */
START_TEST(thin_elements) {
  static const double tolerance[] = {1e-4, 1e-6, 1e-8, 1e-10};
  const struct problem p = {"S1, P(8,2), degree 1", corner_scene,
                            "mesh: paper, elements: 8, grading: 2", tolerance[_i]};
  struct rad_case c;
  prepare(&p, &c);
  compress(&c, p.tolerance);
  int n = c.mesh->n_point;
  ck_assert_int_eq(n, 16272);
  double *z = make_vectors(c.mesh), *exact = calloc(N_VECTOR * (size_t)n, sizeof *z);
  double *y = malloc(sizeof *z * N_VECTOR * (size_t)n), *in[N_VECTOR], *out[N_VECTOR], worst = 0;
  multiply_rows(&c, z, exact);
  pointers(z, n, in);
  pointers(y, n, out);
  rad_h2_apply(&c.h2, N_VECTOR, (const double *const *)in, out);
  for (int i = 0; i < N_VECTOR * n; i++)
    worst = fmax(worst, fabs(y[i] - exact[i]));
  if (getenv("POLYRAD_TEST_VERBOSE"))
    printf("%s: error %.2g of %g, %.1f MB\n", p.name, worst / p.tolerance, p.tolerance,
           c.h2.bytes * 1e-6);
  ck_assert_msg(worst <= p.tolerance, "error %g, tolerance %g, seed %u", worst, p.tolerance, seed);
  free(z);
  free(exact);
  free(y);
  rad_case_free(&c);
}
END_TEST

/* u of both matrices: within three times the tolerance, relative. */
START_TEST(solutions) {
  static const int which[] = {2, 4, 5, 8, 10, 11};
  const struct problem *p = &problems[which[_i]];
  struct rad_case c;
  struct rad_error e;
  prepare(p, &c);
  size_t n = (size_t)c.mesh->n_point;
  double *data = malloc(sizeof *data * 5 * n), *u[2] = {data + 2 * n, data + 3 * n};
  rad_mesh_data(c.mesh, data, data + n);
  ck_assert_int_eq(rad_dense_assemble(c.mesh, &c.rules, NULL, &c.dense, &e), RAD_OK);
  compress(&c, p->tolerance);
  struct rad_operator k[2] = {rad_operator_dense(&c.dense), rad_operator_h2(&c.h2)};
  struct rad_solve_options o = {.tolerance = 1e-13, .quadrature = c.rules.tolerance};
  struct rad_solve_report report;
  for (int m = 0; m < 2; m++)
    ck_assert_msg(rad_solve(&k[m], &o, 1, data, data + n, u[m], data + 4 * n, &report, &e) ==
                      RAD_OK,
                  "%s", e.text);
  ck_assert_int_eq(report.solver, RAD_SOLVER_GMRES);
  double worst = 0, most = 0;
  for (size_t i = 0; i < n; i++) {
    worst = fmax(worst, fabs(u[0][i] - u[1][i]));
    most = fmax(most, fabs(u[0][i]));
  }
  ck_assert_msg(worst <= 3 * p->tolerance * most, "%s: %g of %g", p->name, worst, most);
  free(data);
  rad_case_free(&c);
}
END_TEST

/* What a user gets: quadrature and compression both to the tolerance, against the dense matrix of
 * quadrature 1e-12. Asked for: 3 tolerances of max |u|. The larger size takes 6 GB. */
struct size {
  const char *name;
  void (*scene)(struct deck_text *);
  const char *mesh;
  int unknowns, is_large;
};

static const struct size sizes[] = {
    {"S1, P(8,1)", corner_scene, "mesh: paper, elements: 8, degree: 1", 4608, 0},
    {"shadow, degree 1", shadow_scene, "mesh: uniform, elements: 16, degree: 1", 4608, 0},
    {"S1, P(16,1)", corner_scene, "mesh: paper, elements: 16, degree: 1", 18432, 1},
    {"shadow, degree 1", shadow_scene, "mesh: uniform, elements: 32, degree: 1", 18432, 1},
};

static void solve_as(const struct size *s, const char *matrix, double tolerance,
                     struct rad_case *c) {
  struct deck_text *d = malloc(sizeof *d);
  struct rad_error e;
  deck_begin(d);
  s->scene(d);
  deck_add(d,
           "method: {%s, matrix: %s, solver: gmres, solver_tolerance: 1e-13, "
           "quadrature_tolerance: %g}\n",
           s->mesh, matrix, tolerance);
  ck_assert_msg(deck_solve(d, c, &e) == RAD_OK, "%s", e.text);
  ck_assert_int_eq(c->mesh->n_point, s->unknowns);
  free(d);
}

START_TEST(sizes_and_tolerances) {
  static const double tolerance[] = {1e-4, 1e-6, 1e-8, 1e-10};
  const struct size *s = &sizes[_i];
  struct rad_case exact, c;
  if (s->is_large && !getenv("POLYRAD_TEST_FULL"))
    return;
  solve_as(s, "dense", 1e-12, &exact);
  for (int t = 0; t < 4; t++) {
    double worst = 0, most = 0;
    solve_as(s, "hierarchical", tolerance[t], &c);
    for (int i = 0; i < s->unknowns; i++) {
      worst = fmax(worst, fabs(c.u[i] - exact.u[i]));
      most = fmax(most, fabs(exact.u[i]));
    }
    if (getenv("POLYRAD_TEST_VERBOSE"))
      printf("%-18s n %5d, tolerance %g: error of u %.2g of it, estimate %.2g; %.3g MB\n", s->name,
             s->unknowns, tolerance[t], worst / most / tolerance[t], c.h2.error / tolerance[t],
             c.h2.bytes * 1e-6);
    ck_assert_msg(worst <= 3 * tolerance[t] * most, "%s, %g: %g of %g", s->name, tolerance[t],
                  worst, most);
    rad_case_free(&c);
  }
  rad_case_free(&exact);
}
END_TEST

/* Built and applied by 1, 2 and 7 threads; one vector alone or in company. */
START_TEST(same_bits) {
  static const int which[] = {0, 11, FANS}, threads[] = {1, 2, 7};
  const struct problem *p = &problems[which[_i]];
  struct rad_case c[3];
  double *y[3], *z = NULL, *out[N_VECTOR], *in[N_VECTOR];
  size_t n = 0;
  for (int t = 0; t < 3; t++) {
    omp_set_num_threads(threads[t]);
    prepare(p, &c[t]);
    compress(&c[t], p->tolerance);
    n = (size_t)c[t].mesh->n_point;
    free(z);
    z = make_vectors(c[t].mesh);
    y[t] = malloc(sizeof *z * N_VECTOR * n);
    pointers(z, (int)n, in);
    pointers(y[t], (int)n, out);
    if (t == 2)
      for (int v = 0; v < N_VECTOR; v++)
        rad_h2_apply(&c[t].h2, 1, (const double *const *)&in[v], &out[v]);
    else
      rad_h2_apply(&c[t].h2, N_VECTOR, (const double *const *)in, out);
    const struct rad_h2 *a = &c[0].h2, *b = &c[t].h2;
    ck_assert_uint_eq(a->n_far, b->n_far);
    ck_assert_int_eq(memcmp(a->far, b->far, sizeof(double) * a->n_far), 0);
    ck_assert_int_eq(memcmp(a->row.data, b->row.data, sizeof(double) * a->row.n_data), 0);
    ck_assert_int_eq(memcmp(a->column.data, b->column.data, sizeof(double) * a->column.n_data), 0);
    ck_assert_int_eq(memcmp(a->near.narrow, b->near.narrow, sizeof(float) * a->near.n), 0);
    ck_assert_uint_eq(a->sector.n, b->sector.n);
    ck_assert_int_eq(memcmp(a->sector.narrow, b->sector.narrow, sizeof(float) * a->sector.n), 0);
    ck_assert_int_eq(memcmp(a->spread, b->spread, sizeof(double) * a->n_spread), 0);
    ck_assert_int_eq(memcmp(y[0], y[t], sizeof(double) * N_VECTOR * n), 0);
  }
  for (int t = 0; t < 3; t++) {
    free(y[t]);
    rad_case_free(&c[t]);
  }
  free(z);
}
END_TEST

/* Every pair of points that see each other is in exactly one block: the sum over all blocks of
 * their entries, with those of hidden pairs, is n^2 for a scene without shadows or cuts. */
START_TEST(blocks_cover) {
  struct rad_case c;
  prepare(&problems[_i ? FANS : 0], &c);
  compress(&c, 1e-6);
  const struct rad_h2 *h = &c.h2;
  const struct rad_block_list *lists[] = {&h->blocks.far, &h->blocks.near, &h->blocks.sector};
  double entries = 0, seen = 0;
  for (int t = 0; t < h->tree.n_cluster; t++)
    for (int kind = 0; kind < 3; kind++) {
      const struct rad_block_list *list = lists[kind];
      for (size_t b = list->first[t]; b < list->first[t + 1]; b++)
        entries += (double)h->tree.cluster[t].n * h->tree.cluster[list->source[b]].n;
    }
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      seen += i == j ? 0
                     : (double)(c.mesh->point_first[i + 1] - c.mesh->point_first[i]) *
                           (c.mesh->point_first[j + 1] - c.mesh->point_first[j]);
  ck_assert_double_eq(entries, seen);
  rad_case_free(&c);
}
END_TEST

/* The deck's switch: obeyed, and refused with LU. */
START_TEST(deck_switch) {
  struct deck_text *d = malloc(sizeof *d);
  struct rad_case c;
  struct rad_error e;
  deck_begin(d);
  corner_scene(d);
  int length = d->length;
  deck_add(d, "method: {elements: 6, quadrature_tolerance: 1e-6, matrix: hierarchical}\n");
  ck_assert_msg(deck_solve(d, &c, &e) == RAD_OK, "%s", e.text);
  ck_assert_ptr_nonnull(c.h2.mesh);
  ck_assert_ptr_null(c.dense.k);
  ck_assert_int_eq(c.report.solver, RAD_SOLVER_GMRES);
  ck_assert_double_gt(c.h2.error, 0);
  ck_assert_double_lt(c.h2.error, 2e-6);
  rad_case_free(&c);
  d->length = length;
  deck_add(d, "method: {elements: 6, solver: lu, matrix: hierarchical}\n");
  ck_assert_int_eq(deck_prepare(d, &c, &e), RAD_EINPUT);
  ck_assert_ptr_nonnull(strstr(e.text, "lu needs a dense matrix"));
  rad_case_free(&c);
  free(d);
}
END_TEST

int main(void) {
  Suite *s = suite_create("hierarchical");
  TCase *c = tcase_create("hierarchical");
  tcase_set_timeout(c, 600);
  tcase_add_loop_test(c, products, 0, N_PROBLEM);
  tcase_add_loop_test(c, solutions, 0, 6);
  tcase_add_loop_test(c, sizes_and_tolerances, 0, sizeof sizes / sizeof *sizes);
  tcase_add_loop_test(c, same_bits, 0, 3);
  tcase_add_loop_test(c, thin_elements, 0, 4);
  tcase_add_loop_test(c, blocks_cover, 0, 2);
  tcase_add_test(c, deck_switch);
  suite_add_tcase(s, c);
  return run_suite(s);
}
