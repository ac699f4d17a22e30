#include "factors/body.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/union_find.h"
#include "base/vec.h"
#include "visibility/bvh.h"

enum { MOST_POLYGONS = 200 }; /* of a body that is looked at */

/* Sides are joined to those of polygons that cast shadows; floors and walls around a scene do not.
 */
static int joined(const int *twin, const int *owner, const unsigned char *casts, int side) {
  for (int other = twin[side]; other >= 0 && other != side; other = twin[other])
    if (casts[owner[other]])
      return other;
  return -1;
}

static const double *corner_of(const struct rad_occluders *o, int polygon, int c) {
  const struct rad_occluder *k = &o->occluder[polygon];
  return o->scene->vertex[o->corner[k->first + c % k->n]];
}

static double height(const double normal[3], const double at[3], const double x[3]) {
  double r[3];
  rad_sub(x, at, r);
  return rad_dot(normal, r);
}

/* True if no vertex of the members is on either side of another than the rest. */
static int is_convex(const struct rad_occluders *o, int n, const int *member) {
  for (int a = 0; a < n; a++) {
    const struct rad_occluder *k = &o->occluder[member[a]];
    int above = 0, below = 0;
    for (int b = 0; b < n; b++)
      for (int c = 0; c < o->occluder[member[b]].n; c++) {
        double h = height(k->normal, corner_of(o, member[a], 0), corner_of(o, member[b], c));
        above |= h > o->slack;
        below |= h < -o->slack;
      }
    if (above && below)
      return 0;
  }
  return 1;
}

/* True if the whole scene is on one side of a plane. */
static int bounds_scene(const struct rad_occluders *o, const double normal[3], const double at[3]) {
  int above = 0, below = 0;
  for (int v = 0; v < o->scene->n_vertex && !(above && below); v++) {
    double h = height(normal, at, o->scene->vertex[v]);
    above |= h > o->slack;
    below |= h < -o->slack;
  }
  return !(above && below);
}

/* True if there are no free sides, or a lid over them would hide nothing. */
static int is_closed(const struct rad_occluders *o, const int *join, int n, const int *member) {
  double normal[3] = {0, 0, 0};
  const double *rim[2] = {NULL, NULL};
  for (int a = 0; a < n; a++) {
    const struct rad_occluder *k = &o->occluder[member[a]];
    for (int c = 0; c < k->n; c++) {
      const double *end[2] = {corner_of(o, member[a], c), corner_of(o, member[a], c + 1)};
      if (join[k->first + c] >= 0)
        continue;
      if (!rim[0]) {
        rim[0] = end[0];
        rim[1] = end[1];
      }
      for (int m = 0; m < 2; m++) {
        double u[3], v[3];
        rad_sub(rim[1], rim[0], u);
        rad_sub(end[m], rim[0], v);
        if (!(rad_dot(normal, normal) > 0)) {
          rad_cross(u, v, normal);
          double length = rad_norm(normal), zero = o->slack * rad_norm(u);
          for (int d = 0; d < 3; d++)
            normal[d] = length > zero ? normal[d] / length : 0;
        }
        if (fabs(rad_dot(normal, v)) > o->slack)
          return 0;
      }
    }
  }
  return !rim[0] || (rad_dot(normal, normal) > 0 && bounds_scene(o, normal, rim[0]));
}

/* Polygons of one body point to the next of it, from the first on. */
static void link(const struct rad_occluders *o, const int *owner, const int *join, int *parent,
                 int *next) {
  for (int k = 0; k < o->n; k++) {
    parent[k] = k;
    next[k] = -1;
  }
  for (int k = 0; k < o->n; k++)
    for (int c = o->occluder[k].first; c < o->occluder[k].first + o->occluder[k].n; c++)
      if (join[c] >= 0)
        parent[rad_find_root(parent, owner[join[c]])] = rad_find_root(parent, k);
  for (int k = o->n - 1; k >= 0; k--) {
    int root = rad_find_root(parent, k);
    if (root != k) {
      next[k] = next[root];
      next[root] = k;
    }
  }
}

static void find(const struct rad_occluders *o, const int *join, const unsigned char *casts,
                 const int *parent, const int *next, int *body) {
  int member[MOST_POLYGONS];
  for (int k = 0; k < o->n; k++)
    body[k] = -1;
  for (int k = 0; k < o->n; k++) {
    int n = 0;
    if (parent[k] != k || !casts[k])
      continue;
    for (int m = k; m >= 0 && n <= MOST_POLYGONS; m = next[m])
      if (n++ < MOST_POLYGONS)
        member[n - 1] = m;
    if (n <= MOST_POLYGONS && is_convex(o, n, member) && is_closed(o, join, n, member))
      for (int m = 0; m < n; m++)
        body[member[m]] = k;
  }
}

int rad_bodies_find(const struct rad_occluders *o, const int *twin, const int *owner, int *body) {
  size_t n = (size_t)o->n,
         n_side = n ? (size_t)(o->occluder[n - 1].first + o->occluder[n - 1].n) : 0;
  int *parent = rad_alloc(n, sizeof *parent), *next = rad_alloc(n, sizeof *next);
  int *join = rad_alloc(n_side, sizeof *join);
  unsigned char *casts = rad_calloc(n, 1);
  int failed = !parent || !next || !join || !casts;
  for (int k = 0; !failed && k < o->bvh->n_node; k++)
    for (int q = 0; q < o->bvh->node[k].n; q++)
      casts[o->bvh->item[o->bvh->node[k].first + q]] = 1;
  if (!failed) {
    for (size_t side = 0; side < n_side; side++)
      join[side] = casts[owner[side]] ? joined(twin, owner, casts, (int)side) : -1;
    link(o, owner, join, parent, next);
    find(o, join, casts, parent, next, body);
  }
  free(parent);
  free(next);
  free(join);
  free(casts);
  return failed ? -1 : 0;
}
