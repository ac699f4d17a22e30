#include "oracle.h"

#include <assert.h>
#include <math.h>
#include <quadmath.h>

#include "oracle_work.h"

enum { MAX_DEPTH = 500 };

/* A Gauss rule along one coordinate: x is t (angular) or r (radial). */
struct line {
  quad x[MAX_GAUSS];
  ext weight[MAX_GAUSS]; /* with t' dphi, or r dr */
  ext basis[MAX_GAUSS][MAX_BASIS];
};

/* ---- lines of Gauss points, with the basis ---- */

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
  const quad dd = quad_dot(d, d), r0 = -quad_dot(d, o->v) / dd;
  const ext delta2 = (ext)(quad_dot(c, c) / (dd * dd));
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
    px[i] = (double)quad_dot(y, o->ex);
    py[i] = (double)quad_dot(y, o->ey);
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

long oracle_integrate_with(const struct oracle_rule *rule, const struct oracle_point *x,
                           const struct oracle_element *e, long double *I) {
  struct work o = {.n = rule->n, .ratio = rule->ratio, .I = I};
  assert(rule->n >= 2 && rule->n <= MAX_GAUSS && rule->ratio > 0);
  for (int i = 0; i < e->k_phi * e->k_r; i++)
    I[i] = 0;
  quad_gauss(o.n, o.z, o.w);
  init_axis(&o.phi, e->p_phi, e->sigma, e->k_phi);
  init_axis(&o.r, e->p_r, e->tau, e->k_r);
  place_point(x, o.x, o.n_x);
  place_element(&o, e);
  if (o.height <= 0)
    return 0;
  place_cell(&o, e, &o.whole);
  const quad reach = sqrtq(quad_dot(o.a, o.a)) + o.whole.t1 * sqrtq(quad_dot(o.b, o.b));
  o.size = (double)(o.whole.r1 * reach);
  refine(&o, &o.whole, 0);
  return o.failed ? -1 : o.n_cell;
}

long oracle_integrate(const struct oracle_point *x, const struct oracle_element *e,
                      long double *I) {
  return oracle_integrate_with(&(struct oracle_rule){.n = 20, .ratio = 1}, x, e, I);
}
