#include "integrate/shade.h"

#include <stdlib.h>

#include "base/memory.h"
#include "visibility/visibility.h"

enum rad_code rad_shade_init(const struct rad_scene *scene, int most_targets, struct rad_shade *s,
                             struct rad_error *e) {
  *s = (struct rad_shade){0};
  if (!scene->visibility || scene->visibility->n_partly == 0)
    return RAD_OK;
  int n = scene->visibility->occluders.n;
  s->blocker = rad_alloc((size_t)n, sizeof(int));
  s->first = rad_alloc((size_t)most_targets + 1, sizeof(int));
  return s->blocker && s->first ? RAD_OK : rad_fail_memory(e, "the shadows", 4.0 * n);
}

void rad_shade_free(struct rad_shade *s) {
  free(s->blocker);
  free(s->frame);
  free(s->plane);
  free(s->first);
  free(s->strip);
  rad_parts_free(&s->parts);
  *s = (struct rad_shade){0};
}

static int set_frames(const struct rad_occluders *o, int target, int source, const int *blocker,
                      struct rad_shade *s) {
  if (!rad_reserve((void **)&s->frame, (size_t)s->n_blocker, &s->frame_room, sizeof *s->frame))
    return -1;
  int n = 0;
  for (int b = 0; b < s->n_blocker; b++) {
    rad_shadow_frame_set(o, target, source, blocker[b], &s->frame[n]);
    n += s->frame[n].n > 0;
  }
  s->n_blocker = n;
  return 0;
}

/* Shadows of all blockers for one target. */
static int cast_one(const struct rad_patch *patch, int base, const double mu[2],
                    struct rad_shade *s) {
  if (!rad_reserve((void **)&s->plane, (size_t)(s->n_plane + s->n_blocker), &s->plane_room,
                   sizeof *s->plane))
    return -1;
  for (int b = 0; b < s->n_blocker; b++) {
    struct rad_shadow shadow;
    rad_shadow_cast(&s->frame[b], base, mu, &shadow);
    if (shadow.n > 0)
      rad_half_planes_set(&shadow, patch->base, patch->mu0, patch->mu_a, patch->mu_b,
                          &s->plane[s->n_plane++]);
  }
  return 0;
}

int rad_shade_cast(const struct rad_scene *scene, int target, const struct rad_patch *patch, int n,
                   const int *base, const double (*mu)[2], struct rad_shade *s) {
  const struct rad_visibility *v = scene->visibility;
  if (!v || v->sight[(size_t)target * scene->n_triangle + patch->triangle] != RAD_PARTLY)
    return 0;
  const int *blocker = rad_blockers(v, target, patch->triangle, s->blocker, &s->n_blocker);
  s->n_plane = 0;
  if (set_frames(&v->occluders, target, patch->triangle, blocker, s))
    s->failed = 1;
  for (int i = 0; i < n && !s->failed; i++) {
    s->first[i] = s->n_plane;
    s->failed = cast_one(patch, base[i], mu[i], s) != 0;
  }
  s->first[n] = s->n_plane;
  return !s->failed && s->n_plane > 0;
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
