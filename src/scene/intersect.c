#include "scene/intersect.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"

#define PARALLEL 1e-2 /* sine of the angle between triangles that may lie in one plane */

enum { MAX_CORNER = 6 }; /* of a triangle cut by another */

/* The side of t from vertex m to the next: its first point, and the unit normal of its line that
 * points into t, in t's plane. */
static const double *side_of(const struct rad_triangle *t, int m, double inward[3]) {
  double edge[3], apex[3];
  rad_sub(t->v[(m + 1) % 3], t->v[m], edge);
  rad_sub(t->v[(m + 2) % 3], t->v[m], apex);
  rad_cross(t->normal, edge, inward);
  double length = rad_norm(inward);
  length = rad_dot(apex, inward) < 0 ? -length : length;
  for (int d = 0; d < 3; d++)
    inward[d] /= length;
  return t->v[m];
}

static double along_normal(const double x[3], const double origin[3], const double normal[3]) {
  double r[3];
  rad_sub(x, origin, r);
  return rad_dot(r, normal);
}

/* The point where the height falls from hp at p to 0, on the way to hq at q. */
static void cut_point(const double p[3], double hp, const double q[3], double hq, double x[3]) {
  double s = hp / (hp - hq);
  for (int d = 0; d < 3; d++)
    x[d] = p[d] + s * (q[d] - p[d]);
}

/* --- overlap --- */

/* How far `other` reaches over the side of t that it reaches over least. */
static double least_reach(const struct rad_triangle *t, const struct rad_triangle *other) {
  double least = INFINITY;
  for (int m = 0; m < 3; m++) {
    double inward[3], most = -INFINITY;
    const double *origin = side_of(t, m, inward);
    for (int o = 0; o < 3; o++)
      most = fmax(most, along_normal(other->v[o], origin, inward));
    least = fmin(least, most);
  }
  return least;
}

/* The part of a polygon on the inner side of a line (Sutherland and Hodgman): its corners. */
static int clip(int n, double (*x)[3], const double origin[3], const double inward[3]) {
  double kept[MAX_CORNER + 1][3];
  int n_kept = 0;
  for (int k = 0; k < n; k++) {
    const double *p = x[k], *q = x[(k + 1) % n];
    double hp = along_normal(p, origin, inward), hq = along_normal(q, origin, inward);
    if (hp >= 0 && n_kept < MAX_CORNER)
      memcpy(kept[n_kept++], p, sizeof kept[0]);
    if (((hp > 0 && hq < 0) || (hp < 0 && hq > 0)) && n_kept < MAX_CORNER)
      cut_point(p, hp, q, hq, kept[n_kept++]);
  }
  memcpy(x, kept, (size_t)n_kept * sizeof *x);
  return n_kept;
}

int rad_triangles_overlap(const struct rad_triangle *a, const struct rad_triangle *b,
                          double tolerance, double *above) {
  double across[3], x[MAX_CORNER][3];
  rad_cross(a->normal, b->normal, across);
  if (rad_dot(across, across) > PARALLEL * PARALLEL)
    return 0;
  const struct rad_triangle *large = a->area < b->area ? b : a, *small = large == a ? b : a;
  if (least_reach(large, small) <= tolerance || least_reach(small, large) <= tolerance)
    return 0;
  int n = 3;
  memcpy(x, small->v, sizeof small->v);
  for (int m = 0; m < 3; m++) {
    double inward[3];
    const double *origin = side_of(large, m, inward);
    n = clip(n, x, origin, inward);
  }
  double low = INFINITY, high = -INFINITY;
  for (int k = 0; k < n; k++) {
    double height = along_normal(x[k], large->v[0], large->normal);
    low = fmin(low, height);
    high = fmax(high, height);
  }
  *above = high;
  return n > 0 && low >= -tolerance && high <= tolerance;
}

/* --- crossing --- */

/* Where t meets the plane of `other`, if it reaches beyond it on both sides by more than the
 * tolerance. Shared vertices are in the plane. */
static int find_chord(const struct rad_triangle *t, const struct rad_triangle *other,
                      double tolerance, double chord[2][3]) {
  double h[3];
  int n = 0, front = 0, behind = 0;
  for (int m = 0; m < 3; m++) {
    h[m] = along_normal(t->v[m], other->v[0], other->normal);
    for (int o = 0; o < 3; o++)
      h[m] = t->vertex[m] == other->vertex[o] ? 0 : h[m];
    h[m] = fabs(h[m]) <= tolerance ? 0 : h[m];
    front |= h[m] > 0;
    behind |= h[m] < 0;
  }
  if (!front || !behind)
    return 0;
  for (int m = 0; m < 3; m++) {
    int next = (m + 1) % 3;
    if (h[m] == 0)
      memcpy(chord[n++], t->v[m], sizeof chord[0]);
    else if (h[m] * h[next] < 0)
      cut_point(t->v[m], h[m], t->v[next], h[next], chord[n++]);
  }
  return 1; /* with vertices on both sides there are two ends */
}

static int is_inside(const double x[3], const struct rad_triangle *t, double tolerance) {
  for (int m = 0; m < 3; m++) {
    double inward[3];
    const double *origin = side_of(t, m, inward);
    if (along_normal(x, origin, inward) <= tolerance)
      return 0;
  }
  return 1;
}

static double length_of(double chord[2][3], double direction[3]) {
  rad_sub(chord[1], chord[0], direction);
  return rad_norm(direction);
}

int rad_triangles_cross(const struct rad_triangle *a, const struct rad_triangle *b,
                        double tolerance) {
  double of_a[2][3], of_b[2][3], along_a[3], along_b[3], x[3];
  if (!find_chord(a, b, tolerance, of_a) || !find_chord(b, a, tolerance, of_b))
    return 0;
  double length_a = length_of(of_a, along_a), length_b = length_of(of_b, along_b);
  const int first = length_a >= length_b; /* the longer one gives the direction */
  double(*chord)[3] = first ? of_a : of_b, (*other)[3] = first ? of_b : of_a;
  double *direction = first ? along_a : along_b, length = first ? length_a : length_b;
  if (length <= tolerance)
    return 0;
  for (int d = 0; d < 3; d++)
    direction[d] /= length;
  double p = along_normal(other[0], chord[0], direction);
  double q = along_normal(other[1], chord[0], direction);
  double low = fmax(0, fmin(p, q)), high = fmin(length, fmax(p, q));
  for (int d = 0; d < 3; d++)
    x[d] = chord[0][d] + (low + high) / 2 * direction[d];
  return high - low > tolerance && is_inside(x, a, tolerance) && is_inside(x, b, tolerance);
}
