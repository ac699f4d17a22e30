#include "hole_oracle.h"

#include <math.h>
#include <string.h>

/* The part of a polygon left of the line from a to b; the corners that are left. */
static int cut_left(int n, double (*c)[2], const double a[2], const double b[2]) {
  double out[16][2], f[16];
  int m = 0;
  for (int k = 0; k < n; k++)
    f[k] = (b[0] - a[0]) * (c[k][1] - a[1]) - (b[1] - a[1]) * (c[k][0] - a[0]);
  for (int k = 0; k < n; k++) {
    int next = (k + 1) % n;
    if (f[k] >= 0)
      memcpy(out[m++], c[k], sizeof out[0]);
    if ((f[k] < 0) != (f[next] < 0)) {
      double s = f[k] / (f[k] - f[next]);
      for (int d = 0; d < 2; d++)
        out[m][d] = c[k][d] + s * (c[next][d] - c[k][d]);
      m++;
    }
  }
  memcpy(c, out, sizeof out[0] * (size_t)m);
  return m;
}

/* Factor from (p, z) downwards to a polygon of the plane 0. */
static double factor(int n, double (*c)[2], const double p[2], double z) {
  double sum = 0;
  for (int k = 0; k < n; k++) {
    double ax = c[k][0] - p[0], ay = c[k][1] - p[1];
    double bx = c[(k + 1) % n][0] - p[0], by = c[(k + 1) % n][1] - p[1];
    double nx = z * (by - ay), ny = z * (ax - bx), nz = ax * by - ay * bx; /* times -1 */
    double length = sqrt(nx * nx + ny * ny + nz * nz);
    if (length > 0)
      sum += atan2(length, ax * bx + ay * by + z * z) * nz / length;
  }
  return fabs(sum) / (2 * M_PI);
}

double hole_exchange(const struct hole *hole, int n) {
  double sum = 0, dx = (hole->x1 - hole->x0) / n, dy = (hole->y1 - hole->y0) / n;
  double ratio = hole->z / (hole->h - hole->z), off = 0.5 / sqrt(3);
  for (int i = 0; i < 2 * n; i++)
    for (int j = 0; j < 2 * n; j++) {
      double p[2] = {hole->x0 + dx * (i / 2 + 0.5 + (i % 2 ? off : -off)),
                     hole->y0 + dy * (j / 2 + 0.5 + (j % 2 ? off : -off))};
      double c[16][2];
      int m = 3;
      for (int k = 0; k < 3; k++)
        for (int d = 0; d < 2; d++)
          c[k][d] = p[d] - ratio * (hole->high[k][d] - p[d]);
      for (int k = 0; k < 3 && m; k++)
        m = cut_left(m, c, hole->low[k], hole->low[(k + 1) % 3]);
      if (m > 2)
        sum += factor(m, c, p, hole->z);
    }
  return sum * 0.25 * dx * dy;
}
