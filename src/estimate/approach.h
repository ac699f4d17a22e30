/* Split the leaves around feet that matter until their elements resolve them. */
#ifndef RAD_ESTIMATE_APPROACH_H
#define RAD_ESTIMATE_APPROACH_H

#include "estimate/feet.h"
#include "estimate/layout.h"

/**
 * @param[in] feet   of the mesh before, with their effects
 * @param[in] least  effect from which on a foot matters
 * @param     l      the layout of that mesh, refined or not; origins are kept
 */
enum rad_code rad_approach(const struct rad_feet *feet, double least, struct rad_layout *l,
                           struct rad_error *e);

#endif
