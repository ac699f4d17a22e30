#include "visibility/shadow.h"

#include <stdbool.h>

#include "base/vec.h"
#include "visibility/facing.h"

#define IN_PLANE 1e-12 /* height over extent or distance that counts as zero: rounding */

/* The three polygons of a frame, and how their corners lie to one another's planes. */
struct setting {
  const struct rad_occluders *o;
  const struct rad_triangle *i, *j;
  const struct rad_occluder *k;
  const double *q[RAD_MAX_OCCLUDER_CORNER];                      /* corners of k */
  double i_above_k[3], j_above_k[3], i_above_j[3], j_above_i[3]; /* heights [m] */
  double k_above_i[RAD_MAX_OCCLUDER_CORNER], k_above_j[RAD_MAX_OCCLUDER_CORNER];
  double extent_i, extent_j; /* square of the larger of k and i, of k and j [m2] */
  double k_side_of_i; /* sum of k_above_i: its sign is that of k if a side is in the plane of i */
};

static double square_of_extent(int n, const double *const *corner) {
  double most = 0, r[3];
  for (int a = 0; a < n; a++)
    for (int b = a + 1; b < n; b++) {
      rad_sub(corner[a], corner[b], r);
      most = fmax(most, rad_dot(r, r));
    }
  return most;
}

/* Height of a scene vertex above a plane through `at`; see rad_heights. */
static double height_above(const struct rad_occluders *o, int plane, const double normal[3],
                           const double at[3], double extent, int vertex) {
  double r[3];
  rad_sub(o->scene->vertex[vertex], at, r);
  double height = rad_dot(normal, r);
  bool zero = height * height <= IN_PLANE * IN_PLANE * fmax(extent, rad_dot(r, r)) ||
              rad_in_plane(o, plane, vertex);
  return zero ? 0 : height;
}

static void measure_heights(int target, int source, struct setting *s) {
  const struct rad_occluders *o = s->o;
  const double *vi[3] = {s->i->v[0], s->i->v[1], s->i->v[2]};
  const double *vj[3] = {s->j->v[0], s->j->v[1], s->j->v[2]};
  double extent_k = square_of_extent(s->k->n, s->q);
  s->extent_i = fmax(extent_k, square_of_extent(3, vi));
  s->extent_j = fmax(extent_k, square_of_extent(3, vj));
  int plane_i = o->plane[target], plane_j = o->plane[source];
  rad_heights(s->j, s->i, s->i_above_j);
  rad_heights(s->i, s->j, s->j_above_i);
  for (int m = 0; m < 3; m++) {
    int vertex_i = s->i->vertex[m], vertex_j = s->j->vertex[m];
    s->i_above_k[m] = height_above(o, s->k->plane, s->k->normal, s->q[0], s->extent_i, vertex_i);
    s->j_above_k[m] = height_above(o, s->k->plane, s->k->normal, s->q[0], s->extent_j, vertex_j);
    if (rad_in_plane(o, plane_j, vertex_i))
      s->i_above_j[m] = 0;
    if (rad_in_plane(o, plane_i, vertex_j))
      s->j_above_i[m] = 0;
  }
  s->k_side_of_i = 0;
  for (int c = 0; c < s->k->n; c++) {
    int vertex = o->corner[s->k->first + c];
    s->k_above_i[c] = height_above(o, plane_i, s->i->normal, vi[0], s->extent_i, vertex);
    s->k_above_j[c] = height_above(o, plane_j, s->j->normal, vj[0], s->extent_j, vertex);
    s->k_side_of_i += s->k_above_i[c];
  }
}

/* n.((p - at) x (q - at)), a determinant if n = r - at */
static double triple(const double n[3], const double at[3], const double p[3], const double q[3]) {
  double a[3], b[3], c[3];
  rad_sub(p, at, a);
  rad_sub(q, at, b);
  rad_cross(a, b, c);
  return rad_dot(n, c);
}

/* det(q_s - V_c, q_{s+1} - V_c, v_m - V_c), or a positive multiple, the same for all m and one x */
static double side_value(const struct setting *g, int side, int c, int m, bool in_i, bool in_j) {
  const double *p = g->q[side], *q = g->q[(side + 1) % g->k->n], *x = g->i->v[c], *y = g->j->v[m];
  if (in_i)
    return (g->k_side_of_i > 0 ? -1 : 1) * g->i_above_k[c] * g->j_above_i[m];
  if (in_j)
    return -triple(g->j->normal, y, p, q) * g->i_above_j[c];
  double r[3];
  rad_sub(y, x, r);
  return triple(r, x, p, q);
}

/* By topology, or within rounding. */
static bool on_line(const struct setting *g, int s, int vertex, double above_k, double extent) {
  int side = g->k->first + s;
  if (above_k != 0)
    return false;
  double r[3];
  rad_sub(g->o->scene->vertex[vertex], g->q[s], r);
  double inside = rad_dot(g->o->inward[side], r);
  return inside * inside <= IN_PLANE * IN_PLANE * fmax(extent, rad_dot(r, r)) ||
         rad_on_line(g->o, side, vertex);
}

static void set_side(const struct setting *g, int s, double value[3][3]) {
  int next = (s + 1) % g->k->n, n_on_line = 0;
  bool i_on_line[3], j_on_line[3];
  for (int m = 0; m < 3; m++) {
    i_on_line[m] = on_line(g, s, g->i->vertex[m], g->i_above_k[m], g->extent_i);
    j_on_line[m] = on_line(g, s, g->j->vertex[m], g->j_above_k[m], g->extent_j);
    n_on_line += i_on_line[m];
  }
  bool in_i = n_on_line > 1 || (g->k_above_i[s] == 0 && g->k_above_i[next] == 0);
  bool in_j = g->k_above_j[s] == 0 && g->k_above_j[next] == 0;
  for (int c = 0; c < 3; c++)
    for (int m = 0; m < 3; m++) {
      bool zero = i_on_line[c] || j_on_line[m];
      value[c][m] = zero ? 0 : -side_value(g, s, c, m, in_i, in_j);
    }
}

void rad_shadow_frame_set(const struct rad_occluders *o, int target, int source, int occluder,
                          struct rad_shadow_frame *frame) {
  struct setting g = {.o = o,
                      .i = &o->scene->triangle[target],
                      .j = &o->scene->triangle[source],
                      .k = &o->occluder[occluder]};
  frame->n = 0;
  if (g.k->plane == o->plane[target] || g.k->plane == o->plane[source])
    return;
  for (int c = 0; c < g.k->n; c++)
    g.q[c] = o->scene->vertex[o->corner[g.k->first + c]];
  measure_heights(target, source, &g);
  frame->n = g.k->n;
  for (int m = 0; m < 3; m++) {
    frame->height[m] = g.i_above_k[m];
    frame->beyond[m] = -g.j_above_k[m];
  }
  for (int s = 0; s < g.k->n; s++)
    set_side(&g, s, frame->side[s]);
}

/* Count f in if it is negative somewhere; 0 if it is positive nowhere: then nothing is hidden. */
static inline int keep(struct rad_shadow *shadow) {
  const double *f = shadow->value[shadow->n];
  shadow->n += (f[0] < 0) | (f[1] < 0) | (f[2] < 0);
  return (f[0] > 0) | (f[1] > 0) | (f[2] > 0);
}

void rad_shadow_cast(const struct rad_shadow_frame *frame, int base, const double mu[2],
                     struct rad_shadow *shadow) {
  double lambda[3];
  lambda[base] = 1 - mu[0] - mu[1];
  lambda[base < 2 ? base + 1 : 0] = mu[0];
  lambda[base > 0 ? base - 1 : 2] = mu[1];
  shadow->n = 0;
  double h =
      lambda[0] * frame->height[0] + lambda[1] * frame->height[1] + lambda[2] * frame->height[2];
  if (frame->n == 0 || h == 0)
    return;
  double sign = h > 0 ? 1 : -1;
  for (int c = 0; c < 3; c++)
    lambda[c] *= sign;
  for (int m = 0; m < 3; m++)
    shadow->value[0][m] = sign * frame->beyond[m];
  int falls = keep(shadow);
  for (int s = 0; falls && s < frame->n; s++) {
    const double(*side)[3] = frame->side[s];
    double *f = shadow->value[shadow->n];
    for (int m = 0; m < 3; m++)
      f[m] = lambda[0] * side[0][m] + lambda[1] * side[1][m] + lambda[2] * side[2][m];
    falls = keep(shadow);
  }
  /* a shadow without borders in the source covers it, and keeps the last f */
  shadow->n = falls ? shadow->n + (shadow->n == 0) : 0;
}
