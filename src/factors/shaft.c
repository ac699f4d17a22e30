#include "factors/shaft.h"

static void add_plane(struct rad_shaft *s, const double normal[3], const double at[3], double sign,
                      double slack) {
  if (s->n == RAD_MAX_SHAFT)
    return;
  for (int d = 0; d < 3; d++)
    s->normal[s->n][d] = sign * normal[d];
  s->offset[s->n] = rad_dot(s->normal[s->n], at) - slack;
  s->n++;
}

/* 1: all above the plane, weakly; -1: all below; 0: neither, or all within. */
static int side_of(const struct rad_flat *f, const double normal[3], const double at[3],
                   double zero) {
  int above = 0, below = 0;
  for (int c = 0; c < f->n; c++) {
    double r[3];
    rad_sub(f->corner[c], at, r);
    double h = rad_dot(normal, r);
    above |= h > zero;
    below |= h < -zero;
  }
  return above && below ? 2 : above - below;
}

/* Planes through the edges of one and the vertices of the other. */
static void add_planes(struct rad_shaft *s, const struct rad_flat *a, const struct rad_flat *b,
                       double slack) {
  for (int c = 0; c < a->n; c++) {
    const double *p = a->corner[c], *q = a->corner[c + 1 < a->n ? c + 1 : 0];
    double edge[3], r[3], normal[3];
    rad_sub(q, p, edge);
    for (int v = 0; v < b->n; v++) {
      rad_sub(b->corner[v], p, r);
      rad_cross(edge, r, normal);
      double length = rad_norm(normal), reach = rad_norm(edge) + rad_norm(r);
      if (!(length > 1e-9 * reach * rad_norm(edge)))
        continue;
      for (int d = 0; d < 3; d++)
        normal[d] /= length;
      int of_a = side_of(a, normal, p, 1e-13 * reach), of_b = side_of(b, normal, p, 1e-13 * reach);
      if (of_a == 2 || of_b == 2 || of_a * of_b < 0 || (!of_a && !of_b))
        continue;
      add_plane(s, normal, p, of_a + of_b > 0 ? -1 : 1, slack);
    }
  }
}

void rad_shaft_make(const struct rad_flat *cell, const struct rad_flat *target, double slack,
                    struct rad_shaft *shaft) {
  shaft->n = 0;
  add_plane(shaft, cell->normal, cell->corner[0], -1, slack);
  add_plane(shaft, target->normal, target->corner[0], -1, slack);
  add_planes(shaft, cell, target, slack);
  add_planes(shaft, target, cell, slack);
}

int rad_shaft_misses(const struct rad_shaft *shaft, int n, const double *const *point) {
  for (int k = 0; k < shaft->n; k++) {
    int c = 0;
    while (c < n && rad_dot(shaft->normal[k], point[c]) >= shaft->offset[k])
      c++;
    if (c == n)
      return 1;
  }
  return 0;
}
