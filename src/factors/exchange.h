/* A_P F_PQ of polygons that see all of each other, by the cheapest way that is exact enough. */
#ifndef RAD_FACTORS_EXCHANGE_H
#define RAD_FACTORS_EXCHANGE_H

#include "base/gauss.h"
#include "factors/flat.h"

/**
 * int_P int_Q G dS dS: product rules where the polygons are far apart for their sizes, else the
 * contour form.
 *
 * @param[in]  goal   of the error over A_P A_Q / (pi D^2), D the distance of the centres: rules get
 *                    better as it falls, so the error never grows
 * @param[out] error  bound [m2]
 * @return [m2] at least 0
 */
double rad_exchange(const struct rad_gauss *g, const struct rad_flat *p, const struct rad_flat *q,
                    double goal, double *error);

/* A_P A_Q / (pi D^2) */
double rad_exchange_scale(const struct rad_flat *p, const struct rad_flat *q);

/* The part of f in front of a plane through `at`; heights up to `zero` are none. */
void rad_flat_clip(struct rad_flat *f, const double at[3], const double normal[3], double zero);

#endif
