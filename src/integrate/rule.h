/* Quadrature rules of the mesh's one-dimensional intervals, and how far away each suffices. */
#ifndef RAD_INTEGRATE_RULE_H
#define RAD_INTEGRATE_RULE_H

#include "mesh/mesh.h"

enum { RAD_N_ORDER = 17 };
extern const int rad_order[RAD_N_ORDER]; /* points per direction, ascending */

/**
 * One interval of sigma (angular) or tau (radial) with its rules.
 *
 * Rule o has n = rad_order[o] Gauss points in sigma or tau, given as t = t(phi) or r, and weights
 *   weight[o][a n + q] = w_q L_a (dt/dsigma)   or   w_q L_a r (dr/dtau),        so that
 *   int f L_a r dt dr = sum f(t_q, r_q') weight_phi weight_r.
 */
struct rad_panel {
  double lo, hi, p;
  int k, radial;
  enum rad_angle angle;
  double reach[RAD_N_ORDER];   /* see rad_panel_reach */
  double *point[RAD_N_ORDER];  /* [n]; into one block */
  double *weight[RAD_N_ORDER]; /* [k, n] */
  double *block;               /* owned */
};

/* The rules of a mesh to a tolerance. */
struct rad_rules {
  double tolerance;
  int n_panel;
  struct rad_panel *panel; /* owned [n_panel]; equal intervals share one */
  int *angular, *radial;   /* owned [n_element] panel of each element */
};

enum rad_code rad_rules_build(const struct rad_mesh *mesh, double tolerance,
                              struct rad_rules *rules, struct rad_error *e);
void rad_rules_free(struct rad_rules *rules); /* safe twice */

/**
 * reach[o]: the least D such that rule o integrates
 *   T_{k-1} (1 + z) J / |z - zeta|^4   for every |zeta - 1| + |zeta + 1| = 2 D,
 * z in [-1, 1] the position, to the tolerance, relative to the integral without T_{k-1} (theory
 * 3.5). D is the sum of the distances of x from the ends of the segment over its length, which is
 * not less than that from the middle over the half length. INFINITY if never. J: see weight.
 */
void rad_panel_reach(const struct rad_gauss *g, const struct rad_panel *panel, double tolerance,
                     double reach[RAD_N_ORDER]);

#endif
