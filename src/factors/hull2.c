#include "factors/hull2.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double turn_2d(const double a[2], const double b[2], const double c[2]) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static int compare_points(const void *a, const void *b) {
  const double *p = a, *q = b;
  return p[0] != q[0] ? (p[0] > q[0]) - (p[0] < q[0]) : (p[1] > q[1]) - (p[1] < q[1]);
}

/* Append the lower hull of sorted points, without the last; step -1: the upper hull. */
static void add_chain(int n, const double (*at)[2], int step, struct rad_polygon *hull) {
  int begin = hull->n;
  for (int k = 0; k < n; k++) {
    const double *p = at[step > 0 ? k : n - 1 - k];
    while (hull->n >= begin + 2 &&
           turn_2d(hull->corner[hull->n - 2], hull->corner[hull->n - 1], p) <= 0)
      hull->n--;
    memcpy(hull->corner[hull->n++], p, sizeof hull->corner[0]);
  }
  hull->n--;
}

/* A. M. Andrew, Inf. Proc. Letters 9 (1979) 216-219. */
void rad_hull2(int n, double (*at)[2], struct rad_polygon *hull) {
  qsort(at, (size_t)n, sizeof *at, compare_points);
  hull->n = 0;
  add_chain(n, (const double(*)[2])at, 1, hull);
  add_chain(n, (const double(*)[2])at, -1, hull);
}

void rad_common(const struct rad_polygon *with, struct rad_polygon *part) {
  if (with->n < 3)
    part->n = 0;
  for (int k = 0; k < with->n && part->n; k++) {
    const double *a = with->corner[k], *b = with->corner[k + 1 < with->n ? k + 1 : 0];
    double dx = b[0] - a[0], dy = b[1] - a[1];
    if (part->n >= RAD_MAX_CORNER - 1)
      return; /* too large a part is on the safe side */
    rad_clip(part, dy * a[0] - dx * a[1], -dy, dx);
  }
}
