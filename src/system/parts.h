/* Parts of a scene that exchange no light: each is a problem of its own. */
#ifndef RAD_SYSTEM_PARTS_H
#define RAD_SYSTEM_PARTS_H

#include "system/operator.h"

/**
 * Components of "sees".
 *
 * @param[out] part  [n_triangle] part of each triangle, numbered by their first triangles
 * @return their number
 */
int rad_find_parts(const struct rad_operator *k, int *part);

#endif
