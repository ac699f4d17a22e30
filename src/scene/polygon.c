#include "scene/polygon.h"

#include <math.h>

#include "base/vec.h"

#define FLAT 1e-14  /* area over squared diameter: none */
#define TOUCH 1e-12 /* of the diameter: on the line; rounding */
#define TIE 1e-9    /* relative difference of fatness that does not count */

/* Newell's normal, of length 2 area, from differences to the first corner. */
static void newell(const struct rad_polygon *p, double normal[3]) {
  normal[0] = normal[1] = normal[2] = 0;
  for (int k = 1; k + 1 < p->n; k++) {
    double u[3], v[3], w[3];
    rad_sub(p->x[k], p->x[0], u);
    rad_sub(p->x[k + 1], p->x[0], v);
    rad_cross(u, v, w);
    for (int m = 0; m < 3; m++)
      normal[m] += w[m];
  }
}

/* Twice the largest distance from the first corner: at least the diameter. */
static double extent(const struct rad_polygon *p) {
  double largest = 0;
  for (int k = 1; k < p->n; k++) {
    double d[3];
    rad_sub(p->x[k], p->x[0], d);
    largest = fmax(largest, rad_norm(d));
  }
  return 2 * largest;
}

static double bend_of(const struct rad_polygon *p, const double normal[3], double diameter) {
  double centre[3] = {0}, largest = 0;
  for (int k = 0; k < p->n; k++)
    for (int m = 0; m < 3; m++)
      centre[m] += (p->x[k][m] - p->x[0][m]) / p->n;
  for (int k = 0; k < p->n; k++) {
    double d[3];
    rad_sub(p->x[k], p->x[0], d);
    rad_sub(d, centre, d);
    largest = fmax(largest, fabs(rad_dot(d, normal)));
  }
  return largest / (rad_norm(normal) * diameter);
}

static void project(struct rad_polygon *p, const double normal[3]) {
  int axis = 0;
  for (int m = 1; m < 3; m++)
    axis = fabs(normal[m]) > fabs(normal[axis]) ? m : axis;
  int first = (axis + 1) % 3, second = (axis + 2) % 3;
  for (int k = 0; k < p->n; k++) {
    double d[3];
    rad_sub(p->x[k], p->x[0], d);
    p->corner[k] = (struct rad_polygon_corner){
        .at = {normal[axis] < 0 ? d[second] : d[first], normal[axis] < 0 ? d[first] : d[second]},
        .before = (k + p->n - 1) % p->n,
        .after = (k + 1) % p->n};
  }
}

/* Height of corner c over the line from a to b, times its length; and that length. */
static double height(const struct rad_polygon *p, int a, int b, int c, double *length) {
  const double *o = p->corner[a].at, *q = p->corner[b].at, *r = p->corner[c].at;
  double u[2] = {q[0] - o[0], q[1] - o[1]};
  *length = sqrt(u[0] * u[0] + u[1] * u[1]);
  return u[0] * (r[1] - o[1]) - u[1] * (r[0] - o[0]);
}

/* Whether c is on the left of the line from a to b, not counting (or counting) a thin band. */
static int is_left(const struct rad_polygon *p, int a, int b, int c, double touch) {
  double length, h = height(p, a, b, c, &length);
  return h > touch * length;
}

/* 4 sqrt(3) area / (sum of squared edges), in space; 0 unless counterclockwise in the plane. */
static double fatness(const struct rad_polygon *p, int a, int b, int c, double touch) {
  if (!is_left(p, a, b, c, touch) || !is_left(p, b, c, a, touch) || !is_left(p, c, a, b, touch))
    return 0;
  double u[3], v[3], w[3], n[3];
  rad_sub(p->x[b], p->x[a], u);
  rad_sub(p->x[c], p->x[b], v);
  rad_sub(p->x[a], p->x[c], w);
  rad_cross(u, v, n);
  return 2 * sqrt(3.0) * rad_norm(n) / (rad_dot(u, u) + rad_dot(v, v) + rad_dot(w, w));
}

/* Fatness of the ear at corner b; 0 if another corner lies in it or on its sides. */
static double ear_at(const struct rad_polygon *p, int b, double touch) {
  int a = p->corner[b].before, c = p->corner[b].after;
  double fat = fatness(p, a, b, c, touch);
  for (int k = p->corner[c].after; fat > 0 && k != a; k = p->corner[k].after)
    if (is_left(p, a, b, k, -touch) && is_left(p, b, c, k, -touch) && is_left(p, c, a, k, -touch))
      return 0;
  return fat;
}

static void emit(struct rad_polygon *p, int *n, int a, int b, int c) {
  p->triangle[*n][0] = a;
  p->triangle[*n][1] = b;
  p->triangle[*n][2] = c;
  ++*n;
}

/* The better split of the four corners that are left, one of which is a; 0 if there is none. */
static int split_four(struct rad_polygon *p, int *n, int a, double touch) {
  int b = p->corner[a].after, c = p->corner[b].after, d = p->corner[c].after;
  const int *v = p->vertex;
  double ac = fmin(fatness(p, a, b, c, touch), fatness(p, a, c, d, touch));
  double bd = fmin(fatness(p, a, b, d, touch), fatness(p, b, c, d, touch));
  if (!(ac > 0) && !(bd > 0))
    return 0;
  int low_ac = v[a] < v[c] ? v[a] : v[c], low_bd = v[b] < v[d] ? v[b] : v[d];
  int is_tie = fabs(ac - bd) <= TIE * ac;
  if (is_tie ? low_ac < low_bd : ac > bd) {
    emit(p, n, a, b, c);
    emit(p, n, a, c, d);
  } else {
    emit(p, n, a, b, d);
    emit(p, n, b, c, d);
  }
  return 1;
}

/* The fattest ear, going round from corner `first`; -1 if there is none. */
static int best_ear(const struct rad_polygon *p, int first) {
  int best = -1, k = first;
  do {
    if (p->corner[k].fatness > 0 && (best < 0 || p->corner[k].fatness > p->corner[best].fatness))
      best = k;
    k = p->corner[k].after;
  } while (k != first);
  return best;
}

enum rad_polygon_fault rad_polygon_triangulate(struct rad_polygon *p) {
  double normal[3], diameter = extent(p), touch = TOUCH * diameter;
  newell(p, normal);
  if (!(rad_norm(normal) > FLAT * diameter * diameter))
    return RAD_POLYGON_LINE;
  p->bend = bend_of(p, normal, diameter);
  project(p, normal);
  int n = 0, first = 0;
  for (int k = 0; p->n > 4 && k < p->n; k++)
    p->corner[k].fatness = ear_at(p, k, touch);
  for (int left = p->n; left > 4; left--) {
    int b = best_ear(p, first);
    if (b < 0)
      return RAD_POLYGON_CROSSED;
    int a = p->corner[b].before, c = p->corner[b].after;
    emit(p, &n, a, b, c);
    p->corner[a].after = c;
    p->corner[c].before = a;
    p->corner[a].fatness = ear_at(p, a, touch);
    p->corner[c].fatness = ear_at(p, c, touch);
    first = a;
  }
  if (p->n > 3)
    return split_four(p, &n, first, touch) ? RAD_POLYGON_FINE : RAD_POLYGON_CROSSED;
  emit(p, &n, 0, 1, 2);
  return RAD_POLYGON_FINE;
}
