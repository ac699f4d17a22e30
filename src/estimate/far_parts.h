/* Parts of elements that are far from the points they light. */
#ifndef RAD_ESTIMATE_FAR_PARTS_H
#define RAD_ESTIMATE_FAR_PARTS_H

#include "system/h2_once.h"

/**
 * After a product of o with the bands' vectors u_v first among those gathered.
 *
 * @param[in]     integral  [n_band, n_element] of u_v over each element
 * @param[in]     weight    [n_triangle, n_band] of targets
 * @param[out]    largest   [n_band, n_element] at the points of an element: the largest
 *                          |K u_v of one far element|, from integrals and mean kernels; no weights
 * @param[in,out] part      [n_element] raised to weight |K u_v of the element| at the nodes of the
 *                          far block that weighs most
 */
enum rad_code rad_far_parts(const struct rad_once *o, int n_band, const double *integral,
                            const double *weight, double *largest, double *part,
                            struct rad_error *e);

#endif
