/* Double surface integrals as double contour integrals. */
#ifndef RAD_FACTORS_CONTOUR_H
#define RAD_FACTORS_CONTOUR_H

#include "base/gauss.h"
#include "factors/flat.h"

/**
 * A_P F_PQ = int_P int_Q G dS dS of polygons that see all of each other and are in front of each
 * other:
 *
 *   A_P F_PQ = 1/(2 pi) sum_e sum_f (e.f) int_e int_f ln |x - y| ds dt (theory 12.2)
 *
 * over the edges of P and Q, e.f the product of their directions. The integral over f is closed.
 * That over e is Gauss's with as many points as the nearest singularity of its integrand in the
 * complex plane asks for, on intervals halved towards one that is too near; corners of f on the
 * line of e, where the integrand is u ln u and an analytic function, have that integrated by
 * itself, so common edges and vertices are as exact as all others. Edges on one line are closed.
 *
 * @param[out] error  what truncation and rounding may amount to [m2]: about 1e-14 of the
 *                    circumferences' product
 * @return [m2]. Cost about 60 ns a point, 8 to 15 points a pair of edges that are not
 * perpendicular.
 */
double rad_contour(const struct rad_gauss *g, const struct rad_flat *p, const struct rad_flat *q,
                   double *error);

#endif
