/* Convex polygons in space, and what a point receives from one: Lambert's closed form. */
#ifndef RAD_FACTORS_FLAT_H
#define RAD_FACTORS_FLAT_H

#include <string.h>

#include "base/simd_math.h"
#include "base/vec.h"
#include "visibility/clip.h"

/* Corners counterclockwise about the normal of the side that radiates. */
struct rad_flat {
  int n; /* 0: nothing */
  double corner[RAD_MAX_CORNER][3];
  double normal[3]; /* unit */
};

static inline double rad_distance2(const double a[3], const double b[3]) {
  double d[3];
  rad_sub(a, b, d);
  return rad_dot(d, d);
}

/* p = a + s (b - a) */
static inline void rad_between(const double a[3], const double b[3], double s, double p[3]) {
  for (int d = 0; d < 3; d++)
    p[d] = a[d] + s * (b[d] - a[d]);
}

/* p = sum lambda_m v_m */
static inline void rad_at_lambda(const double v[3][3], const double lambda[3], double p[3]) {
  for (int d = 0; d < 3; d++)
    p[d] = lambda[0] * v[0][d] + lambda[1] * v[1][d] + lambda[2] * v[2][d];
}

/* Twice the area times the normal that the corners run counterclockwise about. */
static inline void rad_flat_turn(const struct rad_flat *f, double turn[3]) {
  turn[0] = turn[1] = turn[2] = 0;
  for (int c = 1; c + 1 < f->n; c++) {
    double a[3], b[3], x[3];
    rad_sub(f->corner[c], f->corner[0], a);
    rad_sub(f->corner[c + 1], f->corner[0], b);
    rad_cross(a, b, x);
    for (int d = 0; d < 3; d++)
      turn[d] += x[d];
  }
}

static inline double rad_flat_area(const struct rad_flat *f) {
  double turn[3];
  rad_flat_turn(f, turn);
  return 0.5 * rad_norm(turn);
}

/* Let the corners run counterclockwise about the normal. */
static inline void rad_flat_orient(struct rad_flat *f) {
  double turn[3];
  rad_flat_turn(f, turn);
  if (rad_dot(turn, f->normal) >= 0)
    return;
  for (int a = 0, b = f->n - 1; a < b; a++, b--) {
    double kept[3];
    memcpy(kept, f->corner[a], sizeof kept);
    memcpy(f->corner[a], f->corner[b], sizeof kept);
    memcpy(f->corner[b], kept, sizeof kept);
  }
}

/**
 * Form factor from a point to a polygon in front of its plane that it sees all of:
 *
 *   F = 1/(2 pi) |sum_e theta_e n.(r_e x r_{e+1}) / |r_e x r_{e+1}||,  r_e = y_e - x (theory 3.9)
 *
 * The cross product is formed from the side and the nearer of its corners.
 */
static inline double rad_flat_factor(const double x[3], const double normal[3],
                                     const struct rad_flat *f) {
  double sum = 0;
  for (int e = 0; e < f->n; e++) {
    const double *a = f->corner[e], *b = f->corner[e + 1 < f->n ? e + 1 : 0];
    double p[3], q[3], side[3], cross[3];
    rad_sub(a, x, p);
    rad_sub(b, x, q);
    rad_sub(b, a, side);
    rad_cross(rad_dot(p, p) < rad_dot(q, q) ? p : q, side, cross);
    double length = rad_norm(cross);
    if (length > 0)
      sum += rad_atan2(length, rad_dot(p, q)) * (rad_dot(normal, cross) / length);
  }
  return fabs(sum) * (0.5 / M_PI);
}

#endif
