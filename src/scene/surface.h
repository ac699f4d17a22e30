/* Surfaces of a scene: numbers for names, and the deck's properties for them. Called by
 * rad_scene_build. */
#ifndef RAD_SCENE_SURFACE_H
#define RAD_SCENE_SURFACE_H

#include "scene/scene.h"

/**
 * Number the surfaces in the order in which their names come first.
 *
 * @param[in]     n, name  [n] names that triangles have; any of them may be equal
 * @param[in,out] scene    out: n_surface, surface_name
 * @param[out]    surface  [n] number of each name's surface
 * @param[out]    entry    [n] first n_surface: place of a surface in deck->surface, or -1
 * @return RAD_OK, RAD_EINPUT for an entry of scene.surfaces that no triangle names, RAD_ESYSTEM
 *         without memory. Cost n log n.
 */
enum rad_code rad_surfaces_number(const struct rad_deck *deck, const char *path, int n,
                                  const char *const *name, struct rad_scene *scene, int *surface,
                                  int *entry, struct rad_error *e);

#endif
