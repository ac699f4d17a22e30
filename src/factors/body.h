/* Convex bodies among what casts shadows. */
#ifndef RAD_FACTORS_BODY_H
#define RAD_FACTORS_BODY_H

#include "visibility/occluder.h"

/**
 * Polygons that sides join belong to one body. It is convex if all of it is on one side of the
 * plane of each of its polygons, weakly, and closed: its free sides, if any, lie in one plane that
 * has the whole scene on one side, so that a lid there would hide nothing. Silhouettes of such a
 * body never cross, wherever one looks from.
 *
 * @param[in]  twin, owner  see rad_pair_engine
 * @param[out] body  [o->n] a polygon of the body, the same for all of it; -1: not a convex one
 * @return -1 without memory, else 0. Cost: polygons times vertices of a body, n for the lids.
 */
int rad_bodies_find(const struct rad_occluders *o, const int *twin, const int *owner, int *body);

#endif
