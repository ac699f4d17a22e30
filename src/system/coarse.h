/* The coarse problem: means over aggregates, which carry what spreads slowly (theory 5.7). */
#ifndef RAD_SYSTEM_COARSE_H
#define RAD_SYSTEM_COARSE_H

#include "system/aggregate.h"
#include "system/operator.h"

enum { RAD_COARSE = 2048 }; /* aggregates: their LU takes a fraction of a second */

/* A_c = I - D_c R K P of one system, factored. */
struct rad_coarse_factor {
  const double *rho; /* borrowed [n] of the system */
  double *lu;        /* owned [n_aggregate, n_aggregate]; NULL: singular, nothing is corrected */
  int *pivot;        /* owned [n_aggregate] */
};

/**
 * C = R K P: P spreads a value over an aggregate, R takes its mean. Several systems share it.
 */
struct rad_coarse {
  const struct rad_tree *tree; /* borrowed from a hierarchical operator, or &own */
  struct rad_tree own;
  struct rad_aggregates aggregates;
  double *k; /* owned [n_aggregate, n_aggregate] column-major: C, until it is factored */
  int n_factor;
  struct rad_coarse_factor *factor; /* owned */
};

/**
 * C from the operator in about the time of a product, and A_c of each system factored.
 *
 * @param[in]  rho  [n_system] of [n]; equal pointers share a factor
 * @param[out] c    to be freed with rad_coarse_free, also after an error. It stays empty, and
 *                  corrects nothing, for scenes of too many triangles.
 * The same bits for any number of threads.
 */
enum rad_code rad_coarse_build(const struct rad_operator *k, int n_system, const double *const *rho,
                               struct rad_coarse *c, struct rad_error *e);
void rad_coarse_free(struct rad_coarse *c); /* safe twice */

/* x = A_c^{-1} R r for the system with that rho, x [n_aggregate], or 0 where A_c is singular;
 * z = P x. Serial; by several threads at once for different vectors. */
void rad_coarse_solve(const struct rad_coarse *c, const double *rho, const double *r, double *x);
void rad_coarse_spread(const struct rad_coarse *c, const double *x, double *z);

/* Bytes of the coarse problem of a mesh, if it comes to that. */
double rad_coarse_bytes(double n, int n_band);

/* C of a dense and of a hierarchical operator; k is zeroed. */
enum rad_code rad_coarse_dense(const struct rad_dense *dense, const struct rad_tree *tree,
                               const struct rad_aggregates *a, double *k, struct rad_error *e);
enum rad_code rad_coarse_h2(const struct rad_h2 *h, const struct rad_aggregates *a, double *k,
                            struct rad_error *e);

#endif
