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
    code = rad_irradiance_at(c->mesh, &c->rules, c->visibility.sight, &list, c->scene.n_band, c->u,
                             s.h, &p->error);
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

/* Area-weighted means of triangle means [n_triangle, n_band] over the caller's surfaces. */
static void mean_of_surfaces(const polyrad *p, const double *value, double *area, double *mean) {
  const struct rad_scene *s = &p->run.scene;
  size_t nb = (size_t)s->n_band, n = (size_t)p->n_surface;
  memset(area, 0, n * sizeof *area);
  memset(mean, 0, n * nb * sizeof *mean);
  for (int t = 0; t < s->n_triangle; t++) {
    size_t to = (size_t)p->caller[s->triangle[t].surface];
    area[to] += s->triangle[t].area;
    for (size_t b = 0; b < nb; b++)
      mean[to * nb + b] += s->triangle[t].area * value[(size_t)t * nb + b];
  }
  for (size_t i = 0; i < n * nb; i++)
    mean[i] /= area[i / nb];
}

polyrad_status polyrad_surface_means(polyrad *p, double *radiosity, double *irradiance) {
  if (!p)
    return POLYRAD_INPUT;
  int before = rad_library_enter(p);
  enum rad_code code = rad_library_refuse_unsolved(p);
  size_t n = (size_t)p->run.scene.n_triangle * (size_t)p->run.scene.n_band;
  double *u = rad_alloc(n, sizeof(double)), *h = rad_alloc(n, sizeof(double));
  double *area = rad_alloc((size_t)p->n_surface, sizeof(double));
  if (!code && (!u || !h || !area))
    code = rad_fail_memory(&p->error, "the means", 16.0 * (double)n);
  if (!code)
    code = rad_case_means(&p->run, u, h, &p->error);
  if (!code && radiosity)
    mean_of_surfaces(p, u, area, radiosity);
  if (!code && irradiance)
    mean_of_surfaces(p, h, area, irradiance);
  free(u);
  free(h);
  free(area);
  return rad_library_leave(p, before, code);
}

/* Net fluxes and temperatures of the scene's surfaces, in the caller's order. */
static enum rad_code heat_of_surfaces(polyrad *p, double *net_flux, double *temperature) {
  size_t n = (size_t)p->run.scene.n_triangle;
  struct rad_result r = {.scene = &p->run.scene,
                         .triangle_radiosity = rad_alloc(n, sizeof(double)),
                         .triangle_irradiance = rad_alloc(n, sizeof(double))};
  struct rad_thermal heat = {0};
  enum rad_code code = RAD_OK;
  if (!r.triangle_radiosity || !r.triangle_irradiance)
    code = rad_fail_memory(&p->error, "the net fluxes", 16.0 * (double)n);
  if (!code)
    code = rad_case_means(&p->run, r.triangle_radiosity, r.triangle_irradiance, &p->error);
  if (!code)
    code = rad_thermal_make(&r, &heat, &p->error);
  for (int s = 0; s < p->n_surface && !code; s++) {
    if (net_flux)
      net_flux[p->caller[s]] = heat.surface.flux[s];
    if (temperature)
      temperature[p->caller[s]] = heat.surface.temperature[s];
  }
  rad_thermal_free(&heat);
  rad_result_free(&r);
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
