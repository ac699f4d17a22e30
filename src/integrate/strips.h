/* The visible part of an element as strips between two sides, for the near integrator. */
#ifndef RAD_INTEGRATE_STRIPS_H
#define RAD_INTEGRATE_STRIPS_H

#include "integrate/near.h"
#include "visibility/clip.h"

/* The whole element: one strip. */
struct rad_strip rad_strip_whole(const struct rad_element *e);

/* Corners (r, r t) of an element, in order. */
void rad_element_polygon(const struct rad_patch *patch, const struct rad_element *e,
                         struct rad_polygon *polygon);

/**
 * Cut a convex polygon with corners (r, r t) at the rays through its corners.
 *
 * @param[out] strip  [RAD_MAX_CORNER]
 * @return number of strips
 */
int rad_strips(const struct rad_patch *patch, const struct rad_element *e,
               const struct rad_polygon *polygon, struct rad_strip *strip);

#endif
