/* Whether light that a scene radiates can leave it. */
#ifndef RAD_SCENE_ENCLOSURE_H
#define RAD_SCENE_ENCLOSURE_H

#include "scene/scene.h"

/**
 * A scene is enclosed if all its shells are closed (shell.h) and each of them that radiates
 * outwards, or is a sheet, lies within one that radiates inwards: nothing escapes and no back is
 * lit. By topology, without an integral, so that balances of light can be held against it.
 *
 * @return RAD_ESYSTEM without memory. Cost shells times triangles
 */
enum rad_code rad_find_enclosure(const struct rad_scene *scene, int *is_enclosed,
                                 struct rad_error *e);

#endif
