/* Solving (I - diag(rho) K) u = E: LU, GMRES or a partial Neumann series. */
#ifndef RAD_SYSTEM_SOLVE_H
#define RAD_SYSTEM_SOLVE_H

#include "system/operator.h"

/* Where GMRES or the bounces are, at the last point that they can go on from with the same bits:
 * GMRES between two cycles. Systems are the bands and, for GMRES, the same with E = 1. */
struct rad_iterate {
  int n_system;   /* 0: at the beginning */
  double *u;      /* owned [n_system, n] */
  int64_t *steps; /* owned [n_system] */
  double *before; /* owned [n_system] residual where the last cycle began */
};

enum rad_code rad_iterate_init(int n_system, int n, struct rad_iterate *x, struct rad_error *e);
void rad_iterate_free(struct rad_iterate *x); /* safe twice */

struct rad_solve_options {
  enum rad_solver solver;
  double tolerance;  /* max-norm residual over max |u| (gmres) */
  int bounces;       /* neumann */
  double quadrature; /* tolerance of the matrix entries: how far a closed row sum may be from 1 */
  struct rad_iterate *iterate; /* where to begin and, after RAD_ESTOPPED, to go on; or NULL */
};

/* What a solve says of itself; worst over the bands. */
struct rad_solve_report {
  enum rad_solver solver; /* used */
  int iterations;         /* GMRES steps or bounces; 0 for LU */
  int converged;
  double kappa;              /* max rho K1 over the collocation points */
  double inverse_norm;       /* max w, w of (5.2): norm of the inverse operator; NAN: Neumann */
  double residual;           /* max |E - u + rho K u| [W/m2] */
  double condition_estimate; /* max norm, dgecon; NAN without LU */
  double remainder;          /* Neumann: bound of the bounces left out [W/m2]; 0 otherwise */
  int n_part;                /* independent parts of the scene; LU factors each by itself */
  double seconds_factor, seconds_solve;
};

enum { RAD_LU_UNKNOWNS = 600 }; /* auto: LU up to here, GMRES beyond */

/* The solver that `auto` stands for, with a dense matrix; without one LU becomes GMRES. */
enum rad_solver rad_solver_pick(enum rad_solver asked, double n);

/* Bytes that a run holds at once: the matrix, and LU's copy of it or GMRES's vectors. */
double rad_solver_bytes(enum rad_solver used, double n, int n_band);

/**
 * Solve for all bands.
 *
 * @param[in]  rho  [n_band, n] reflectivity at the points; emission [n_band, n] E [W/m2]
 * @param[out] u    [n_band, n] [W/m2]; on RAD_ENUMERIC with report->converged == 0 the best so far
 * @param[out] h    [n_band, n] irradiance K u at the points [W/m2]
 * @return RAD_ENUMERIC for a closed scene with rho = 1, a singular matrix, or no convergence;
 * RAD_ESTOPPED once rad_stop_asked()
 */
enum rad_code rad_solve(const struct rad_operator *k, const struct rad_solve_options *options,
                        int n_band, const double *rho, const double *emission, double *u, double *h,
                        struct rad_solve_report *report, struct rad_error *e);

/* One system of the solvers behind rad_solve: (I - diag(rho) K) u = emission. */
struct rad_linear {
  const double *rho, *emission; /* [n] */
  double *u;                    /* out [n] */
  double tolerance;             /* GMRES: of the max-norm residual over max |u| */
  int steps;                    /* out: GMRES steps */
  int goes_on;                  /* GMRES: u, steps and before are those of a run that was stopped */
  double before;                /* out: residual where the last cycle began */
};

/* One matrix for each independent part, two right-hand sides: u for the emission, w [n] for 1.
 * part: [n_triangle] of rad_find_parts. */
enum rad_code rad_lu(const struct rad_dense *dense, int n_part, const int *part,
                     const struct rad_linear *system, double *w, struct rad_solve_report *report,
                     struct rad_error *e);

/**
 * Restarted GMRES for several systems, whose products with K are taken in one pass.
 *
 * Each ends when its true residual, recomputed from K, is below its tolerance times max |u|. After
 * RAD_ESTOPPED all are as they were between two cycles.
 */
enum rad_code rad_gmres(const struct rad_operator *k, int n_system, struct rad_linear *system,
                        struct rad_error *e);

/* r = E - u + rho K u, its largest entry; h = K u. All [n]. */
double rad_residual(const struct rad_operator *k, const double *rho, const double *emission,
                    const double *u, double *h, double *r);

#endif
