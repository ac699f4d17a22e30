#include "visibility/facing.h"

#include <float.h>

#include "base/vec.h"

#define IN_PLANE 1e-12 /* height over extent or distance that counts as zero: rounding */
#define ROUNDING (16 * DBL_EPSILON) /* height over the distance from the origin: the same */

static double square_of_distance(const double a[3], const double b[3]) {
  double d[3];
  rad_sub(a, b, d);
  return rad_dot(d, d);
}

static double larger(double a, double b) { /* fmax is a call, for the sake of NaN */
  return a > b ? a : b;
}

static double square_of_extent(const struct rad_triangle *t) {
  return larger(square_of_distance(t->v[0], t->v[1]),
                larger(square_of_distance(t->v[1], t->v[2]), square_of_distance(t->v[2], t->v[0])));
}

/* The larger triangle's; `known` < 0 until it is needed. */
static double common_extent(const struct rad_triangle *i, const struct rad_triangle *j,
                            double *known) {
  if (*known < 0)
    *known = larger(square_of_extent(i), square_of_extent(j));
  return *known;
}

/* Height of j's vertex m above the plane of i; see rad_heights. */
static inline double height_of(const struct rad_triangle *i, const struct rad_triangle *j, int m,
                               double *extent) {
  int vertex = j->vertex[m];
  double r[3];
  rad_sub(j->v[m], i->v[0], r);
  double height = rad_dot(i->normal, r), zero = IN_PLANE * IN_PLANE;
  double rounding = ROUNDING * ROUNDING * rad_dot(j->v[m], j->v[m]);
  if (height * height <= zero * rad_dot(r, r) || height * height <= rounding ||
      vertex == i->vertex[0] || vertex == i->vertex[1] || vertex == i->vertex[2] ||
      height * height <= zero * common_extent(i, j, extent))
    return 0;
  return height;
}

void rad_heights(const struct rad_triangle *i, const struct rad_triangle *j, double h[3]) {
  double extent = -1;
  for (int m = 0; m < 3; m++)
    h[m] = height_of(i, j, m, &extent);
}

enum rad_side_of_plane rad_side_of(const struct rad_triangle *i, const struct rad_triangle *j) {
  double h[3];
  rad_heights(i, j, h);
  int front = h[0] > 0 || h[1] > 0 || h[2] > 0;
  int behind = h[0] < 0 || h[1] < 0 || h[2] < 0;
  return front ? (behind ? RAD_ACROSS : RAD_IN_FRONT) : RAD_BEHIND;
}

/* True if j has a point in front of i, which one vertex then is. */
static int reaches_front(const struct rad_triangle *i, const struct rad_triangle *j,
                         double *extent) {
  for (int m = 0; m < 3; m++) {
    double r[3];
    rad_sub(j->v[m], i->v[0], r);
    if (rad_dot(i->normal, r) > 0 && height_of(i, j, m, extent) > 0)
      return 1;
  }
  return 0;
}

/* The points x of i and y of j with n_i.(y - x) > 0 and n_j.(x - y) > 0 are independent choices:
 * y in front of the plane of i, x in front of that of j. */
int rad_faces(const struct rad_triangle *i, const struct rad_triangle *j) {
  double extent = -1;
  return reaches_front(i, j, &extent) && reaches_front(j, i, &extent);
}
