/* What an adaptive run costs beside its final solve: the same mesh, made, assembled, solved and
 * estimated from nothing.
 *
 *   build/release/tests/bench_adaptive [scene | -1] [repeats] [tolerance...]
 *
 * Scenes as in tests/cases/adaptive_scenes.h, -1: all. Medians of the repeats, interleaved. */
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

#include "adaptive_scenes.h"
#include "base/clock.h"
#include "base/memory.h"
#include "median.h"

enum { MAX_REPEAT = 64 };

static void need(enum rad_code code, const struct rad_error *e) {
  if (!code)
    return;
  fprintf(stderr, "%s\n", e->text);
  exit((int)code);
}

/* The last level of a run, from its layout alone. */
static double final_solve(const struct rad_adaptive *a, const struct rad_goal *goal) {
  struct rad_mesh mesh;
  struct rad_rules rules;
  struct rad_dense dense;
  struct rad_indicator indicator;
  struct rad_solve_report report;
  struct rad_error e;
  struct rad_reuse none = {NULL, NULL, a->layout.passive};
  double start = rad_seconds();
  need(rad_layout_mesh(&a->layout, &mesh, &e), &e);
  need(rad_rules_build(&mesh, a->quadrature, &rules, &e), &e);
  need(rad_dense_assemble(&mesh, &rules, &none, &dense, &e), &e);
  double *u = rad_calloc((size_t)mesh.n_point * 2, sizeof(double)), *h = u + mesh.n_point;
  struct rad_solve_options o = {
      .solver = goal->solver, .tolerance = 0.01 * goal->tolerance, .quadrature = a->quadrature};
  struct rad_operator k = rad_operator_dense(&dense);
  need(rad_solve(&k, &o, 1, a->rho, a->emission, u, h, &report, &e), &e);
  need(rad_indicate(&mesh, &rules, a->layout.passive, NULL, u, INFINITY, &indicator, &e), &e);
  double seconds = rad_seconds() - start;
  free(u);
  rad_indicator_free(&indicator);
  rad_dense_free(&dense);
  rad_rules_free(&rules);
  rad_mesh_free(&mesh);
  return seconds;
}

static void measure(int scene, double tolerance, int repeats) {
  static struct deck_text text;
  const char *name = adaptive_scene(scene, &text);
  struct rad_case c;
  struct rad_error e;
  need(deck_prepare(&text, &c, &e), &e);
  double whole[MAX_REPEAT], last[MAX_REPEAT];
  int unknowns = 0, levels = 0;
  for (int i = 0; i < repeats; i++) {
    struct rad_goal goal = {.tolerance = tolerance, .memory = rad_memory_available()};
    struct rad_adaptive a;
    double start = rad_seconds();
    need(rad_adapt(&c.scene, &goal, &a, &e), &e);
    whole[i] = rad_seconds() - start;
    last[i] = final_solve(&a, &goal);
    unknowns = a.mesh->n_point;
    levels = a.levels;
    rad_adaptive_free(&a);
  }
  double run = median(whole, repeats), final = median(last, repeats);
  printf("%-13s %-7g %7d %6d %9.4f %9.4f %6.2f\n", name, tolerance, unknowns, levels, run, final,
         run / final);
  fflush(stdout);
  rad_case_free(&c);
}

int main(int argc, char **argv) {
  static const double usual[] = {1e-2, 1e-3, 1e-4, 1e-6};
  int scene = argc > 1 ? atoi(argv[1]) : -1, repeats = argc > 2 ? atoi(argv[2]) : 5;
  if (scene < -1 || scene >= N_ADAPTIVE_SCENE || repeats < 1 || repeats > MAX_REPEAT) {
    fprintf(stderr, "usage: bench_adaptive [scene 0..%d | -1] [repeats <= %d] [tolerance...]\n",
            N_ADAPTIVE_SCENE - 1, MAX_REPEAT);
    return 2;
  }
  printf("%d threads, medians of %d\n", omp_get_max_threads(), repeats);
  printf("%-13s %-7s %7s %6s %9s %9s %6s\n", "scene", "toler.", "unkn.", "levels", "run s",
         "final s", "ratio");
  for (int s = scene < 0 ? 0 : scene; s <= (scene < 0 ? N_ADAPTIVE_SCENE - 1 : scene); s++)
    for (int t = 0; t < (argc > 3 ? argc - 3 : 4); t++)
      measure(s, argc > 3 ? atof(argv[3 + t]) : usual[t], repeats);
  return 0;
}
