/* Fans: thin elements side by side around a vertex. */
#ifndef RAD_SYSTEM_FAN_H
#define RAD_SYSTEM_FAN_H

#include "mesh/mesh.h"

/**
 * A fan is all elements of one patch between the same two values of tau, if they have more than
 * `leaf` unknowns, and those of any `leaf` of them next to one another are no wider than long.
 *
 * @param[out] fan  [n_element] number of an element's fan, or -1
 * @return 0 without memory
 */
int rad_fans_find(const struct rad_mesh *mesh, int leaf, int *fan);

#endif
