#include "visibility/irradiance.h"

#include <math.h>

#include "base/simd_math.h"
#include "base/vec.h"

/* theta n_x.(p x q) / |p x q| of the side from x + p to x + q, in the plane z. */
static inline double side_share(const double p[3], const double q[3], double dx, double dy,
                                const double normal[3]) {
  double p2 = rad_dot(p, p), q2 = rad_dot(q, q), z = -p[2];
  const double *near = p2 < q2 ? p : q;
  double cross[3] = {z * dy, -z * dx, near[0] * dy - near[1] * dx};
  double length = rad_norm(cross);
  return length > 0 ? rad_atan2(length, rad_dot(p, q)) * (rad_dot(normal, cross) / length) : 0;
}

double rad_polygon_form_factor(const struct rad_polygon *polygon, const double x[3],
                               const double normal[3]) {
  double sum = 0;
  for (int e = 0; e < polygon->n; e++) {
    const double *a = polygon->corner[e], *b = polygon->corner[e + 1 < polygon->n ? e + 1 : 0];
    const double p[3] = {a[0] - x[0], a[1] - x[1], -x[2]};
    const double q[3] = {b[0] - x[0], b[1] - x[1], -x[2]};
    sum += side_share(p, q, b[0] - a[0], b[1] - a[1], normal);
  }
  return fabs(sum) * (0.5 / M_PI);
}

double rad_parts_form_factor(const struct rad_parts *parts, const double x[3],
                             const double normal[3]) {
  double sum = 0;
  for (int p = 0; p < parts->n; p++)
    sum += rad_polygon_form_factor(&parts->part[p], x, normal);
  return sum;
}
