/* Gauss-Legendre rules and Legendre polynomials on [-1, 1]. */
#ifndef RAD_BASE_GAUSS_H
#define RAD_BASE_GAUSS_H

#include "base/error.h"

enum { RAD_GAUSS_MAX = 64 };

/* All rules with 1..RAD_GAUSS_MAX points; rule n starts at entry n(n-1)/2. */
struct rad_gauss {
  double *node;   /* owned, ascending within a rule */
  double *weight; /* owned */
};

enum rad_code rad_gauss_init(struct rad_gauss *g, struct rad_error *e);
void rad_gauss_free(struct rad_gauss *g); /* safe twice */

static inline const double *rad_gauss_node(const struct rad_gauss *g, int n) {
  return g->node + n * (n - 1) / 2;
}

static inline const double *rad_gauss_weight(const struct rad_gauss *g, int n) {
  return g->weight + n * (n - 1) / 2;
}

/* P_0(x) .. P_{k-1}(x) into p [k]. */
void rad_legendre(int k, double x, double *p);

/**
 * The Lagrange polynomials on the k Gauss points in terms of Legendre polynomials.
 *
 *   L_a(x) = sum_m T[a,m] P_m(x),  T[a,m] = (2m+1)/2 w_a P_m(x_a)              (theory 4.3)
 *
 * @param[out] t  [k, k] row-major: row a, column m
 */
void rad_lagrange_from_legendre(const struct rad_gauss *g, int k, double *t);

#endif
