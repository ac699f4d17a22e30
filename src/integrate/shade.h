/* The shadows on one source patch for a batch of targets. */
#ifndef RAD_INTEGRATE_SHADE_H
#define RAD_INTEGRATE_SHADE_H

#include <stddef.h>

#include "integrate/strips.h"
#include "mesh/mesh.h"
#include "visibility/visible.h"

/* Memory of one thread. The shadows of the last targets on the last source triangle are kept: its
 * patches follow one another. */
struct rad_shade {
  int target, source, n_target; /* triangles, targets; target -1: none kept */
  int *base;                    /* owned [most targets] */
  double (*mu)[2];              /* owned [most targets] */
  int *blocker;                 /* owned [occluders] */
  size_t frame_room;
  struct rad_shadow_frame *frame; /* owned [frame_room], of the blockers */
  size_t shadow_room;
  struct rad_shadow *shadow; /* owned [shadow_room] in the source triangle's barycentric terms */
  int *first;                /* owned [most targets + 1] of each target's shadows */
  size_t plane_room;
  struct rad_half_planes *plane; /* owned [plane_room] the shadows in the patch's (r, r t) */
  struct rad_parts parts;        /* visible parts of an element, in (r, r t) */
  size_t strip_room;
  struct rad_strip *strip; /* owned [strip_room] */
  int failed;              /* out of memory */
};

enum rad_code rad_shade_init(const struct rad_scene *scene, int most_targets, struct rad_shade *s,
                             struct rad_error *e);
void rad_shade_free(struct rad_shade *s); /* safe twice */

/**
 * Cast the shadows between a target triangle and a patch for n targets.
 *
 * @return 0 if there are none at all. Without memory s->failed is set.
 */
int rad_shade_cast(const struct rad_scene *scene, int target, const struct rad_patch *patch, int n,
                   const int *base, const double (*mu)[2], struct rad_shade *s);

/* What target i sees of a convex polygon of the patch, i < 0: without shadows; s->parts is that. */
enum rad_sight rad_shade_polygon(struct rad_shade *s, int i, const struct rad_polygon *polygon);

/* s->parts as strips of an element; their number, in s->strip. */
int rad_shade_strips(struct rad_shade *s, const struct rad_patch *patch,
                     const struct rad_element *e);

#endif
