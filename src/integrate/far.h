/* Well separated targets: tensor Gauss rules on a whole element, many targets at once. */
#ifndef RAD_INTEGRATE_FAR_H
#define RAD_INTEGRATE_FAR_H

#include "integrate/rule.h"
#include "integrate/view.h"

enum { RAD_TILE = 64 };

/* Targets in the frame of a source patch, ready for vector loops. */
struct rad_tile {
  double x[RAD_TILE], y[RAD_TILE], z[RAD_TILE]; /* [m] */
};

/**
 * I[b](x_i) = int_e G(x_i, y) L_b(y) dS for one plane element, unclipped (theory 3.4)
 *
 * @param[in]  n        number of targets in tile, <= RAD_TILE; those with z <= 0 give 0;
 *                      the tile is padded with copies of the last
 * @param[in]  angular  panel of sigma; radial: of tau; with the numbers of the rules to use
 * @param[out] out      [k_phi k_r, RAD_TILE] row-major: function, target
 * Cost n * (points of both rules) kernel values. No allocation; thread-safe.
 */
void rad_far(const struct rad_patch *patch, const struct rad_view *view,
             const struct rad_panel *angular, int angular_rule, const struct rad_panel *radial,
             int radial_rule, struct rad_tile *tile, int n, double *restrict out);

#endif
