/* What the interpolant of u* between the estimate's samples leaves out, element by element. */
#ifndef RAD_ESTIMATE_REMAINDER_H
#define RAD_ESTIMATE_REMAINDER_H

#include "estimate/indicator.h"
#include "integrate/rule.h"

/**
 * The largest |u* - I u*| / scale of all bands at random points of each element that is near a face
 * which it does not touch, I u* the interpolant on the finer mesh (theory 17.2). Points are the
 * same in every run.
 *
 * @param[in]  passive    [n_triangle] faces on which u = E; or NULL
 * @param[in]  u          [n_band, mesh->n_point] solution on mesh
 * @param[out] remainder  [n_element]; 0 on all other elements
 */
enum rad_code rad_remainder(const struct rad_mesh *mesh, const struct rad_rules *rules,
                            const unsigned char *passive, const double *u,
                            const struct rad_indicator *x, double *remainder, struct rad_error *e);

#endif
