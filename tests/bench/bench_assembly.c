/* Assembly against dgetrf on the same matrix, and its speed-up with threads, in one run.
 *
 *   build/release/tests/bench_assembly [N] [tolerance] [repeats]
 *
 * Surface S1, P(N,1), degree 1. Medians of the repeats. Every assembly is into fresh pages, as in a
 * run; the first is reported apart, since a machine may then have to find its memory. */
#include <lapacke.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/memory.h"
#include "median.h"
#include "surface_s1.h"
#include "system/dense.h"
#include "visibility/visibility.h"

static double assemble(const struct rad_mesh *mesh, const struct rad_rules *rules, int threads,
                       struct rad_dense *dense) {
  struct rad_error e;
  omp_set_num_threads(threads);
  double start = rad_seconds();
  if (rad_dense_assemble(mesh, rules, NULL, dense, &e)) {
    fprintf(stderr, "%s\n", e.text);
    exit(e.code);
  }
  return rad_seconds() - start;
}

static double factor(const struct rad_dense *dense) {
  size_t n = (size_t)dense->n, bytes = n * n * sizeof(double);
  double *a = rad_pages_alloc(bytes);
  int *pivot = rad_alloc(n, sizeof(int));
  if (!a || !pivot)
    return 0;
  for (size_t i = 0; i < n * n; i++)
    a[i] = -0.5 * dense->k[i] + (i % (n + 1) == 0);
  double start = rad_seconds();
  LAPACKE_dgetrf(LAPACK_COL_MAJOR, (int)n, (int)n, a, (int)n, pivot);
  double seconds = rad_seconds() - start;
  rad_pages_free(a, bytes);
  free(pivot);
  return seconds;
}

int main(int argc, char **argv) {
  int n = argc > 1 ? atoi(argv[1]) : 16, repeats = argc > 3 ? atoi(argv[3]) : 5;
  double tolerance = argc > 2 ? atof(argv[2]) : 1e-9, one[64], two[64];
  if (n < 1 || repeats < 1 || repeats > 64 || !(tolerance > 0)) {
    fprintf(stderr, "usage: bench_assembly [N] [tolerance] [repeats <= 64]\n");
    return 2;
  }
  struct rad_triangle tri[3];
  struct rad_scene scene;
  struct rad_mesh mesh;
  struct rad_rules rules;
  struct rad_dense dense;
  struct rad_error e;
  struct rad_visibility visibility;
  make_s1(tri, &scene);
  if (rad_visibility_build(&scene, &visibility, &e))
    return 1;
  struct rad_deck_method m = {.elements = n, .grading = 1, .degree = 1};
  if (rad_mesh_build(&scene, &m, &mesh, &e) || rad_rules_build(&mesh, tolerance, &rules, &e))
    return 1;
  printf("first assembly, 2 threads  %8.3f s\n", assemble(&mesh, &rules, 2, &dense));
  rad_dense_free(&dense);
  for (int i = 0; i < repeats; i++) { /* interleaved: both see the same neighbours */
    one[i] = assemble(&mesh, &rules, 1, &dense);
    rad_dense_free(&dense);
    two[i] = assemble(&mesh, &rules, 2, &dense);
    if (i + 1 < repeats)
      rad_dense_free(&dense);
  }
  double t1 = median(one, repeats), t2 = median(two, repeats), lu = factor(&dense);
  double pairs = (double)(dense.counters.near + dense.counters.far);
  printf("unknowns                   %8d\n", dense.n);
  printf("assembly, 1 thread         %8.3f s   (least %.3f)\n", t1, one[0]);
  printf("assembly, 2 threads        %8.3f s   (least %.3f)\n", t2, two[0]);
  printf("speed-up                   %8.2f     (of the least: %.2f)\n", t1 / t2, one[0] / two[0]);
  printf("kernel values              %8.3g     %.1f a pair, %.2f ns each on one thread\n",
         (double)dense.counters.kernel_values, (double)dense.counters.kernel_values / pairs,
         1e9 * t1 / (double)dense.counters.kernel_values);
  printf("pairs near, far            %8lld %lld\n", (long long)dense.counters.near,
         (long long)dense.counters.far);
  printf("dgetrf, 2 threads          %8.3f s\n", lu);
  printf("dgetrf / assembly          %8.1f\n", lu / t2);
  rad_dense_free(&dense);
  rad_rules_free(&rules);
  rad_mesh_free(&mesh);
  return 0;
}
