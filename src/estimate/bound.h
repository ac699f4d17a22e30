/* From what the indicator found to bounds of |u - u*|. */
#ifndef RAD_ESTIMATE_BOUND_H
#define RAD_ESTIMATE_BOUND_H

#include "estimate/adapt.h"

/* Factor for what the samples of d may miss. */
double rad_safety(const struct rad_scene *s);

/* bound and bound_limit. Theory 6.4: quadrature of u*, interpolation in u*, and both of K d, each
 * err by `quadrature`. */
void rad_set_bound(struct rad_adaptive *a);

/* The largest rho of a triangle; 0 where u = E is known: so much of an error of K u comes back. */
double rad_reflects(const struct rad_adaptive *a, int triangle);

/* source, light_source, z and element_bound: z = (I - rho K)^{-1} g. */
enum rad_code rad_set_element_bound(struct rad_adaptive *a, struct rad_error *e);

#endif
