#include "integrate/strips.h"

#include <math.h>

/* Cut corners are good to the rounding of the polygon's size: nearer to the patch's corner t means
 * nothing, and a strip no wider than that is none. */
#define ROUNDING 1e-15

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

/* A corner's ray, and by how much rounding may turn it. */
struct ray_at {
  double t, doubt;
};

static void sort(struct ray_at *x, int n) {
  for (int i = 1; i < n; i++)
    for (int j = i; j > 0 && x[j].t < x[j - 1].t; j--) {
      struct ray_at keep = x[j];
      x[j] = x[j - 1];
      x[j - 1] = keep;
    }
}

int rad_strips(const struct rad_patch *patch, const struct rad_element *e,
               const struct rad_polygon *polygon, struct rad_strip *strip) {
  struct ray_at ray[RAD_MAX_CORNER];
  double most = rad_graded(e->tau[1], e->p_r); /* a cut rounds by the size of the whole */
  int n_ray = 0, n = 0, at_corner = 0;
  for (int i = 0; i < polygon->n; i++) {
    double r = polygon->corner[i][0];
    if (r > ROUNDING * most)
      ray[n_ray++] = (struct ray_at){polygon->corner[i][1] / r, 1e-14 + ROUNDING * most / r};
    else
      at_corner = 1; /* the patch's corner: on every ray */
  }
  sort(ray, n_ray);
  for (int i = 0; i + 1 < n_ray; i++) {
    const struct ray_at *side = &ray[i];
    if (side[1].t - side[0].t <= fmax(side[0].doubt, side[1].doubt))
      continue;
    double mid = 0.5 * (side[0].t + side[1].t);
    struct rad_strip *s = &strip[n++];
    for (int d = 0; d < 2; d++)
      s->sigma[d] =
          fmin(fmax(rad_ungraded(rad_angle_phi(patch->angle, side[d].t), e->p_phi), e->sigma[0]),
               e->sigma[1]);
    s->lower = at_corner ? (struct rad_side_line){0, 1, 0} : side_at(polygon, mid, 0);
    s->upper = side_at(polygon, mid, 1);
  }
  return n;
}
