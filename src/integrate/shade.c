#include "integrate/shade.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "visibility/visibility.h"

enum rad_code rad_shade_init(const struct rad_scene *scene, int most_targets, struct rad_shade *s,
                             struct rad_error *e) {
  *s = (struct rad_shade){.target = -1};
  if (!scene->visibility || scene->visibility->n_partly == 0)
    return RAD_OK;
  int n = scene->visibility->occluders.n;
  s->blocker = rad_alloc((size_t)n, sizeof(int));
  s->first = rad_alloc((size_t)most_targets + 1, sizeof(int));
  s->base = rad_alloc((size_t)most_targets, sizeof *s->base);
  s->mu = rad_alloc((size_t)most_targets, sizeof *s->mu);
  return s->blocker && s->first && s->base && s->mu ? RAD_OK
                                                    : rad_fail_memory(e, "the shadows", 4.0 * n);
}

void rad_shade_free(struct rad_shade *s) {
  free(s->base);
  free(s->mu);
  free(s->blocker);
  free(s->frame);
  free(s->shadow);
  free(s->plane);
  free(s->first);
  free(s->strip);
  rad_parts_free(&s->parts);
  *s = (struct rad_shade){0};
}

/* Frames of the blockers that may cast a shadow; returns their number, or -1. */
static int set_frames(const struct rad_visibility *v, int target, int source, struct rad_shade *s) {
  int n_blocker, n = 0;
  const int *blocker = rad_blockers(v, target, source, s->blocker, &n_blocker);
  if (!rad_reserve((void **)&s->frame, (size_t)n_blocker, &s->frame_room, sizeof *s->frame))
    return -1;
  for (int b = 0; b < n_blocker; b++) {
    rad_shadow_frame_set(&v->occluders, target, source, blocker[b], &s->frame[n]);
    n += s->frame[n].n > 0;
  }
  return n;
}

/* The shadows of all blockers for all targets on a source triangle; 0 without memory. */
static int cast_all(const struct rad_visibility *v, int target, int source, int n, const int *base,
                    const double (*mu)[2], struct rad_shade *s) {
  int n_frame = set_frames(v, target, source, s), n_shadow = 0;
  s->target = -1;
  if (n_frame < 0)
    return 0;
  for (int i = 0; i < n; i++) {
    s->first[i] = n_shadow;
    if (!rad_reserve((void **)&s->shadow, (size_t)(n_shadow + n_frame), &s->shadow_room,
                     sizeof *s->shadow))
      return 0;
    for (int b = 0; b < n_frame; b++) {
      rad_shadow_cast(&s->frame[b], base[i], mu[i], &s->shadow[n_shadow]);
      n_shadow += s->shadow[n_shadow].n > 0;
    }
  }
  s->first[n] = n_shadow;
  s->target = target;
  s->source = source;
  s->n_target = n;
  memcpy(s->base, base, sizeof *base * (size_t)n);
  memcpy(s->mu, mu, sizeof *mu * (size_t)n);
  return 1;
}

/* The kept shadows are those of these targets. */
static int is_kept(const struct rad_shade *s, int target, int source, int n, const int *base,
                   const double (*mu)[2]) {
  return s->target == target && s->source == source && s->n_target == n &&
         !memcmp(s->base, base, sizeof *base * (size_t)n) &&
         !memcmp(s->mu, mu, sizeof *mu * (size_t)n);
}

int rad_shade_cast(const struct rad_scene *scene, int target, const struct rad_patch *patch, int n,
                   const int *base, const double (*mu)[2], struct rad_shade *s) {
  const struct rad_visibility *v = scene->visibility;
  int source = patch->triangle;
  if (!v || v->sight[(size_t)target * (size_t)scene->n_triangle + (size_t)source] != RAD_PARTLY)
    return 0;
  if (!is_kept(s, target, source, n, base, mu) && !cast_all(v, target, source, n, base, mu, s)) {
    s->failed = 1;
    return 0;
  }
  int n_shadow = s->first[n];
  if (!rad_reserve((void **)&s->plane, (size_t)n_shadow, &s->plane_room, sizeof *s->plane)) {
    s->failed = 1;
    return 0;
  }
  for (int i = 0; i < n_shadow; i++)
    rad_half_planes_set(&s->shadow[i], patch->base, patch->mu0, patch->mu_a, patch->mu_b,
                        &s->plane[i]);
  return n_shadow > 0;
}

enum rad_sight rad_shade_polygon(struct rad_shade *s, int i, const struct rad_polygon *polygon) {
  int first = i < 0 ? 0 : s->first[i], n = i < 0 ? 0 : s->first[i + 1] - first;
  int sight = rad_visible(polygon, n, s->plane + first, &s->parts);
  if (sight >= 0)
    return (enum rad_sight)sight;
  s->failed = 1;
  return RAD_HIDDEN;
}

int rad_shade_strips(struct rad_shade *s, const struct rad_patch *patch,
                     const struct rad_element *e) {
  int n = 0;
  if (!rad_reserve((void **)&s->strip, (size_t)s->parts.n * RAD_MAX_CORNER, &s->strip_room,
                   sizeof *s->strip)) {
    s->failed = 1;
    return 0;
  }
  for (int p = 0; p < s->parts.n; p++)
    n += rad_strips(patch, e, &s->parts.part[p], s->strip + n);
  return n;
}
