#include "integrate/point_factor.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "visibility/facing.h"

static enum rad_code make_mesh(const struct rad_scene *scene, struct rad_mesh *mesh,
                               struct rad_error *e) {
  enum rad_code code = rad_mesh_begin(scene, NULL, mesh, e);
  for (int t = 0; t < scene->n_triangle && !code; t++) {
    struct rad_patch patch;
    rad_patch_whole(scene, t, &patch);
    rad_mesh_add_patch(mesh, &patch);
    rad_mesh_add_element(
        mesh, (struct rad_element){
                  .sigma = {0, 1}, .tau = {0, 1}, .p_phi = 1, .p_r = 1, .k_phi = 1, .k_r = 1});
  }
  return code ? code : rad_mesh_finish(mesh, e);
}

enum rad_code rad_receivers_begin(const struct rad_scene *scene, double tolerance,
                                  struct rad_receivers *r, struct rad_error *e) {
  *r = (struct rad_receivers){.scene = scene};
  enum rad_code code = make_mesh(scene, &r->mesh, e);
  if (!code)
    code = rad_rules_build(&r->mesh, tolerance, &r->rules, e);
  r->facet = rad_alloc((size_t)scene->n_triangle, sizeof *r->facet);
  if (!code && !r->facet)
    code = rad_fail_memory(e, "the receivers", (double)scene->n_triangle * sizeof *r->facet);
  for (int t = 0; t < scene->n_triangle && !code; t++)
    rad_facet_source_set(&scene->triangle[t], &r->facet[t]);
  return code;
}

void rad_receivers_free(struct rad_receivers *r) {
  rad_rules_free(&r->rules);
  rad_mesh_free(&r->mesh);
  free(r->facet);
  *r = (struct rad_receivers){0};
}

void rad_senders_finish(const struct rad_scene *scene, struct rad_senders *s) {
  const struct rad_triangle *t = &scene->triangle[s->triangle];
  int padded = (s->n + RAD_FACET_LANES - 1) / RAD_FACET_LANES * RAD_FACET_LANES;
  for (int q = 0; q < padded; q++) {
    int at = q < s->n ? q : s->n - 1, base = s->base[at];
    const double *v = t->v[base], *v1 = t->v[(base + 1) % 3], *v2 = t->v[(base + 2) % 3];
    for (int d = 0; d < 3; d++) {
      s->component[d][q] = v[d];
      s->component[3 + d][q] = s->mu[at][0] * (v1[d] - v[d]) + s->mu[at][1] * (v2[d] - v[d]);
      s->component[6 + d][q] = t->normal[d];
    }
  }
}

static struct rad_facet_targets targets_of(const struct rad_senders *s) {
  struct rad_facet_targets t;
  for (int d = 0; d < 3; d++) {
    t.v[d] = s->component[d];
    t.d[d] = s->component[3 + d];
    t.normal[d] = s->component[6 + d];
  }
  return t;
}

/* Points first..first + n by the integrator that knows shadows and roundings. */
static void by_patch(const struct rad_receivers *r, const struct rad_senders *s, int first, int n,
                     int receiver, double *value, struct rad_scratch *scratch) {
  struct rad_targets targets = {s->triangle, n, s->base + first, (const double(*)[2])s->mu + first,
                                NULL};
  rad_patch_block(&r->mesh, &r->rules, &targets, receiver, NULL, value + first, 0, scratch);
}

/* Values that the vector loop was not sure of: cut at the horizon, or hard to round. */
static void with_care(const struct rad_receivers *r, const struct rad_senders *s,
                      const struct rad_receiver *to, struct rad_facet_error allowed, double *value,
                      struct rad_scratch *scratch) {
  const struct rad_triangle *t = r->scene->triangle;
  struct rad_facet_targets all = targets_of(s);
  int cut = rad_side_of(&t[s->triangle], &t[to->triangle]) == RAD_ACROSS;
  for (int q = 0; q < s->n; q++) {
    if (!isnan(value[q]))
      continue;
    struct rad_polygon front;
    rad_facet_front(&r->facet[to->triangle], &all, q, cut, &front);
    value[q] = rad_facet_part(&r->facet[to->triangle], &all, q, &front, allowed);
    if (isnan(value[q]))
      by_patch(r, s, q, 1, to->triangle, value, scratch);
  }
}

void rad_point_factors(const struct rad_receivers *r, const struct rad_senders *s,
                       const struct rad_receiver *to, double *value, struct rad_scratch *scratch) {
  const struct rad_facet_error allowed = {r->rules.tolerance, to->rounding};
  if (to->sight == RAD_PARTLY) {
    by_patch(r, s, 0, s->n, to->triangle, value, scratch);
    return;
  }
  struct rad_facet_targets targets = targets_of(s);
  int doubts = 0;
  for (int q = 0; q < s->n; q += RAD_FACET_LANES)
    doubts |= rad_facet_values(&r->facet[to->triangle], &targets, q, allowed, value + q);
  if (doubts)
    with_care(r, s, to, allowed, value, scratch);
}
