#include "oracle.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <quadmath.h>
#include <string.h>

_Static_assert(LDBL_MANT_DIG >= 64, "the oracle sums in extended precision");

__extension__ typedef __float128 quad;
typedef long double ext;

enum { MAX_GAUSS = 40, MAX_BASIS = 16, MAX_CORNER = 16, MAX_DEPTH = 500 };

/* One graded coordinate, u -> u^p, and its Lagrange basis. */
struct axis {
  quad p, inverse_p;
  int whole; /* p if it is a small whole number, else 0 */
  double lo, hi;
  int k;
  quad node[MAX_BASIS];
  ext scale[MAX_BASIS]; /* 1 / prod_{m != c} (node_c - node_m) */
};

/* A Gauss rule along one coordinate: x is t (angular) or r (radial). */
struct line {
  quad x[MAX_GAUSS];
  ext weight[MAX_GAUSS]; /* with t' dphi, or r dr */
  ext basis[MAX_GAUSS][MAX_BASIS];
};

struct cell {
  quad s0, s1, t0, t1; /* angular: sigma and t */
  quad u0, u1, r0, r1; /* radial: tau and r */
};

struct work {
  int n, polar;
  double ratio, size; /* size of the element */
  struct cell whole;
  quad pi, root3;
  quad z[MAX_GAUSS], w[MAX_GAUSS];
  struct axis phi, r;
  quad x[3], n_x[3], n_y[3];
  quad a[3], b[3], v[3], va[3], vb[3]; /* v is relative to x; va = v x a, vb = v x b */
  quad g, ga, gb;                      /* n_x.(y-x) = g + r (ga + t gb) */
  quad noise;                          /* rounding in n_x.(y-x): smaller is zero */
  quad height, front;                  /* n_y.(x-y); height |a x b| / pi */
  quad ex[3], ey[3];                   /* orthonormal, in the plane of the source */
  long n_cell;
  int failed;
  ext *I;
  ext part[MAX_BASIS * MAX_BASIS]; /* of one cell: keeps rounding from piling up in I */
};

/* ---- vectors, Gauss points ---- */

static quad dot(const quad *p, const quad *q) {
  return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
}

static void cross(const quad *p, const quad *q, quad *out) {
  for (int i = 0; i < 3; i++) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    out[i] = p[j] * q[k] - p[k] * q[j];
  }
}

static void widen(const double *p, quad *out) {
  for (int i = 0; i < 3; i++)
    out[i] = p[i];
}

/* out = unit(p x q), turned towards `side`; returns |p x q|. */
static quad unit_normal(const quad *p, const quad *q, const double *side, quad *out) {
  quad s[3];
  widen(side, s);
  cross(p, q, out);
  const quad length = sqrtq(dot(out, out));
  const quad factor = (dot(out, s) < 0 ? -1 : 1) / length;
  for (int i = 0; i < 3; i++)
    out[i] *= factor;
  return length;
}

static void gauss(int n, quad *z, quad *w) {
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
  gauss(n, zq, wq);
  for (int i = 0; i < n; i++) {
    z[i] = (ext)zq[i];
    w[i] = (ext)wq[i];
  }
}

/* ---- coordinates and basis ---- */

static void init_axis(struct axis *g, double p, const double *box, int k) {
  quad z[MAX_BASIS], w[MAX_BASIS];
  assert(k >= 1 && k <= MAX_BASIS && p >= 1 && 0 <= box[0] && box[0] < box[1] && box[1] <= 1);
  *g = (struct axis){.p = p, .inverse_p = 1 / (quad)p, .lo = box[0], .hi = box[1], .k = k};
  g->whole = p <= 64 && p == floor(p) ? (int)p : 0;
  gauss(k, z, w);
  for (int c = 0; c < k; c++)
    g->node[c] = ((1 - z[c]) * box[0] + (1 + z[c]) * box[1]) / 2;
  for (int c = 0; c < k; c++) {
    quad product = 1;
    for (int m = 0; m < k; m++)
      product *= m == c ? 1 : g->node[c] - g->node[m];
    g->scale[c] = (ext)(1 / product);
  }
}

static quad grade(const struct axis *g, quad u) {
  if (!g->whole)
    return u > 0 ? powq(u, g->p) : 0;
  quad y = u;
  for (int i = 1; i < g->whole; i++)
    y *= u;
  return y;
}

static quad ungrade(const struct axis *g, quad y) {
  return g->whole == 1 || y <= 0 ? y : powq(y, g->inverse_p);
}

static quad angle(const struct work *o, quad phi) {
  return o->polar ? o->root3 * tanq(o->pi / 6 * phi) : phi;
}

static quad angle_slope(const struct work *o, quad t) {
  return o->polar ? o->pi / 6 * (o->root3 + t * t / o->root3) : 1;
}

static quad unangle(const struct work *o, quad t) {
  return o->polar ? 6 / o->pi * atanq(t / o->root3) : t;
}

/* d ln y / d ln u over a range, for its size against a distance; twice if the range is wide. */
static double steepness(const struct axis *g, quad lo, quad hi) {
  const double grow = (double)(g->p * (1 - lo / hi));
  return grow > 2 ? 2 * grow : grow;
}

static void lagrange(const struct axis *g, quad u, ext *basis) {
  ext difference[MAX_BASIS], product = 1;
  for (int c = 0; c < g->k; c++) { /* differences in quad: they are what cancels */
    difference[c] = (ext)(u - g->node[c]);
    basis[c] = g->scale[c] * product;
    product *= difference[c];
  }
  product = 1;
  for (int c = g->k - 1; c >= 0; c--) {
    basis[c] *= product;
    product *= difference[c];
  }
}

static void fill_line(const struct work *o, const struct axis *g, quad lo, quad hi,
                      struct line *l) {
  const int angular = g == &o->phi;
  for (int q = 0; q < o->n; q++) {
    const quad half = (hi - lo) / 2, u = lo + half * (1 + o->z[q]), y = grade(g, u);
    l->x[q] = angular ? angle(o, y) : y;
    const quad jacobian = angular ? angle_slope(o, l->x[q]) : y;
    l->weight[q] = (ext)(half * o->w[q] * g->p * y / u * jacobian);
    lagrange(g, u, l->basis[q]);
  }
}

/* ---- quadrature on one cell ---- */

/*
 * Along the ray of t: |x-y|^2 = d.d (s^2 + delta^2), d = a + t b, s = r - r0. Only r - r0 and
 * n_x.(y-x) can cancel, and these are formed in quad.
 */
static void add_ray(struct work *o, const struct line *angular, int q, const struct line *radial) {
  const quad t = angular->x[q], gd = o->ga + t * o->gb;
  quad d[3], c[3];
  for (int i = 0; i < 3; i++) {
    d[i] = o->a[i] + t * o->b[i];
    c[i] = o->va[i] + t * o->vb[i];
  }
  const quad dd = dot(d, d), r0 = -dot(d, o->v) / dd;
  const ext delta2 = (ext)(dot(c, c) / (dd * dd));
  const ext factor = angular->weight[q] * (ext)(o->front / (dd * dd));
  ext row[MAX_BASIS] = {0};
  for (int i = 0; i < o->n; i++) {
    const ext s = (ext)(radial->x[i] - r0), square = s * s + delta2;
    const ext f = radial->weight[i] * (ext)(o->g + radial->x[i] * gd) / (square * square);
    for (int m = 0; m < o->r.k; m++)
      row[m] += f * radial->basis[i][m];
  }
  for (int m = 0; m < o->r.k; m++)
    for (int l = 0; l < o->phi.k; l++)
      o->part[l + o->phi.k * m] += factor * angular->basis[q][l] * row[m];
}

static void end_cell(struct work *o) {
  for (int i = 0; i < o->phi.k * o->r.k; i++) {
    o->I[i] += o->part[i];
    o->part[i] = 0;
  }
  o->n_cell++;
}

static void add_plain(struct work *o, const struct cell *e, quad s0, quad s1) {
  struct line angular, radial;
  fill_line(o, &o->phi, s0, s1, &angular);
  fill_line(o, &o->r, e->u0, e->u1, &radial);
  for (int q = 0; q < o->n; q++)
    add_ray(o, &angular, q, &radial);
  end_cell(o);
}

/*
 * A strip of a cell where the horizon stays at one side, or crosses every ray. The crossing
 * r = -g / (ga + t gb) has a pole in t; strips shrink with their distance to it.
 */
static void add_strip(struct work *o, const struct cell *e, quad s0, quad s1, int depth) {
  const quad middle = angle(o, grade(&o->phi, (s0 + s1) / 2));
  const quad gd = o->ga + middle * o->gb, g0 = o->g + e->r0 * gd, g1 = o->g + e->r1 * gd;
  if (g0 <= 0 && g1 <= 0)
    return;
  if (g0 >= 0 && g1 >= 0) {
    add_plain(o, e, s0, s1);
    return;
  }
  const quad phi = grade(&o->phi, s1), t0 = angle(o, grade(&o->phi, s0)), t1 = angle(o, phi);
  const quad pole = fminq(fabsq(o->ga + t0 * o->gb), fabsq(o->ga + t1 * o->gb));
  const quad size = fabsq(o->gb) * angle_slope(o, t1) * phi * steepness(&o->phi, s0, s1);
  if (depth < MAX_DEPTH / 4 && size > pole) {
    add_strip(o, e, s0, (s0 + s1) / 2, depth + 1);
    add_strip(o, e, (s0 + s1) / 2, s1, depth + 1);
    return;
  }
  struct line angular, radial;
  fill_line(o, &o->phi, s0, s1, &angular);
  for (int q = 0; q < o->n; q++) {
    quad cut = ungrade(&o->r, -o->g / (o->ga + angular.x[q] * o->gb));
    cut = fminq(fmaxq(cut, e->u0), e->u1);
    fill_line(o, &o->r, g0 > 0 ? e->u0 : cut, g0 > 0 ? cut : e->u1, &radial);
    add_ray(o, &angular, q, &radial);
  }
  end_cell(o);
}

/* Cuts a cell at the rays where the horizon leaves it, and at the ray parallel to the horizon. */
static void add_clipped(struct work *o, const struct cell *e) {
  quad cut[5] = {e->s0}, edge[3] = {0};
  int n = 1;
  if (e->r0 > 0)
    edge[0] = -o->g / e->r0;
  edge[1] = -o->g / e->r1;
  for (int i = 0; i < 3 && o->gb != 0; i++) {
    const quad t = (edge[i] - o->ga) / o->gb;
    if (!(t > e->t0 && t < e->t1))
      continue;
    const quad s = ungrade(&o->phi, unangle(o, t));
    int j = n++;
    for (; j > 1 && cut[j - 1] > s; j--)
      cut[j] = cut[j - 1];
    cut[j] = s;
  }
  cut[n] = e->s1;
  for (int i = 0; i < n; i++)
    if (cut[i] < cut[i + 1])
      add_strip(o, e, cut[i], cut[i + 1], 0);
}

/* ---- subdivision ---- */

/* Distance from x to a cell, a plane convex quadrangle; the range of n_x.(y-x) on it. */
static double distance(const struct work *o, const struct cell *e, quad *low, quad *high) {
  const quad r[4] = {e->r0, e->r1, e->r1, e->r0}, t[4] = {e->t0, e->t0, e->t1, e->t1};
  double px[4], py[4], best = INFINITY;
  for (int i = 0; i < 4; i++) {
    quad y[3];
    for (int k = 0; k < 3; k++)
      y[k] = o->v[k] + r[i] * (o->a[k] + t[i] * o->b[k]);
    px[i] = (double)dot(y, o->ex);
    py[i] = (double)dot(y, o->ey);
    const quad g = o->g + r[i] * (o->ga + t[i] * o->gb);
    *low = i == 0 ? g : fminq(*low, g);
    *high = i == 0 ? g : fmaxq(*high, g);
  }
  int inside = 1;
  for (int i = 0; i < 4; i++) {
    const int j = (i + 1) % 4;
    const double dx = px[j] - px[i], dy = py[j] - py[i], square = dx * dx + dy * dy;
    inside = inside && py[i] * dx - px[i] * dy <= 0;
    const double along = square > 0 ? -(px[i] * dx + py[i] * dy) / square : 0;
    const double s = fmin(fmax(along, 0), 1);
    best = fmin(best, hypot(px[i] + s * dx, py[i] + s * dy));
  }
  return hypot(inside ? 0 : best, (double)o->height);
}

/* Against the element, if its basis is rich. */
static int too_wide(const struct axis *g, quad lo, quad hi) {
  return g->k > 3 && hi - lo > 0.6 * (g->hi - g->lo);
}

/* u^p with a broken p is singular at 0. */
static int too_broken(const struct axis *g, quad lo, quad hi) {
  return !g->whole && lo < 0.29 * hi;
}

static double area(const struct cell *e) {
  return (double)((e->t1 - e->t0) * (e->r1 - e->r0) * (e->r1 + e->r0));
}

/*
 * Which coordinate to split (0 none, 1 angular, 2 radial) and where. Sizes are linearised at the
 * outer end, as the grading brings the complex poles of the kernel nearer to the real axis.
 */
static int choose_split(const struct work *o, const struct cell *e, double far, quad *at) {
  double b = 0, d0 = 0, d1 = 0;
  for (int i = 0; i < 3; i++) {
    b += pow((double)o->b[i], 2);
    d0 += pow((double)(o->a[i] + e->t0 * o->b[i]), 2);
    d1 += pow((double)(o->a[i] + e->t1 * o->b[i]), 2);
  }
  const double phi = (double)unangle(o, e->t1), r = (double)e->r1, d = sqrt(fmax(d0, d1));
  const double grow = phi * steepness(&o->phi, e->s0, e->s1);
  const double size_s = r * sqrt(b) * (double)angle_slope(o, e->t1) * grow;
  const double size_u = r * d * steepness(&o->r, e->u0, e->u1);
  const quad middle[3] = {0, (e->s0 + e->s1) / 2, (e->u0 + e->u1) / 2};
  int split = 0;
  if (fmax(size_s, size_u) > o->ratio * far)
    split = size_s > size_u ? 1 : 2;
  else if (grow > 1.5 || too_wide(&o->phi, e->s0, e->s1)) /* t(phi) has a pole at phi = 3 */
    split = 1;
  else if (too_wide(&o->r, e->u0, e->u1))
    split = 2;
  *at = middle[split];
  const double share = area(e) / area(&o->whole) * pow(1 + o->size / far, 2);
  if (split > 0 || share < 1e-18) /* the cell no longer counts */
    return split;
  if (too_broken(&o->phi, e->s0, e->s1)) {
    *at = e->s1 * 0.3;
    return 1;
  }
  *at = e->u1 * 0.3;
  return too_broken(&o->r, e->u0, e->u1) ? 2 : 0;
}

static void refine(struct work *o, const struct cell *e, int depth) {
  quad low = 0, high = 0, at = 0;
  const double far = distance(o, e, &low, &high);
  if (far <= o->noise || depth >= MAX_DEPTH)
    o->failed = 1;
  if (high <= o->noise || o->failed)
    return;
  const int split = choose_split(o, e, far, &at);
  if (split == 0 && low < -o->noise) {
    add_clipped(o, e);
  } else if (split == 0) {
    add_plain(o, e, e->s0, e->s1);
  } else {
    struct cell lower = *e, upper = *e;
    if (split == 1) {
      lower.s1 = upper.s0 = at;
      lower.t1 = upper.t0 = angle(o, grade(&o->phi, lower.s1));
    } else {
      lower.u1 = upper.u0 = at;
      lower.r1 = upper.r0 = grade(&o->r, lower.u1);
    }
    refine(o, &lower, depth + 1);
    refine(o, &upper, depth + 1);
  }
}

/* ---- entry points ---- */

static void place_point(const struct oracle_point *p, quad *x, quad *n_x) {
  quad f1[3], f2[3];
  widen(p->edge1, f1);
  widen(p->edge2, f2);
  for (int i = 0; i < 3; i++)
    x[i] = (quad)p->vertex[i] + p->mu1 * f1[i] + p->mu2 * f2[i];
  unit_normal(f1, f2, p->normal, n_x);
}

static void place_element(struct work *o, const struct oracle_element *e) {
  quad ab[3];
  widen(e->v, o->v);
  widen(e->a, o->a);
  widen(e->b, o->b);
  for (int i = 0; i < 3; i++)
    o->v[i] -= o->x[i];
  const quad area = unit_normal(o->a, o->b, e->normal, o->n_y);
  cross(o->v, o->a, o->va);
  cross(o->v, o->b, o->vb);
  o->polar = e->polar;
  o->pi = 4 * atanq(1);
  o->root3 = sqrtq(3);
  o->g = dot(o->n_x, o->v);
  o->ga = dot(o->n_x, o->a);
  o->gb = dot(o->n_x, o->b);
  const quad scale = dot(o->v, o->v) + dot(o->a, o->a) + dot(o->b, o->b);
  o->noise = sqrtq(scale) * 1e-31;
  o->g = fabsq(o->g) < o->noise ? 0 : o->g;
  o->height = -dot(o->n_y, o->v);
  o->front = o->height * area / o->pi;
  cross(o->a, o->b, ab);
  cross(ab, o->a, o->ey); /* (ex, ey): b lies to the left of a */
  const quad la = sqrtq(dot(o->a, o->a)), ly = sqrtq(dot(o->ey, o->ey));
  for (int i = 0; i < 3; i++) {
    o->ex[i] = o->a[i] / la;
    o->ey[i] /= ly;
  }
}

static void place_cell(const struct work *o, const struct oracle_element *e, struct cell *whole) {
  *whole = (struct cell){.s0 = e->sigma[0], .s1 = e->sigma[1], .u0 = e->tau[0], .u1 = e->tau[1]};
  whole->t0 = angle(o, grade(&o->phi, whole->s0));
  whole->t1 = angle(o, grade(&o->phi, whole->s1));
  whole->r0 = grade(&o->r, whole->u0);
  whole->r1 = grade(&o->r, whole->u1);
}

long oracle_integrate_with(const struct oracle_rule *rule, const struct oracle_point *x,
                           const struct oracle_element *e, long double *I) {
  struct work o = {.n = rule->n, .ratio = rule->ratio, .I = I};
  assert(rule->n >= 2 && rule->n <= MAX_GAUSS && rule->ratio > 0);
  for (int i = 0; i < e->k_phi * e->k_r; i++)
    I[i] = 0;
  gauss(o.n, o.z, o.w);
  init_axis(&o.phi, e->p_phi, e->sigma, e->k_phi);
  init_axis(&o.r, e->p_r, e->tau, e->k_r);
  place_point(x, o.x, o.n_x);
  place_element(&o, e);
  if (o.height <= 0)
    return 0;
  place_cell(&o, e, &o.whole);
  const quad reach = sqrtq(dot(o.a, o.a)) + o.whole.t1 * sqrtq(dot(o.b, o.b));
  o.size = (double)(o.whole.r1 * reach);
  refine(&o, &o.whole, 0);
  return o.failed ? -1 : o.n_cell;
}

long oracle_integrate(const struct oracle_point *x, const struct oracle_element *e,
                      long double *I) {
  return oracle_integrate_with(&(struct oracle_rule){.n = 20, .ratio = 1}, x, e, I);
}

/* ---- Lambert ---- */

/* Corners relative to x, clipped to n_x.y >= 0; returns how many remain. */
static int clip(int n, quad (*y)[3], const quad *n_x, quad (*out)[3]) {
  int m = 0;
  for (int i = 0; i < n; i++) {
    const quad *p = y[i], *q = y[(i + 1) % n];
    const quad gp = dot(n_x, p), gq = dot(n_x, q);
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
    cross(p, side, c);
    const quad length = sqrtq(dot(c, c));
    if (length > 0)
      sum += atan2q(length, dot(p, q)) * dot(n_x, c) / length;
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
  unit_normal(e1, e2, normal, n_y);
  return dot(n_y, corner[0]) < 0 ? lambert(n_vertex, corner, n_x) : 0;
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
