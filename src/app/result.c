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

/* int L_b dS of one element's trial functions, from the finest rules. */
static void element_weights(const struct rad_case *c, int element, double *weight) {
  const struct rad_element *e = &c->mesh->element[element];
  const struct rad_patch *patch = &c->mesh->patch[e->patch];
  const struct rad_panel *angular = &c->rules.panel[c->rules.angular[element]];
  const struct rad_panel *radial = &c->rules.panel[c->rules.radial[element]];
  int o = RAD_N_ORDER - 1, n = rad_order[o], k = e->k_phi * e->k_r;
  double wt[RAD_GAUSS_MAX] = {0}, wr[RAD_GAUSS_MAX] = {0};
  for (int q = 0; q < n; q++) {
    for (int a = 0; a < e->k_phi; a++)
      wt[a] += angular->weight[o][a * n + q];
    for (int b = 0; b < e->k_r; b++)
      wr[b] += radial->weight[o][b * n + q];
  }
  for (int f = 0; f < e->n_function; f++) {
    weight[f] = 0;
    for (int b = 0; b < k; b++)
      if (e->fold || b == f)
        weight[f] += (e->fold ? e->fold[f * k + b] : 1) * wt[b % e->k_phi] * wr[b / e->k_phi];
    weight[f] *= patch->a1 * patch->b2;
  }
}

/* Graded Gauss points of a triangle's six sub-triangles, with weights that sum to 1. */
enum { MEAN_POINTS = 10, MEAN_TOTAL = RAD_N_SUB * MEAN_POINTS * MEAN_POINTS };

static void mean_points(const struct rad_case *c, int t, int *triangle, int *base, double (*mu)[2],
                        double *weight) {
  const double *x = rad_gauss_node(&c->mesh->gauss, MEAN_POINTS);
  const double *w = rad_gauss_weight(&c->mesh->gauss, MEAN_POINTS);
  int at = 0;
  for (int s = 0; s < RAD_N_SUB; s++) {
    struct rad_patch patch;
    rad_patch_sub_triangle(&c->scene, t, s, RAD_ANGLE_POLAR, &patch);
    for (int q = 0; q < MEAN_POINTS * MEAN_POINTS; q++, at++) {
      double sigma = 0.5 * (1 + x[q % MEAN_POINTS]), tau = 0.5 * (1 + x[q / MEAN_POINTS]);
      double phi = sigma * sigma * sigma, r = tau * tau * tau,
             angle = rad_angle_t(patch.angle, phi);
      triangle[at] = t;
      base[at] = patch.base;
      rad_patch_mu(&patch, phi, r, mu[at]);
      weight[at] = 0.25 * w[q % MEAN_POINTS] * w[q / MEAN_POINTS] * 3 * sigma * sigma *
                   rad_angle_dt(patch.angle, angle) * 3 * tau * tau * r * patch.a1 * patch.b2 /
                   c->scene.triangle[t].area;
    }
  }
}

/* Mean irradiance of a passive triangle, which has no collocation points of its own. */
static enum rad_code passive_mean(const struct rad_case *c, int t, double *irradiance,
                                  struct rad_error *e) {
  int nb = c->scene.n_band;
  int *triangle = rad_alloc(MEAN_TOTAL, 2 * sizeof(int));
  double(*mu)[2] = rad_alloc(MEAN_TOTAL, sizeof *mu);
  double *weight = rad_alloc(MEAN_TOTAL, (size_t)(nb + 1) * sizeof(double));
  enum rad_code code = RAD_OK;
  if (!triangle || !mu || !weight) {
    code = rad_fail_memory(e, "the means", MEAN_TOTAL * 8.0 * (nb + 4));
  } else {
    double *h = weight + MEAN_TOTAL;
    mean_points(c, t, triangle, triangle + MEAN_TOTAL, mu, weight);
    struct rad_point_list list = {MEAN_TOTAL, triangle, triangle + MEAN_TOTAL,
                                  (const double(*)[2])mu};
    code = rad_irradiance_at(c->mesh, &c->rules, c->visibility.sight, &list, nb, c->u, h, e);
    for (int b = 0; b < nb && !code; b++) {
      irradiance[t * nb + b] = 0;
      for (int q = 0; q < MEAN_TOTAL; q++)
        irradiance[t * nb + b] += weight[q] * h[q * nb + b];
    }
  }
  free(triangle);
  free(mu);
  free(weight);
  return code;
}

enum rad_code rad_case_means(const struct rad_case *c, double *radiosity, double *irradiance,
                             struct rad_error *err) {
  int nb = c->scene.n_band;
  memset(radiosity, 0, sizeof(double) * (size_t)(c->scene.n_triangle * nb));
  memset(irradiance, 0, sizeof(double) * (size_t)(c->scene.n_triangle * nb));
  for (int i = 0; i < c->mesh->n_element; i++) {
    const struct rad_element *e = &c->mesh->element[i];
    int t = rad_element_triangle(c->mesh, i);
    double weight[RAD_GAUSS_MAX * RAD_GAUSS_MAX];
    element_weights(c, i, weight);
    for (int b = 0; b < nb; b++)
      for (int f = 0; f < e->n_function; f++) {
        size_t at = (size_t)b * c->mesh->n_point + e->first + f;
        radiosity[t * nb + b] += weight[f] * c->u[at] / c->scene.triangle[t].area;
        irradiance[t * nb + b] += weight[f] * c->h[at] / c->scene.triangle[t].area;
      }
  }
  enum rad_code code = RAD_OK;
  for (int t = 0; t < c->scene.n_triangle && c->is_adaptive && !code; t++)
    if (c->adaptive.layout.passive[t])
      code = passive_mean(c, t, irradiance, err);
  return code;
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
  size_t means = (size_t)c->scene.n_triangle * (size_t)c->scene.n_band;
  *r = (struct rad_result){.deck = &c->deck,
                           .scene = &c->scene,
                           .command = command,
                           .matrix =
                               c->plan.system.matrix == RAD_MATRIX_DENSE ? "dense" : "hierarchical",
                           .solver = solver_name(c->report.solver),
                           .threads = omp_get_max_threads(),
                           .edge_exponent = exponents(c->adaptive.layout.exponents.beta),
                           .vertex_exponent = exponents(c->adaptive.layout.exponents.alpha),
                           .triangle_radiosity = rad_alloc(means, sizeof(double)),
                           .triangle_irradiance = rad_alloc(means, sizeof(double))};
  if (!r->triangle_radiosity || !r->triangle_irradiance)
    return rad_fail_memory(e, "the result", 16.0 * (double)means);
  rad_progress_phase(c->scene.progress, "means and picture");
  enum rad_code code = rad_case_means(c, r->triangle_radiosity, r->triangle_irradiance, e);
  if (!code)
    code = rad_case_picture(c, &r->picture, e);
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
