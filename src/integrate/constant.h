/* A constant on a whole triangle or a part of it: Lambert's closed form. */
#ifndef RAD_INTEGRATE_CONSTANT_H
#define RAD_INTEGRATE_CONSTANT_H

#include "scene/scene.h"
#include "visibility/clip.h"

enum { RAD_FACET_LANES = 16 }; /* targets at a time */

/* A source triangle, ready for Lambert's form. */
struct rad_facet_source {
  double v[3][3], side[3][3]; /* vertices; v[m + 1] - v[m] [m] */
  double length[3];           /* of the sides [m] */
  double normal[3];
  double scale; /* +-1/(2 pi): positive if the vertices run clockwise about the normal */
};

void rad_facet_source_set(const struct rad_triangle *source, struct rad_facet_source *s);

/* Rounding that a value may have: relative times the value, or absolute [-]. */
struct rad_facet_error {
  double relative, absolute;
};

/* Target points x = v + d with their normals, ready for vector loops: [coordinate][target]. v is a
 * vertex of the target's triangle, d the way from there to x, so that a source that touches the
 * target in v, however small both are, is seen without cancellation. */
struct rad_facet_targets {
  const double *v[3], *d[3], *normal[3]; /* [m], [m], [-] */
};

/**
 * K[i] = int G(x_i, y) dS over the triangle for the targets first..first + RAD_FACET_LANES
 *
 *   K = 1/(2 pi) | sum_m theta_m n_x.Gamma_m |,  theta_m the angle between R_m and R_{m+1},
 *   R_m = y_m - x,  Gamma_m = R_m x (y_{m+1} - y_m) / | . |                      (theory 3.9)
 *
 * The error is taken as 4e-16/(2 pi) sum_m theta_m |R_m| |y_{m+1} - y_m| / |R_m x (y_{m+1} - y_m)|
 * (theory 3.14; the relative error of each product of a side; |.|_1 for |R_m|; measured: less than
 * half of it). Relative to K that is about 1e-16 distance over extent, over both cosines. 0 for
 * targets behind the source.
 *
 * @param[in]  allowed    of each value
 * @param[out] value      [RAD_FACET_LANES]; NAN where rounding exceeds what is allowed, or a vertex
 * of the source is behind the target's plane
 * @return nonzero if there are NANs. No allocation; thread-safe.
 */
int rad_facet_values(const struct rad_facet_source *s, const struct rad_facet_targets *targets,
                     int first, struct rad_facet_error allowed, double *restrict value);

/**
 * The same for one target and a convex part of the source in front of its plane.
 *
 * @param[in] part  corners (b1, b2): y = v_0 + b1 (v_1 - v_0) + b2 (v_2 - v_0); in the order of the
 *                  triangle's vertices
 * @return the value, or NAN where rounding exceeds what is allowed
 */
double rad_facet_part(const struct rad_facet_source *s, const struct rad_facet_targets *targets,
                      int target, const struct rad_polygon *part, struct rad_facet_error allowed);

/* The part of the source in front of the plane of a target (cut: it crosses that plane), or all. */
void rad_facet_front(const struct rad_facet_source *s, const struct rad_facet_targets *targets,
                     int target, int cut, struct rad_polygon *part);

#endif
