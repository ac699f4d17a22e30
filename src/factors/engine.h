/* What integrals between pairs of triangles need to know of a scene. */
#ifndef RAD_FACTORS_ENGINE_H
#define RAD_FACTORS_ENGINE_H

#include "base/gauss.h"
#include "scene/scene.h"
#include "visibility/visibility.h"

/* Read-only once it is made; threads share it. */
struct rad_pair_engine {
  const struct rad_scene *scene;           /* borrowed, with its visibility */
  const struct rad_visibility *visibility; /* borrowed */
  struct rad_gauss gauss;
  int *twin;  /* owned [corners of all occluders], of the side from corner c to the next: a side of
                 another occluder between the same two vertices; -1: none, a free edge */
  int *owner; /* owned, the same size: the occluder of a side */
  int *body;  /* owned [occluders] convex body of each, see rad_bodies_find; -1: none */
};

/**
 * @param[in]  scene  with visibility (rad_visibility_build)
 * @param[out] g      to be freed with rad_pair_engine_free, also after an error
 * @return RAD_OK, or RAD_ESYSTEM without memory. Cost n log n.
 */
enum rad_code rad_pair_engine_init(const struct rad_scene *scene, struct rad_pair_engine *g,
                                   struct rad_error *e);
void rad_pair_engine_free(struct rad_pair_engine *g); /* safe twice */

#endif
