#include "visibility/part_sight.h"

#include <math.h>
#include <stdlib.h>

#include "base/vec.h"

enum { MAX_POINT = RAD_MAX_PART_CORNER * RAD_MAX_PART_CORNER + 2 * RAD_MAX_PART_CORNER };

/* Where the hull of both parts meets the plane of an occluder, in coordinates of that plane. */
struct section {
  int n;
  int parted;   /* one part is on one side of the plane, the other on the other, weakly */
  int accurate; /* the points are known within the slack */
  double point[MAX_POINT][2];
};

/* Coordinates in the plane of an occluder: along the first side's inward normal, and across. */
struct axes {
  const double *origin, *normal, *u;
  double v[3];
};

static struct axes axes_of(const struct rad_occluders *o, const struct rad_occluder *k) {
  struct axes a = {o->scene->vertex[o->corner[k->first]], k->normal, o->inward[k->first], {0}};
  rad_cross(a.normal, a.u, a.v);
  return a;
}

static void flatten(const struct axes *a, const double x[3], double y[2]) {
  double r[3];
  rad_sub(x, a->origin, r);
  y[0] = rad_dot(a->u, r);
  y[1] = rad_dot(a->v, r);
}

/* The point of segment x y in the plane; h, g: heights of its ends. */
static void pierce(const struct rad_occluders *o, const struct axes *a, const double *x, double h,
                   const double *y, double g, struct section *s) {
  double at[3], t = h / (h - g), length2 = 0;
  for (int d = 0; d < 3; d++) {
    at[d] = x[d] + t * (y[d] - x[d]);
    length2 += (y[d] - x[d]) * (y[d] - x[d]);
  }
  double least = fabs(h - g) * o->slack / o->rounding;
  s->accurate &= least * least >= length2;
  flatten(a, at, s->point[s->n++]);
}

/* 0 if the hull is on one side of the plane. */
static int make_section(const struct rad_occluders *o, const struct axes *a,
                        const struct rad_part *p, const struct rad_part *q, struct section *s) {
  const struct rad_part *part[2] = {p, q};
  double height[2][RAD_MAX_PART_CORNER];
  int above[2] = {0}, below[2] = {0};
  for (int m = 0; m < 2; m++)
    for (int c = 0; c < part[m]->n; c++) {
      double r[3];
      rad_sub(part[m]->corner[c], a->origin, r);
      height[m][c] = rad_dot(a->normal, r);
      above[m] += height[m][c] > o->slack;
      below[m] += height[m][c] < -o->slack;
    }
  if (above[0] + above[1] == 0 || below[0] + below[1] == 0)
    return 0;
  s->n = 0;
  s->accurate = 1;
  s->parted = (!above[0] && !below[1]) || (!below[0] && !above[1]);
  for (int m = 0; m < 2; m++) {
    for (int c = 0; c < part[m]->n; c++)
      if (fabs(height[m][c]) <= o->slack)
        flatten(a, part[m]->corner[c], s->point[s->n++]);
    int n = part[m]->n; /* a part that the plane cuts does so in two of its sides */
    for (int c = 0; c < n; c++) {
      int d = c + 1 < n ? c + 1 : 0;
      if ((height[m][c] > o->slack && height[m][d] < -o->slack) ||
          (height[m][c] < -o->slack && height[m][d] > o->slack))
        pierce(o, a, part[m]->corner[c], height[m][c], part[m]->corner[d], height[m][d], s);
    }
  }
  for (int c = 0; c < p->n; c++)
    for (int d = 0; d < q->n; d++)
      if ((height[0][c] > o->slack && height[1][d] < -o->slack) ||
          (height[0][c] < -o->slack && height[1][d] > o->slack))
        pierce(o, a, p->corner[c], height[0][c], q->corner[d], height[1][d], s);
  return 1;
}

static int by_place(const void *left, const void *right) {
  const double *a = left, *b = right;
  if (a[0] != b[0])
    return a[0] < b[0] ? -1 : 1;
  return (a[1] > b[1]) - (a[1] < b[1]);
}

static double turn(const double a[2], const double b[2], const double c[2]) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* Convex hull, counterclockwise; sorts the points. Returns its corners' number (Andrew 1979). */
static int convex_hull(struct section *s, double hull[][2]) {
  int n = 0;
  qsort(s->point, (size_t)s->n, sizeof *s->point, by_place);
  for (int pass = 0, least = 2; pass < 2; pass++, least = n + 1) {
    for (int m = pass; m < s->n; m++) {
      const double *x = s->point[pass ? s->n - 1 - m : m];
      while (n >= least && turn(hull[n - 2], hull[n - 1], x) <= 0)
        n--;
      hull[n][0] = x[0];
      hull[n++][1] = x[1];
    }
  }
  return n > 1 ? n - 1 : n;
}

/* True if a side of the section has the polygon on its other side, weakly. */
static int section_separates(const struct rad_occluders *o, const struct rad_occluder *k,
                             const struct axes *a, struct section *s) {
  double hull[2 * MAX_POINT][2], corner[RAD_MAX_OCCLUDER_CORNER][2];
  int n = convex_hull(s, hull);
  for (int c = 0; c < k->n; c++)
    flatten(a, o->scene->vertex[o->corner[k->first + c]], corner[c]);
  for (int m = 0; m < n; m++) {
    const double *from = hull[m], *to = hull[m + 1 < n ? m + 1 : 0];
    double length = hypot(to[0] - from[0], to[1] - from[1]);
    int beyond = length > o->slack;
    for (int c = 0; c < k->n && beyond; c++)
      beyond = turn(from, to, corner[c]) <= o->slack * length;
    if (beyond)
      return 1;
  }
  return 0;
}

/* What one occluder leaves: the reasoning of sight.c, for convex parts. */
static enum rad_sight past(const struct rad_occluders *o, const struct rad_occluder *k,
                           const struct rad_part *p, const struct rad_part *q) {
  struct axes a = axes_of(o, k);
  struct section s;
  if (!make_section(o, &a, p, q, &s))
    return RAD_FREE;
  if (!s.accurate)
    return RAD_PARTLY;
  int all = s.parted;
  for (int side = k->first; side < k->first + k->n; side++) {
    double r[3], normal[2] = {rad_dot(o->inward[side], a.u), rad_dot(o->inward[side], a.v)};
    rad_sub(o->scene->vertex[o->corner[side]], a.origin, r);
    double from = rad_dot(o->inward[side], r);
    int outside = 0, inside = 0;
    for (int m = 0; m < s.n; m++) {
      double depth = normal[0] * s.point[m][0] + normal[1] * s.point[m][1] - from;
      outside += depth <= o->slack;
      inside += depth >= -o->slack;
    }
    if (outside == s.n)
      return RAD_FREE;
    all &= inside == s.n;
  }
  if (all)
    return RAD_HIDDEN;
  return section_separates(o, k, &a, &s) ? RAD_FREE : RAD_PARTLY;
}

enum rad_sight rad_sight_parts(const struct rad_occluders *o, const struct rad_part *p,
                               const struct rad_part *q, int *list, int *n) {
  int kept = 0;
  for (int i = 0; i < *n; i++) {
    enum rad_sight sight = past(o, &o->occluder[list[i]], p, q);
    if (sight == RAD_HIDDEN)
      return RAD_HIDDEN;
    if (sight == RAD_PARTLY)
      list[kept++] = list[i];
  }
  *n = kept;
  return kept ? RAD_PARTLY : RAD_FREE;
}
