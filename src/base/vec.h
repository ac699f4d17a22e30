/* Three-vectors. */
#ifndef RAD_BASE_VEC_H
#define RAD_BASE_VEC_H

#include <math.h>

static inline double rad_dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void rad_sub(const double a[3], const double b[3], double c[3]) {
  for (int i = 0; i < 3; i++)
    c[i] = a[i] - b[i];
}

static inline void rad_cross(const double a[3], const double b[3], double c[3]) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

static inline double rad_norm(const double a[3]) {
  return sqrt(rad_dot(a, a));
}

#endif
