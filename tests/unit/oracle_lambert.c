/* The closed form for the constant 1. */
#include <assert.h>
#include <math.h>
#include <quadmath.h>
#include <string.h>

#include "oracle.h"
#include "oracle_work.h"

enum { MAX_CORNER = 16 };

/* Corners relative to x, clipped to n_x.y >= 0; returns how many remain. */
static int clip(int n, quad (*y)[3], const quad *n_x, quad (*out)[3]) {
  int m = 0;
  for (int i = 0; i < n; i++) {
    const quad *p = y[i], *q = y[(i + 1) % n];
    const quad gp = quad_dot(n_x, p), gq = quad_dot(n_x, q);
    if (gp >= 0)
      memcpy(out[m++], p, 3 * sizeof(quad));
    if ((gp > 0 && gq < 0) || (gp < 0 && gq > 0)) {
      for (int k = 0; k < 3; k++)
        out[m][k] = p[k] + gp / (gp - gq) * (q[k] - p[k]);
      m++;
    }
  }
  return m;
}

static long double lambert(int n, quad (*corner)[3], const quad *n_x) {
  quad y[2 * MAX_CORNER][3], sum = 0;
  const int m = clip(n, corner, n_x, y);
  for (int i = 0; i < m; i++) {
    const quad *p = y[i], *q = y[(i + 1) % m];
    const quad side[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
    quad c[3];
    quad_cross(p, side, c);
    const quad length = sqrtq(quad_dot(c, c));
    if (length > 0)
      sum += atan2q(length, quad_dot(p, q)) * quad_dot(n_x, c) / length;
  }
  return (ext)(fabsq(sum) / (8 * atanq(1)));
}

long double oracle_lambert(const struct oracle_point *x, int n_vertex, const double (*y)[3],
                           const double normal[3]) {
  quad p[3], n_x[3], n_y[3], corner[MAX_CORNER][3], e1[3], e2[3];
  assert(n_vertex >= 3 && n_vertex <= MAX_CORNER);
  place_point(x, p, n_x);
  for (int i = 0; i < n_vertex; i++)
    for (int k = 0; k < 3; k++)
      corner[i][k] = y[i][k] - p[k];
  for (int k = 0; k < 3; k++) {
    e1[k] = corner[1][k] - corner[0][k];
    e2[k] = corner[2][k] - corner[0][k];
  }
  quad_normal(e1, e2, normal, n_y);
  return quad_dot(n_y, corner[0]) < 0 ? lambert(n_vertex, corner, n_x) : 0;
}

long double oracle_lambert_element(const struct oracle_point *x, const struct oracle_element *e) {
  struct work o = {0};
  quad corner[4][3];
  place_point(x, o.x, o.n_x);
  place_element(&o, e);
  init_axis(&o.phi, e->p_phi, e->sigma, 1);
  init_axis(&o.r, e->p_r, e->tau, 1);
  place_cell(&o, e, &o.whole);
  const struct cell *c = &o.whole;
  const quad r[4] = {c->r0, c->r1, c->r1, c->r0}, t[4] = {c->t0, c->t0, c->t1, c->t1};
  for (int i = 0; i < 4; i++)
    for (int k = 0; k < 3; k++)
      corner[i][k] = o.v[k] + r[i] * (o.a[k] + t[i] * o.b[k]);
  return o.height > 0 ? lambert(4, corner, o.n_x) : 0;
}
