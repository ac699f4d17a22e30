#include "visibility/clip.h"

#include <assert.h>
#include <math.h>
#include <stddef.h>

/* A convex polygon gains one corner, and there is room for that. Corners that are convex but for
 * rounding may gain more: then memory is safe, and no more can be said. */
static inline void add(struct rad_polygon *polygon, double x, double y) {
  if (polygon->n < RAD_MAX_CORNER) {
    polygon->corner[polygon->n][0] = x;
    polygon->corner[polygon->n++][1] = y;
  }
}

void rad_split(const struct rad_polygon *polygon, double c0, double c1, double c2,
               struct rad_polygon *above, struct rad_polygon *below) {
  assert(polygon->n < RAD_MAX_CORNER);
  int n = polygon->n, any_above = 0, any_below = 0;
  double f[RAD_MAX_CORNER + 1];
  for (int i = 0; i < n; i++) {
    f[i] = c0 + c1 * polygon->corner[i][0] + c2 * polygon->corner[i][1];
    any_above |= f[i] > 0;
    any_below |= f[i] < 0;
  }
  f[n] = f[0];
  above->n = 0;
  if (below)
    below->n = 0;
  for (int i = 0; i < n; i++) {
    const double *p = polygon->corner[i], *q = polygon->corner[i + 1 < n ? i + 1 : 0];
    if (any_above && f[i] >= 0)
      add(above, p[0], p[1]);
    if (below && any_below && f[i] <= 0)
      add(below, p[0], p[1]);
    if ((f[i] < 0 && f[i + 1] > 0) || (f[i] > 0 && f[i + 1] < 0)) {
      double s = f[i] / (f[i] - f[i + 1]);
      double x = p[0] + s * (q[0] - p[0]), y = p[1] + s * (q[1] - p[1]);
      add(above, x, y);
      if (below)
        add(below, x, y);
    }
  }
}

void rad_clip(struct rad_polygon *polygon, double c0, double c1, double c2) {
  struct rad_polygon in = *polygon;
  rad_split(&in, c0, c1, c2, polygon, NULL);
}

double rad_polygon_area(const struct rad_polygon *polygon) {
  const double(*c)[2] = polygon->corner;
  double sum = 0;
  for (int i = 1; i + 1 < polygon->n; i++)
    sum += (c[i][0] - c[0][0]) * (c[i + 1][1] - c[0][1]) -
           (c[i][1] - c[0][1]) * (c[i + 1][0] - c[0][0]);
  return fabs(sum) / 2;
}
