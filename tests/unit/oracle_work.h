/* Shared by the files of the oracle, and by nobody else: numbers, coordinates, geometry. */
#ifndef POLYRAD_TEST_ORACLE_WORK_H
#define POLYRAD_TEST_ORACLE_WORK_H

#include <quadmath.h>

#include "oracle.h"

__extension__ typedef __float128 quad;
typedef long double ext;

enum { MAX_GAUSS = 40, MAX_BASIS = 16 };

/* One graded coordinate, u -> u^p, and its Lagrange basis. */
struct axis {
  quad p, inverse_p;
  int whole; /* p if it is a small whole number, else 0 */
  double lo, hi;
  int k;
  quad node[MAX_BASIS];
  ext scale[MAX_BASIS]; /* 1 / prod_{m != c} (node_c - node_m) */
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

static inline quad quad_dot(const quad *p, const quad *q) {
  return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
}

static inline void quad_cross(const quad *p, const quad *q, quad *out) {
  for (int i = 0; i < 3; i++) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    out[i] = p[j] * q[k] - p[k] * q[j];
  }
}

/* out = unit(p x q), turned towards `side`; returns |p x q|. */
quad quad_normal(const quad *p, const quad *q, const double *side, quad *out);

void quad_gauss(int n, quad *z, quad *w); /* on [-1, 1] */

/* A coordinate on `box` with k Gauss points. */
void init_axis(struct axis *g, double p, const double *box, int k);
quad grade(const struct axis *g, quad u);   /* u^p */
quad ungrade(const struct axis *g, quad y); /* its inverse */

quad angle(const struct work *o, quad phi); /* t */
quad angle_slope(const struct work *o, quad t);
quad unangle(const struct work *o, quad t); /* phi */

void place_point(const struct oracle_point *p, quad *x, quad *n_x);

/* All of the work that depends on the geometry; after place_point. */
void place_element(struct work *o, const struct oracle_element *e);

/* The whole element; after both axes. */
void place_cell(const struct work *o, const struct oracle_element *e, struct cell *whole);

#endif
