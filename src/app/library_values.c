/* The C library of include/polyrad.h: values of a solution, and view factors. */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/library.h"
#include "base/memory.h"
#include "output/thermal.h"

/* Points as the evaluation wants them, in three owned arrays. */
struct points {
  int *triangle, *base;
  double (*mu)[2];
  double *h;
};

static enum rad_code fail_point(polyrad *p, int i, const char *what, int triangle) {
  return rad_fail(&p->error, RAD_EINPUT, "point %d %s triangle %d; correct it", i + 1, what,
                  triangle + 1);
}

/* Barycentric coordinates if `weighted`, else positions. */
static enum rad_code locate(polyrad *p, int n, const int *triangle, const double *at, int weighted,
                            struct points *points) {
  for (int i = 0; i < n; i++, at += 3) {
    struct rad_place place;
    if (triangle[i] < 0 || triangle[i] >= p->run.scene.n_triangle)
      return rad_fail(&p->error, RAD_EINPUT,
                      "point %d has the triangle index %d; give one of 0 to %d", i + 1, triangle[i],
                      p->run.scene.n_triangle - 1);
    if (!isfinite(at[0]) || !isfinite(at[1]) || !isfinite(at[2]))
      return fail_point(p, i, "has a coordinate that is not finite, on", triangle[i]);
    if (weighted && !(fabs(at[0] + at[1] + at[2] - 1) <= RAD_OFF))
      return fail_point(p, i, "has barycentric coordinates whose sum is not 1, on", triangle[i]);
    place = weighted ? rad_place_weighted(triangle[i], at)
                     : rad_place_in(&p->run.scene, triangle[i], at);
    if (!(place.off <= RAD_OFF))
      return fail_point(p, i, "does not lie on", triangle[i]);
    points->triangle[i] = place.triangle;
    points->base[i] = place.base;
    memcpy(points->mu[i], place.mu, sizeof place.mu);
  }
  return RAD_OK;
}

static enum rad_code evaluate(polyrad *p, int n, const int *triangle, const double *at,
                              int weighted, double *radiosity, double *irradiance) {
  struct rad_case *c = &p->run;
  size_t total = (size_t)n * (size_t)c->scene.n_band;
  struct points s = {rad_alloc((size_t)n, sizeof(int)), rad_alloc((size_t)n, sizeof(int)),
                     rad_alloc((size_t)n, sizeof *s.mu), rad_alloc(total, sizeof(double))};
  enum rad_code code = RAD_OK;
  if (!s.triangle || !s.base || !s.mu || !s.h)
    code = rad_fail_memory(&p->error, "the points", 24.0 * n + 8.0 * (double)total);
  if (!code)
    code = locate(p, n, triangle, at, weighted, &s);
  struct rad_point_list list = {n, s.triangle, s.base, (const double(*)[2])s.mu};
  if (!code)
    code = rad_irradiance_at(c->mesh, &c->rules, &list, c->scene.n_band, c->u, s.h, &p->error);
  if (!code && irradiance)
    memcpy(irradiance, s.h, total * sizeof(double));
  if (!code && radiosity)
    rad_iterated(&c->scene, &list, s.h, radiosity);
  free(s.triangle);
  free(s.base);
  free(s.mu);
  free(s.h);
  return code;
}

static polyrad_status evaluate_any(polyrad *p, int n, const int *triangle, const double *at,
                                   int weighted, double *radiosity, double *irradiance) {
  if (!p)
    return POLYRAD_INPUT;
  int before = rad_library_enter(p);
  enum rad_code code = rad_library_refuse_unsolved(p);
  if (!code && (n < 0 || n > INT_MAX / POLYRAD_MAX_BAND))
    code = rad_fail(&p->error, RAD_EINPUT, "n is %d; give 0 to %d points", n,
                    INT_MAX / POLYRAD_MAX_BAND);
  if (!code && n && (!triangle || !at))
    code = rad_library_fail_null(p, !triangle ? "triangle" : weighted ? "weight" : "position");
  if (!code && n)
    code = evaluate(p, n, triangle, at, weighted, radiosity, irradiance);
  return rad_library_leave(p, before, code);
}

polyrad_status polyrad_evaluate(polyrad *p, int n, const int *triangle, const double *weight,
                                double *radiosity, double *irradiance) {
  return evaluate_any(p, n, triangle, weight, 1, radiosity, irradiance);
}

polyrad_status polyrad_evaluate_at(polyrad *p, int n, const int *triangle, const double *position,
                                   double *radiosity, double *irradiance) {
  return evaluate_any(p, n, triangle, position, 0, radiosity, irradiance);
}

/* Rows of the scene's surfaces in the caller's order; nothing if `to` is NULL. */
static void to_caller(const polyrad *p, const double *row, int n_band, double *to) {
  for (int s = 0; s < p->n_surface && to; s++)
    for (int b = 0; b < n_band; b++)
      to[p->caller[s] * n_band + b] = row[s * n_band + b];
}

static enum rad_code means_of_surfaces(polyrad *p, int errors, double *radiosity,
                                       double *irradiance) {
  const struct rad_scene *s = &p->run.scene;
  struct rad_means m = {0};
  enum rad_code code = rad_means_of_surfaces(s, &p->run.means, &m, &p->error);
  if (!code) {
    to_caller(p, errors ? m.error_radiosity : m.radiosity, s->n_band, radiosity);
    to_caller(p, errors ? m.error_irradiance : m.irradiance, s->n_band, irradiance);
  }
  rad_means_free(&m);
  return code;
}

static polyrad_status means_or_errors(polyrad *p, int errors, double *radiosity,
                                      double *irradiance) {
  if (!p)
    return POLYRAD_INPUT;
  int before = rad_library_enter(p);
  enum rad_code code = rad_library_refuse_unsolved(p);
  if (!code)
    code = means_of_surfaces(p, errors, radiosity, irradiance);
  return rad_library_leave(p, before, code);
}

polyrad_status polyrad_surface_means(polyrad *p, double *radiosity, double *irradiance) {
  return means_or_errors(p, 0, radiosity, irradiance);
}

polyrad_status polyrad_surface_errors(polyrad *p, double *radiosity, double *irradiance) {
  return means_or_errors(p, 1, radiosity, irradiance);
}

/* Net fluxes and temperatures of the scene's surfaces, in the caller's order. */
static enum rad_code heat_of_surfaces(polyrad *p, double *net_flux, double *temperature) {
  struct rad_thermal heat = {0};
  enum rad_code code = rad_thermal_make(&p->run.scene, &p->run.means, &heat, &p->error);
  if (!code) {
    to_caller(p, heat.surface.flux, 1, net_flux);
    to_caller(p, heat.surface.temperature, 1, temperature);
  }
  rad_thermal_free(&heat);
  return code;
}

polyrad_status polyrad_surface_heat(polyrad *p, double *net_flux, double *temperature) {
  if (!p)
    return POLYRAD_INPUT;
  int before = rad_library_enter(p);
  enum rad_code code = rad_library_refuse_unsolved(p);
  if (!code && !p->run.scene.heat)
    code = rad_fail(&p->error, RAD_EINPUT,
                    "the scene has no emissivity; give emissivity and temperature or flux");
  if (!code)
    code = heat_of_surfaces(p, net_flux, temperature);
  return rad_library_leave(p, before, code);
}

polyrad_status polyrad_view_factors(polyrad *p, double tolerance, double *factor) {
  if (!p)
    return POLYRAD_INPUT;
  int before = rad_library_enter(p);
  struct rad_view_factors f = {0};
  enum rad_code code = factor ? RAD_OK : rad_library_fail_null(p, "factor");
  if (!code && !p->run.scene.visibility)
    code = rad_fail(&p->error, RAD_EINPUT, "there is no scene: polyrad_create has failed");
  if (!code && !(tolerance == 0 || (tolerance > 0 && tolerance < 1)))
    code = rad_fail(&p->error, RAD_EINPUT, "tolerance is %g; give a number from 0 to 1", tolerance);
  if (!code)
    code = rad_view_factors(&p->run.scene, tolerance > 0 ? tolerance : 1e-6, 0, &f, &p->error);
  size_t n = (size_t)p->n_surface;
  for (size_t s = 0; s < n && !code; s++)
    for (size_t t = 0; t < n; t++)
      factor[(size_t)p->caller[s] * n + (size_t)p->caller[t]] = f.matrix[s * n + t];
  if (!code && !f.converged)
    code = rad_fail(&p->error, RAD_ENUMERIC, "the view factors have an error of %.2e: %s",
                    f.worst_error, f.reason);
  rad_view_factors_free(&f);
  return rad_library_leave(p, before, code);
}
