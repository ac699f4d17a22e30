#include "system/solve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "system/parts.h"

enum rad_solver rad_solver_pick(enum rad_solver asked, double n) {
  if (asked != RAD_SOLVER_AUTO)
    return asked;
  return n <= RAD_LU_UNKNOWNS ? RAD_SOLVER_LU : RAD_SOLVER_GMRES;
}

double rad_solver_bytes(enum rad_solver used, double n, int n_band) {
  double matrix = 8 * n * n, vectors = 8 * n * (6.0 * n_band + 8);
  if (used == RAD_SOLVER_LU)
    return 2 * matrix + vectors;
  return matrix + vectors + (used == RAD_SOLVER_GMRES ? 16 * n * n_band * 42 : 0);
}

static double max_abs(int n, const double *x) {
  double most = 0;
  for (int i = 0; i < n; i++)
    if (isnan(x[i]))
      return NAN;
    else
      most = fmax(most, fabs(x[i]));
  return most;
}

double rad_residual(const struct rad_operator *k, const double *rho, const double *emission,
                    const double *u, double *h, double *r) {
  rad_operator_apply(k, 1, &u, &h);
  for (int i = 0; i < k->n; i++)
    r[i] = emission[i] - u[i] + rho[i] * h[i];
  return max_abs(k->n, r);
}

/* A triangle of an independent part of the scene that is closed and has rho = 1 throughout, or -1.
 * Closed: K1 = 1 to within rounding and quadrature at every point. */
static int find_closed_white(const struct rad_operator *k, const double *rho, const double *k1,
                             double slack, int n_part, const int *part) {
  const struct rad_mesh *mesh = k->mesh;
  int n = mesh->scene->n_triangle;
  for (int c = 0; c < n_part; c++) {
    int white = 1, first = -1;
    for (int i = 0; i < n && white; i++)
      if (part[i] == c) {
        first = first < 0 ? i : first;
        for (int p = mesh->point_first[i]; p < mesh->point_first[i + 1] && white; p++)
          white = rho[p] == 1 && k1[p] > 1 - slack;
      }
    if (white)
      return first;
  }
  return -1;
}

/* kappa, and refusal of scenes where light is never lost. */
static enum rad_code check_contraction(const struct rad_operator *k, const double *rho,
                                       double quadrature, int n_part, const int *part,
                                       double *kappa, struct rad_error *e) {
  int n = k->n, white = -1;
  double *one = rad_alloc((size_t)n, 2 * sizeof(double));
  if (!one)
    return rad_fail_memory(e, "the solver", 16.0 * n);
  double *k1 = one + n;
  for (int i = 0; i < n; i++)
    one[i] = 1;
  rad_operator_apply(k, 1, (const double *const[]){one}, &k1);
  for (int i = 0; i < n; i++)
    *kappa = fmax(*kappa, rho[i] * k1[i]);
  double slack = fmax(1e-6, 20 * quadrature);
  if (*kappa > 1 - slack)
    white = find_closed_white(k, rho, k1, slack, n_part, part);
  free(one);
  if (white < 0)
    return RAD_OK;
  const struct rad_scene *scene = k->mesh->scene;
  if (scene->heat && scene->heat[white].kind == RAD_HEAT_FLUX)
    return rad_fail(e, RAD_ENUMERIC,
                    "the scene is singular: the part that holds triangle %d (%s) is closed and its "
                    "faces have prescribed fluxes (or rho = 1) only, which fixes the differences "
                    "of T^4 but not their level; give one face a temperature or open the scene",
                    white + 1, scene->surface_name[scene->triangle[white].surface]);
  return rad_fail(e, RAD_ENUMERIC,
                  "the scene is singular: the part that holds triangle %d (%s) is closed and has "
                  "rho = 1 on every face, so light is never lost and no radiosity is finite; lower "
                  "rho of one face or open the scene",
                  white + 1, scene->surface_name[scene->triangle[white].surface]);
}

/* u after a number of bounces, and the bound kappa^(b+1) / (1 - kappa) max E of the rest. */
static void neumann(const struct rad_operator *k, int bounces, const struct rad_linear *l,
                    double *work, struct rad_solve_report *report) {
  int n = k->n;
  const double *u = l->u;
  memcpy(l->u, l->emission, sizeof(double) * (size_t)n);
  for (int b = 0; b < bounces; b++) {
    rad_operator_apply(k, 1, &u, &work);
    for (int i = 0; i < n; i++)
      l->u[i] = l->emission[i] + l->rho[i] * work[i];
  }
  double kappa = report->kappa;
  double rest =
      kappa < 1 ? pow(kappa, bounces + 1) / (1 - kappa) * max_abs(n, l->emission) : INFINITY;
  report->iterations = bounces;
  report->remainder = fmax(report->remainder, rest);
}

/* Every band by GMRES at once, with w (E = 1) as one more system each. */
static enum rad_code gmres(const struct rad_operator *k, double tolerance, int n_band,
                           const struct rad_linear *band, double *one, double *w,
                           struct rad_solve_report *report, struct rad_error *e) {
  struct rad_linear system[2 * RAD_MAX_BAND];
  for (int i = 0; i < k->n; i++)
    one[i] = 1;
  for (int b = 0; b < n_band; b++) {
    system[b] = band[b];
    system[b].tolerance = tolerance;
    system[n_band + b] =
        (struct rad_linear){band[b].rho, one, w + (size_t)b * (size_t)k->n, tolerance, 0};
  }
  enum rad_code code = rad_gmres(k, 2 * n_band, system, e);
  for (int b = 0; b < n_band; b++)
    report->iterations =
        report->iterations > system[b].steps ? report->iterations : system[b].steps;
  return code;
}

/* The solver that was asked for, on every band; w [n_band, n] but for Neumann. */
static enum rad_code dispatch(const struct rad_operator *k, const struct rad_solve_options *o,
                              const int *part, int n_band, const struct rad_linear *band,
                              double *one, double *w, struct rad_solve_report *report,
                              struct rad_error *e) {
  enum rad_code code = RAD_OK;
  if (report->solver == RAD_SOLVER_GMRES)
    code = gmres(k, o->tolerance, n_band, band, one, w, report, e);
  for (int b = 0; b < n_band && !code && report->solver == RAD_SOLVER_LU; b++)
    code =
        rad_lu(k->dense, report->n_part, part, &band[b], w + (size_t)b * (size_t)k->n, report, e);
  for (int b = 0; b < n_band && report->solver == RAD_SOLVER_NEUMANN; b++)
    neumann(k, o->bounces, &band[b], one, report);
  report->inverse_norm =
      code || report->solver == RAD_SOLVER_NEUMANN ? NAN : max_abs(k->n * n_band, w);
  return code;
}

enum rad_code rad_solve(const struct rad_operator *k, const struct rad_solve_options *options,
                        int n_band, const double *rho, const double *emission, double *u, double *h,
                        struct rad_solve_report *report, struct rad_error *e) {
  size_t n = (size_t)k->n;
  *report = (struct rad_solve_report){.solver = rad_solver_pick(options->solver, k->n),
                                      .condition_estimate = NAN};
  if (report->solver == RAD_SOLVER_LU && !k->dense)
    report->solver = RAD_SOLVER_GMRES;
  double *work = rad_alloc(((size_t)n_band + 1) * n, sizeof(double)), start = rad_seconds();
  int *part = rad_alloc((size_t)k->mesh->scene->n_triangle, sizeof(int));
  if (!work || !part) {
    free(work);
    free(part);
    return rad_fail_memory(e, "the solver", 8.0 * (double)n * (n_band + 1));
  }
  report->n_part = rad_find_parts(k, part);
  struct rad_linear band[RAD_MAX_BAND];
  enum rad_code code = RAD_OK;
  for (int b = 0; b < n_band && !code; b++) {
    size_t at = (size_t)b * n;
    band[b] = (struct rad_linear){rho + at, emission + at, u + at, 0, 0};
    code = check_contraction(k, band[b].rho, options->quadrature, report->n_part, part,
                             &report->kappa, e);
  }
  if (!code) {
    code = dispatch(k, options, part, n_band, band, work, work + n, report, e);
    for (int b = 0; b < n_band && !isnan(report->residual); b++) {
      double r = rad_residual(k, band[b].rho, band[b].emission, band[b].u, h + (size_t)b * n, work);
      report->residual = isnan(r) ? NAN : fmax(report->residual, r);
    }
    if (!code && !isfinite(report->residual))
      code =
          rad_fail(e, RAD_ENUMERIC,
                   "the solution is not finite (residual %g); check rho and emission of the deck",
                   report->residual);
  }
  report->seconds_solve = rad_seconds() - start - report->seconds_factor;
  report->converged = !code;
  free(part);
  free(work);
  return code;
}
