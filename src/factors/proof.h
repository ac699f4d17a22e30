/* What can be proved of what a cell sees of its target: nothing, or at most and at least how much.
 */
#ifndef RAD_FACTORS_PROOF_H
#define RAD_FACTORS_PROOF_H

#include "factors/pair.h"

/* int F dS over a cell, whatever points say. */
struct rad_range {
  double low, high; /* [m2] */
};

/**
 * Bounds from planes that part the cell from the target. Every segment between them crosses such a
 * plane within the convex hull P of the points where those between corners do. If the plane's
 * blockers cover P, nothing is seen; if they leave little of it, no more than what the cell sends
 * there arrives. And a blocker takes away no more than what the cell sends to it.
 *
 * @param[in] n, list  blockers in the shaft (numbers in the pair)
 * @param[in] all      int F dS of the unobstructed target, and its error
 * @return -1 without memory, 1 if the target is hidden, else 0
 */
int rad_proof_range(struct rad_pair *p, const struct rad_flat *cell, int n, const int *list,
                    const double all[2], struct rad_range *range);

#endif
