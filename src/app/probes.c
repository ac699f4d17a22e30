/* Sensors: where they are in the scene, and u* and the irradiance there. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/case.h"
#include "base/memory.h"
#include "base/vec.h"
#include "estimate/checks.h"
#include "scene/heat.h"

/* A weight below this is rounding: the point is on the edge. */
#define ON_EDGE 1e-12

/* Part of a point's way along an edge that it is moved by. Ends of elements of the next face lie
 * exactly there where points are asked for, and each of the two elements that meet in one sees it
 * displaced by its own rounding, 1e-16, which must not matter; what light changes on the way does
 * not. */
#define ASIDE 1e-13

void rad_place_limit(double mu[2]) {
  for (int d = 0; d < 2; d++)
    mu[d] = fmax(mu[d], RAD_LIMIT);
  for (int d = 0; d < 2; d++)
    if (mu[d] <= RAD_LIMIT && mu[!d] > RAD_LIMIT)
      mu[!d] *= 1 - ASIDE;
}

struct rad_place rad_place_weighted(int triangle, const double weight[3]) {
  struct rad_place p = {.triangle = triangle};
  for (int c = 0; c < 3; c++) {
    p.base = weight[c] > weight[p.base] ? c : p.base;
    p.off = fmax(p.off, -weight[c]);
  }
  for (int d = 0; d < 2; d++) {
    double w = weight[(p.base + 1 + d) % 3];
    p.mu[d] = w > ON_EDGE ? w : 0;
  }
  rad_place_limit(p.mu);
  return p;
}

struct rad_place rad_place_in(const struct rad_scene *scene, int triangle, const double at[3]) {
  const struct rad_triangle *t = &scene->triangle[triangle];
  double off[3], weight[3];
  rad_triangle_weights(t, at, weight);
  struct rad_place p = rad_place_weighted(triangle, weight);
  rad_sub(at, t->v[p.base], off);
  p.off = fmax(fabs(rad_dot(off, t->normal)) / sqrt(2 * t->area), p.off);
  return p;
}

static enum rad_code locate(const struct rad_case *c, const struct rad_deck_probe *probe,
                            struct rad_place *best, struct rad_error *e) {
  best->off = INFINITY;
  for (int t = 0; t < c->scene.n_triangle; t++) {
    const char *name = c->scene.surface_name[c->scene.triangle[t].surface];
    if (probe->surface && strcmp(probe->surface, name))
      continue;
    struct rad_place p = rad_place_in(&c->scene, t, probe->at);
    if (p.off < best->off)
      *best = p;
  }
  if (best->off <= RAD_OFF)
    return RAD_OK;
  const char *where = probe->surface ? probe->surface : "any surface";
  char line[32] = "";
  if (probe->line)
    snprintf(line, sizeof line, "%d:", probe->line);
  if (best->off == INFINITY)
    return rad_fail(e, RAD_EINPUT,
                    "%s:%s error: probe %s names the surface '%s', which does not exist; correct "
                    "the name or leave it out",
                    c->deck.path, line, probe->name, where);
  return rad_fail(
      e, RAD_EINPUT,
      "%s:%s error: probe %s at (%g, %g, %g) does not lie on %s; move it onto a triangle",
      c->deck.path, line, probe->name, probe->at[0], probe->at[1], probe->at[2], where);
}

/* Places of all probes, or only whether they have one when place is NULL. */
static enum rad_code locate_all(const struct rad_case *c, struct rad_place *place,
                                struct rad_error *e) {
  enum rad_code code = RAD_OK;
  struct rad_place unused;
  for (int i = 0; i < c->deck.n_probe && !code; i++)
    code = locate(c, &c->deck.probe[i], place ? &place[i] : &unused, e);
  return code;
}

enum rad_code rad_case_check_probes(const struct rad_case *c, struct rad_error *e) {
  return locate_all(c, NULL, e);
}

/* What h lacks at a point beside K z, over the band's scale. Where a mesh has no limits at edges,
 * nothing is known of them. */
static double light_source(const struct rad_case *c, const struct rad_point_list *list, int i,
                           int band) {
  const struct rad_mesh *mesh = c->mesh;
  const double *mu = list->mu[i];
  int first = mesh->patch_first[list->triangle[i]];
  int n = mesh->patch_first[list->triangle[i] + 1] - first;
  double phi, r;
  int patch = first + rad_patch_locate(&mesh->patch[first], n, list->base[i], mu, &phi, &r);
  if (mesh->patch[patch].corner < 0 && fmin(fmin(mu[0], mu[1]), 1 - mu[0] - mu[1]) < RAD_NEAREST)
    return INFINITY;
  return c->adaptive.light_source[rad_mesh_locate(mesh, patch, phi, r) * c->scene.n_band + band];
}

/* |h - K u_h| <= |K d| + K z (theory 6.11); NaN where the run has no bound. */
static enum rad_code set_errors(const struct rad_case *c, const struct rad_point_list *list,
                                struct rad_result *r, struct rad_error *e) {
  int nb = c->scene.n_band;
  double *error = r->probe_error_irradiance =
      rad_alloc((size_t)list->n * (size_t)nb, sizeof(double));
  if (!error)
    return rad_fail_memory(e, "the probes", 8.0 * list->n * nb);
  for (int i = 0; i < list->n * nb; i++)
    error[i] = NAN;
  if (!c->has_bound || list->n == 0)
    return RAD_OK;
  enum rad_code code = rad_irradiance_at(c->mesh, &c->rules, list, nb, c->adaptive.z, error, e);
  for (int i = 0; i < list->n && !code; i++)
    for (int b = 0; b < nb; b++)
      error[i * nb + b] =
          c->adaptive.indicator.scale[b] * (light_source(c, list, i, b) + error[i * nb + b]);
  return code;
}

enum rad_code rad_case_probes(const struct rad_case *c, struct rad_result *r, struct rad_error *e) {
  size_t n = (size_t)c->deck.n_probe, nb = (size_t)c->scene.n_band;
  struct rad_place *place = rad_alloc(n, sizeof *place);
  int *triangle = rad_alloc(n, 2 * sizeof(int)), *base = triangle + n;
  double(*mu)[2] = rad_alloc(n, sizeof *mu);
  r->probe_position = rad_alloc(n, 3 * sizeof(double));
  r->probe_normal = rad_alloc(n, 3 * sizeof(double));
  r->probe_radiosity = rad_alloc(n * nb, sizeof(double));
  r->probe_irradiance = rad_alloc(n * nb, sizeof(double));
  r->probe_flux = rad_alloc(n, sizeof(double));
  r->probe_temperature = rad_alloc(n, sizeof(double));
  enum rad_code code = RAD_OK;
  if (!place || !triangle || !mu || !r->probe_position || !r->probe_normal || !r->probe_radiosity ||
      !r->probe_irradiance || !r->probe_flux || !r->probe_temperature)
    code = rad_fail_memory(e, "the probes", 100.0 * (double)n);
  else
    code = locate_all(c, place, e);
  for (size_t i = 0; i < n && !code; i++) {
    triangle[i] = place[i].triangle;
    base[i] = place[i].base;
    memcpy(mu[i], place[i].mu, sizeof mu[i]);
    memcpy(r->probe_position + 3 * i, c->deck.probe[i].at, 3 * sizeof(double));
    memcpy(r->probe_normal + 3 * i, c->scene.triangle[place[i].triangle].normal,
           3 * sizeof(double));
  }
  struct rad_point_list list = {(int)n, triangle, base, (const double(*)[2])mu};
  if (!code && n)
    code = rad_irradiance_at(c->mesh, &c->rules, &list, (int)nb, c->u, r->probe_irradiance, e);
  if (!code)
    code = set_errors(c, &list, r, e);
  if (!code)
    rad_iterated(&c->scene, &list, r->probe_irradiance, r->probe_radiosity);
  for (size_t i = 0; i < n && !code && c->scene.heat; i++) {
    const struct rad_heat *heat = &c->scene.heat[triangle[i]];
    r->probe_flux[i] = r->probe_radiosity[i] - r->probe_irradiance[i];
    r->probe_temperature[i] =
        rad_heat_temperature(rad_heat_fourth_power(heat, r->probe_irradiance[i]));
  }
  free(place);
  free(triangle);
  free(mu);
  return code;
}
