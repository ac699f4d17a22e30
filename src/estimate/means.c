#include "estimate/means.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "estimate/balance.h"
#include "estimate/bound.h"
#include "scene/enclosure.h"
#include "system/cluster.h"

/* Parts of the tolerance that the integrals of means may use up, at least and at most; between them
 * a part of what the bound leaves. */
#define INTEGRATION_LEAST 0.1
#define INTEGRATION_MOST 0.5
#define INTEGRATION_OF_REST 0.75

/* Pairs of elements and triangles up to which means without an error are integrated to a tolerance.
 * Beyond, they take the points that are exact for u, and about the time of the matrix. */
#define PLAIN_PAIRS 5e4

/* z is a bound: this part of the tolerance is exact enough for its own mean. */
#define BOUND_PART 0.1

void rad_means_free(struct rad_means *m) {
  free(m->radiosity);
  free(m->irradiance);
  free(m->error_radiosity);
  free(m->error_irradiance);
  free(m->integration);
  *m = (struct rad_means){0};
}

static enum rad_code allocate(int n_row, int n_band, struct rad_means *m, struct rad_error *e) {
  size_t n = (size_t)n_row * (size_t)n_band;
  double **list[] = {&m->radiosity, &m->irradiance, &m->error_radiosity, &m->error_irradiance,
                     &m->integration};
  *m = (struct rad_means){.n = n_row, .n_band = n_band, .worst = NAN};
  for (int i = 0; i < 5; i++)
    if (!(*list[i] = rad_calloc(n, sizeof(double))))
      return rad_fail_memory(e, "the means", 40.0 * (double)n);
  return RAD_OK;
}

/* Mean of E over a triangle, and how far two rules differ where E is a function. */
static double mean_emission(const struct rad_mesh *mesh, int t, int b, double *error) {
  const struct rad_scene *s = mesh->scene;
  const double *at = s->emission + ((size_t)t * 3) * (size_t)s->n_band + b;
  *error = 0;
  if (!s->emission_at)
    return (at[0] + at[s->n_band] + at[2 * s->n_band]) / 3;
  double mean[2] = {0, 0};
  for (int p = mesh->patch_first[t]; p < mesh->patch_first[t + 1]; p++)
    for (int i = mesh->element_first[p]; i < mesh->element_first[p + 1]; i++)
      for (int rule = 0; rule < 2; rule++) {
        struct rad_light light;
        struct rad_weights none = {.mesh = mesh};
        struct rad_light_cell cell = rad_light_cell_whole(mesh, i);
        rad_light_set(&none, &cell, mesh->element[i].k_r / 2 + 2 + 2 * rule, &light);
        for (int q = 0; q < light.senders.n; q++)
          mean[rule] += light.dS[q] / s->triangle[t].area *
                        rad_emission(s, t, b, light.senders.base[q], light.senders.mu[q]);
      }
  *error = fabs(mean[1] - mean[0]);
  return mean[1];
}

/* u = E + rho h of means. */
static void set_radiosity(const struct rad_mesh *mesh, struct rad_means *m) {
  for (int t = 0; t < m->n; t++)
    for (int b = 0; b < m->n_band; b++) {
      int i = t * m->n_band + b;
      double error, rho = mesh->scene->rho[i];
      m->radiosity[i] = mean_emission(mesh, t, b, &error) + rho * m->irradiance[i];
      m->error_radiosity[i] = error + rho * m->error_irradiance[i];
    }
}

static void set_irradiance(const struct rad_scene *s, const struct rad_received *r,
                           struct rad_means *m) {
  for (int t = 0; t < m->n; t++)
    for (int b = 0; b < m->n_band; b++) {
      int i = t * m->n_band + b;
      m->irradiance[i] = r->value[t * r->n_weight + b] / s->triangle[t].area;
      m->integration[i] = r->error[t * r->n_weight + b] / s->triangle[t].area;
    }
}

/* Mean over a triangle of the largest |K d| found on each element, over scale. */
static double mean_received(const struct rad_indicator *x, int t, int b) {
  const struct rad_mesh *mesh = &x->fine;
  double sum = 0;
  for (int p = mesh->patch_first[t]; p < mesh->patch_first[t + 1]; p++)
    for (int i = mesh->element_first[p]; i < mesh->element_first[p + 1]; i++)
      sum += rad_element_area(mesh, i) * x->received[i * mesh->scene->n_band + b];
  return sum / mesh->scene->triangle[t].area;
}

/* (17.2); column n_band of r is that of z. */
static void set_errors(const struct rad_estimate *x, const struct rad_received *r,
                       struct rad_means *m) {
  const struct rad_indicator *indicator = x->indicator;
  const struct rad_scene *s = indicator->fine.scene;
  double unseen_part = rad_safety(s) - 1;
  for (int t = 0; t < m->n; t++)
    for (int b = 0; b < m->n_band; b++) {
      int i = t * m->n_band + b, z = t * r->n_weight + m->n_band;
      double bound = (r->value[z] + r->error[z]) / s->triangle[t].area;
      double sampled = unseen_part * mean_received(indicator, t, b) +
                       rad_safety(s) * indicator->unseen_received[i];
      m->error_irradiance[i] = indicator->scale[b] * (sampled + bound) + m->integration[i];
    }
}

static void set_worst(const struct rad_indicator *x, struct rad_means *m) {
  m->worst = 0;
  for (int i = 0; i < m->n * m->n_band; i++) {
    double scale = x->scale[i % m->n_band];
    double most = fmax(m->error_irradiance[i], m->error_radiosity[i]);
    if (scale > 0 && most / scale > m->worst) {
      m->worst = most / scale;
      m->worst_triangle = i / m->n_band;
    }
  }
}

/* What the faces receive, and the backs of faces where light may get there. */
static enum rad_code receive(const struct rad_weights *w, const double *allowed,
                             struct rad_received *r, struct rad_means *m, struct rad_error *e) {
  const struct rad_scene *s = w->mesh->scene;
  struct rad_weights light = *w;
  struct rad_enclosure room;
  enum rad_code code = rad_find_enclosure(s, &room, e);
  m->is_enclosed = room.is_closed;
  light.n = s->n_band;
  if (!code)
    code = rad_receive(w, s, 0, allowed, r, e);
  memcpy(m->sent, r->sent, sizeof *m->sent * (size_t)s->n_band);
  if (code || room.hides_backs || !r->n_sender)
    return code;
  return rad_receive_on_backs(&light, allowed, m->on_backs, m->backs_error, e);
}

/* z as a function of the finer mesh. */
static double *spread_bound(const struct rad_mesh *fine, const double *element_bound) {
  double *z = rad_alloc((size_t)fine->n_point, sizeof(double));
  for (int i = 0; z && i < fine->n_element; i++)
    for (int f = 0; f < fine->element[i].n_function; f++)
      z[fine->element[i].first + f] = element_bound[i];
  return z;
}

enum rad_code rad_means_estimated(const struct rad_estimate *x, double tolerance,
                                  struct rad_means *m, struct rad_error *e) {
  const struct rad_indicator *indicator = x->indicator;
  const struct rad_mesh *fine = &indicator->fine;
  struct rad_weights w = {.mesh = fine, .n = fine->scene->n_band + 1};
  double start = rad_seconds(), allowed[RAD_MAX_WEIGHT];
  struct rad_received r = {0};
  enum rad_code code = allocate(fine->scene->n_triangle, fine->scene->n_band, m, e);
  double *z = spread_bound(fine, x->element_bound), most = 0;
  for (int i = 0; i < fine->n_element; i++)
    most = fmax(most, x->element_bound[i]);
  double left = fmin(fmax(INTEGRATION_OF_REST * (tolerance - most), INTEGRATION_LEAST * tolerance),
                     INTEGRATION_MOST * tolerance);
  for (int b = 0; b < m->n_band; b++) {
    w.w[b] = indicator->star + (size_t)b * (size_t)fine->n_point;
    allowed[b] = left * indicator->scale[b];
  }
  w.w[m->n_band] = z;
  allowed[m->n_band] = BOUND_PART * tolerance;
  if (!code && !z)
    code = rad_fail_memory(e, "the means", 8.0 * fine->n_point);
  if (!code)
    code = receive(&w, allowed, &r, m, e);
  if (!code) {
    set_irradiance(fine->scene, &r, m);
    set_errors(x, &r, m);
    set_radiosity(fine, m);
    set_worst(indicator, m);
  }
  rad_received_free(&r);
  free(z);
  m->seconds = rad_seconds() - start;
  return code;
}

enum rad_code rad_means_plain(const struct rad_mesh *mesh, const double *u, double tolerance,
                              struct rad_means *m, struct rad_error *e) {
  const struct rad_scene *s = mesh->scene;
  struct rad_weights w = {.mesh = mesh, .n = s->n_band};
  double start = rad_seconds(), allowed[RAD_MAX_WEIGHT];
  struct rad_received r = {0};
  enum rad_code code = allocate(s->n_triangle, s->n_band, m, e);
  for (int b = 0; b < s->n_band; b++) {
    double most = 0;
    w.w[b] = u + (size_t)b * (size_t)mesh->n_point;
    for (int i = 0; i < mesh->n_point; i++)
      most = fmax(most, fabs(w.w[b][i]));
    allowed[b] = (double)mesh->n_element * s->n_triangle > PLAIN_PAIRS
                     ? INFINITY
                     : INTEGRATION_LEAST * tolerance * most;
  }
  if (!code)
    code = receive(&w, allowed, &r, m, e);
  if (!code) {
    set_irradiance(s, &r, m);
    for (int i = 0; i < m->n * m->n_band; i++)
      m->error_irradiance[i] = NAN;
    set_radiosity(mesh, m);
  }
  rad_received_free(&r);
  m->seconds = rad_seconds() - start;
  return code;
}

enum rad_code rad_means_of_surfaces(const struct rad_scene *scene, const struct rad_means *triangle,
                                    struct rad_means *surface, struct rad_error *e) {
  size_t nb = (size_t)scene->n_band;
  enum rad_code code = allocate(scene->n_surface, scene->n_band, surface, e);
  double *area = rad_calloc((size_t)scene->n_surface, sizeof(double));
  if (!code && !area)
    code = rad_fail_memory(e, "the means", 8.0 * scene->n_surface);
  for (int t = 0; t < scene->n_triangle && !code; t++)
    area[scene->triangle[t].surface] += scene->triangle[t].area;
  for (int t = 0; t < scene->n_triangle && !code; t++)
    for (size_t b = 0; b < nb; b++) {
      size_t to = (size_t)scene->triangle[t].surface, i = (size_t)t * nb + b, j = to * nb + b;
      double share = scene->triangle[t].area / area[to];
      surface->radiosity[j] += share * triangle->radiosity[i];
      surface->irradiance[j] += share * triangle->irradiance[i];
      surface->error_radiosity[j] += share * triangle->error_radiosity[i];
      surface->error_irradiance[j] += share * triangle->error_irradiance[i];
      surface->integration[j] += share * triangle->integration[i];
    }
  free(area);
  return code;
}
