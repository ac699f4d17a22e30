#include "factors/critical.h"

#include <math.h>

#include "factors/skew.h"

#define ZERO 1e-10 /* of the pair's size: lines nearer than this to the border do not cross */
#define SAME 1e-8  /* of the cell's size: lines that are one */
#define SIDE 1e-9  /* sines that are none */
#define NEAR 2.5   /* largest cell over its distance from an edge */

/* What the search for lines works with. */
struct search {
  const struct rad_pair *p;
  const struct rad_flat *cell;
  struct rad_critical *c;
  double cell_size;
};

static const double *corner_of(const struct rad_pair *p, const struct rad_occluder *k, int c) {
  const struct rad_occluders *o = &p->g->visibility->occluders;
  return o->scene->vertex[o->corner[k->first + c % k->n]];
}

/* ---- silhouettes ---- */

/* Sine of the angle at the edge between a polygon with that edge and the plane through y and it. */
static double polygon_side(const struct rad_pair *p, const double y[3], const double a[3],
                           const double b[3], int side) {
  const double *inward = p->g->visibility->occluders.inward[side];
  double ya[3], yb[3], normal[3];
  rad_sub(a, y, ya);
  rad_sub(b, y, yb);
  rad_cross(ya, yb, normal);
  double length = rad_norm(normal);
  return length > 0 ? rad_dot(normal, inward) / length : 0;
}

/* True if the polygons of two twins lie on opposite sides of the edge as seen from all of the cell:
 * by far from its middle, and each on that side or, but for rounding, on none from all corners. One
 * may change sides where the other is seen edge on; only those of one plane change together. */
static int opposite(const struct rad_pair *p, const struct rad_flat *cell, const double *a,
                    const double *b, int side, int other) {
  double middle[3];
  for (int d = 0; d < 3; d++)
    middle[d] = (cell->corner[0][d] + cell->corner[1][d] + cell->corner[2][d]) / 3;
  double sign = polygon_side(p, middle, a, b, side);
  if (!(sign * polygon_side(p, middle, a, b, other) < -SIDE))
    return 0;
  sign = sign > 0 ? 1 : -1;
  for (int m = 0; m < 3; m++) {
    double one = sign * polygon_side(p, cell->corner[m], a, b, side);
    double two = sign * polygon_side(p, cell->corner[m], a, b, other);
    if ((one < -SIDE || two > SIDE) && fabs(one + two) > SIDE)
      return 0;
  }
  return 1;
}

/* True if another polygon goes on beyond a side wherever in the cell one looks from, or has the
 * side and does not reach into the shaft: then neither does the side. */
static int goes_on(const struct rad_pair *p, const struct rad_flat *cell, int side, const double *a,
                   const double *b, const int *mark, int now) {
  for (int other = p->g->twin[side]; other >= 0 && other != side; other = p->g->twin[other]) {
    if (mark[p->g->owner[other]] != now || opposite(p, cell, a, b, side, other))
      return 1;
  }
  return 0;
}

/* Another polygon's side was it before. */
static int is_known(const struct rad_critical *c, int from, int to) {
  for (int e = 0; e < c->n_edge; e++)
    if ((c->edge[e].vertex[0] == from && c->edge[e].vertex[1] == to) ||
        (c->edge[e].vertex[0] == to && c->edge[e].vertex[1] == from))
      return 1;
  return 0;
}

static void find_edges(const struct rad_pair *p, const struct rad_flat *cell,
                       const struct rad_shaft *shaft, int n, const int *list, const int *mark,
                       int now, struct rad_critical *c) {
  const struct rad_occluders *o = &p->g->visibility->occluders;
  for (int i = 0; i < n; i++) {
    const struct rad_occluder *k = &o->occluder[p->blocker[list[i]]];
    for (int s = 0; s < k->n; s++) {
      const double *end[2] = {corner_of(p, k, s), corner_of(p, k, s + 1)};
      int from = o->corner[k->first + s], to = o->corner[k->first + (s + 1) % k->n];
      if (is_known(c, from, to) || rad_shaft_misses(shaft, 2, end) ||
          goes_on(p, cell, k->first + s, end[0], end[1], mark, now))
        continue;
      if (c->n_edge == RAD_MAX_SILHOUETTE) {
        c->crowded = 1;
        return;
      }
      c->edge[c->n_edge++] = (struct rad_silhouette){
          end[0], end[1], {from, to}, k->plane, p->g->body[p->blocker[list[i]]]};
      c->skew |= k->plane != c->edge[0].plane;
    }
  }
}

/* ---- lines ---- */

static void add_line(struct search *s, const double f[3]) {
  struct rad_critical *c = s->c;
  double same = SAME * s->cell_size;
  for (int k = 0; k < c->n_line; k++) {
    const double *g = c->line[k];
    double plus = 0, minus = 0;
    for (int m = 0; m < 3; m++) {
      plus = fmax(plus, fabs(f[m] - g[m]));
      minus = fmax(minus, fabs(f[m] + g[m]));
    }
    if (plus <= same || minus <= same)
      return;
  }
  if (c->n_line == RAD_MAX_LINE) {
    c->crowded = 1;
    return;
  }
  memcpy(c->line[c->n_line++], f, sizeof c->line[0]);
}

/* Distances of the cell's corners from where the plane cuts that of the cell; 0 if it does not
 * cross the cell. */
static int crosses(const struct search *s, const double normal[3], const double at[3],
                   double f[3]) {
  const double *n = s->p->s->normal;
  double along = rad_dot(normal, n), across = 0;
  for (int d = 0; d < 3; d++)
    across += (normal[d] - along * n[d]) * (normal[d] - along * n[d]);
  across = sqrt(across);
  double zero = ZERO * s->p->size * across;
  int above = 0, below = 0;
  for (int m = 0; m < 3; m++) {
    double r[3];
    rad_sub(s->cell->corner[m], at, r);
    f[m] = rad_dot(normal, r);
    above |= f[m] > zero;
    below |= f[m] < -zero;
  }
  if (!above || !below)
    return 0;
  for (int m = 0; m < 3; m++)
    f[m] /= across;
  return 1;
}

/* The two points of the cell's border where f vanishes. */
static void ends_of(const struct rad_flat *cell, const double f[3], double y[2][3]) {
  int n = 0;
  for (int m = 0; m < 3 && n < 2; m++) {
    int next = (m + 1) % 3;
    if ((f[m] < 0) != (f[next] < 0))
      rad_between(cell->corner[m], cell->corner[next], f[m] / (f[m] - f[next]), y[n++]);
  }
}

/* True if, from y, v is seen on the same side of both ends of an edge: 1 or -1; else 0. */
static int beside(const double y[3], const double p[3], const double q[3], const double v[3],
                  const double normal[3]) {
  double to_p[3], to_q[3], to_v[3], a[3], b[3];
  rad_sub(p, y, to_p);
  rad_sub(q, y, to_q);
  rad_sub(v, y, to_v);
  rad_cross(to_p, to_v, a);
  rad_cross(to_q, to_v, b);
  double of_p = rad_dot(a, normal), of_q = rad_dot(b, normal);
  return of_p > 0 && of_q > 0 ? 1 : of_p < 0 && of_q < 0 ? -1 : 0;
}

/* True if the rays from both points through v pass the target on one side of it. */
static int misses_target(const struct rad_pair *p, double y[2][3], const double v[3]) {
  const struct rad_flat *t = &p->face;
  double z[2][3], r[3];
  for (int k = 0; k < 2; k++) {
    rad_sub(y[k], t->corner[0], r);
    double hy = rad_dot(r, t->normal);
    rad_sub(v, t->corner[0], r);
    double hv = rad_dot(r, t->normal);
    if (!(hy - hv > 1e-12 * p->size))
      return 0;
    rad_between(y[k], v, hy / (hy - hv), z[k]);
  }
  for (int c = 0; c < t->n; c++) {
    const double *a = t->corner[c], *b = t->corner[c + 1 < t->n ? c + 1 : 0];
    double edge[3], inward[3];
    rad_sub(b, a, edge);
    rad_cross(t->normal, edge, inward);
    double zero = -ZERO * p->size * rad_norm(edge);
    int outside = 0;
    for (int k = 0; k < 2; k++) {
      rad_sub(z[k], a, r);
      outside += rad_dot(inward, r) < zero;
    }
    if (outside == 2)
      return 1;
  }
  return 0;
}

/* The line where an edge passes over a vertex v, which is one of the target or of a blocker. */
static void try_event(struct search *s, const double *p, const double *q, const double *v,
                      int of_target) {
  double pq[3], pv[3], normal[3], f[3], y[2][3];
  rad_sub(q, p, pq);
  rad_sub(v, p, pv);
  rad_cross(pq, pv, normal);
  if (!(rad_dot(normal, normal) > 1e-24 * rad_dot(pq, pq) * rad_dot(pv, pv)) ||
      !crosses(s, normal, p, f))
    return;
  ends_of(s->cell, f, y);
  int first = beside(y[0], p, q, v, normal), last = beside(y[1], p, q, v, normal);
  if ((first && first == last) || (!of_target && misses_target(s->p, y, v)))
    return;
  add_line(s, f);
}

static void edges_and_target(struct search *s) {
  const struct rad_flat *t = &s->p->face;
  const struct rad_critical *c = s->c;
  for (int e = 0; e < c->n_edge; e++)
    for (int m = 0; m < t->n; m++) {
      const double *a = t->corner[m], *b = t->corner[m + 1 < t->n ? m + 1 : 0];
      const struct rad_silhouette *edge = &c->edge[e];
      try_event(s, edge->p, edge->q, a, 1);
      try_event(s, a, b, edge->p, 1);
      try_event(s, a, b, edge->q, 1);
    }
}

/* Two edges in one plane seem to be one where y crosses it, wherever their ends are. */
static void common_plane(struct search *s, const struct rad_silhouette *x,
                         const struct rad_silhouette *y) {
  double u[3], v[3], w[3], normal[3], other[3], f[3];
  rad_sub(x->q, x->p, u);
  rad_sub(y->p, x->p, v);
  rad_sub(y->q, x->p, w);
  rad_cross(u, v, normal);
  rad_cross(u, w, other);
  if (rad_dot(other, other) > rad_dot(normal, normal))
    memcpy(normal, other, sizeof normal);
  if (rad_dot(normal, normal) > 0 && crosses(s, normal, x->p, f))
    add_line(s, f);
}

static void edges_and_edges(struct search *s) {
  const struct rad_critical *c = s->c;
  for (int a = 0; a < c->n_edge; a++)
    for (int b = 0; b < c->n_edge && !c->crowded; b++) {
      const struct rad_silhouette *x = &c->edge[a], *y = &c->edge[b];
      if (x->plane == y->plane || rad_same_body(x, y))
        continue;
      if (!rad_are_skew(x->p, x->q, y->p, y->q)) {
        common_plane(s, x, y);
        continue;
      }
      for (int k = 0; k < 2; k++)
        if (y->vertex[k] != x->vertex[0] && y->vertex[k] != x->vertex[1])
          try_event(s, x->p, x->q, k ? y->q : y->p, 0);
    }
}

/* Where the cell crosses the plane of a blocker. */
static void blocker_planes(struct search *s, int n, const int *list) {
  const struct rad_occluders *o = &s->p->g->visibility->occluders;
  for (int i = 0; i < n; i++) {
    const struct rad_occluder *k = &o->occluder[s->p->blocker[list[i]]];
    double f[3];
    if (crosses(s, k->normal, corner_of(s->p, k, 0), f))
      add_line(s, f);
  }
}

static double longest_edge(const struct rad_flat *cell) {
  double most = 0;
  for (int c = 0; c < cell->n; c++)
    most = fmax(most, rad_distance2(cell->corner[c], cell->corner[c + 1 < cell->n ? c + 1 : 0]));
  return sqrt(most);
}

void rad_critical_find(const struct rad_pair *p, const struct rad_flat *cell,
                       const struct rad_shaft *shaft, int n, const int *list, const int *mark,
                       int now, struct rad_critical *c) {
  c->n_edge = c->n_line = c->crowded = c->skew = 0;
  find_edges(p, cell, shaft, n, list, mark, now, c);
  struct search s = {.p = p, .cell = cell, .c = c, .cell_size = longest_edge(cell)};
  if (!c->crowded && c->n_edge)
    blocker_planes(&s, n, list);
  if (!c->crowded)
    edges_and_target(&s);
  if (!c->crowded && c->skew)
    edges_and_edges(&s);
}

/* ---- nearness ---- */

static double clamp(double x) {
  return x < 0 ? 0 : x > 1 ? 1 : x;
}

/* Square of the distance of two segments. */
static double segments2(const double *p, const double *q, const double *a, const double *b) {
  double u[3], v[3], w[3], x[3], y[3];
  rad_sub(q, p, u);
  rad_sub(b, a, v);
  rad_sub(p, a, w);
  double uu = rad_dot(u, u), uv = rad_dot(u, v), vv = rad_dot(v, v), uw = rad_dot(u, w);
  double vw = rad_dot(v, w), det = uu * vv - uv * uv;
  double s = det > 1e-14 * uu * vv ? clamp((uv * vw - vv * uw) / det) : 0;
  double t = vv > 0 ? clamp((uv * s + vw) / vv) : 0;
  s = uu > 0 ? clamp((uv * t - uw) / uu) : 0;
  rad_between(p, q, s, x);
  rad_between(a, b, t, y);
  return rad_distance2(x, y);
}

/* Height of a point whose foot is in the cell; else INFINITY. */
static double above(const struct rad_flat *cell, const double *x) {
  double r[3];
  for (int c = 0; c < 3; c++) {
    double edge[3], inward[3];
    rad_sub(cell->corner[(c + 1) % 3], cell->corner[c], edge);
    rad_cross(cell->normal, edge, inward);
    rad_sub(x, cell->corner[c], r);
    if (rad_dot(inward, r) < 0)
      return INFINITY;
  }
  return fabs(rad_dot(cell->normal, r));
}

/* True if the segment touches the cell, or is far away for the cell's size. */
static int is_far(const struct rad_flat *cell, double size, double zero, const double *p,
                  const double *q) {
  double least = fmin(above(cell, p), above(cell, q));
  least *= least;
  for (int c = 0; c < 3; c++)
    least = fmin(least, segments2(p, q, cell->corner[c], cell->corner[(c + 1) % 3]));
  return least <= zero * zero || size * size <= NEAR * NEAR * least;
}

int rad_critical_far(const struct rad_pair *p, const struct rad_flat *cell,
                     const struct rad_critical *c) {
  double size = longest_edge(cell), zero = ZERO * p->size;
  for (int e = 0; e < c->n_edge; e++)
    if (!is_far(cell, size, zero, c->edge[e].p, c->edge[e].q))
      return 0;
  for (int m = 0; m < p->face.n; m++)
    if (!is_far(cell, size, zero, p->face.corner[m], p->face.corner[(m + 1) % p->face.n]))
      return 0;
  return 1;
}
