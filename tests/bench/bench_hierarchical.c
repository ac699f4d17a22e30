/* The hierarchical matrix of surface S1, P(N,p), degree 1: time, memory, ranks, product against the
 * machine's bandwidth, solve.
 *
 *   build/release/tests/bench_hierarchical [N] [tolerance] [p]
 *
 * The bandwidth is STREAM's triad, a = b + s c on three arrays of 64 MB, best of ten, counted as 24
 * bytes an entry, in the same process and with the same threads as the product. */
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/memory.h"
#include "surface_s1.h"
#include "system/solve.h"
#include "visibility/visibility.h"

static double triad(void) {
  enum { N = 8 << 20, REPEATS = 10 };
  double *a = rad_pages_alloc(N * sizeof *a), *b = rad_pages_alloc(N * sizeof *b);
  double *c = rad_pages_alloc(N * sizeof *c), best = 0;
  for (int r = 0; a && b && c && r <= REPEATS; r++) { /* the first only touches the pages */
    double start = rad_seconds();
#pragma omp parallel for simd schedule(static) default(none) shared(a, b, c, r)
    for (int i = 0; i < N; i++)
      a[i] = r ? b[i] + 3.0 * c[i] : (b[i] = c[i] = 1);
    double speed = 24.0 * N / (rad_seconds() - start);
    best = r && speed > best ? speed : best;
  }
  rad_pages_free(a, N * sizeof *a);
  rad_pages_free(b, N * sizeof *b);
  rad_pages_free(c, N * sizeof *c);
  return best;
}

/* Seconds of the fastest of a few products. */
static double product(const struct rad_h2 *h, const double *u, double *y) {
  double best = 1e30;
  for (int r = 0; r < 20; r++) {
    double start = rad_seconds();
    rad_h2_apply(h, 1, &u, &y);
    double seconds = rad_seconds() - start;
    best = seconds < best ? seconds : best;
  }
  return best;
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
  printf("memory                     %10.1f MB: bases %.1f, far %.1f, near %.1f; predicted %.1f\n",
         h->bytes * 1e-6, 8e-6 * (double)(h->row.n_data + h->column.n_data),
         8e-6 * (double)h->n_far, (h->near_narrow ? 4e-6 : 8e-6) * (double)h->n_near,
         plan->bytes * 1e-6);
  printf("blocks                     %10zu far of mean rank %.1f, %zu near\n",
         h->blocks.far.first[h->tree.n_cluster], h->mean_rank,
         h->blocks.near.first[h->tree.n_cluster]);
}

static void solve(const struct rad_h2 *h) {
  size_t n = (size_t)h->mesh->n_point;
  double *data = rad_alloc(4 * n, sizeof(double));
  struct rad_solve_options o = {RAD_SOLVER_GMRES, 1e-10, 0, h->tolerance};
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
  double bandwidth = triad(), seconds = product(&h, u, y), traffic = rad_h2_traffic(&h);
  printf("product                    %10.5f s for %.1f MB: %.1f GB/s, %.0f %% of triad's %.1f\n",
         seconds, traffic * 1e-6, traffic / seconds * 1e-9, 100 * traffic / seconds / bandwidth,
         bandwidth * 1e-9);
  free(u);
  free(y);
  rad_h2_free(&h);
  rad_rules_free(&rules);
  rad_mesh_free(&mesh);
  rad_visibility_free(&visibility);
  return 0;
}
