#include "estimate/smooth.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "visibility/facing.h"

static void add_point(struct rad_singular *s, const double x[3], int vertex) {
  memcpy(s->point[s->n_point], x, sizeof s->point[0]);
  s->point_vertex[s->n_point++] = vertex;
}

static void add_line(struct rad_singular *s, const struct rad_triangle *t, int a, int b) {
  memcpy(s->line[s->n_line][0], t->v[a], sizeof t->v[a]);
  memcpy(s->line[s->n_line][1], t->v[b], sizeof t->v[b]);
  s->line_vertex[s->n_line][0] = t->vertex[a];
  s->line_vertex[s->n_line++][1] = t->vertex[b];
}

void rad_singular_set(const struct rad_triangle *sender, const struct rad_triangle *receiver,
                      struct rad_singular *s) {
  double height[3];
  *s = (struct rad_singular){0};
  rad_heights(sender, receiver, height);
  for (int a = 0; a < 3; a++) {
    int b = (a + 1) % 3;
    add_point(s, receiver->v[a], receiver->vertex[a]);
    if (height[a] != 0 || height[b] != 0)
      add_line(s, receiver, a, b);
    if (height[a] * height[b] < 0) {
      double x[3], part = height[a] / (height[a] - height[b]);
      for (int d = 0; d < 3; d++)
        x[d] = receiver->v[a][d] + part * (receiver->v[b][d] - receiver->v[a][d]);
      add_point(s, x, -1);
    }
  }
}

/* A straight line y = m + z h. */
struct way {
  double m[3], h[3];
  int vertex; /* of the scene where it begins, or -1 */
};

static struct way between(const double from[3], const double to[3], int vertex) {
  struct way w = {.vertex = vertex};
  for (int d = 0; d < 3; d++) {
    w.m[d] = 0.5 * (from[d] + to[d]);
    w.h[d] = 0.5 * (to[d] - from[d]);
  }
  return w;
}

/* Half of the longer axis of the ellipse with foci -1 and 1 through x + i y. */
static double axis(double x, double y) {
  return 0.5 * (hypot(x - 1, y) + hypot(x + 1, y));
}

static double axis_of_point(const struct way *w, const double point[3]) {
  double to[3], normal[3], h2 = rad_dot(w->h, w->h);
  rad_sub(point, w->m, to);
  rad_cross(to, w->h, normal);
  return axis(rad_dot(to, w->h) / h2, rad_norm(normal) / h2);
}

/* |(y - p) x e|^2 = |A + z B|^2 = 0; INFINITY if y is then beside the edge's ends, where the line
 * is none of T's. */
static double axis_of_line(const struct way *w, const double line[2][3]) {
  double e[3], to[3], a[3], b[3], ab[3];
  rad_sub(line[1], line[0], e);
  rad_sub(w->m, line[0], to);
  rad_cross(to, e, a);
  rad_cross(w->h, e, b);
  rad_cross(a, b, ab);
  double b2 = rad_dot(b, b);
  if (!(b2 > 1e-24 * rad_dot(w->h, w->h) * rad_dot(e, e)))
    return INFINITY;
  double x = -rad_dot(a, b) / b2, y = rad_norm(ab) / b2;
  double along = (rad_dot(to, e) + x * rad_dot(w->h, e)) / rad_dot(e, e);
  return along < 0 || along > 1 ? INFINITY : axis(x, y);
}

static double least_axis(const struct way *w, const struct rad_singular *s) {
  double least = INFINITY;
  int v = w->vertex;
  if (!(rad_dot(w->h, w->h) > 0))
    return least;
  for (int i = 0; i < s->n_point; i++)
    if (v < 0 || s->point_vertex[i] != v)
      least = fmin(least, axis_of_point(w, s->point[i]));
  for (int i = 0; i < s->n_line; i++)
    if (v < 0 || (s->line_vertex[i][0] != v && s->line_vertex[i][1] != v))
      least = fmin(least, axis_of_line(w, s->line[i]));
  return least;
}

void rad_smoothness(const struct rad_cell_shape *cell, const struct rad_singular *s,
                    double axis[2]) {
  const double(*c)[3] = cell->corner;
  double middle[4][3]; /* of the sides 0-1, 2-3, 0-2, 1-3 */
  for (int d = 0; d < 3; d++) {
    middle[0][d] = 0.5 * (c[0][d] + c[1][d]);
    middle[1][d] = 0.5 * (c[2][d] + c[3][d]);
    middle[2][d] = 0.5 * (c[0][d] + c[2][d]);
    middle[3][d] = 0.5 * (c[1][d] + c[3][d]);
  }
  const struct way way[2][3] = {
      {between(c[0], c[1], -1), between(c[2], c[3], -1), between(middle[2], middle[3], -1)},
      {between(c[0], c[2], cell->vertex), between(c[1], c[3], cell->vertex),
       between(middle[0], middle[1], cell->vertex)}};
  for (int k = 0; k < 2; k++) {
    axis[k] = INFINITY;
    for (int i = 0; i < 3; i++)
      axis[k] = fmin(axis[k], least_axis(&way[k][i], s));
  }
}
