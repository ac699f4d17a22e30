#include "visibility/clip.h"

#include <assert.h>

void rad_clip(struct rad_polygon *polygon, double c0, double c1, double c2) {
  assert(polygon->n < RAD_MAX_CORNER);
  struct rad_polygon in = *polygon;
  int n = 0, inside = 0;
  for (int i = 0; i < in.n; i++) {
    const double *p = in.corner[i], *q = in.corner[(i + 1) % in.n];
    double fp = c0 + c1 * p[0] + c2 * p[1], fq = c0 + c1 * q[0] + c2 * q[1];
    inside |= fp > 0;
    if (fp >= 0) {
      polygon->corner[n][0] = p[0];
      polygon->corner[n++][1] = p[1];
    }
    if ((fp < 0 && fq > 0) || (fp > 0 && fq < 0)) {
      double s = fp / (fp - fq);
      polygon->corner[n][0] = p[0] + s * (q[0] - p[0]);
      polygon->corner[n++][1] = p[1] + s * (q[1] - p[1]);
    }
  }
  polygon->n = inside ? n : 0;
}
