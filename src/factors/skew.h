/* What may hinge on three edges in one ray: curves on the cell that are no lines. */
#ifndef RAD_FACTORS_SKEW_H
#define RAD_FACTORS_SKEW_H

#include "factors/critical.h"

/**
 * Where no line crosses the cell, F(y -> target) is analytic but for parts of the target near which
 * two edges that are not in one plane may seem to cross, and a third one, of the target or of
 * another blocker, may pass through the crossing. As y runs over the cell, the shadow of an edge
 * stays within the convex hull of those from the cell's corners; so the crossing stays within the
 * hulls of both.
 *
 * @return at most what the cell sends to all such parts [m2], at most `most`
 */
double rad_skew_bound(const struct rad_pair *p, const struct rad_flat *cell,
                      const struct rad_shaft *shaft, const struct rad_critical *c, double most);

#endif
