#include "integrate/strips.h"

#include <math.h>

struct rad_strip rad_strip_whole(const struct rad_element *e) {
  return (struct rad_strip){{e->sigma[0], e->sigma[1]},
                            {rad_graded(e->tau[0], e->p_r), 1, 0},
                            {rad_graded(e->tau[1], e->p_r), 1, 0}};
}

void rad_element_polygon(const struct rad_patch *patch, const struct rad_element *e,
                         struct rad_polygon *polygon) {
  double r0 = rad_graded(e->tau[0], e->p_r), r1 = rad_graded(e->tau[1], e->p_r);
  double t0 = rad_angle_t(patch->angle, rad_graded(e->sigma[0], e->p_phi));
  double t1 = rad_angle_t(patch->angle, rad_graded(e->sigma[1], e->p_phi));
  double corner[4][2] = {{r0, r0 * t0}, {r1, r1 * t0}, {r1, r1 * t1}, {r0, r0 * t1}};
  polygon->n = r0 > 0 ? 4 : 3;
  for (int i = 0; i < polygon->n; i++)
    for (int d = 0; d < 2; d++)
      polygon->corner[i][d] = corner[i][d];
}

/* The side of the polygon met by the ray at angle t: from the corner out, first or last. */
static struct rad_side_line side_at(const struct rad_polygon *polygon, double t, int last) {
  struct rad_side_line found = {0, 1, 0};
  double best = last ? -1 : INFINITY;
  for (int i = 0; i < polygon->n; i++) {
    const double *p = polygon->corner[i], *q = polygon->corner[(i + 1) % polygon->n];
    double c1 = q[1] - p[1], c2 = p[0] - q[0], g = c1 * p[0] + c2 * p[1];
    double fp = p[1] - t * p[0], fq = q[1] - t * q[0]; /* sides of the ray */
    if ((fp > 0) == (fq > 0) && fp != 0 && fq != 0)
      continue;
    if (fp == fq)
      continue; /* along the ray */
    double r = p[0] + fp / (fp - fq) * (q[0] - p[0]);
    if (last ? r > best : r < best) {
      best = r;
      found = (struct rad_side_line){g, c1, c2};
    }
  }
  return found;
}

static void sort(double *x, int n) {
  for (int i = 1; i < n; i++)
    for (int j = i; j > 0 && x[j] < x[j - 1]; j--) {
      double keep = x[j];
      x[j] = x[j - 1];
      x[j - 1] = keep;
    }
}

int rad_strips(const struct rad_patch *patch, const struct rad_element *e,
               const struct rad_polygon *polygon, struct rad_strip *strip) {
  double t[RAD_MAX_CORNER];
  int n_t = 0, n = 0, at_corner = 0;
  for (int i = 0; i < polygon->n; i++) {
    if (polygon->corner[i][0] > 0)
      t[n_t++] = polygon->corner[i][1] / polygon->corner[i][0];
    else
      at_corner = 1; /* the patch's corner: on every ray */
  }
  sort(t, n_t);
  for (int i = 0; i + 1 < n_t; i++) {
    if (t[i + 1] - t[i] <= 1e-14)
      continue;
    double mid = 0.5 * (t[i] + t[i + 1]);
    struct rad_strip *s = &strip[n++];
    for (int d = 0; d < 2; d++)
      s->sigma[d] =
          fmin(fmax(rad_ungraded(rad_angle_phi(patch->angle, t[i + d]), e->p_phi), e->sigma[0]),
               e->sigma[1]);
    s->lower = at_corner ? (struct rad_side_line){0, 1, 0} : side_at(polygon, mid, 0);
    s->upper = side_at(polygon, mid, 1);
  }
  return n;
}
