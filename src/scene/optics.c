#include "scene/optics.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "scene/heat.h"

enum rad_code rad_optics_begin(struct rad_scene *s, struct rad_error *e) {
  size_t n = (size_t)s->n_triangle, n_band = (size_t)s->n_band;
  s->rho = rad_calloc(n * n_band, sizeof *s->rho);
  s->emission = rad_calloc(3 * n * n_band, sizeof *s->emission);
  return s->rho && s->emission ? RAD_OK
                               : rad_fail_memory(e, "the scene", 32.0 * (double)(n * n_band));
}

static int has_surface(const struct rad_deck_optics *o) {
  return o->has_rho || o->has_emissivity;
}

static int has_source(const struct rad_deck_optics *o) {
  return o->has_emission || o->has_temperature || o->has_flux;
}

static const char *source_name(const struct rad_deck_optics *o) {
  return o->has_emission ? "emission" : o->has_temperature ? "temperature" : "flux";
}

static enum rad_code fail_missing(const struct rad_checked *c, int t,
                                  const struct rad_deck_optics *reflects,
                                  const struct rad_deck_optics *radiates, struct rad_error *e) {
  const struct rad_scene *s = c->scene;
  const char *name = s->surface_name[s->triangle[t].surface];
  const char *what = has_surface(reflects)
                         ? reflects->has_rho ? "emission" : "temperature (or flux)"
                     : radiates->has_temperature || radiates->has_flux ? "emissivity"
                                                                       : "rho";
  const char *key = what[0] == 't' ? "temperature" : what;
  if (c->number[t] <= c->n_deck)
    return rad_check_fail(c, t, e, "no %s; give %s here or in scene.surfaces.%s", what, key, name);
  return rad_check_fail(c, t, e, "no %s; give scene.surfaces.%s.%s in %s", what, name, key,
                        c->path);
}

static enum rad_code set_heat(const struct rad_checked *c, int t,
                              const struct rad_deck_optics *reflects,
                              const struct rad_deck_optics *radiates, struct rad_scene *s,
                              struct rad_error *e) {
  if (!s->heat && !(s->heat = rad_calloc((size_t)s->n_triangle, sizeof *s->heat)))
    return rad_fail_memory(e, "the scene", (double)s->n_triangle * sizeof *s->heat);
  struct rad_heat *h = &s->heat[t];
  *h = (struct rad_heat){radiates->has_flux ? RAD_HEAT_FLUX : RAD_HEAT_TEMPERATURE,
                         reflects->emissivity, radiates->temperature, radiates->flux};
  if (h->kind == RAD_HEAT_FLUX && h->emissivity == 0)
    return rad_check_fail(c, t, e,
                          "emissivity is 0, so no temperature can give its flux; give a number "
                          "above 0, at most 1");
  s->rho[t] = rad_heat_rho(h);
  for (int m = 0; m < 3; m++)
    s->emission[3 * t + m] = rad_heat_emission(h);
  return RAD_OK;
}

enum rad_code rad_optics_set(const struct rad_checked *c, int t, const struct rad_deck_optics *own,
                             const struct rad_deck_optics *shared, struct rad_scene *s,
                             struct rad_error *e) {
  const struct rad_deck_optics *reflects = has_surface(own) || !shared ? own : shared;
  const struct rad_deck_optics *radiates = has_source(own) || !shared ? own : shared;
  if (!has_surface(reflects) || !has_source(radiates))
    return fail_missing(c, t, reflects, radiates, e);
  if (reflects->has_rho != radiates->has_emission)
    return rad_check_fail(c, t, e,
                          "'%s' here and '%s' in scene.surfaces.%s exclude each other; give rho "
                          "and emission, or emissivity and temperature, or emissivity and flux",
                          reflects == own ? reflects->has_rho ? "rho" : "emissivity"
                                          : source_name(radiates),
                          reflects == own     ? source_name(radiates)
                          : reflects->has_rho ? "rho"
                                              : "emissivity",
                          s->surface_name[s->triangle[t].surface]);
  if (!reflects->has_rho)
    return set_heat(c, t, reflects, radiates, s, e);
  size_t n_band = (size_t)s->n_band;
  memcpy(s->rho + (size_t)t * n_band, reflects->rho, n_band * sizeof *s->rho);
  for (size_t m = 0; m < 3; m++)
    memcpy(s->emission + (3 * (size_t)t + m) * n_band, radiates->emission[m],
           n_band * sizeof *s->emission);
  return RAD_OK;
}
