/* Values at points of the picture. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/picture.h"
#include "base/memory.h"

enum rad_code rad_canvas_begin(const struct rad_case *c, struct rad_canvas *canvas,
                               struct rad_error *e) {
  int nb = c->scene.n_band;
  const double *in[2 * RAD_MAX_BAND];
  *canvas = (struct rad_canvas){.c = c, .width = 2 * nb + 1};
  canvas->is_dark = c->has_bound && rad_indicator_scale(&c->adaptive.indicator, nb) == 0;
  if (!c->has_bound || canvas->is_dark)
    return RAD_OK;
  for (int b = 0; b < nb; b++) {
    in[b] = c->u + (size_t)b * (size_t)c->mesh->n_point;
    in[nb + b] = c->adaptive.z + (size_t)b * (size_t)c->mesh->n_point;
  }
  enum rad_code code =
      rad_once_begin(c->mesh, &c->rules, RAD_ONCE_LEAF, c->rules.tolerance, &canvas->once, e);
  return code ? code : rad_once_gather(&canvas->once, 2 * nb, in, e);
}

void rad_canvas_free(struct rad_canvas *canvas) {
  rad_once_free(&canvas->once);
  free(canvas->dot);
  free(canvas->value);
  free(canvas->tile);
  free(canvas->sample);
  *canvas = (struct rad_canvas){0};
}

int64_t rad_canvas_add(struct rad_canvas *p, int element, double sigma, double tau) {
  size_t n = (size_t)p->n_dot + 1;
  if (!rad_reserve((void **)&p->dot, n, &p->room_dot, sizeof *p->dot) ||
      !rad_reserve((void **)&p->value, n * (size_t)p->width, &p->room_value, sizeof(double)))
    return -1;
  p->dot[p->n_dot] = (struct rad_dot){element, sigma, tau};
  return p->n_dot++;
}

/* Where a dot is evaluated, from the vertex that weighs most. Patches that start at a vertex are
 * exact there and along their edge, however near; elsewhere what is as small as rounding is on an
 * edge. */
static void set_site(const struct rad_case *c, const struct rad_dot *dot, int *base, double mu[2]) {
  const struct rad_element *el = &c->mesh->element[dot->element];
  const struct rad_patch *patch = &c->mesh->patch[el->patch];
  double phi = pow(dot->sigma, el->p_phi), r = pow(dot->tau, el->p_r), weight[3];
  rad_patch_mu(patch, phi > 0 ? phi : RAD_LIMIT, r > 0 ? r : RAD_LIMIT, mu);
  *base = patch->base;
  weight[patch->base] = 1 - mu[0] - mu[1];
  weight[(patch->base + 1) % 3] = mu[0];
  weight[(patch->base + 2) % 3] = mu[1];
  if (patch->corner >= 0 && weight[patch->base] >= fmax(mu[0], mu[1]) * (1 - 1e-14)) {
    rad_place_limit(mu);
  } else {
    struct rad_place place = rad_place_weighted(patch->triangle, weight);
    *base = place.base;
    memcpy(mu, place.mu, sizeof place.mu);
  }
}

/* u_h, and h of the collocation points, by the trial functions. */
static void interpolate(const struct rad_case *c, const struct rad_dot *dot, double *value) {
  const struct rad_element *el = &c->mesh->element[dot->element];
  double basis[RAD_GAUSS_MAX * RAD_GAUSS_MAX];
  int nb = c->scene.n_band;
  rad_element_basis(c->mesh, dot->element, pow(dot->sigma, el->p_phi), pow(dot->tau, el->p_r),
                    basis);
  for (int b = 0; b < nb; b++) {
    const double *u = c->u + (size_t)b * (size_t)c->mesh->n_point + el->first;
    const double *h = c->h + (size_t)b * (size_t)c->mesh->n_point + el->first;
    double su = 0, sh = 0;
    for (int f = 0; f < el->n_function; f++) {
      su += basis[f] * u[f];
      sh += basis[f] * h[f];
    }
    value[b] = sh;
    value[nb + b] = su;
  }
  value[2 * nb] = NAN;
}

/* Some dots as the evaluation wants them. */
struct sites {
  int *first, *count; /* owned [n_element] */
  int *base;          /* owned [n] */
  double (*mu)[2];    /* owned [n] */
  double *y;          /* owned [2 n_band, n]: h, then K z */
};

static void sites_free(struct sites *s) {
  free(s->first);
  free(s->base);
  free(s->mu);
  free(s->y);
}

static enum rad_code sites_make(const struct rad_canvas *p, int64_t from, struct sites *s,
                                struct rad_error *e) {
  const struct rad_case *c = p->c;
  size_t n = (size_t)(p->n_dot - from), n_element = (size_t)c->mesh->n_element;
  *s = (struct sites){.first = rad_calloc(2 * n_element, sizeof(int)),
                      .base = rad_alloc(n, sizeof(int)),
                      .mu = rad_alloc(n, sizeof *s->mu),
                      .y = rad_alloc(n * 2 * (size_t)c->scene.n_band, sizeof(double))};
  if (!s->first || !s->base || !s->mu || !s->y)
    return rad_fail_memory(e, "the picture (output.sampling)",
                           (double)n * (20 + 16.0 * c->scene.n_band));
  s->count = s->first + n_element;
  for (int i = 0; i < (int)n; i++) {
    const struct rad_dot *dot = &p->dot[from + i];
    if (s->count[dot->element]++ == 0)
      s->first[dot->element] = i;
    set_site(c, dot, &s->base[i], s->mu[i]);
  }
  return RAD_OK;
}

/* u* = E + rho h, and the bound g + rho K z of its error (theory 6.2), the worst band. */
static enum rad_code take(struct rad_canvas *p, int64_t from, const struct sites *s,
                          struct rad_error *e) {
  const struct rad_case *c = p->c;
  size_t n = (size_t)(p->n_dot - from);
  int nb = c->scene.n_band;
  double unit = rad_indicator_scale(&c->adaptive.indicator, nb);
  for (size_t i = 0; i < n; i++) {
    const struct rad_dot *dot = &p->dot[from + (int64_t)i];
    int t = rad_element_triangle(c->mesh, dot->element);
    double *value = p->value + ((size_t)from + i) * (size_t)p->width, more = 0;
    for (int b = 0; b < nb; b++) {
      double rho = c->scene.rho[t * nb + b], h = s->y[(size_t)b * n + i];
      if (!isfinite(h))
        return rad_fail_integral(&c->scene, t, e);
      value[b] = h;
      value[nb + b] = rad_emission(&c->scene, t, b, s->base[i], s->mu[i]) + rho * h;
      more = fmax(more, rho * s->y[(size_t)(nb + b) * n + i]);
    }
    value[2 * nb] = (c->adaptive.source[dot->element] + more) * unit;
  }
  return RAD_OK;
}

enum rad_code rad_canvas_evaluate(struct rad_canvas *p, int64_t from, struct rad_error *e) {
  const struct rad_case *c = p->c;
  double *y[2 * RAD_MAX_BAND];
  struct sites s;
  size_t n = (size_t)(p->n_dot - from);
  if (!c->has_bound) {
    for (int64_t i = from; i < p->n_dot; i++)
      interpolate(c, &p->dot[i], p->value + (size_t)i * (size_t)p->width);
    return RAD_OK;
  }
  if (p->is_dark) {
    memset(p->value + (size_t)from * (size_t)p->width, 0, sizeof(double) * n * (size_t)p->width);
    return RAD_OK;
  }
  enum rad_code code = sites_make(p, from, &s, e);
  for (int v = 0; v < 2 * c->scene.n_band && !code; v++)
    y[v] = s.y + (size_t)v * n;
  struct rad_element_points points = {s.first, s.count, s.base, (const double(*)[2])s.mu};
  if (!code)
    code = rad_once_at(&p->once, &points, 2 * c->scene.n_band, y, NULL, NULL, e);
  if (!code)
    code = take(p, from, &s, e);
  sites_free(&s);
  return code;
}
