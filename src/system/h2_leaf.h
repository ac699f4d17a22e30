/* What interpolation needs of a leaf: polynomials at its points, and their integrals. */
#ifndef RAD_SYSTEM_H2_LEAF_H
#define RAD_SYSTEM_H2_LEAF_H

#include "system/interpolate.h"

/* c[m] = C_m(x) at a point in the rectangle of a leaf. */
void rad_leaf_polynomials(const struct rad_interpolation *p, const struct rad_tree *tree,
                          const struct rad_cluster *leaf, const double x[3], double *c);

/* v[m + n_node l] = C_m(x_l) for the points l of a leaf (theory 14.2). */
void rad_leaf_values(const struct rad_interpolation *p, const struct rad_tree *tree,
                     const struct rad_cluster *leaf, double *v);

/**
 * v[m + n_node l] = int L_l C_m dS / sqrt(d_l) for the trial functions l of a leaf, d_l as in
 * rad_leaf_shares (theory 14.2), by Gauss rules that are exact, or good to the tolerance for what
 * is interpolated from at least the leaf's diameter away.
 *
 * @param[in,out] scratch  [n_node (k_phi k_r + k_r)] for the largest element
 */
void rad_leaf_moments(const struct rad_interpolation *p, const struct rad_tree *tree,
                      const struct rad_cluster *leaf, double tolerance, double *v, double *scratch);

/* d[l]: the share of trial function l in the area of its element, all equal [m2]. */
void rad_leaf_shares(const struct rad_tree *tree, const struct rad_cluster *leaf, double *d);

#endif
