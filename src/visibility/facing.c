#include "visibility/facing.h"

#include <math.h>
#include <stdlib.h>

#include "base/vec.h"
#include "visibility/hull.h"

#define IN_PLANE 1e-12 /* height over extent or distance that counts as zero: rounding */
#define OVERLAP 1e-10  /* of the scene's size: less counts as separated; the welding distance */

static double square_of_distance(const double a[3], const double b[3]) {
  double d[3];
  rad_sub(a, b, d);
  return rad_dot(d, d);
}

static double larger(double a, double b) { /* fmax is a call, for the sake of NaN */
  return a > b ? a : b;
}

static double square_of_extent(const struct rad_triangle *t) {
  return larger(square_of_distance(t->v[0], t->v[1]),
                larger(square_of_distance(t->v[1], t->v[2]), square_of_distance(t->v[2], t->v[0])));
}

/* The larger triangle's; `known` < 0 until it is needed. */
static double common_extent(const struct rad_triangle *i, const struct rad_triangle *j,
                            double *known) {
  if (*known < 0)
    *known = larger(square_of_extent(i), square_of_extent(j));
  return *known;
}

/* Height of j's vertex m above the plane of i; see rad_heights. */
static inline double height_of(const struct rad_triangle *i, const struct rad_triangle *j, int m,
                               double *extent) {
  int vertex = j->vertex[m];
  double r[3];
  rad_sub(j->v[m], i->v[0], r);
  double height = rad_dot(i->normal, r), zero = IN_PLANE * IN_PLANE;
  if (height * height <= zero * rad_dot(r, r) || vertex == i->vertex[0] || vertex == i->vertex[1] ||
      vertex == i->vertex[2] || height * height <= zero * common_extent(i, j, extent))
    return 0;
  return height;
}

void rad_heights(const struct rad_triangle *i, const struct rad_triangle *j, double h[3]) {
  double extent = -1;
  for (int m = 0; m < 3; m++)
    h[m] = height_of(i, j, m, &extent);
}

enum rad_side_of_plane rad_side_of(const struct rad_triangle *i, const struct rad_triangle *j) {
  double h[3];
  rad_heights(i, j, h);
  int front = h[0] > 0 || h[1] > 0 || h[2] > 0;
  int behind = h[0] < 0 || h[1] < 0 || h[2] < 0;
  return front ? (behind ? RAD_ACROSS : RAD_IN_FRONT) : RAD_BEHIND;
}

/* True if j has a point in front of i, which one vertex then is. */
static int reaches_front(const struct rad_triangle *i, const struct rad_triangle *j,
                         double *extent) {
  for (int m = 0; m < 3; m++) {
    double r[3];
    rad_sub(j->v[m], i->v[0], r);
    if (rad_dot(i->normal, r) > 0 && height_of(i, j, m, extent) > 0)
      return 1;
  }
  return 0;
}

/* The points x of i and y of j with n_i.(y - x) > 0 and n_j.(x - y) > 0 are independent choices:
 * y in front of the plane of i, x in front of that of j. */
int rad_faces(const struct rad_triangle *i, const struct rad_triangle *j) {
  double extent = -1;
  return reaches_front(i, j, &extent) && reaches_front(j, i, &extent);
}

static int boxes_apart(const struct rad_hull *hull, const struct rad_triangle *k, double slack) {
  for (int d = 0; d < 3; d++) {
    double low = fmin(k->v[0][d], fmin(k->v[1][d], k->v[2][d]));
    double high = fmax(k->v[0][d], fmax(k->v[1][d], k->v[2][d]));
    if (low >= hull->high[d] - slack || high <= hull->low[d] + slack)
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
  struct rad_hull hull;
  if (!rad_hull_make(&hull, &t[i], &t[j]))
    return -1;
  for (int c = 0; c < n_candidate; c++) {
    int k = candidate ? candidate[c] : c;
    if (k != i && k != j && !boxes_apart(&hull, &t[k], slack) && !behind(&t[i], &t[k], slack) &&
        !behind(&t[j], &t[k], slack) && !rad_hull_separated(&hull, slack, t[k].normal, 3, t[k].v))
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
      if ((k = blocker_of(scene, i, j, n_candidate, candidate, slack)) >= 0) {
        found[0] = i;
        found[1] = j;
        found[2] = k;
      }
  free(candidate);
  return k >= 0;
}
