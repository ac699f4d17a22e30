/* From the caller's arrays to a scene. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/library.h"
#include "base/memory.h"
#include "visibility/isolated.h"

/* Triangles of which n_triangle^2 is still a size that can be asked for. */
enum { MAX_TRIANGLE = 100000000 };

static int bands_of(const struct polyrad_scene *s) {
  return s->n_band ? s->n_band : 1;
}

static enum rad_code check_counts(const struct polyrad_scene *s, struct rad_error *e) {
  if (s->n_triangle < 1 || s->n_triangle > MAX_TRIANGLE || !s->triangle)
    return rad_fail(e, RAD_EINPUT, "the scene has %d triangles; give triangle and n_triangle",
                    s->triangle ? s->n_triangle : 0);
  if (s->n_vertex < 1 || !s->vertex)
    return rad_fail(e, RAD_EINPUT, "the scene has %d vertices; give vertex and n_vertex",
                    s->vertex ? s->n_vertex : 0);
  if (s->n_band < 0 || s->n_band > POLYRAD_MAX_BAND)
    return rad_fail(e, RAD_EINPUT, "n_band is %d; give 1 to %d bands, or 0 for one", s->n_band,
                    POLYRAD_MAX_BAND);
  if (s->n_surface < 0 || s->n_surface > s->n_triangle || !s->surface != !s->n_surface)
    return rad_fail(e, RAD_EINPUT,
                    "n_surface is %d and surface is %s; give both for 1 to %d surfaces, or neither",
                    s->n_surface, s->surface ? "given" : "NULL", s->n_triangle);
  if (s->surface_name && !s->surface)
    return rad_fail(e, RAD_EINPUT,
                    "surface_name is given, but no surface; give surface and n_surface with it");
  int given = !!s->emission + !!s->vertex_emission + !!s->emission_at;
  if (s->emissivity && (s->rho || given || bands_of(s) > 1))
    return rad_fail(e, RAD_EINPUT,
                    "emissivity is given, and so are rho, an emission or several bands; for heat "
                    "radiation give emissivity and temperature or flux only");
  if (!s->emissivity && (s->temperature || s->flux))
    return rad_fail(e, RAD_EINPUT, "temperature or flux is given; give emissivity with them");
  if (s->emissivity)
    return RAD_OK;
  if (!s->rho)
    return rad_fail(e, RAD_EINPUT, "rho is NULL; give it for every triangle and band");
  if (given != 1)
    return rad_fail(e, RAD_EINPUT,
                    "%d of emission, vertex_emission and emission_at are given; give one", given);
  return RAD_OK;
}

static enum rad_code check_indices(const struct polyrad_scene *s, struct rad_error *e) {
  for (int t = 0; t < s->n_triangle; t++) {
    for (int m = 0; m < 3; m++)
      if (s->triangle[3 * (size_t)t + m] < 0 || s->triangle[3 * (size_t)t + m] >= s->n_vertex)
        return rad_fail(e, RAD_EINPUT, "triangle %d has the vertex index %d; give one of 0 to %d",
                        t + 1, s->triangle[3 * (size_t)t + m], s->n_vertex - 1);
    if (s->surface && (s->surface[t] < 0 || s->surface[t] >= s->n_surface))
      return rad_fail(e, RAD_EINPUT, "triangle %d has the surface index %d; give one of 0 to %d",
                      t + 1, s->surface[t], s->n_surface - 1);
  }
  return RAD_OK;
}

/* Every triangle has a number in exactly one of temperature and flux; NaN is none. */
static enum rad_code check_heat(const struct polyrad_scene *s, struct rad_error *e) {
  for (int t = 0; t < s->n_triangle && s->emissivity; t++) {
    double temperature = s->temperature ? s->temperature[t] : NAN,
           flux = s->flux ? s->flux[t] : NAN;
    if (!(s->emissivity[t] >= 0 && s->emissivity[t] <= 1))
      return rad_fail(e, RAD_EINPUT, "triangle %d has the emissivity %g; give a number from 0 to 1",
                      t + 1, s->emissivity[t]);
    if (isnan(temperature) == isnan(flux) || isinf(flux) || isinf(temperature) || temperature < 0)
      return rad_fail(e, RAD_EINPUT,
                      "triangle %d has the temperature %g and the flux %g; give one of them, a "
                      "temperature of 0 or more or a finite flux, and NaN for the other",
                      t + 1, temperature, flux);
  }
  return RAD_OK;
}

static void copy_heat(const struct polyrad_scene *s, int t, struct rad_deck_optics *o) {
  o->has_flux = s->flux && !isnan(s->flux[t]);
  o->has_temperature = !o->has_flux;
  o->has_emissivity = true;
  o->emissivity = s->emissivity[t];
  o->flux = o->has_flux ? s->flux[t] : 0;
  o->temperature = o->has_flux ? 0 : s->temperature[t];
}

static enum rad_code copy_names(const struct polyrad_scene *s, polyrad *p) {
  struct rad_error *e = &p->error;
  int n = s->n_surface ? s->n_surface : 1;
  p->name = rad_calloc((size_t)n, sizeof *p->name);
  p->caller = rad_alloc((size_t)n, sizeof *p->caller);
  if (!p->name || !p->caller)
    return rad_fail_memory(e, "the surfaces", 12.0 * n);
  p->n_surface = n;
  for (int i = 0; i < n; i++) {
    char text[32];
    const char *name = text;
    snprintf(text, sizeof text, "surface_%d", i + 1);
    if (s->surface_name && s->n_surface && !(name = s->surface_name[i]))
      return rad_fail(e, RAD_EINPUT, "surface_name[%d] is NULL; give a name, or none at all", i);
    p->caller[i] = -1;
    if (!(p->name[i] = strdup(name)))
      return rad_fail_memory(e, "the surfaces", 100);
  }
  return RAD_OK;
}

/* The caller's triangle t as one of a deck. */
static void copy_triangle(const struct polyrad_scene *s, const polyrad *p, int t,
                          struct rad_deck_triangle *to) {
  size_t at = (size_t)t, nb = (size_t)bands_of(s);
  *to = (struct rad_deck_triangle){
      .name = p->name[s->surface ? s->surface[t] : 0],
      .optics = {.has_rho = !s->emissivity, .has_emission = !s->emissivity}};
  if (s->emissivity)
    copy_heat(s, t, &to->optics);
  else
    memcpy(to->optics.rho, s->rho + at * nb, nb * sizeof(double));
  for (size_t m = 0; m < 3; m++) {
    memcpy(to->vertex[m], s->vertex + 3 * (size_t)s->triangle[3 * at + m], 3 * sizeof(double));
    const double *emission = s->emission          ? s->emission + at * nb
                             : s->vertex_emission ? s->vertex_emission + (3 * at + m) * nb
                                                  : NULL;
    if (emission)
      memcpy(to->optics.emission[m], emission, nb * sizeof(double));
  }
}

/* The deck whose scene this is; its triangles borrow their names from p. */
static enum rad_code build(const struct polyrad_scene *s, polyrad *p) {
  char band[RAD_MAX_BAND][12]; /* any int */
  struct rad_deck deck = {.n_band = bands_of(s),
                          .n_triangle = s->n_triangle,
                          .triangle = rad_alloc((size_t)s->n_triangle, sizeof *deck.triangle)};
  if (!deck.triangle)
    return rad_fail_memory(&p->error, "the scene", (double)s->n_triangle * sizeof *deck.triangle);
  for (int b = 0; b < deck.n_band; b++) {
    snprintf(band[b], sizeof band[b], "%d", b + 1);
    deck.band[b] = band[b];
  }
  for (int t = 0; t < s->n_triangle; t++)
    copy_triangle(s, p, t, &deck.triangle[t]);
  enum rad_code code = rad_scene_build(&deck, &p->run.scene, &p->run.notes, &p->error);
  free(deck.triangle);
  return code;
}

/* The scene numbers names by their first triangles: find the caller's numbers. */
static enum rad_code find_callers(const struct polyrad_scene *s, polyrad *p) {
  const struct rad_scene *scene = &p->run.scene;
  for (int t = 0; t < scene->n_triangle; t++) {
    int mine = s->surface ? s->surface[t] : 0, *known = &p->caller[scene->triangle[t].surface];
    if (*known >= 0 && *known != mine)
      return rad_fail(&p->error, RAD_EINPUT,
                      "surfaces %d and %d have the same name, '%s'; give them different ones",
                      *known + 1, mine + 1, p->name[mine]);
    *known = mine;
  }
  if (scene->n_surface < p->n_surface)
    return rad_fail(&p->error, RAD_EINPUT,
                    "%d of the %d surfaces have no triangles; give them some or leave them out",
                    p->n_surface - scene->n_surface, p->n_surface);
  return RAD_OK;
}

enum rad_code rad_library_scene(const struct polyrad_scene *s, polyrad *p) {
  enum rad_code code = check_counts(s, &p->error);
  code = code ? code : check_indices(s, &p->error);
  code = code ? code : check_heat(s, &p->error);
  code = code ? code : copy_names(s, p);
  code = code ? code : build(s, p);
  code = code ? code : find_callers(s, p);
  if (!code && s->emission_at) {
    p->emission_at = s->emission_at;
    p->user = s->user;
    p->run.scene.emission_at = rad_library_emission;
    p->run.scene.emission_context = p;
  }
  code = code ? code : rad_visibility_build(&p->run.scene, &p->run.visibility, &p->error);
  return code ? code : rad_check_isolated(&p->run.scene, "scene", &p->run.notes, &p->error);
}

double rad_library_emission(void *context, int triangle, int band, int base, const double mu[2]) {
  polyrad *p = context;
  double x[3], weight[3];
  if (p->bad_triangle >= 0)
    return NAN;
  rad_triangle_point(&p->run.scene.triangle[triangle], base, mu, x);
  weight[base] = 1 - mu[0] - mu[1];
  weight[(base + 1) % 3] = mu[0];
  weight[(base + 2) % 3] = mu[1];
  double value = p->emission_at(x, triangle, weight, band, p->user);
  if (isfinite(value))
    return value;
  p->bad_triangle = triangle;
  p->bad_band = band;
  return NAN;
}

enum rad_code rad_library_judge(polyrad *p, enum rad_code code) {
  if (p->bad_triangle < 0)
    return code;
  code = rad_fail(
      &p->error, RAD_EINPUT, "emission_at is not finite on triangle %d (%s) in band %d; correct it",
      p->bad_triangle + 1,
      p->run.scene.surface_name[p->run.scene.triangle[p->bad_triangle].surface], p->bad_band + 1);
  p->bad_triangle = -1;
  return code;
}
