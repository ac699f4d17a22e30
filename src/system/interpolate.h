/* Tensor Chebyshev interpolation in rectangles: the kernel between two planes as a small matrix. */
#ifndef RAD_SYSTEM_INTERPOLATE_H
#define RAD_SYSTEM_INTERPOLATE_H

#include "system/cluster.h"

enum { RAD_MAX_INTERPOLATION = 20 };

/* The q Chebyshev points of [-1, 1]; nodes of a rectangle are numbered i + q j. */
struct rad_interpolation {
  int q, n; /* points per direction; n = q q */
  double node[RAD_MAX_INTERPOLATION];
  double inverse[RAD_MAX_INTERPOLATION];                      /* 1 / prod_{m != i} (z_i - z_m) */
  double root[RAD_MAX_INTERPOLATION * RAD_MAX_INTERPOLATION]; /* [n] square roots of the mean's
                                                                 weights: they sum to 1 */
};

/* q from the tolerance: see theory 14.3. */
void rad_interpolation_init(struct rad_interpolation *p, double tolerance);

/* Values of the q Lagrange polynomials at z in [-1, 1]. Cost 4 q. */
void rad_interpolation_at(const struct rad_interpolation *p, double z, double *value);

/* E[i' + q i]: the Lagrange polynomials i of [low, high] at the nodes i' of [low1, high1]. */
void rad_interpolation_between(const struct rad_interpolation *p, double low, double high,
                               double low1, double high1, double *e);

/* The same in both directions, between a cluster and one of its children. */
void rad_interpolation_child(const struct rad_interpolation *p, const struct rad_cluster *parent,
                             const struct rad_cluster *child,
                             double e[2][RAD_MAX_INTERPOLATION * RAD_MAX_INTERPOLATION]);

/**
 * out = A z B^T for n matrices z [q, q], all column-major.
 *
 * @param[in] transposed  A^T and B^T in place of A and B
 * Tensor transfer between rectangles: 4 n q^3 operations.
 */
void rad_interpolation_transfer(const struct rad_interpolation *p, const double *a, const double *b,
                                int transposed, int n, const double *restrict z,
                                double *restrict out);

/**
 * s[a + n b] = G(x_a, y_b) between the nodes of a target and of a source cluster (theory 14.2)
 *
 * G without the cuts of (1.2): it is continued beyond the triangles' rims. Cost n^2 kernel values.
 */
void rad_interpolation_kernel(const struct rad_interpolation *p, const struct rad_tree *tree,
                              const struct rad_cluster *target, const struct rad_cluster *source,
                              double *s);

#endif
