/* How the Legendre modes of u* decay in an element. */
#ifndef RAD_ESTIMATE_MODES_H
#define RAD_ESTIMATE_MODES_H

#include "mesh/mesh.h"

/* What is set for one element: size of the modes beyond its own, over scale, and decay of all of
 * them, e^-rate per degree, in both directions. */
struct rad_modes {
  double *tail_phi, *tail_r, *rate_phi, *rate_r;
};

/**
 * @param[in]  fine    mesh with more points per element
 * @param[in]  coarse  the element of the mesh that has the unknowns; `i` is its number
 * @param[in]  star    [n_band, fine->n_point] u*
 * @param[in]  scale   [n_band]
 */
void rad_modes(const struct rad_mesh *fine, int i, const struct rad_element *coarse, int n_band,
               const double *star, const double *scale, struct rad_modes out);

#endif
