/* Whether light that a scene radiates can leave it. */
#ifndef RAD_SCENE_ENCLOSURE_H
#define RAD_SCENE_ENCLOSURE_H

#include "scene/scene.h"

struct rad_enclosure {
  int is_closed;   /* what faces radiate meets the scene again, at fronts or backs of faces */
  int hides_backs; /* no light comes to the back of a face; only known of a closed scene */
};

/**
 * By topology, without an integral, so that balances of light can be held against it.
 *
 * Around a closed surface (shell.h) every point has a winding number, which changes only across
 * that surface and is 0 far away. So light stays where it is not 0: a scene is closed if it is not
 * 0 in front of every face, for some surface that nothing crosses. A doubtful scene is not closed.
 *
 * @return RAD_ESYSTEM without memory. Cost pieces that hang together by edges times triangles
 */
enum rad_code rad_find_enclosure(const struct rad_scene *scene, struct rad_enclosure *x,
                                 struct rad_error *e);

#endif
