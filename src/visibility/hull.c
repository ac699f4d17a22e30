#include "visibility/hull.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "visibility/facing.h"

/* Append the part of triangle j in front of a plane above which its vertices are h high. */
static void add_front(struct rad_hull *hull, const double h[3], const struct rad_triangle *j) {
  for (int m = 0; m < 3; m++) {
    int next = (m + 1) % 3;
    if (h[m] >= 0) {
      hull->vertex[hull->n] = j->vertex[m];
      memcpy(hull->corner[hull->n++], j->v[m], sizeof j->v[m]);
    }
    if ((h[m] < 0 && h[next] > 0) || (h[m] > 0 && h[next] < 0)) {
      double s = h[m] / (h[m] - h[next]), *corner = hull->corner[hull->n];
      hull->vertex[hull->n++] = -1;
      for (int d = 0; d < 3; d++)
        corner[d] = j->v[m][d] + s * (j->v[next][d] - j->v[m][d]);
    }
  }
}

int rad_hull_make(struct rad_hull *hull, const struct rad_triangle *i,
                  const struct rad_triangle *j) {
  double of_j[3], of_i[3];
  rad_heights(i, j, of_j);
  if (!(of_j[0] > 0 || of_j[1] > 0 || of_j[2] > 0))
    return 0;
  rad_heights(j, i, of_i);
  if (!(of_i[0] > 0 || of_i[1] > 0 || of_i[2] > 0))
    return 0;
  hull->n = 0;
  add_front(hull, of_i, i);
  hull->n_first = hull->n;
  add_front(hull, of_j, j);
  for (int d = 0; d < 3; d++) {
    double low = hull->corner[0][d], high = low;
    for (int c = 1; c < hull->n; c++) {
      low = hull->corner[c][d] < low ? hull->corner[c][d] : low;
      high = hull->corner[c][d] > high ? hull->corner[c][d] : high;
    }
    hull->low[d] = low;
    hull->high[d] = high;
  }
  return 1;
}

/* A polygon to be kept out of the hull. */
struct polygon {
  int n;
  const double (*corner)[3];
  double slack;
};

/* True if a plane with this normal, of any length, separates hull and k. */
static int separates(const double axis[3], const struct rad_hull *hull, const struct polygon *k) {
  double length = rad_norm(axis);
  if (!(length > 0))
    return 0;
  double hull_low = INFINITY, hull_high = -INFINITY, low = INFINITY, high = -INFINITY, r[3];
  for (int c = 0; c < hull->n; c++) {
    rad_sub(hull->corner[c], hull->corner[0], r);
    hull_low = fmin(hull_low, rad_dot(axis, r));
    hull_high = fmax(hull_high, rad_dot(axis, r));
  }
  for (int m = 0; m < k->n; m++) {
    rad_sub(k->corner[m], hull->corner[0], r);
    low = fmin(low, rad_dot(axis, r));
    high = fmax(high, rad_dot(axis, r));
  }
  return fmin(hull_high - low, high - hull_low) <= k->slack * length;
}

int rad_hull_separated(const struct rad_hull *hull, double slack, const double normal[3], int n,
                       const double (*corner)[3]) {
  const struct polygon k = {n, corner, slack};
  if (separates(normal, hull, &k))
    return 1;
  for (int a = 0; a < hull->n; a++)
    for (int b = a + 1; b < hull->n; b++) {
      double u[3], v[3], axis[3];
      rad_sub(hull->corner[b], hull->corner[a], u);
      for (int c = b + 1; c < hull->n; c++) {
        rad_sub(hull->corner[c], hull->corner[a], v);
        rad_cross(u, v, axis);
        if (separates(axis, hull, &k))
          return 1;
      }
      for (int m = 0; m < n; m++) {
        rad_sub(corner[(m + 1) % n], corner[m], v);
        rad_cross(u, v, axis);
        if (separates(axis, hull, &k))
          return 1;
      }
    }
  return 0;
}
