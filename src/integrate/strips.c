#include "integrate/strips.h"

#include <math.h>

#define ROUNDING 1e-15 /* of cut corners, over the size of what they were cut from */
#define SAME_RAY 1e-14

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

/* Angles t of the polygon's corners, ascending: [RAD_MAX_CORNER]. A corner's t is good to
 * `rounding` over its r; within that it is on the ray of a corner farther out, if there is one.
 * Returns their number; at_corner: the polygon reaches the patch's corner. */
static int corner_rays(const struct rad_polygon *polygon, double rounding, double *t,
                       int *at_corner) {
  int n = 0, left = polygon->n, done[RAD_MAX_CORNER] = {0};
  for (; left > 0; left--) {
    int far = -1, known = 0;
    for (int i = 0; i < polygon->n; i++)
      if (!done[i] && (far < 0 || polygon->corner[i][0] > polygon->corner[far][0]))
        far = i;
    double r = polygon->corner[far][0], at = polygon->corner[far][1] / r;
    if (!(r > rounding))
      break;
    done[far] = 1;
    for (int i = 0; i < n; i++)
      known |= fabs(t[i] - at) <= SAME_RAY + rounding / r;
    int place = known ? -1 : n++;
    for (; place > 0 && t[place - 1] > at; place--)
      t[place] = t[place - 1];
    if (!known)
      t[place] = at;
  }
  *at_corner = left > 0;
  return n;
}

int rad_strips(const struct rad_patch *patch, const struct rad_element *e,
               const struct rad_polygon *polygon, struct rad_strip *strip) {
  double t[RAD_MAX_CORNER], sigma[RAD_MAX_CORNER];
  int at_corner, n = corner_rays(polygon, ROUNDING * rad_graded(e->tau[1], e->p_r), t, &at_corner);
  for (int i = 0; i < n; i++) {
    double s = rad_ungraded(rad_angle_phi(patch->angle, t[i]), e->p_phi);
    sigma[i] = fmin(fmax(s, e->sigma[0]), e->sigma[1]);
  }
  for (int i = 0; i + 1 < n; i++) {
    double mid = 0.5 * (t[i] + t[i + 1]);
    strip[i].sigma[0] = sigma[i];
    strip[i].sigma[1] = sigma[i + 1];
    strip[i].lower = at_corner ? (struct rad_side_line){0, 1, 0} : side_at(polygon, mid, 0);
    strip[i].upper = side_at(polygon, mid, 1);
  }
  return n > 1 ? n - 1 : 0;
}
