/* Which triangles can see each other at all, leaving aside what stands between. */
#ifndef RAD_VISIBILITY_FACING_H
#define RAD_VISIBILITY_FACING_H

#include "scene/scene.h"

/* Position of triangle j relative to the plane of triangle i (front = the radiating side of i). */
enum rad_side_of_plane {
  RAD_BEHIND,   /* no point of j strictly in front */
  RAD_IN_FRONT, /* no point of j strictly behind, some in front */
  RAD_ACROSS    /* points on both sides */
};

/**
 * Heights n_i.(y - v) [m] of the vertices y of j above the plane of i.
 *
 * Zero for vertices shared with i, and below 1e-12 of the larger triangle's extent, or of |y - v|
 * if that is more; and below the rounding of y, 3.6e-15 |y|, which counts far from the origin: a
 * block that rests on a floor there sees nothing of it.
 */
void rad_heights(const struct rad_triangle *i, const struct rad_triangle *j, double h[3]);

/* Side of the plane of i on which j lies, by the signs of rad_heights. Not symmetric. */
enum rad_side_of_plane rad_side_of(const struct rad_triangle *i, const struct rad_triangle *j);

/* True if some point of i and some point of j are in front of each other. Symmetric. */
int rad_faces(const struct rad_triangle *i, const struct rad_triangle *j);

#endif
