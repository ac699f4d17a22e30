/* Convex hulls of a few points in a plane. */
#ifndef RAD_FACTORS_HULL2_H
#define RAD_FACTORS_HULL2_H

#include "visibility/clip.h"

/* Sorts the points, n <= RAD_MAX_CORNER / 2; the hull is counterclockwise and has fewer than three
 * corners if they are on a line. */
void rad_hull2(int n, double (*at)[2], struct rad_polygon *hull);

/* The common part of a polygon and a convex, counterclockwise one. */
void rad_common(const struct rad_polygon *with, struct rad_polygon *part);

#endif
