/* Ask for an accuracy: solve, estimate, refine what contributes most, until the bound meets it. */
#ifndef RAD_ESTIMATE_ADAPT_H
#define RAD_ESTIMATE_ADAPT_H

#include "estimate/means.h"
#include "estimate/stage.h"

struct rad_goal {
  double tolerance; /* of max |u - u*| over max |u| */
  enum rad_solver solver;
  enum rad_matrix matrix;
  double solver_tolerance;      /* 0: from tolerance */
  double quadrature_tolerance;  /* 0: from tolerance */
  double memory;                /* bytes that may be used */
  const struct rad_stage *from; /* where to go on, or NULL: from the beginning */
};

/* The last level of an adaptive run. */
struct rad_adaptive {
  struct rad_layout layout;
  struct rad_mesh *mesh; /* owned; its address is kept by dense or h2 */
  struct rad_rules rules;
  struct rad_dense dense; /* one of these two */
  struct rad_h2 h2;
  double *rho, *emission, *u, *h; /* owned [n_band, n_point] */
  struct rad_solve_report report;
  struct rad_indicator indicator;
  double bound;         /* of max |u - u*| over max |u|, from 1e-7 of edges and vertices on */
  double bound_limit;   /* the same right up to edges and vertices */
  double *source;       /* owned [n_element] g of (6.2), over max |u|: the element's largest
                           |rho K d|, limits at edges included, what its samples may miss, and what
                           integrals, compression and solver add */
  double *light_source; /* owned [n_element, n_band] the same of K u_h in place of u*, with |K d| */
  double *z;            /* owned [n_band, n_point] z of (6.2) at the collocation points */
  double *remainder;    /* owned [n_element] of u* beside its interpolant (theory 17.2), with the
                           safety factor, over max |u| */
  double *element_bound; /* owned [n_element] z, largest of the element's points */
  struct rad_means means;
  double *least_weight; /* owned [n_triangle, n_band] of K d, or NULL: where means asked for more */
  double wanted;        /* the bound, or the same with those weights: what refinement lowers */
  double target;        /* of `wanted`: the tolerance, or less where means ask for that */
  double quadrature;    /* tolerance of the matrix entries, and of compression */
  int levels;
  int stuck;              /* of them in a row that hardly lowered the bound */
  double least;           /* bound of all levels */
  struct rad_stage stage; /* owned: where the last level that was done begins, and after
                             RAD_ESTOPPED the run can go on to the same bits; no leaves: none was */
  double seconds_before;  /* spent on levels before the last */
  double seconds_assemble, seconds_estimate;
  char reason[256]; /* why the tolerance was not reached; empty if it was */
};

/* Whether the means met the tolerance: with integrals to a part of it this is not to be exact. */
static inline int rad_adaptive_means_met(const struct rad_adaptive *a, double tolerance) {
  return a->means.worst <= tolerance;
}

/**
 * @param[out] a  to be freed with rad_adaptive_free, also after an error
 * @return RAD_OK also when the tolerance could not be reached: a->reason says why
 */
enum rad_code rad_adapt(const struct rad_scene *scene, const struct rad_goal *goal,
                        struct rad_adaptive *a, struct rad_error *e);

/**
 * Indicator, bounds and means of a mesh made by hand and solved elsewhere: a->mesh, rules, dense or
 * h2, rho, emission, u, h and report are given, the rest is zero.
 */
enum rad_code rad_adapt_estimate(const struct rad_scene *scene, const struct rad_goal *goal,
                                 struct rad_adaptive *a, struct rad_error *e);

/* The matrix of the last level. */
struct rad_operator rad_adaptive_operator(const struct rad_adaptive *a);

void rad_adaptive_free(struct rad_adaptive *a); /* safe twice */

#endif
