/* Irradiance of a point by convex polygons of constant radiosity: Lambert's formula. */
#ifndef RAD_VISIBILITY_IRRADIANCE_H
#define RAD_VISIBILITY_IRRADIANCE_H

#include "visibility/visible.h"

/**
 * Form factor from a point to a polygon, all of which it sees and none of which is behind it,
 *
 *   F = 1/(2 pi) |sum_e theta_e n_x.(r_e x r_{e+1}) / |r_e x r_{e+1}||,  r_e = y_e - x,
 *                                                                               (theory 3.9)
 * theta_e the angle between r_e and r_{e+1}: the integral of [n_x.(y - x)] [n_y.(x - y)] / (pi |x -
 * y|^4) over the polygon.
 *
 * r_e x r_{e+1} is formed from the side and the nearer of its corners, and no Z is subtracted from
 * another, so that tiny Z and corners near x cost no accuracy. Rounding is a few 1e-16 of sum
 * theta_e |r| / |distance of x from the line of e|, r to the nearer corner: relative to F, about
 * distance over extent for a small polygon.
 *
 * @param[in] polygon  corners (X, Y, 0) [m], either orientation
 * @param[in] x        (X, Y, Z), Z > 0, in the same frame [m]
 * @param[in] normal   unit normal of the receiver in that frame
 * @return 0 <= F; sides whose line x lies on count nothing
 */
double rad_polygon_form_factor(const struct rad_polygon *polygon, const double x[3],
                               const double normal[3]);

/* The sum over the parts. */
double rad_parts_form_factor(const struct rad_parts *parts, const double x[3],
                             const double normal[3]);

#endif
