#include "oracle_work.h"

#include <assert.h>
#include <float.h>
#include <math.h>

#include "oracle.h"

_Static_assert(LDBL_MANT_DIG >= 64, "the oracle sums in extended precision");

/* ---- vectors, Gauss points ---- */

static void widen(const double *p, quad *out) {
  for (int i = 0; i < 3; i++)
    out[i] = p[i];
}

quad quad_normal(const quad *p, const quad *q, const double *side, quad *out) {
  quad s[3];
  widen(side, s);
  quad_cross(p, q, out);
  const quad length = sqrtq(quad_dot(out, out));
  const quad factor = (quad_dot(out, s) < 0 ? -1 : 1) / length;
  for (int i = 0; i < 3; i++)
    out[i] *= factor;
  return length;
}

void quad_gauss(int n, quad *z, quad *w) {
  const quad pi = 4 * atanq(1);
  for (int i = 0; i < n; i++) {
    quad u = -cosq(pi * (i + (quad)0.75) / (n + (quad)0.5)), slope = 1, step = 1;
    for (int pass = 0; pass < 30 && fabsq(step) > 1e-30; pass++) {
      quad p0 = 1, p1 = u;
      for (int m = 2; m <= n; m++) {
        const quad p2 = ((2 * m - 1) * u * p1 - (m - 1) * p0) / m;
        p0 = p1;
        p1 = p2;
      }
      slope = n * (p0 - u * p1) / (1 - u * u);
      step = p1 / slope;
      u -= step;
    }
    z[i] = u;
    w[i] = 2 / ((1 - u * u) * slope * slope);
  }
}

void oracle_gauss(int n, long double *z, long double *w) {
  quad zq[MAX_GAUSS], wq[MAX_GAUSS];
  assert(n >= 1 && n <= MAX_GAUSS);
  quad_gauss(n, zq, wq);
  for (int i = 0; i < n; i++) {
    z[i] = (ext)zq[i];
    w[i] = (ext)wq[i];
  }
}

/* ---- coordinates and basis ---- */

void init_axis(struct axis *g, double p, const double *box, int k) {
  quad z[MAX_BASIS], w[MAX_BASIS];
  assert(k >= 1 && k <= MAX_BASIS && p >= 1 && 0 <= box[0] && box[0] < box[1] && box[1] <= 1);
  *g = (struct axis){.p = p, .inverse_p = 1 / (quad)p, .lo = box[0], .hi = box[1], .k = k};
  g->whole = p <= 64 && p == floor(p) ? (int)p : 0;
  quad_gauss(k, z, w);
  for (int c = 0; c < k; c++)
    g->node[c] = ((1 - z[c]) * box[0] + (1 + z[c]) * box[1]) / 2;
  for (int c = 0; c < k; c++) {
    quad product = 1;
    for (int m = 0; m < k; m++)
      product *= m == c ? 1 : g->node[c] - g->node[m];
    g->scale[c] = (ext)(1 / product);
  }
}

quad grade(const struct axis *g, quad u) {
  if (!g->whole)
    return u > 0 ? powq(u, g->p) : 0;
  quad y = u;
  for (int i = 1; i < g->whole; i++)
    y *= u;
  return y;
}

quad ungrade(const struct axis *g, quad y) {
  return g->whole == 1 || y <= 0 ? y : powq(y, g->inverse_p);
}

quad angle(const struct work *o, quad phi) {
  return o->polar ? o->root3 * tanq(o->pi / 6 * phi) : phi;
}

quad angle_slope(const struct work *o, quad t) {
  return o->polar ? o->pi / 6 * (o->root3 + t * t / o->root3) : 1;
}

quad unangle(const struct work *o, quad t) {
  return o->polar ? 6 / o->pi * atanq(t / o->root3) : t;
}

/* ---- point and element ---- */

void place_point(const struct oracle_point *p, quad *x, quad *n_x) {
  quad f1[3], f2[3];
  widen(p->edge1, f1);
  widen(p->edge2, f2);
  for (int i = 0; i < 3; i++)
    x[i] = (quad)p->vertex[i] + p->mu1 * f1[i] + p->mu2 * f2[i];
  quad_normal(f1, f2, p->normal, n_x);
}

void place_element(struct work *o, const struct oracle_element *e) {
  quad ab[3];
  widen(e->v, o->v);
  widen(e->a, o->a);
  widen(e->b, o->b);
  for (int i = 0; i < 3; i++)
    o->v[i] -= o->x[i];
  const quad area = quad_normal(o->a, o->b, e->normal, o->n_y);
  quad_cross(o->v, o->a, o->va);
  quad_cross(o->v, o->b, o->vb);
  o->polar = e->polar;
  o->pi = 4 * atanq(1);
  o->root3 = sqrtq(3);
  o->g = quad_dot(o->n_x, o->v);
  o->ga = quad_dot(o->n_x, o->a);
  o->gb = quad_dot(o->n_x, o->b);
  const quad scale = quad_dot(o->v, o->v) + quad_dot(o->a, o->a) + quad_dot(o->b, o->b);
  o->noise = sqrtq(scale) * 1e-31;
  o->g = fabsq(o->g) < o->noise ? 0 : o->g;
  o->height = -quad_dot(o->n_y, o->v);
  o->front = o->height * area / o->pi;
  quad_cross(o->a, o->b, ab);
  quad_cross(ab, o->a, o->ey); /* (ex, ey): b lies to the left of a */
  const quad la = sqrtq(quad_dot(o->a, o->a)), ly = sqrtq(quad_dot(o->ey, o->ey));
  for (int i = 0; i < 3; i++) {
    o->ex[i] = o->a[i] / la;
    o->ey[i] /= ly;
  }
}

void place_cell(const struct work *o, const struct oracle_element *e, struct cell *whole) {
  *whole = (struct cell){.s0 = e->sigma[0], .s1 = e->sigma[1], .u0 = e->tau[0], .u1 = e->tau[1]};
  whole->t0 = angle(o, grade(&o->phi, whole->s0));
  whole->t1 = angle(o, grade(&o->phi, whole->s1));
  whole->r0 = grade(&o->r, whole->u0);
  whole->r1 = grade(&o->r, whole->u1);
}
