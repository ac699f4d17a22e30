/* The hierarchical matrix of surface S1, P(N,p), degree 1: time, memory, ranks, product against the
 * machine's bandwidth, solve.
 *
 *   build/release/tests/bench_hierarchical [N] [tolerance] [p]
 *
 * The bandwidth is STREAM's triad, a = b + s c on three arrays of 64 MB, counted as 24 bytes an
 * entry, by turns with the product and with the same threads. */
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/memory.h"
#include "median.h"
#include "surface_s1.h"
#include "system/solve.h"
#include "visibility/visibility.h"

/* Three arrays for STREAM's triad. */
enum { N_TRIAD = 8 << 20, ROUNDS = 21 };

static double triad(double *a, const double *b, const double *c) {
  double start = rad_seconds();
#pragma omp parallel for simd schedule(static) default(none) shared(a, b, c)
  for (int i = 0; i < N_TRIAD; i++)
    a[i] = b[i] + 3.0 * c[i];
  return 24.0 * N_TRIAD / (rad_seconds() - start);
}

/* A product only reads: the same three arrays, summed. */
static double read_all(const double *a, const double *b, const double *c, double *sum) {
  double start = rad_seconds(), s0 = 0, s1 = 0, s2 = 0;
#pragma omp parallel for simd schedule(static) default(none) shared(a, b, c)                       \
    reduction(+ : s0, s1, s2)
  for (int i = 0; i < N_TRIAD; i++) {
    s0 += a[i];
    s1 += b[i];
    s2 += c[i];
  }
  *sum += s0 + s1 + s2;
  return 24.0 * N_TRIAD / (rad_seconds() - start);
}

/* Product, triad and reading by turns, since the host's bandwidth changes from one moment to the
 * next. */
static void print_product(const struct rad_h2 *h, const double *u, double *y) {
  double *a = rad_pages_alloc(N_TRIAD * sizeof *a), *b = rad_pages_alloc(N_TRIAD * sizeof *b);
  double *c = rad_pages_alloc(N_TRIAD * sizeof *c), sum = 0;
  double seconds[ROUNDS], speed[ROUNDS], share[ROUNDS], reading[ROUNDS];
  if (!a || !b || !c)
    exit(3);
#pragma omp parallel for simd schedule(static) default(none) shared(a, b, c)
  for (int i = 0; i < N_TRIAD; i++)
    a[i] = b[i] = c[i] = 1; /* touch the pages */
  for (int r = -1; r < ROUNDS; r++) {
    double start = rad_seconds();
    rad_h2_apply(h, 1, &u, &y);
    double took = rad_seconds() - start, traffic = rad_h2_traffic(h);
    double bandwidth = triad(a, b, c), reads = read_all(a, b, c, &sum);
    if (r >= 0) {
      seconds[r] = took;
      speed[r] = bandwidth;
      share[r] = traffic / took / bandwidth;
      reading[r] = traffic / took / reads;
    }
  }
  printf(
      "product                    %10.5f s for %.1f MB; triad %.1f GB/s; product over triad "
      "%.0f %%, over reading three arrays %.0f %% (medians of %d rounds, sum %g)\n",
      median(seconds, ROUNDS), rad_h2_traffic(h) * 1e-6, median(speed, ROUNDS) * 1e-9,
      100 * median(share, ROUNDS), 100 * median(reading, ROUNDS), ROUNDS, sum);
  rad_pages_free(a, N_TRIAD * sizeof *a);
  rad_pages_free(b, N_TRIAD * sizeof *b);
  rad_pages_free(c, N_TRIAD * sizeof *c);
}

static void need(enum rad_code code, const struct rad_error *e) {
  if (!code)
    return;
  fprintf(stderr, "%s\n", e->text);
  exit(code);
}

static void print_build(const struct rad_h2 *h, const struct rad_h2_plan *plan, double build) {
  printf("unknowns                   %10d, tolerance %g\n", h->mesh->n_point, h->tolerance);
  printf("build                      %10.3f s: blocks %.3f, bases %.3f, far %.3f, near %.3f\n",
         build, h->seconds_blocks, h->seconds_bases, h->seconds_far, h->seconds_near);
  printf("check                      %10.3f s: error %.2e of a row sum\n", h->seconds_check,
         h->error);
  double size = h->near.narrow ? 4e-6 : 8e-6;
  printf(
      "memory                     %10.1f MB: bases %.1f, far %.1f, near %.1f, sectors %.1f; "
      "predicted %.1f\n",
      h->bytes * 1e-6, 8e-6 * (double)(h->row.n_data + h->column.n_data), 8e-6 * (double)h->n_far,
      size * (double)h->near.n, size * (double)h->sector.n + 8e-6 * (double)h->n_spread,
      plan->bytes * 1e-6);
  printf("blocks                     %10zu far of mean rank %.1f, %zu near, %zu of sectors\n",
         h->blocks.far.first[h->tree.n_cluster], h->mean_rank,
         h->blocks.near.first[h->tree.n_cluster], h->blocks.sector.first[h->tree.n_cluster]);
}

static void solve(const struct rad_h2 *h) {
  size_t n = (size_t)h->mesh->n_point;
  double *data = rad_alloc(4 * n, sizeof(double));
  struct rad_solve_options o = {
      .solver = RAD_SOLVER_GMRES, .tolerance = 1e-10, .quadrature = h->tolerance};
  struct rad_solve_report report;
  struct rad_operator k = rad_operator_h2(h);
  struct rad_error e;
  if (!data)
    exit(3);
  rad_mesh_data(h->mesh, data, data + n);
  need(rad_solve(&k, &o, 1, data, data + n, data + 2 * n, data + 3 * n, &report, &e), &e);
  printf("solve                      %10.3f s, %d steps for u and for w\n", report.seconds_solve,
         report.iterations);
  free(data);
}

int main(int argc, char **argv) {
  int n = argc > 1 ? atoi(argv[1]) : 16;
  double tolerance = argc > 2 ? atof(argv[2]) : 1e-7, p = argc > 3 ? atof(argv[3]) : 1;
  if (n < 1 || !(tolerance > 0) || !(p >= 1)) {
    fprintf(stderr, "usage: bench_hierarchical [N] [tolerance] [p]\n");
    return 2;
  }
  struct rad_triangle tri[3];
  struct rad_scene scene;
  struct rad_visibility visibility;
  struct rad_mesh mesh;
  struct rad_rules rules;
  struct rad_h2 h;
  struct rad_h2_plan plan;
  struct rad_error e;
  double start = rad_seconds();
  make_s1(tri, &scene);
  static double rho[3] = {0.5, 0.5, 0.5}, emission[9] = {.5, .5, .5, 1, 1, 1, .3, .3, .3};
  scene.n_band = 1;
  scene.rho = rho;
  scene.emission = emission;
  struct rad_deck_method m = {.elements = n, .grading = p, .degree = 1};
  need(rad_visibility_build(&scene, &visibility, &e), &e);
  need(rad_mesh_build(&scene, &m, &mesh, &e), &e);
  need(rad_rules_build(&mesh, tolerance, &rules, &e), &e);
  need(rad_h2_predict(&mesh, tolerance, &plan, &e), &e);
  double before = rad_seconds();
  need(rad_h2_build(&mesh, &rules, tolerance, &h, &e), &e);
  double build = rad_seconds() - before;
  need(rad_h2_check(&h, &rules, &e), &e);
  print_build(&h, &plan, build);
  solve(&h);
  printf("all of it                  %10.3f s, peak memory %.1f MB, %d threads\n",
         rad_seconds() - start, rad_memory_peak() * 1e-6, omp_get_max_threads());
  double *u = rad_calloc((size_t)mesh.n_point, sizeof(double));
  double *y = rad_calloc((size_t)mesh.n_point, sizeof(double));
  if (!u || !y)
    return 3;
  print_product(&h, u, y);
  free(u);
  free(y);
  rad_h2_free(&h);
  rad_rules_free(&rules);
  rad_mesh_free(&mesh);
  rad_visibility_free(&visibility);
  return 0;
}
