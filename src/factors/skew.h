/* What may hinge on three edges in one ray: curves on the cell that are no lines. */
#ifndef RAD_FACTORS_SKEW_H
#define RAD_FACTORS_SKEW_H

#include "factors/critical.h"

/* True if two segments are not in one plane: only then may they seem to cross from other points
 * than those of that plane, which is a line on the cell, and have nothing in common. */
int rad_are_skew(const double *p, const double *q, const double *a, const double *b);

/**
 * Where no line crosses the cell, F(y -> target) is analytic but for parts of the target near which
 * two edges that are not in one plane may seem to cross, and a third one, of the target or of
 * another blocker, may pass through the crossing. As y runs over the cell, the shadow of an edge
 * stays within the convex hull of those from the cell's corners; so the crossing stays within the
 * hulls of both.
 *
 * @return at most what may hinge on that: a share of what the cell sends to all such parts [m2],
 * and at most `most`
 */
double rad_skew_bound(const struct rad_pair *p, const struct rad_flat *cell,
                      const struct rad_shaft *shaft, const struct rad_critical *c, double most);

#endif
