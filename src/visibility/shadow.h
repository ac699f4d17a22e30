/* The shadow that one occluder casts on the plane of a source triangle, seen from one point. */
#ifndef RAD_VISIBILITY_SHADOW_H
#define RAD_VISIBILITY_SHADOW_H

#include "visibility/occluder.h"

enum { RAD_MAX_SHADOW_SIDE = RAD_MAX_OCCLUDER_CORNER + 1 };

/**
 * y in the source triangle is hidden from x iff every f_s(y) > 0, s < n. Each f_s is affine on the
 * source, and given by its values at the source's three vertices; it vanishes on the plane through
 * x and a side of the occluder, or on the occluder's own plane, which y must be beyond. Only those
 * that change sign in the source triangle are kept, and one if none does.
 */
struct rad_shadow {
  int n; /* 0: no shadow falls on the source triangle */
  double value[RAD_MAX_SHADOW_SIDE][3];
};

/**
 * Everything about target i, source j and occluder k that does not depend on the point x of i.
 *
 * With V the target's and v the source's vertices, lambda the barycentric coordinates of x in i, q
 * the occluder's corners counterclockwise about its normal n_k, and h the height of x above it
 * (theory 13.2):
 *
 *   f_s(v_m) = -sign(h) sum_c lambda_c det(q_s - V_c, q_{s+1} - V_c, v_m - V_c)
 *   f_n(v_m) = -sign(h) n_k.(v_m - q_0),   h = sum_c lambda_c n_k.(V_c - q_0)
 *
 * because the volume of the tetrahedron x, q_s, q_{s+1}, v_m is affine in x. The sign makes it the
 * cone from x through the occluder and not its mirror image. Vertices are subtracted from one
 * another before anything else, so what vanishes because a vertex is shared is 0. By topology or
 * within rounding (1e-12, as in rad_heights) so are heights of vertices in a plane, and the volumes
 * of those on the line of a side. A side in the plane of i has f_s(v_m) = +-|h| n_i.(v_m - V_0), up
 * to a factor, and one in the plane of j is n_j.(x - v_0) times an area: exact signs, however near
 * x is to that side or to j. So points near shared vertices and edges keep the relative accuracy of
 * lambda.
 */
struct rad_shadow_frame {
  int n;            /* sides of the occluder; 0: it never casts a shadow */
  double height[3]; /* [c] n_k.(V_c - q_0) [m] */
  double beyond[3]; /* [m] -n_k.(v_m - q_0) [m] */
  double side[RAD_MAX_OCCLUDER_CORNER][3][3]; /* [s][c][m] minus the determinants, up to a factor */
};

/**
 * @param[in] target, source  triangles of o->scene;  occluder: number in o->occluder
 * @param[out] frame  n = 0 if the occluder lies in the plane of target or source
 * Cost about 0.1 us a side. No allocation; thread-safe.
 */
void rad_shadow_frame_set(const struct rad_occluders *o, int target, int source, int occluder,
                          struct rad_shadow_frame *frame);

/**
 * The shadow seen from x = V_base + mu1 F1 + mu2 F2 of the target (see rad_patch).
 *
 * No shadow if x is in the occluder's plane. Cost 9 products a side.
 *
 * @param[in] base  0..2, a vertex that x is near to: lambda = (1 - mu1 - mu2, mu1, mu2) from there
 */
void rad_shadow_cast(const struct rad_shadow_frame *frame, int base, const double mu[2],
                     struct rad_shadow *shadow);

#endif
