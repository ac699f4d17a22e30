/* The convex hull of a cell and the target it looks at, by planes: what lies outside blocks
 * nothing.
 */
#ifndef RAD_FACTORS_SHAFT_H
#define RAD_FACTORS_SHAFT_H

#include "factors/flat.h"

enum { RAD_MAX_SHAFT = 40 };

struct rad_shaft {
  int n;
  double normal[RAD_MAX_SHAFT][3], offset[RAD_MAX_SHAFT]; /* inside: normal.x < offset, unit */
};

/**
 * Planes through an edge of the one and a vertex of the other that have both on one side, and the
 * planes of both: enough to bound the hull of two convex polygons in front of each other.
 *
 * @param[in] slack  how far in a plane may be and count as touched [m]
 */
void rad_shaft_make(const struct rad_flat *cell, const struct rad_flat *target, double slack,
                    struct rad_shaft *shaft);

/* True if one plane has all points outside, weakly. */
int rad_shaft_misses(const struct rad_shaft *shaft, int n, const double *const *point);

#endif
