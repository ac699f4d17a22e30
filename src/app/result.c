/* From a solved case to the arrays of its result file. */
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "app/case.h"
#include "base/memory.h"
#include "base/vec.h"

/* Position and values at one point of the picture. */
static void picture_point(const struct rad_case *c, int element, double phi, double r, int64_t at,
                          struct rad_picture *p) {
  const struct rad_element *e = &c->mesh.element[element];
  const struct rad_patch *patch = &c->mesh.patch[e->patch];
  double mu[2], value[RAD_GAUSS_MAX * RAD_GAUSS_MAX];
  rad_patch_mu(patch, phi, r, mu);
  rad_triangle_point(&c->scene.triangle[patch->triangle], patch->base, mu, p->point + 3 * at);
  rad_element_basis(&c->mesh, element, phi, r, value);
  int nb = c->scene.n_band;
  for (int b = 0; b < nb; b++) {
    const double *u = c->u + (size_t)b * c->mesh.n_point + e->first;
    const double *h = c->h + (size_t)b * c->mesh.n_point + e->first;
    double su = 0, sh = 0;
    for (int f = 0; f < e->n_function; f++) {
      su += value[f] * u[f];
      sh += value[f] * h[f];
    }
    p->radiosity[at * nb + b] = su;
    p->irradiance[at * nb + b] = sh;
  }
}

/* The cells of one element: s x s in its graded variables; those at r = 0 are triangles. */
static void picture_element(const struct rad_case *c, int element, int s, struct rad_picture *p) {
  const struct rad_element *e = &c->mesh.element[element];
  int64_t first = (int64_t)element * (s + 1) * (s + 1);
  for (int j = 0; j <= s; j++)
    for (int i = 0; i <= s; i++) {
      double sigma = e->sigma[0] + (e->sigma[1] - e->sigma[0]) * i / s;
      double tau = e->tau[0] + (e->tau[1] - e->tau[0]) * j / s;
      picture_point(c, element, pow(sigma, e->p_phi), pow(tau, e->p_r), first + j * (s + 1) + i, p);
    }
  for (int j = 0; j < s; j++)
    for (int i = 0; i < s; i++) {
      int64_t corner = first + j * (s + 1) + i, *list = p->connectivity + p->offset[p->n_cell];
      int tip = j == 0 && e->tau[0] == 0, n = 0;
      list[n++] = corner;
      if (!tip)
        list[n++] = corner + 1;
      list[n++] = corner + s + 2;
      list[n++] = corner + s + 1;
      p->type[p->n_cell] = tip ? 5 : 9;
      p->triangle[p->n_cell] = rad_element_triangle(&c->mesh, element);
      p->n_cell++;
      p->offset[p->n_cell] = p->offset[p->n_cell - 1] + n;
    }
}

enum rad_code rad_case_picture(const struct rad_case *c, struct rad_picture *p,
                               struct rad_error *e) {
  size_t s = (size_t)c->deck.output.sampling, n = (size_t)c->mesh.n_element;
  size_t points = n * (s + 1) * (s + 1), cells = n * s * s, nb = (size_t)c->scene.n_band;
  *p = (struct rad_picture){.n_point = (int64_t)points,
                            .point = rad_alloc(points, 3 * sizeof(double)),
                            .connectivity = rad_alloc(cells, 4 * sizeof(int64_t)),
                            .offset = rad_calloc(cells + 1, sizeof(int64_t)),
                            .type = rad_alloc(cells, 1),
                            .triangle = rad_alloc(cells, sizeof(int)),
                            .radiosity = rad_alloc(points * nb, sizeof(double)),
                            .irradiance = rad_alloc(points * nb, sizeof(double))};
  if (!p->point || !p->connectivity || !p->offset || !p->type || !p->triangle || !p->radiosity ||
      !p->irradiance)
    return rad_fail_memory(e, "the picture (output.sampling)",
                           (double)points * (24 + 16.0 * (double)nb));
  for (int i = 0; i < c->mesh.n_element; i++)
    picture_element(c, i, (int)s, p);
  return RAD_OK;
}

/* int L_b dS of one element's trial functions, from the finest rules. */
static void element_weights(const struct rad_case *c, int element, double *weight) {
  const struct rad_element *e = &c->mesh.element[element];
  const struct rad_patch *patch = &c->mesh.patch[e->patch];
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

enum rad_code rad_case_means(const struct rad_case *c, double *radiosity, double *irradiance,
                             struct rad_error *err) {
  (void)err;
  int nb = c->scene.n_band;
  memset(radiosity, 0, sizeof(double) * (size_t)(c->scene.n_triangle * nb));
  memset(irradiance, 0, sizeof(double) * (size_t)(c->scene.n_triangle * nb));
  for (int i = 0; i < c->mesh.n_element; i++) {
    const struct rad_element *e = &c->mesh.element[i];
    int t = rad_element_triangle(&c->mesh, i);
    double weight[RAD_GAUSS_MAX * RAD_GAUSS_MAX];
    element_weights(c, i, weight);
    for (int b = 0; b < nb; b++)
      for (int f = 0; f < e->n_function; f++) {
        size_t at = (size_t)b * c->mesh.n_point + e->first + f;
        radiosity[t * nb + b] += weight[f] * c->u[at] / c->scene.triangle[t].area;
        irradiance[t * nb + b] += weight[f] * c->h[at] / c->scene.triangle[t].area;
      }
  }
  return RAD_OK;
}

static enum rad_code set_points(const struct rad_case *c, struct rad_result *r,
                                struct rad_error *e) {
  size_t n = (size_t)c->mesh.n_point, nb = (size_t)c->scene.n_band;
  r->n_point = c->mesh.n_point;
  r->point = rad_alloc(n, 3 * sizeof(double));
  r->point_triangle = rad_alloc(n, sizeof(int));
  r->value = rad_alloc(n * nb, sizeof(double));
  if (!r->point || !r->point_triangle || !r->value)
    return rad_fail_memory(e, "the result", (double)n * (28 + 8.0 * (double)nb));
  for (int t = 0; t < c->scene.n_triangle; t++)
    for (int i = c->mesh.point_first[t]; i < c->mesh.point_first[t + 1]; i++) {
      rad_triangle_point(&c->scene.triangle[t], c->mesh.point_base[i], c->mesh.point_mu[i],
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

static void set_diagnostics(const struct rad_case *c, struct rad_diagnostics *d) {
  *d = (struct rad_diagnostics){.unknowns = c->mesh.n_point,
                                .elements = c->mesh.n_element,
                                .kappa = c->report.kappa,
                                .error_indicator = NAN,
                                .error_bound = NAN,
                                .residual = c->report.residual,
                                .iterations = c->report.iterations,
                                .condition_estimate = c->report.condition_estimate,
                                .converged = c->report.converged,
                                .matrix_bytes = c->plan.matrix_bytes,
                                .peak_memory_bytes = rad_memory_peak(),
                                .kernel_values = c->dense.counters.kernel_values,
                                .pairs_near = c->dense.counters.near,
                                .pairs_far = c->dense.counters.far,
                                .pairs_skipped = c->dense.pairs_skipped,
                                .seconds_scene = c->seconds_scene,
                                .seconds_mesh = c->seconds_mesh,
                                .seconds_assemble = c->seconds_assemble,
                                .seconds_factor = c->report.seconds_factor,
                                .seconds_solve = c->report.seconds_solve};
}

enum rad_code rad_case_result(const struct rad_case *c, const char *command, struct rad_result *r,
                              struct rad_error *e) {
  size_t means = (size_t)c->scene.n_triangle * (size_t)c->scene.n_band;
  *r = (struct rad_result){.deck = &c->deck,
                           .scene = &c->scene,
                           .command = command,
                           .matrix = "dense",
                           .solver = solver_name(c->report.solver),
                           .threads = omp_get_max_threads(),
                           .triangle_radiosity = rad_alloc(means, sizeof(double)),
                           .triangle_irradiance = rad_alloc(means, sizeof(double))};
  if (!r->triangle_radiosity || !r->triangle_irradiance)
    return rad_fail_memory(e, "the result", 16.0 * (double)means);
  enum rad_code code = rad_case_means(c, r->triangle_radiosity, r->triangle_irradiance, e);
  if (!code)
    code = rad_case_picture(c, &r->picture, e);
  if (!code)
    code = set_points(c, r, e);
  if (!code)
    code = rad_case_probes(c, r, e);
  if (!code)
    set_diagnostics(c, &r->diagnostics);
  return code;
}
