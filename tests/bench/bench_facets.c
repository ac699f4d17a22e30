/* Time and memory of a closed box of many facets: sight, assembly, solve.
 *
 *   build/release/tests/bench_facets [n] [threads] [tolerance] [inner]
 *
 * Each of the six faces of a unit cube has n x n squares of two triangles: 12 n^2 facets, one
 * constant each; with `inner` a box of 12 inner^2 facets stands in the middle, seen from outside.
 * rho 0.3 to 0.8 and E 0 to 1 by face. The floor of the assembly is the time to
 * touch as many fresh pages as the matrix has, that of a product the time to read them. */
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "base/vec.h"
#include "system/solve.h"
#include "visibility/visibility.h"

/* Corner and two sides of each face; seen from inside, the sides turn to the left. */
static const double face[6][3][3] = {
    {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}},
    {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
    {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}}, {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}}};

static int vertex_number(int n, const int index[3]) {
  return (index[0] * (n + 1) + index[1]) * (n + 1) + index[2];
}

/* A box [low, low + size]^3 whose vertices are numbered from `first`; turned: seen from outside. */
struct box {
  int n, first, surface, turned;
  double low, size;
};

/* The half `second` of square (i, j) of face f. */
static void set_triangle(const struct box *box, int f, int i, int j, int second,
                         struct rad_scene *scene, struct rad_triangle *t) {
  const int step[2][3][2] = {{{0, 0}, {1, 0}, {1, 1}}, {{0, 0}, {1, 1}, {0, 1}}};
  double u[3], v[3];
  *t = (struct rad_triangle){.surface = box->surface + f};
  for (int k = 0; k < 3; k++) {
    int c = box->turned && k > 0 ? 3 - k : k, index[3];
    for (int d = 0; d < 3; d++)
      index[d] = (int)lround(face[f][0][d] * box->n + face[f][1][d] * (i + step[second][c][0]) +
                             face[f][2][d] * (j + step[second][c][1]));
    t->vertex[k] = box->first + vertex_number(box->n, index);
    for (int d = 0; d < 3; d++)
      scene->vertex[t->vertex[k]][d] = t->v[k][d] = box->low + box->size * index[d] / box->n;
  }
  rad_sub(t->v[1], t->v[0], u);
  rad_sub(t->v[2], t->v[0], v);
  rad_cross(u, v, t->normal);
  t->area = 0.5 * rad_norm(t->normal);
  for (int d = 0; d < 3; d++)
    t->normal[d] /= 2 * t->area;
}

/* Fill in the triangles of a box from number `at` on; vertices within it stay at its corner. */
static int add_box(const struct box *box, struct rad_scene *scene, int at) {
  int n = box->n, points = (n + 1) * (n + 1) * (n + 1);
  for (int v = 0; v < points; v++)
    for (int d = 0; d < 3; d++)
      scene->vertex[box->first + v][d] = box->low;
  for (int k = 0; k < 12 * n * n; k++)
    set_triangle(box, k / (2 * n * n), k / (2 * n) % n, k / 2 % n, k % 2, scene,
                 &scene->triangle[at + k]);
  return at + 12 * n * n;
}

static int make_scene(int n, int inner, struct rad_scene *scene) {
  int outer_points = (n + 1) * (n + 1) * (n + 1);
  *scene = (struct rad_scene){.n_triangle = 12 * (n * n + inner * inner),
                              .n_vertex = outer_points + (inner + 1) * (inner + 1) * (inner + 1),
                              .n_surface = 12,
                              .n_band = 1,
                              .size = sqrt(3)};
  scene->triangle = rad_alloc((size_t)scene->n_triangle, sizeof *scene->triangle);
  scene->vertex = rad_alloc((size_t)scene->n_vertex, sizeof *scene->vertex);
  if (!scene->triangle || !scene->vertex)
    return 0;
  int at = add_box(&(struct box){n, 0, 0, 0, 0, 1}, scene, 0);
  if (inner)
    add_box(&(struct box){inner, outer_points, 6, 1, 0.3, 0.4}, scene, at);
  else
    scene->n_vertex = outer_points;
  return 1;
}

/* Seconds to touch, and to read, as many pages. */
static void measure_pages(size_t bytes, double *touch, double *read) {
  double start = rad_seconds(), sum = 0;
  double *page = rad_pages_alloc(bytes);
  if (!page)
    return;
  memset(page, 1, bytes);
  *touch = rad_seconds() - start;
  start = rad_seconds();
#pragma omp parallel for simd reduction(+ : sum) default(none) shared(page, bytes)
  for (size_t i = 0; i < bytes / sizeof *page; i++)
    sum += page[i];
  *read = rad_seconds() - start;
  if (isnan(sum))
    puts("");
  rad_pages_free(page, bytes);
}

static double worst_row(const struct rad_dense *dense, double *work) {
  double worst = 0, *one = work, *sum = work + dense->n;
  for (int i = 0; i < dense->n; i++)
    one[i] = 1;
  rad_dense_apply(dense, 1, (const double *const[]){one}, &sum);
  for (int i = 0; i < dense->n; i++)
    worst = fmax(worst, fabs(sum[i] - 1));
  return worst;
}

int main(int argc, char **argv) {
  static const double rho_of[6] = {0.3, 0.4, 0.5, 0.6, 0.7, 0.8}, e_of[6] = {1, 0, 0, 0.5, 0, 0};
  int n = argc > 1 ? atoi(argv[1]) : 29, threads = argc > 2 ? atoi(argv[2]) : 1;
  double tolerance = argc > 3 ? atof(argv[3]) : 1e-10;
  int inner = argc > 4 ? atoi(argv[4]) : 0;
  if (n < 1 || n > 60 || inner < 0 || inner > 60 || threads < 1 || !(tolerance > 0)) {
    fprintf(stderr, "usage: bench_facets [n <= 60] [threads] [tolerance] [inner <= 60]\n");
    return 2;
  }
  omp_set_num_threads(threads);
  struct rad_scene scene;
  struct rad_visibility visibility;
  struct rad_mesh mesh;
  struct rad_rules rules;
  struct rad_dense dense;
  struct rad_solve_report report;
  struct rad_error e = {0};
  struct rad_deck_method m = {.mesh = RAD_MESH_UNIFORM, .elements = 1, .degree = 0};
  struct rad_solve_options o = {
      .solver = RAD_SOLVER_GMRES, .tolerance = 1e-13, .quadrature = tolerance};
  double start = rad_seconds(), touch = NAN, read = NAN;
  if (!make_scene(n, inner, &scene) || rad_mesh_build(&scene, &m, &mesh, &e) ||
      rad_rules_build(&mesh, tolerance, &rules, &e))
    return 1;
  double mesh_time = rad_seconds() - start;
  start = rad_seconds();
  if (rad_visibility_build(&scene, &visibility, &e))
    return 1;
  double sees_time = rad_seconds() - start;
  start = rad_seconds();
  if (rad_dense_assemble(&mesh, &rules, NULL, &dense, &e))
    return 1;
  double assemble_time = rad_seconds() - start;
  size_t size = (size_t)dense.n;
  double *data = rad_alloc(size, 6 * sizeof *data);
  if (!data)
    return 1;
  for (size_t i = 0; i < size; i++) {
    data[i] = rho_of[scene.triangle[i].surface % 6];
    data[size + i] = e_of[scene.triangle[i].surface % 6];
  }
  struct rad_operator k = rad_operator_dense(&dense);
  if (rad_solve(&k, &o, 1, data, data + size, data + 2 * size, data + 3 * size, &report, &e))
    return 1;
  double peak = rad_memory_peak(), pairs = (double)(dense.counters.far + dense.counters.near);
  printf("facets                     %8d       tolerance %.0e, threads %d\n", dense.n, tolerance,
         threads);
  printf("mesh and rules             %8.3f s\n", mesh_time);
  printf("sight                      %8.3f s\n", sees_time);
  printf("assembly                   %8.3f s     %.1f ns a pair\n", assemble_time,
         1e9 * assemble_time / pairs);
  printf("pairs by the closed form   %8lld       by quadrature %lld, none %lld\n",
         (long long)dense.counters.far, (long long)dense.counters.near,
         (long long)dense.pairs_skipped);
  printf("solve                      %8.3f s     %d steps\n", report.seconds_solve,
         report.iterations);
  printf("worst |row sum - 1|        %8.1e\n", worst_row(&dense, data + 4 * size));
  printf("memory                     %8.1f MB    matrix %.1f, sight %.1f\n", peak / 1e6,
         8e-6 * (double)size * (double)size, 1e-6 * (double)size * (double)size);
  rad_dense_free(&dense);
  measure_pages(size * size * sizeof(double), &touch, &read);
  printf("touching as many pages     %8.3f s     reading them %.3f s\n", touch, read);
  free(data);
  rad_rules_free(&rules);
  rad_mesh_free(&mesh);
  rad_visibility_free(&visibility);
  free(scene.triangle);
  free(scene.vertex);
  return 0;
}
