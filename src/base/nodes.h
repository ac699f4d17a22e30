/* The points of trial functions in one direction, and the Lagrange polynomials on them. */
#ifndef RAD_BASE_NODES_H
#define RAD_BASE_NODES_H

#include "base/gauss.h"

enum { RAD_NODES_MAX = 32 }; /* points per direction */

/* Only Gauss points keep collocation stable at small angles; the others show how it fails. */
enum rad_node_kind {
  RAD_NODES_GAUSS,
  RAD_NODES_BIASED,      /* 1 - step (k-1-a), step = min(0.1, 1/k): crowded at 1 */
  RAD_NODES_EQUIDISTANT, /* (a + 1/2) / k */
  RAD_NODES_VERTEX,      /* a / (k-1): both ends of the interval */
  RAD_NODES_LIST         /* given */
};

/* What was asked for. */
struct rad_node_choice {
  enum rad_node_kind kind;
  int n;                    /* LIST: points; other numbers of points are Gauss points */
  double at[RAD_NODES_MAX]; /* LIST: ascending, in [0, 1] */
};

/**
 * Points x_0 < .. < x_{k-1} in [-1, 1] for every k = 1 .. RAD_NODES_MAX, and the matrices T of
 *
 *   L_a(x) = sum_m T[a,m] P_m(x)                                                  (theory 4.3)
 *
 * A single point is the middle, unless the list is one point.
 */
struct rad_nodes {
  double *at;                     /* owned; k points from entry k(k-1)/2 on */
  double *matrix;                 /* owned; [k, k] row-major from entry (k-1)k(2k-1)/6 on */
  double loss[RAD_NODES_MAX + 1]; /* max_a sum_m |T[a,m]| over that of Gauss points: by how much
                                     errors of Legendre moments grow */
};

enum rad_code rad_nodes_init(const struct rad_gauss *g, const struct rad_node_choice *choice,
                             struct rad_nodes *nodes, struct rad_error *e);
void rad_nodes_free(struct rad_nodes *nodes); /* safe twice */

static inline const double *rad_nodes_at(const struct rad_nodes *nodes, int k) {
  return nodes->at + k * (k - 1) / 2;
}

static inline const double *rad_nodes_matrix(const struct rad_nodes *nodes, int k) {
  return nodes->matrix + (k - 1) * k * (2 * k - 1) / 6;
}

/* Values of the k Lagrange polynomials at x in [-1, 1]. */
void rad_lagrange(const struct rad_nodes *nodes, int k, double x, double *value);

#endif
