/* Which triangles can see each other at all, and which scenes need shadows. */
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
 * if that is more.
 */
void rad_heights(const struct rad_triangle *i, const struct rad_triangle *j, double h[3]);

/* Side of the plane of i on which j lies, by the signs of rad_heights. Not symmetric. */
enum rad_side_of_plane rad_side_of(const struct rad_triangle *i, const struct rad_triangle *j);

/* True if some point of i and some point of j are in front of each other. Symmetric. */
int rad_faces(const struct rad_triangle *i, const struct rad_triangle *j);

/**
 * Find three triangles i, j, k such that k may cast a shadow between i and j.
 *
 * Conservative and sharp for triangles: conv(i u j), each cut at the other's plane, is the union of
 * all segments between them, and k casts no shadow iff a plane separates it (weakly) from that
 * hull. Overlaps below 1e-10 of the scene's size are rounding and count as separated. Weakly
 * separated are thus all neighbours in a convex scene, and the back of a slit from everything its
 * front sees.
 *
 * @param[out] found  {i, j, k}, i < j: the first in that order; untouched if there is none
 * @return 1 if found, else 0. Cost n n_vertex + n^2, and for every pair that faces each other a
 *         bounding-box test and at most 150 separating axes for each triangle whose plane cuts
 *         the scene. A convex scene has no such triangle.
 */
int rad_find_shadow(const struct rad_scene *scene, int found[3]);

#endif
