/* From what a deck says of a triangle and of its surface to rho, E and heat. Called by
 * rad_scene_build. */
#ifndef RAD_SCENE_OPTICS_H
#define RAD_SCENE_OPTICS_H

#include "scene/check.h"

/* Room for rho and emission of all triangles. */
enum rad_code rad_optics_begin(struct rad_scene *scene, struct rad_error *e);

/**
 * rho, emission and, in thermal scenes, heat of triangle t (theory 15.1).
 *
 * @param[in] own     of the triangle; wins over `shared`, of its surface, or NULL
 * @return RAD_EINPUT where one is missing, or they exclude each other
 */
enum rad_code rad_optics_set(const struct rad_checked *checked, int t,
                             const struct rad_deck_optics *own,
                             const struct rad_deck_optics *shared, struct rad_scene *scene,
                             struct rad_error *e);

#endif
