#include "visibility/facing.h"

#include <math.h>
#include <stdlib.h>

#include "base/vec.h"

#define IN_PLANE 1e-12 /* height over extent or distance that counts as zero: rounding */
#define OVERLAP 1e-10  /* of the scene's size: less counts as separated; the welding distance */

enum { MAX_HULL = 8 }; /* two triangles, each cut once */

static double square_of_distance(const double a[3], const double b[3]) {
  double d[3];
  rad_sub(a, b, d);
  return rad_dot(d, d);
}

static double square_of_extent(const struct rad_triangle *t) {
  return fmax(square_of_distance(t->v[0], t->v[1]),
              fmax(square_of_distance(t->v[1], t->v[2]), square_of_distance(t->v[2], t->v[0])));
}

/* Heights of j's vertices above the plane of i; zero if shared or within rounding. */
static void heights(const struct rad_triangle *i, const struct rad_triangle *j, double h[3]) {
  double extent = fmax(square_of_extent(i), square_of_extent(j));
  for (int m = 0; m < 3; m++) {
    int vertex = j->vertex[m];
    h[m] = 0;
    if (vertex == i->vertex[0] || vertex == i->vertex[1] || vertex == i->vertex[2])
      continue;
    double r[3];
    rad_sub(j->v[m], i->v[0], r);
    double height = rad_dot(i->normal, r);
    if (height * height > IN_PLANE * IN_PLANE * fmax(extent, rad_dot(r, r)))
      h[m] = height;
  }
}

enum rad_side_of_plane rad_side_of(const struct rad_triangle *i, const struct rad_triangle *j) {
  double h[3];
  heights(i, j, h);
  int front = h[0] > 0 || h[1] > 0 || h[2] > 0;
  int behind = h[0] < 0 || h[1] < 0 || h[2] < 0;
  return front ? (behind ? RAD_ACROSS : RAD_IN_FRONT) : RAD_BEHIND;
}

/* The points x of i and y of j with n_i.(y - x) > 0 and n_j.(x - y) > 0 are independent choices:
 * y in front of the plane of i, x in front of that of j. */
int rad_faces(const struct rad_triangle *i, const struct rad_triangle *j) {
  return rad_side_of(i, j) != RAD_BEHIND && rad_side_of(j, i) != RAD_BEHIND;
}

/* Corners of what lies between i and j: the convex hull of both, each cut at the other's plane. */
struct hull {
  int n;
  double corner[MAX_HULL][3];
  double low[3], high[3];
  double slack; /* overlaps up to this are none [m] */
};

/* Append the part of j in front of the plane of i. */
static void add_front(struct hull *hull, const struct rad_triangle *i,
                      const struct rad_triangle *j) {
  double h[3];
  heights(i, j, h);
  for (int m = 0; m < 3; m++) {
    int next = (m + 1) % 3;
    if (h[m] >= 0) {
      double *corner = hull->corner[hull->n++];
      for (int d = 0; d < 3; d++)
        corner[d] = j->v[m][d];
    }
    if ((h[m] < 0 && h[next] > 0) || (h[m] > 0 && h[next] < 0)) {
      double s = h[m] / (h[m] - h[next]), *corner = hull->corner[hull->n++];
      for (int d = 0; d < 3; d++)
        corner[d] = j->v[m][d] + s * (j->v[next][d] - j->v[m][d]);
    }
  }
}

static void make_hull(struct hull *hull, const struct rad_triangle *i,
                      const struct rad_triangle *j) {
  hull->n = 0;
  add_front(hull, i, j);
  add_front(hull, j, i);
  for (int d = 0; d < 3; d++) {
    hull->low[d] = INFINITY;
    hull->high[d] = -INFINITY;
    for (int c = 0; c < hull->n; c++) {
      hull->low[d] = fmin(hull->low[d], hull->corner[c][d]);
      hull->high[d] = fmax(hull->high[d], hull->corner[c][d]);
    }
  }
}

static int boxes_apart(const struct hull *hull, const struct rad_triangle *k) {
  for (int d = 0; d < 3; d++) {
    double low = fmin(k->v[0][d], fmin(k->v[1][d], k->v[2][d]));
    double high = fmax(k->v[0][d], fmax(k->v[1][d], k->v[2][d]));
    if (low >= hull->high[d] - hull->slack || high <= hull->low[d] + hull->slack)
      return 1;
  }
  return 0;
}

/* True if no vertex of k is in front of i: then the plane of i keeps it away from every hull. */
static int behind(const struct rad_triangle *i, const struct rad_triangle *k, double slack) {
  for (int m = 0; m < 3; m++) {
    double r[3];
    rad_sub(k->v[m], i->v[0], r);
    if (rad_dot(i->normal, r) > slack)
      return 0;
  }
  return 1;
}

/* True if a plane with this normal, of any length, separates hull and k. */
static int separates(const double axis[3], const struct hull *hull, const struct rad_triangle *k) {
  double length = rad_norm(axis);
  if (!(length > 0))
    return 0;
  double hull_low = INFINITY, hull_high = -INFINITY, low = INFINITY, high = -INFINITY, r[3];
  for (int c = 0; c < hull->n; c++) {
    rad_sub(hull->corner[c], hull->corner[0], r);
    hull_low = fmin(hull_low, rad_dot(axis, r));
    hull_high = fmax(hull_high, rad_dot(axis, r));
  }
  for (int m = 0; m < 3; m++) {
    rad_sub(k->v[m], hull->corner[0], r);
    low = fmin(low, rad_dot(axis, r));
    high = fmax(high, rad_dot(axis, r));
  }
  return fmin(hull_high - low, high - hull_low) <= hull->slack * length;
}

/* Separating-axis theorem: the faces of the Minkowski difference hull - k are faces of the hull, k,
 * and edge times edge. Which corners span faces and edges is not worked out: all do as candidates.
 */
static int separated(const struct hull *hull, const struct rad_triangle *k) {
  if (separates(k->normal, hull, k))
    return 1;
  for (int a = 0; a < hull->n; a++)
    for (int b = a + 1; b < hull->n; b++) {
      double u[3], v[3], axis[3];
      rad_sub(hull->corner[b], hull->corner[a], u);
      for (int c = b + 1; c < hull->n; c++) {
        rad_sub(hull->corner[c], hull->corner[a], v);
        rad_cross(u, v, axis);
        if (separates(axis, hull, k))
          return 1;
      }
      for (int m = 0; m < 3; m++) {
        rad_sub(k->v[(m + 1) % 3], k->v[m], v);
        rad_cross(u, v, axis);
        if (separates(axis, hull, k))
          return 1;
      }
    }
  return 0;
}

/* A triangle with the whole scene on one side of its plane cannot stand between anything. */
static int supports(const struct rad_scene *scene, const struct rad_triangle *k, double slack) {
  double low = 0, high = 0;
  for (int v = 0; v < scene->n_vertex; v++) {
    double r[3];
    rad_sub(scene->vertex[v], k->v[0], r);
    low = fmin(low, rad_dot(k->normal, r));
    high = fmax(high, rad_dot(k->normal, r));
  }
  return fmin(high, -low) <= slack;
}

/* The first of the candidates (NULL: of all) that shadows the pair i, j, or -1. */
static int blocker_of(const struct rad_scene *scene, int i, int j, int n_candidate,
                      const int *candidate, double slack) {
  const struct rad_triangle *t = scene->triangle;
  struct hull hull = {.slack = slack};
  make_hull(&hull, &t[i], &t[j]);
  for (int c = 0; c < n_candidate; c++) {
    int k = candidate ? candidate[c] : c;
    if (k != i && k != j && !boxes_apart(&hull, &t[k]) && !behind(&t[i], &t[k], slack) &&
        !behind(&t[j], &t[k], slack) && !separated(&hull, &t[k]))
      return k;
  }
  return -1;
}

int rad_find_shadow(const struct rad_scene *scene, int found[3]) {
  const double slack = OVERLAP * scene->size;
  const struct rad_triangle *t = scene->triangle;
  int *candidate = malloc(((size_t)scene->n_triangle + 1) * sizeof *candidate);
  int n_candidate = candidate ? 0 : scene->n_triangle, k = -1; /* without memory: all, slowly */
  for (int c = 0; candidate && c < scene->n_triangle; c++)
    if (!supports(scene, &t[c], slack))
      candidate[n_candidate++] = c;
  for (int i = 0; n_candidate && k < 0 && i < scene->n_triangle; i++)
    for (int j = i + 1; k < 0 && j < scene->n_triangle; j++)
      if (rad_faces(&t[i], &t[j]) &&
          (k = blocker_of(scene, i, j, n_candidate, candidate, slack)) >= 0) {
        found[0] = i;
        found[1] = j;
        found[2] = k;
      }
  free(candidate);
  return k >= 0;
}
