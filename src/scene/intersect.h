/* Two triangles that have more than their rims in common. */
#ifndef RAD_SCENE_INTERSECT_H
#define RAD_SCENE_INTERSECT_H

#include "scene/scene.h"

/**
 * True if a and b overlap in area, and lie in one plane there.
 *
 * Overlap: no edge of either separates them, as lines of the plane, to within `tolerance`. In one
 * plane: the part of the smaller above the larger is nowhere farther from it than `tolerance`.
 * Triangles that share an edge or a vertex, or touch, do not overlap. Sides are not looked at.
 *
 * @param[in]  tolerance  [m]
 * @param[out] above      largest height of the common part of the smaller over the larger, towards
 *                        the larger's radiating side; set if they overlap [m]
 */
int rad_triangles_overlap(const struct rad_triangle *a, const struct rad_triangle *b,
                          double tolerance, double *above);

/**
 * True if a and b cross: they have a segment in common that is longer than `tolerance`, and whose
 * midpoint is farther than this from every edge of both. One that stands on the other does not
 * cross it.
 */
int rad_triangles_cross(const struct rad_triangle *a, const struct rad_triangle *b,
                        double tolerance);

#endif
