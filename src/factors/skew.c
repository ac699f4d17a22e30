#include "factors/skew.h"

#include <math.h>

#include "factors/exchange.h"
#include "factors/hull2.h"

#define ROUGH 1e-2
#define NOTHING 1e-24 /* of the square of the pair's size: an area */

#define HINGES                                                                                     \
  0.15 /* of a part: mean of a square over a triangle, a sixth to a half, in half of it */
#define FLAT 1e-9 /* sine that is none */

/* The target's plane. */
struct screen {
  const struct rad_pair *p;
  double u[3], v[3];
  struct rad_polygon face;                      /* the target, counterclockwise */
  struct rad_polygon swept[RAD_MAX_SILHOUETTE]; /* where the shadow of an edge may be */
  double along[RAD_MAX_SILHOUETTE][3][2]; /* its direction, from each corner of the cell; or 0 */
};

static void set_screen(const struct rad_pair *p, struct screen *s) {
  const struct rad_flat *t = &p->face;
  double r[3];
  s->p = p;
  rad_sub(t->corner[1], t->corner[0], s->u);
  double length = rad_norm(s->u);
  for (int d = 0; d < 3; d++)
    s->u[d] /= length;
  rad_cross(t->normal, s->u, s->v);
  s->face.n = t->n;
  for (int c = 0; c < t->n; c++) {
    rad_sub(t->corner[c], t->corner[0], r);
    s->face.corner[c][0] = rad_dot(s->u, r);
    s->face.corner[c][1] = rad_dot(s->v, r);
  }
}

/* Shadow on the screen of a point of height hp, seen from y of height hy > hp. */
static void cast(const struct screen *s, const double y[3], double hy, const double q[3], double hq,
                 double at[2]) {
  double z[3], r[3];
  rad_between(y, q, hy / (hy - hq), z);
  rad_sub(z, s->p->face.corner[0], r);
  at[0] = rad_dot(s->u, r);
  at[1] = rad_dot(s->v, r);
}

static double height(const struct screen *s, const double x[3]) {
  double r[3];
  rad_sub(x, s->p->face.corner[0], r);
  return rad_dot(s->p->face.normal, r);
}

/* Keep the part of an edge within the shaft; 0 if there is none. */
static int clip_edge(const struct rad_shaft *shaft, double end[2][3]) {
  double first = 0, last = 1, p[3], q[3];
  memcpy(p, end[0], sizeof p);
  memcpy(q, end[1], sizeof q);
  for (int k = 0; k < shaft->n; k++) {
    double a = shaft->offset[k] - rad_dot(shaft->normal[k], p);
    double b = shaft->offset[k] - rad_dot(shaft->normal[k], q);
    if (a < 0 && b < 0)
      return 0;
    if (a < 0)
      first = fmax(first, a / (a - b));
    else if (b < 0)
      last = fmin(last, a / (a - b));
  }
  rad_between(p, q, first, end[0]);
  rad_between(p, q, last, end[1]);
  return first < last;
}

/* The hull of an edge's shadows from the cell's corners, within the target; all of the target where
 * the edge, within the shaft, reaches higher than one of them. */
static void sweep(struct screen *s, const struct rad_flat *cell, const struct rad_shaft *shaft,
                  const struct rad_silhouette *edge, int e) {
  struct rad_polygon *swept = &s->swept[e];
  double end[2][3], at[6][2], h[2];
  int n = 0;
  memcpy(end[0], edge->p, sizeof end[0]);
  memcpy(end[1], edge->q, sizeof end[1]);
  memset(s->along[e], 0, sizeof s->along[e]);
  *swept = s->face;
  if (!clip_edge(shaft, end)) {
    swept->n = 0;
    return;
  }
  for (int k = 0; k < 2; k++)
    h[k] = fmax(0, height(s, end[k]));
  for (int m = 0; m < 3; m++) {
    double hy = height(s, cell->corner[m]);
    if (!(hy - fmax(h[0], h[1]) > 1e-9 * s->p->size))
      return;
    for (int k = 0; k < 2; k++)
      cast(s, cell->corner[m], hy, end[k], h[k], at[n++]);
  }
  for (int m = 0; m < 3; m++)
    for (int d = 0; d < 2; d++)
      s->along[e][m][d] = at[2 * m + 1][d] - at[2 * m][d];
  rad_hull2(n, at, swept);
  if (swept->n < 3)
    swept->n = 0;
  rad_common(&s->face, swept);
}

int rad_are_skew(const double *p, const double *q, const double *a, const double *b) {
  double u[3], v[3], w[3], cross[3];
  rad_sub(q, p, u);
  rad_sub(b, a, v);
  rad_sub(a, p, w);
  rad_cross(u, v, cross);
  double volume = rad_dot(cross, w);
  return volume * volume > FLAT * FLAT * rad_dot(u, u) * rad_dot(v, v) * rad_dot(w, w);
}

static int edges_are_skew(const struct rad_silhouette *a, const struct rad_silhouette *b) {
  return rad_are_skew(a->p, a->q, b->p, b->q);
}

/* True if a third edge may pass through the part: one of the target, or of another plane. */
static int third_edge(const struct screen *s, const struct rad_critical *c, int a, int b,
                      const struct rad_polygon *part) {
  double zero = 1e-12 * s->p->size;
  for (int k = 0; k < s->face.n; k++) {
    const double *p = s->face.corner[k], *q = s->face.corner[k + 1 < s->face.n ? k + 1 : 0];
    double dx = q[0] - p[0], dy = q[1] - p[1], length = hypot(dx, dy);
    const double *v = s->p->face.corner[k], *w = s->p->face.corner[k + 1 < s->face.n ? k + 1 : 0];
    if (!rad_are_skew(c->edge[a].p, c->edge[a].q, v, w) ||
        !rad_are_skew(c->edge[b].p, c->edge[b].q, v, w))
      continue;
    for (int m = 0; m < part->n; m++)
      if (dx * (part->corner[m][1] - p[1]) - dy * (part->corner[m][0] - p[0]) <= zero * length)
        return 1;
  }
  for (int e = 0; e < c->n_edge; e++) {
    struct rad_polygon common = *part;
    if (!edges_are_skew(&c->edge[e], &c->edge[a]) || !edges_are_skew(&c->edge[e], &c->edge[b]))
      continue;
    rad_common(&s->swept[e], &common);
    if (common.n >= 3)
      return 1;
  }
  return 0;
}

/* What the cell sends to a part of the screen, at most. */
static double sent(const struct screen *s, const struct rad_flat *cell,
                   const struct rad_polygon *part) {
  const struct rad_flat *t = &s->p->face;
  struct rad_flat f = {.n = part->n};
  double error;
  memcpy(f.normal, t->normal, sizeof f.normal);
  for (int c = 0; c < f.n; c++)
    for (int d = 0; d < 3; d++)
      f.corner[c][d] =
          t->corner[0][d] + part->corner[c][0] * s->u[d] + part->corner[c][1] * s->v[d];
  rad_flat_orient(&f);
  double value = rad_exchange(&s->p->g->gauss, cell, &f, ROUGH, &error);
  return value + error;
}

/* How much of the part may change: all of it if the shadows are nearly parallel, for the crossing
 * runs through it at once; else it sets in like a square, in a triangle that is a half of it. */
static double weight(const struct screen *s, int a, int b) {
  double least = 1;
  for (int m = 0; m < 3; m++) {
    const double *u = s->along[a][m], *v = s->along[b][m];
    double length = hypot(u[0], u[1]) * hypot(v[0], v[1]);
    double sine = length > 0 ? fabs(u[0] * v[1] - u[1] * v[0]) / length : 0;
    least = fmin(least, sine);
  }
  return least > HINGES ? HINGES / least : 1;
}

double rad_skew_bound(const struct rad_pair *p, const struct rad_flat *cell,
                      const struct rad_shaft *shaft, const struct rad_critical *c, double most) {
  struct screen s;
  double sum = 0;
  set_screen(p, &s);
  for (int e = 0; e < c->n_edge; e++)
    sweep(&s, cell, shaft, &c->edge[e], e);
  for (int a = 0; a < c->n_edge; a++)
    for (int b = a + 1; b < c->n_edge && sum < most; b++) {
      struct rad_polygon part = s.swept[a];
      if (rad_same_body(&c->edge[a], &c->edge[b]) || !edges_are_skew(&c->edge[a], &c->edge[b]))
        continue;
      rad_common(&s.swept[b], &part);
      if (part.n < 3 || !(rad_polygon_area(&part) > NOTHING * p->size * p->size) ||
          !third_edge(&s, c, a, b, &part))
        continue;
      sum += weight(&s, a, b) * sent(&s, cell, &part);
    }
  return fmin(sum, most);
}
