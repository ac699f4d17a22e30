/* Vertices of a scene: close corners become one. Called by rad_scene_build. */
#ifndef RAD_SCENE_WELD_H
#define RAD_SCENE_WELD_H

#include "scene/scene.h"

/**
 * Measure the scene and number its vertices; corners closer than 1e-10 of the scene's size are one
 * vertex, and take the coordinates of the one met first.
 *
 * A hash grid: cost proportional to the number of triangles.
 *
 * @param[in,out] scene  in: finite triangle[].v; out: size, vertex, n_vertex, and the triangles'
 *                       v and vertex
 * @param[in]     path   of the deck, for messages
 * @return RAD_OK, RAD_EINPUT if the size is not from 1e-60 to 1e60, or RAD_ESYSTEM out of memory
 */
enum rad_code rad_weld(struct rad_scene *scene, const char *path, struct rad_error *e);

#endif
