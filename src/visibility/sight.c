#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec.h"
#include "visibility/bvh.h"
#include "visibility/facing.h"
#include "visibility/hull.h"
#include "visibility/occluder.h"

enum { MAX_SECTION = 16 }; /* corners above times corners below, and those in the plane */

/* What one polygon keeps two triangles from seeing of one another. */
enum block { BLOCKS_NONE, BLOCKS_SOME, BLOCKS_ALL };

/* Two triangles that face each other. */
struct pair {
  const struct rad_occluders *o;
  const struct rad_triangle *i, *j;
  int plane_i, plane_j;
  struct rad_hull hull;
  double center[3], along[3]; /* from i's centroid to j's: the axis of the shaft */
  double inverse;             /* 1 / along.along */
  double radius;              /* of the shaft: the hull is within it of the axis */
};

/* Where the hull meets the plane of a polygon: the convex hull of these points. */
struct section {
  int n;
  double at[MAX_SECTION][3];
  int from[MAX_SECTION][2]; /* the corners of the hull that it is between, maybe the same */
  int parted;   /* one triangle is on the one side of the plane, the other on the other, weakly */
  int accurate; /* `at` is known within the slack, along the plane */
};

/* --- cheap tests --- */

static double larger(double a, double b) { /* fmax is a call, for the sake of NaN */
  return a > b ? a : b;
}

static int boxes_apart(const double low[3], const double high[3], const struct rad_hull *hull,
                       double slack) {
  for (int d = 0; d < 3; d++)
    if (low[d] >= hull->high[d] - slack || high[d] <= hull->low[d] + slack)
      return 1;
  return 0;
}

/* True if no point of the box is in front of t. */
static int box_behind(const struct rad_box *box, const struct rad_triangle *t, double slack) {
  double most = 0;
  for (int d = 0; d < 3; d++)
    most += t->normal[d] * ((t->normal[d] > 0 ? box->high[d] : box->low[d]) - t->v[0][d]);
  return most <= slack;
}

/* True if the ball around the box does not reach the shaft. */
static int box_off_shaft(const struct rad_box *box, const struct pair *p) {
  double r[3], half[3];
  for (int d = 0; d < 3; d++) {
    r[d] = 0.5 * (box->low[d] + box->high[d]) - p->center[d];
    half[d] = 0.5 * (box->high[d] - box->low[d]);
  }
  double s = rad_dot(r, p->along) * p->inverse;
  s = s < 0 ? 0 : s > 1 ? 1 : s;
  for (int d = 0; d < 3; d++)
    r[d] -= s * p->along[d];
  double reach = p->radius + rad_norm(half);
  return rad_dot(r, r) > reach * reach;
}

/* True if no corner of the polygon is in front of t. */
static int polygon_behind(const struct rad_occluders *o, const struct rad_occluder *k,
                          const struct rad_triangle *t) {
  for (int c = 0; c < k->n; c++) {
    double r[3];
    rad_sub(o->scene->vertex[o->corner[k->first + c]], t->v[0], r);
    if (rad_dot(t->normal, r) > o->slack)
      return 0;
  }
  return 1;
}

/* --- the section --- */

static void add_corner(struct section *s, const struct rad_hull *hull, int c,
                       const double origin[3]) {
  rad_sub(hull->corner[c], origin, s->at[s->n]);
  s->from[s->n][0] = s->from[s->n][1] = c;
  s->n++;
}

/* The section's points, counted from the polygon's first corner. 0 if the hull is on one side. */
static int make_section(const struct pair *p, const struct rad_occluder *k, struct section *s) {
  const struct rad_hull *hull = &p->hull;
  const double *origin = p->o->scene->vertex[p->o->corner[k->first]];
  double h[RAD_MAX_HULL];
  int above[RAD_MAX_HULL], below[RAD_MAX_HULL], n_above = 0, n_below = 0;
  for (int c = 0; c < hull->n; c++) {
    double r[3];
    rad_sub(hull->corner[c], origin, r);
    h[c] = rad_dot(k->normal, r);
    if (h[c] > p->o->slack)
      above[n_above++] = c;
    else if (h[c] < -p->o->slack)
      below[n_below++] = c;
  }
  if (!n_above || !n_below)
    return 0;
  s->n = 0;
  for (int c = 0; c < hull->n; c++)
    if (fabs(h[c]) <= p->o->slack)
      add_corner(s, hull, c, origin);
  int n_first = hull->n_first;
  s->parted = above[n_above - 1] < n_first ? below[0] >= n_first
                                           : above[0] >= n_first && below[n_below - 1] < n_first;
  s->accurate = 1;
  for (int a = 0; a < n_above; a++)
    for (int b = 0; b < n_below; b++) {
      const double *x = hull->corner[above[a]], *y = hull->corner[below[b]];
      double d[3], drop = h[above[a]] - h[below[b]], t = h[above[a]] / drop, *at = s->at[s->n];
      rad_sub(y, x, d);
      for (int m = 0; m < 3; m++)
        at[m] = x[m] - origin[m] + t * d[m];
      s->from[s->n][0] = above[a];
      s->from[s->n++][1] = below[b];
      double least = drop * p->o->slack / p->o->rounding;
      s->accurate &= least * least >= rad_dot(d, d);
    }
  return 1;
}

/* A section and a polygon in the coordinates of their plane. */
struct flat {
  int n_s, n_k;
  double s[MAX_SECTION][2], k[RAD_MAX_OCCLUDER_CORNER][2];
};

static void flatten(const struct rad_occluders *o, const struct rad_occluder *k,
                    const struct section *s, struct flat *f) {
  const double *origin = o->scene->vertex[o->corner[k->first]], *u = o->inward[k->first];
  double v[3], r[3];
  rad_cross(k->normal, u, v);
  f->n_s = s->n;
  f->n_k = k->n;
  for (int q = 0; q < s->n; q++) {
    f->s[q][0] = rad_dot(u, s->at[q]);
    f->s[q][1] = rad_dot(v, s->at[q]);
  }
  for (int c = 0; c < k->n; c++) {
    rad_sub(o->scene->vertex[o->corner[k->first + c]], origin, r);
    f->k[c][0] = rad_dot(u, r);
    f->k[c][1] = rad_dot(v, r);
  }
}

static double cross_2d(const double p[2], const double q[2], const double r[2]) {
  return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
}

static double distance_2d(const double p[2], const double q[2]) {
  return sqrt((q[0] - p[0]) * (q[0] - p[0]) + (q[1] - p[1]) * (q[1] - p[1]));
}

/* True if the line through p and q has the polygon on its right and the section on its left. */
static int line_separates(const struct flat *f, const double p[2], const double q[2],
                          double slack) {
  double zero = slack * distance_2d(p, q);
  for (int c = 0; c < f->n_k; c++)
    if (cross_2d(p, q, f->k[c]) > zero)
      return 0;
  for (int c = 0; c < f->n_s; c++)
    if (cross_2d(p, q, f->s[c]) < -zero)
      return 0;
  return 1;
}

/* Which points span the section's sides is not worked out: many are on one line, or the same. */
static int section_separates(const struct flat *f, double slack) {
  for (int p = 0; p < f->n_s; p++)
    for (int q = 0; q < f->n_s; q++)
      if (distance_2d(f->s[p], f->s[q]) > slack && line_separates(f, f->s[p], f->s[q], slack))
        return 1;
  return 0;
}

/* --- one polygon --- */

/* All that is known from the distances of the section's points inside each side. */
struct inside {
  int beyond; /* all are beyond one side, weakly */
  int within; /* one is within all sides */
  int all;    /* all of a parted section are, or by topology on the border */
};

/* True if corner c of the hull is in a plane by topology; both triangles' planes meet where one is
 * cut. */
static int corner_in_plane(const struct pair *p, int c, int plane) {
  int vertex = p->hull.vertex[c];
  return vertex < 0 ? plane == p->plane_i || plane == p->plane_j
                    : rad_in_plane(p->o, plane, vertex);
}

/* True if point q of a section is on the line of k's side `side` by topology: as a vertex of it, or
 * because another plane has the side and both corners that q is between. */
static int on_border(const struct pair *p, const struct rad_occluder *k, int side,
                     const struct section *s, int q) {
  const struct rad_occluders *o = p->o;
  int c = s->from[q][0], d = s->from[q][1], from = o->corner[side];
  int to = o->corner[side + 1 < k->first + k->n ? side + 1 : k->first];
  if (c == d)
    return p->hull.vertex[c] >= 0 && rad_on_line(o, side, p->hull.vertex[c]);
  for (int m = o->plane_of_first[from]; m < o->plane_of_first[from + 1]; m++) {
    int plane = o->plane_of[m];
    if (plane != k->plane && rad_in_plane(o, plane, to) && corner_in_plane(p, c, plane) &&
        corner_in_plane(p, d, plane))
      return 1;
  }
  return 0;
}

static struct inside sort_points(const struct pair *p, const struct rad_occluder *k,
                                 const struct section *s) {
  const struct rad_occluders *o = p->o;
  const double *origin = o->scene->vertex[o->corner[k->first]];
  struct inside result = {.all = s->parted};
  unsigned outside = 0, every = (1u << s->n) - 1; /* bit q: point q is not well within all sides */
  for (int side = k->first; side < k->first + k->n; side++) {
    double r[3];
    rad_sub(o->scene->vertex[o->corner[side]], origin, r);
    double zero = rad_dot(o->inward[side], r) + o->slack;
    unsigned bits = 0;
    for (int q = 0; q < s->n; q++)
      bits |= (unsigned)!(rad_dot(o->inward[side], s->at[q]) > zero) << q;
    result.beyond |= bits == every;
    outside |= bits;
    for (int q = 0; result.all && q < s->n; q++)
      result.all = !(bits >> q & 1) || on_border(p, k, side, s, q);
  }
  result.within = outside != every;
  return result;
}

/**
 * Whether polygon k stands between the pair.
 *
 * If the hull has corners on both sides of k's plane, it meets the plane in the section S, the
 * convex hull of the points where segments between corners above and below pierce it, and of the
 * corners in it. The hull's interior meets the plane in the inside of S; so k is separated from the
 * hull iff it is from S within the plane, which is decided by the sides of both.
 *
 * k hides all if i is weakly above and j weakly below, or the other way round, and S is in k: the
 * segment from any x of i to any y of j that are not in the plane themselves crosses the plane, and
 * does so in the hull, hence in S, hence in k. What x or y in the plane see does not matter: these
 * are the points of a line at most, or i or j would be in the plane.
 *
 * Where the hull crosses the plane at so small an angle that S is not known well enough, the
 * separating axes in space decide, and nothing is hidden.
 */
static enum block what_blocks(const struct pair *p, const struct rad_occluder *k) {
  const struct rad_occluders *o = p->o;
  if (k->plane == p->plane_i || k->plane == p->plane_j ||
      boxes_apart(k->low, k->high, &p->hull, o->slack) || polygon_behind(o, k, p->i) ||
      polygon_behind(o, k, p->j))
    return BLOCKS_NONE;
  struct section s;
  if (!make_section(p, k, &s))
    return BLOCKS_NONE;
  if (!s.accurate) {
    double corner[RAD_MAX_OCCLUDER_CORNER][3];
    for (int c = 0; c < k->n; c++)
      memcpy(corner[c], o->scene->vertex[o->corner[k->first + c]], sizeof corner[c]);
    return rad_hull_separated(&p->hull, o->slack, k->normal, k->n, corner) ? BLOCKS_NONE
                                                                           : BLOCKS_SOME;
  }
  struct inside inside = sort_points(p, k, &s);
  if (inside.beyond)
    return BLOCKS_NONE;
  if (inside.all)
    return BLOCKS_ALL;
  if (inside.within)
    return BLOCKS_SOME;
  struct flat f;
  flatten(o, k, &s, &f);
  return section_separates(&f, o->slack) ? BLOCKS_NONE : BLOCKS_SOME;
}

/* --- all polygons --- */

static double farthest_square(const double center[3], const struct rad_triangle *t) {
  double most = 0;
  for (int m = 0; m < 3; m++) {
    double r[3];
    rad_sub(t->v[m], center, r);
    most = larger(most, rad_dot(r, r));
  }
  return most;
}

/* Fill in the pair; 0 if i and j do not face each other. The points within a distance of the axis
 * are convex, so the shaft holds the hull if it holds both triangles. */
static int make_pair(const struct rad_occluders *o, int i, int j, struct pair *p) {
  p->o = o;
  p->i = &o->scene->triangle[i];
  p->j = &o->scene->triangle[j];
  if (!rad_hull_make(&p->hull, p->i, p->j))
    return 0;
  p->plane_i = o->plane[i];
  p->plane_j = o->plane[j];
  double end[3];
  for (int d = 0; d < 3; d++) {
    p->center[d] = (p->i->v[0][d] + p->i->v[1][d] + p->i->v[2][d]) / 3;
    end[d] = (p->j->v[0][d] + p->j->v[1][d] + p->j->v[2][d]) / 3;
  }
  rad_sub(end, p->center, p->along);
  double square = rad_dot(p->along, p->along);
  p->inverse = square > 0 ? 1 / square : 0;
  p->radius = sqrt(larger(farthest_square(p->center, p->i), farthest_square(end, p->j)));
  return 1;
}

static int compare_ints(const void *a, const void *b) {
  return (*(const int *)a > *(const int *)b) - (*(const int *)a < *(const int *)b);
}

enum rad_sight rad_sight_between(const struct rad_occluders *o, int i, int j, int *list, int *n) {
  struct pair p;
  int stack[RAD_BVH_DEPTH] = {0}, n_stack = o->bvh->n_node > 0, n_blocker = 0;
  if (n)
    *n = 0;
  if (i == j)
    return RAD_HIDDEN;
  if (!n_stack)
    return rad_faces(&o->scene->triangle[i], &o->scene->triangle[j]) ? RAD_FREE : RAD_HIDDEN;
  if (!make_pair(o, i < j ? i : j, i < j ? j : i, &p)) /* ordered: the same rounding both ways */
    return RAD_HIDDEN;
  while (n_stack) {
    const struct rad_bvh_node *node = &o->bvh->node[stack[--n_stack]];
    if (boxes_apart(node->box.low, node->box.high, &p.hull, o->slack) ||
        box_behind(&node->box, p.i, o->slack) || box_behind(&node->box, p.j, o->slack) ||
        box_off_shaft(&node->box, &p))
      continue;
    if (node->n == 0) {
      stack[n_stack++] = node->first;
      stack[n_stack++] = node->first + 1;
    }
    for (int q = node->first; q < node->first + node->n; q++) {
      int k = o->bvh->item[q];
      enum block block = what_blocks(&p, &o->occluder[k]);
      if (block == BLOCKS_ALL)
        return RAD_HIDDEN;
      if (block == BLOCKS_SOME && list)
        list[n_blocker] = k;
      n_blocker += block == BLOCKS_SOME;
    }
  }
  if (list && n_blocker > 1)
    qsort(list, (size_t)n_blocker, sizeof *list, compare_ints);
  if (n)
    *n = n_blocker;
  return n_blocker ? RAD_PARTLY : RAD_FREE;
}
