#include "system/solve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "base/stop.h"
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

/* K1 is the part of its hemisphere that a point sees: more than 1 is an error of the program. */
static enum rad_code check_hemispheres(const struct rad_operator *k, const double *k1, double slack,
                                       struct rad_error *e) {
  const struct rad_scene *scene = k->mesh->scene;
  int worst = 0;
  for (int i = 0; i < k->n; i++)
    if (!(k1[i] <= k1[worst]))
      worst = i;
  if (k->n == 0 || k1[worst] <= 1 + slack)
    return RAD_OK;
  int t = 0;
  while (k->mesh->point_first[t + 1] <= worst)
    t++;
  return rad_fail(e, RAD_ENUMERIC,
                  "a point of triangle %d (%s) sees %.9g of its hemisphere, and no more than 1 is "
                  "possible (to %.1g): an error of polyrad; please report the deck",
                  t + 1, scene->surface_name[scene->triangle[t].surface], k1[worst], slack);
}

static enum rad_code fail_closed_white(const struct rad_scene *scene, int white,
                                       struct rad_error *e) {
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

/* kappa, and refusal of scenes where light of a band is never lost. */
static enum rad_code check_contraction(const struct rad_operator *k, const double *rho,
                                       const double *k1, double slack, const int *part,
                                       struct rad_solve_report *report, struct rad_error *e) {
  for (int i = 0; i < k->n; i++)
    report->kappa = fmax(report->kappa, rho[i] * k1[i]);
  int white =
      report->kappa > 1 - slack ? find_closed_white(k, rho, k1, slack, report->n_part, part) : -1;
  return white < 0 ? RAD_OK : fail_closed_white(k->mesh->scene, white, e);
}

/* What a point sees of its hemisphere. */
static void set_k1(const struct rad_operator *k, double *one, double *k1) {
  for (int i = 0; i < k->n; i++)
    one[i] = 1;
  rad_operator_apply(k, 1, (const double *const[]){one}, &k1);
}

enum rad_code rad_iterate_init(int n_system, int n, struct rad_iterate *x, struct rad_error *e) {
  size_t m = (size_t)n_system;
  rad_iterate_free(x);
  x->u = rad_alloc(m * (size_t)n, sizeof(double));
  x->steps = rad_alloc(m, sizeof(int64_t));
  x->before = rad_alloc(m, sizeof(double));
  if (!x->u || !x->steps || !x->before)
    return rad_fail_memory(e, "the iterate", 8.0 * (double)m * n);
  x->n_system = n_system;
  return RAD_OK;
}

void rad_iterate_free(struct rad_iterate *x) {
  free(x->u);
  free(x->steps);
  free(x->before);
  *x = (struct rad_iterate){0};
}

/* Systems to where an earlier run has left them. */
static void take_up(const struct rad_iterate *x, int n_system, int n, struct rad_linear *system) {
  if (!x || x->n_system != n_system)
    return;
  for (int i = 0; i < n_system; i++) {
    memcpy(system[i].u, x->u + (size_t)i * (size_t)n, sizeof(double) * (size_t)n);
    system[i].steps = (int)x->steps[i];
    system[i].before = x->before[i];
    system[i].goes_on = 1;
  }
}

/* Systems as they are, after a signal. */
static enum rad_code lay_down(int n_system, int n, const struct rad_linear *system,
                              struct rad_iterate *x, struct rad_error *e) {
  enum rad_code code = x ? rad_iterate_init(n_system, n, x, e) : RAD_OK;
  for (int i = 0; x && !code && i < n_system; i++) {
    memcpy(x->u + (size_t)i * (size_t)n, system[i].u, sizeof(double) * (size_t)n);
    x->steps[i] = system[i].steps;
    x->before[i] = system[i].before;
  }
  return code ? code : rad_fail_stopped(e);
}

/* u after a number of bounces, and the bound kappa^(b+1) / (1 - kappa) max E of the rest. */
static void neumann(const struct rad_operator *k, int bounces, struct rad_linear *l, double *work,
                    struct rad_solve_report *report) {
  int n = k->n;
  const double *u = l->u;
  if (!l->goes_on)
    memcpy(l->u, l->emission, sizeof(double) * (size_t)n);
  for (; l->steps < bounces && !rad_stop_asked(); l->steps++) {
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
static enum rad_code gmres(const struct rad_operator *k, const struct rad_solve_options *o,
                           int n_band, const struct rad_linear *band, double *one, double *w,
                           struct rad_solve_report *report, struct rad_error *e) {
  struct rad_linear system[2 * RAD_MAX_BAND];
  for (int i = 0; i < k->n; i++)
    one[i] = 1;
  for (int b = 0; b < n_band; b++) {
    system[b] = band[b];
    system[b].tolerance = o->tolerance;
    system[n_band + b] = (struct rad_linear){.rho = band[b].rho,
                                             .emission = one,
                                             .u = w + (size_t)b * (size_t)k->n,
                                             .tolerance = o->tolerance};
  }
  take_up(o->iterate, 2 * n_band, k->n, system);
  enum rad_code code = rad_gmres(k, 2 * n_band, system, e);
  if (code == RAD_ESTOPPED)
    code = lay_down(2 * n_band, k->n, system, o->iterate, e);
  for (int b = 0; b < n_band; b++)
    report->iterations =
        report->iterations > system[b].steps ? report->iterations : system[b].steps;
  return code;
}

/* The solver that was asked for, on every band; w [n_band, n] but for Neumann. */
static enum rad_code dispatch(const struct rad_operator *k, const struct rad_solve_options *o,
                              const int *part, int n_band, struct rad_linear *band, double *one,
                              double *w, struct rad_solve_report *report, struct rad_error *e) {
  enum rad_code code = RAD_OK;
  if (report->solver == RAD_SOLVER_NEUMANN)
    take_up(o->iterate, n_band, k->n, band);
  if (report->solver == RAD_SOLVER_GMRES)
    code = gmres(k, o, n_band, band, one, w, report, e);
  for (int b = 0; b < n_band && !code && report->solver == RAD_SOLVER_LU; b++)
    code =
        rad_lu(k->dense, report->n_part, part, &band[b], w + (size_t)b * (size_t)k->n, report, e);
  for (int b = 0; b < n_band && report->solver == RAD_SOLVER_NEUMANN; b++)
    neumann(k, o->bounces, &band[b], one, report);
  if (report->solver == RAD_SOLVER_NEUMANN && rad_stop_asked())
    code = lay_down(n_band, k->n, band, o->iterate, e);
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
  double *k1 = work + n, slack = fmax(1e-6, 20 * options->quadrature);
  set_k1(k, work, k1);
  for (int b = 0; b < n_band && !code; b++) {
    size_t at = (size_t)b * n;
    band[b] = (struct rad_linear){.rho = rho + at, .emission = emission + at, .u = u + at};
    code = check_contraction(k, band[b].rho, k1, slack, part, report, e);
  }
  if (!code)
    code = check_hemispheres(k, k1, slack + (k->h2 ? 20 * k->h2->error : 0), e);
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
