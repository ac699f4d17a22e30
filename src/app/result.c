/* From a solved case to the arrays of its result file. */
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "app/case.h"
#include "base/memory.h"
#include "base/vec.h"

/* What the relative numbers of an estimate refer to [W/m2]. */
static double scale(const struct rad_case *c) {
  return rad_indicator_scale(&c->adaptive.indicator, c->scene.n_band);
}

static enum rad_code set_points(const struct rad_case *c, struct rad_result *r,
                                struct rad_error *e) {
  size_t n = (size_t)c->mesh->n_point, nb = (size_t)c->scene.n_band;
  r->n_point = c->mesh->n_point;
  r->point = rad_alloc(n, 3 * sizeof(double));
  r->point_triangle = rad_alloc(n, sizeof(int));
  r->value = rad_alloc(n * nb, sizeof(double));
  if (!r->point || !r->point_triangle || !r->value)
    return rad_fail_memory(e, "the result", (double)n * (28 + 8.0 * (double)nb));
  for (int t = 0; t < c->scene.n_triangle; t++)
    for (int i = c->mesh->point_first[t]; i < c->mesh->point_first[t + 1]; i++) {
      rad_triangle_point(&c->scene.triangle[t], c->mesh->point_base[i], c->mesh->point_mu[i],
                         r->point + 3 * i);
      r->point_triangle[i] = t;
      for (size_t b = 0; b < nb; b++)
        r->value[(size_t)i * nb + b] = c->u[b * n + (size_t)i];
    }
  return RAD_OK;
}

static const char *solver_name(enum rad_solver s) {
  return s == RAD_SOLVER_LU ? "lu" : s == RAD_SOLVER_GMRES ? "gmres" : "neumann";
}

static double indicator(const struct rad_case *c) {
  return c->adaptive.indicator.change * scale(c);
}

static const struct rad_counters *counters(const struct rad_case *c) {
  return c->h2.mesh ? &c->h2.counters : &c->dense.counters;
}

static void set_diagnostics(const struct rad_case *c, struct rad_diagnostics *d) {
  *d = (struct rad_diagnostics){.unknowns = c->mesh->n_point,
                                .elements = c->mesh->n_element,
                                .kappa = c->report.kappa,
                                .error_indicator = c->has_bound ? indicator(c) : NAN,
                                .error_bound = c->has_bound ? c->adaptive.bound * scale(c) : NAN,
                                .error_bound_limit =
                                    c->has_bound ? c->adaptive.bound_limit * scale(c) : NAN,
                                .compression_error = c->h2.error,
                                .residual = c->report.residual,
                                .iterations = c->report.iterations,
                                .condition_estimate = c->report.condition_estimate,
                                .converged = c->report.converged,
                                .means_error = c->means.n ? c->means.worst : NAN,
                                .means_converged = c->means.n && c->means.worst <= c->tolerance,
                                .matrix_bytes = c->plan.system.matrix_bytes,
                                .peak_memory_bytes = rad_memory_peak(),
                                .kernel_values = counters(c)->kernel_values,
                                .pairs_near = counters(c)->near,
                                .pairs_far = counters(c)->far,
                                .pairs_skipped = c->dense.pairs_skipped,
                                .seconds_scene = c->seconds_scene,
                                .seconds_mesh = c->seconds_mesh,
                                .seconds_assemble = c->seconds_assemble,
                                .seconds_factor = c->report.seconds_factor,
                                .seconds_solve = c->report.seconds_solve,
                                .seconds_estimate = c->seconds_estimate,
                                .seconds_levels = c->seconds_levels};
}

/* The first number of a list of triples, or NULL. */
static const double *exponents(double (*list)[3]) {
  return list ? list[0] : NULL;
}

/* As asked; else that of an adaptive run, and 1e-6 on a mesh made by hand. */
static double view_tolerance(const struct rad_case *c) {
  return c->is_adaptive || c->deck.tolerance > 0 ? c->tolerance : 1e-6;
}

enum rad_code rad_case_result(const struct rad_case *c, const char *command, struct rad_result *r,
                              struct rad_error *e) {
  *r = (struct rad_result){.deck = &c->deck,
                           .scene = &c->scene,
                           .command = command,
                           .matrix =
                               c->plan.system.matrix == RAD_MATRIX_DENSE ? "dense" : "hierarchical",
                           .solver = solver_name(c->report.solver),
                           .threads = omp_get_max_threads(),
                           .edge_exponent = exponents(c->adaptive.layout.exponents.beta),
                           .vertex_exponent = exponents(c->adaptive.layout.exponents.alpha),
                           .means = c->means.n ? &c->means : NULL,
                           .balance = c->means.n ? &c->balance : NULL};
  rad_progress_phase(c->scene.progress, "picture");
  enum rad_code code = rad_case_picture(c, &r->picture, e);
  if (!code)
    code = set_points(c, r, e);
  if (!code)
    code = rad_case_probes(c, r, e);
  if (!code && c->deck.output.view_factors)
    code = rad_view_factors(&c->scene, view_tolerance(c), 0, &r->view_factors, e);
  if (!code)
    set_diagnostics(c, &r->diagnostics);
  return code;
}
