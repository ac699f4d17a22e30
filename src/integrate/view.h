/* A target triangle as seen from a source patch: linear maps that keep relative accuracy. */
#ifndef RAD_INTEGRATE_VIEW_H
#define RAD_INTEGRATE_VIEW_H

#include "mesh/patch.h"

/**
 * A point x = V_c + mu1 F1 + mu2 F2 of the target triangle has in the frame of the patch (its
 * corner the origin, e1, e2 in its plane, its radiating normal third) the coordinates
 *
 *   (X, Y, Z) = origin[c] + mu1 along[c][0] + mu2 along[c][1]                         (theory 3.1)
 *
 * and a source point y = (y1, y2, 0) = r (a + t b) lies at the height
 *
 *   n_x.(y - x) = n0 + r (na + t nb)                                                  (theory 3.2)
 *
 * above the target's plane. Whatever vanishes because a vertex or an edge is shared is set to 0, so
 * heights and offsets near it are exact to rounding relative to their own size.
 */
struct rad_view {
  double origin[3][3];   /* [c][coordinate] [m] */
  double along[3][2][3]; /* [c][mu][coordinate] [m] */
  double n0, na, nb;     /* [m] */
};

void rad_view_set(const struct rad_triangle *target, const struct rad_triangle *source,
                  const struct rad_patch *patch, struct rad_view *view);

static inline void rad_view_point(const struct rad_view *view, int base, const double mu[2],
                                  double x[3]) {
  for (int d = 0; d < 3; d++)
    x[d] =
        view->origin[base][d] + (mu[0] * view->along[base][0][d] + mu[1] * view->along[base][1][d]);
}

#endif
