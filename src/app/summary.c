/* What a run says of itself: the lines of its summary, and its warnings. */
#include "app/summary.h"

#include <math.h>

#include "base/number.h"
#include "estimate/balance.h"
#include "output/thermal.h"

static const char *mesh_name[] = {"paper", "graded", "uniform", "geometric"};
static const char *solver_name[] = {"auto", "lu", "gmres", "neumann"};

void rad_print_notes(const struct rad_case *c, FILE *log) {
  for (int i = 0; i < c->notes.n; i++)
    fprintf(log, "%s\n", c->notes.text[i]);
}

void rad_print_head(const struct rad_case *c, FILE *out) {
  const struct rad_deck_method *m = &c->deck.method;
  fprintf(out, "%s\n", c->deck.title[0] ? c->deck.title : c->deck.path);
  fprintf(out, "  scene    %d triangles, %d surfaces, %d band%s\n", c->scene.n_triangle,
          c->scene.n_surface, c->scene.n_band, c->scene.n_band > 1 ? "s" : "");
  if (c->is_adaptive) {
    fprintf(out,
            "  accuracy %.3g of the largest radiosity: radiosity at any point, and means over "
            "surfaces\n",
            c->tolerance);
    return;
  }
  int geometric = m->mesh == RAD_MESH_GEOMETRIC;
  fprintf(out, "  mesh     %s, N = %d, %s = %g, degree %d%s: %d elements, %d unknowns\n",
          mesh_name[m->mesh], m->elements, geometric ? "ratio" : "p",
          geometric ? m->ratio : m->grading, m->degree,
          m->nodes.kind == RAD_NODES_GAUSS ? "" : ", NOT GAUSS POINTS", c->mesh->n_element,
          c->mesh->n_point);
}

/* What an adaptive run leaves out, and why. */
void rad_print_passive(const struct rad_layout *l, FILE *out) {
  static const char *const why[] = {NULL, "black", "unlit", "seeing nothing"};
  int n_triangle = l->scene->n_triangle;
  for (int reason = RAD_BLACK; reason <= RAD_ALONE; reason++) {
    int n = 0;
    for (int t = 0; t < n_triangle; t++)
      n += l->passive[t] == reason;
    if (n)
      fprintf(out, "  left out unknowns on %d triangle%s: %s, u = E there\n", n, n > 1 ? "s" : "",
              why[reason]);
  }
}

static double surface_area(const struct rad_scene *scene, int surface) {
  double area = 0;
  for (int t = 0; t < scene->n_triangle; t++)
    area += scene->triangle[t].surface == surface ? scene->triangle[t].area : 0;
  return area;
}

static enum rad_code print_means(const struct rad_case *c, FILE *out, struct rad_error *e) {
  int nb = c->scene.n_band;
  struct rad_means m;
  enum rad_code code = rad_means_of_surfaces(&c->scene, &c->means, &m, e);
  if (!code)
    fprintf(out, "  surface %-16s %9s   %26s   %26s\n", "", "area [m2]", "mean radiosity [W/m2]",
            "mean irradiance [W/m2]");
  for (int i = 0; i < c->scene.n_surface * nb && !code; i++) {
    char name[96], u[64], h[64];
    int s = i / nb;
    snprintf(name, sizeof name, nb > 1 ? "%.40s, %.40s" : "%.40s", c->scene.surface_name[s],
             c->scene.band[i % nb]);
    rad_number_with_error(m.radiosity[i], m.error_radiosity[i], u, sizeof u);
    rad_number_with_error(m.irradiance[i], m.error_irradiance[i], h, sizeof h);
    fprintf(out, "          %-16s %9.4g   %26s   %26s\n", name, surface_area(&c->scene, s), u, h);
  }
  rad_means_free(&m);
  return code;
}

const char *rad_solver_name(enum rad_solver s) {
  return solver_name[s];
}

static void print_probes(const struct rad_case *c, const struct rad_result *r, FILE *out) {
  int nb = c->scene.n_band;
  if (c->deck.n_probe)
    fprintf(out, "  probe   %-16s %41s   %22s\n", "", "radiosity [W/m2]", "irradiance [W/m2]");
  for (int i = 0; i < c->deck.n_probe; i++)
    for (int b = 0; b < nb; b++) {
      char name[96];
      snprintf(name, sizeof name, nb > 1 ? "%.40s, %.40s" : "%.40s", c->deck.probe[i].name,
               c->scene.band[b]);
      fprintf(out, "          %-16s %41.12g   %22.12g\n", name, r->probe_radiosity[i * nb + b],
              r->probe_irradiance[i * nb + b]);
    }
}

static void print_view_factors(const struct rad_view_factors *f, FILE *out) {
  if (!f->matrix)
    return;
  double least = INFINITY, most = 0;
  for (int s = 0; s < f->n; s++) {
    least = fmin(least, f->row_sum[s]);
    most = fmax(most, f->row_sum[s]);
  }
  fprintf(out,
          "  views    %d x %d view factors, error %.1e, reciprocity to %.1e, rows sum to %.9g .. "
          "%.9g; %lld points, %.3f s%s\n",
          f->n, f->n, f->worst_error, f->worst_reciprocity, least, most, (long long)f->points,
          f->seconds, f->converged ? "" : " (NOT CONVERGED)");
}

/* Errors of what, and relative to what. */
static void print_errors(const struct rad_case *c, const struct rad_diagnostics *d, FILE *out) {
  double bound = c->adaptive.bound, most = bound > 0 ? d->error_bound / bound : 0;
  fprintf(out,
          "  error    of the radiosity at any point at most %.2e W/m2: %.2e of the largest "
          "radiosity, %.4g W/m2%s; nearer than 1e-7 to edges and vertices %.2e\n",
          d->error_bound, bound, most, bound <= c->tolerance ? "" : " (NOT THE TOLERANCE)",
          c->adaptive.bound_limit);
  fprintf(out, "           of the means below as stated there, at most %.2e of it%s\n",
          d->means_error, d->means_converged ? "" : " (NOT THE TOLERANCE)");
}

static void print_run(const struct rad_case *c, const struct rad_result *r, FILE *out) {
  const struct rad_solve_report *s = &c->report;
  const struct rad_diagnostics *d = &r->diagnostics;
  if (c->is_adaptive) {
    fprintf(out, "  mesh     adaptive, %d levels: %d elements, %d unknowns\n", c->adaptive.levels,
            c->mesh->n_element, c->mesh->n_point);
    rad_print_passive(&c->adaptive.layout, out);
  }
  if (c->has_bound)
    print_errors(c, d, out);
  else
    fprintf(out, "  error    not estimated%s\n",
            c->deck.tolerance > 0 ? ": a Neumann series, or a uniform mesh of degree 1"
                                  : "; accuracy.tolerance gives a bound");
  if (c->plan.system.matrix == RAD_MATRIX_HIERARCHICAL)
    fprintf(out, "  matrix   hierarchical, %.3g MB; compression %.1e of a row, estimated %.1e\n",
            c->plan.system.matrix_bytes / 1e6, c->h2.tolerance, c->h2.error);
  else
    fprintf(out, "  matrix   dense, %.3g MB; %lld near and %lld far pairs, %lld skipped%s\n",
            c->plan.system.matrix_bytes / 1e6, (long long)d->pairs_near, (long long)d->pairs_far,
            (long long)d->pairs_skipped,
            c->is_adaptive && c->adaptive.levels > 1 ? "; the rest from the level before" : "");
  fprintf(out, "  solver   %s", solver_name[s->solver]);
  if (s->n_part > 1)
    fprintf(out, ", %d independent parts%s", s->n_part,
            s->solver == RAD_SOLVER_LU ? " apart" : " (no blocks between them)");
  if (s->solver == RAD_SOLVER_GMRES)
    fprintf(out, ", %d steps", s->iterations);
  if (s->solver == RAD_SOLVER_NEUMANN)
    fprintf(out, ", %d bounces, the rest is below %.2e W/m2", s->iterations, s->remainder);
  fprintf(out, "; kappa %.4f, residual %.1e W/m2", s->kappa, s->residual);
  if (!isnan(s->condition_estimate))
    fprintf(out, ", condition %.3g", s->condition_estimate);
  if (!isnan(s->inverse_norm))
    fprintf(out, ", |inverse| %.4g", s->inverse_norm);
  fprintf(out, "\n");
}

void rad_print_time(const struct rad_result *r, FILE *out) {
  const struct rad_diagnostics *d = &r->diagnostics;
  fprintf(out, "  time     %.3f s: ", d->seconds_total);
  if (d->seconds_levels > 0)
    fprintf(out, "levels before %.3f, ", d->seconds_levels);
  fprintf(out, "assemble %.3f, factor %.3f, solve %.3f, ", d->seconds_assemble, d->seconds_factor,
          d->seconds_solve);
  if (d->seconds_estimate > 0)
    fprintf(out, "estimate %.3f, ", d->seconds_estimate);
  fprintf(out, "output %.3f; %d threads\n", d->seconds_output, r->threads);
}

/* Net heat and temperatures of a thermal scene, and whether they close. */
static enum rad_code print_heat(const struct rad_case *c, FILE *out, FILE *log,
                                struct rad_error *e) {
  struct rad_thermal t;
  enum rad_code code = rad_thermal_make(&c->scene, &c->means, &t, e);
  if (!code && t.cold >= 0)
    fprintf(log,
            "%s: warning: triangle %d (%s) has no temperature: its flux draws more heat than "
            "arrives there, and T^4 would be negative\n",
            c->deck.path, t.cold + 1, c->scene.surface_name[c->scene.triangle[t.cold].surface]);
  if (!code && t.surface.n && out) {
    fprintf(out, "  heat    %-16s %20s   %24s   %22s\n", "", "temperature [K]",
            "net flux u - h [W/m2]", "net power [W]");
    for (int s = 0; s < t.surface.n; s++) {
      char kelvin[64], flux[64], power[64];
      rad_number_with_error(t.surface.temperature[s], t.surface.error_temperature[s], kelvin,
                            sizeof kelvin);
      rad_number_with_error(t.surface.flux[s], t.surface.error_flux[s], flux, sizeof flux);
      rad_number_with_error(t.surface.power[s], t.surface.error_power[s], power, sizeof power);
      fprintf(out, "          %-16s %20s   %24s   %22s\n", c->scene.surface_name[s], kelvin, flux,
              power);
    }
    char sum[64];
    rad_number_with_error(t.sum, t.error_sum, sum, sizeof sum);
    fprintf(out, "          sum of net powers %s W, of %.7g W given off: 0 in a closed scene\n",
            sum, t.given);
  }
  rad_thermal_free(&t);
  return code;
}

/* Light that the solution makes or loses is told from this part of the emission on. */
#define IMBALANCE 0.1

static void warn_imbalance(const struct rad_case *c, const struct rad_balance *b, int k,
                           FILE *log) {
  double part = fabs(b->imbalance[k]) / b->given[k];
  if (!c->has_bound && c->report.solver != RAD_SOLVER_NEUMANN && part > IMBALANCE)
    fprintf(log,
            "%s: warning: %s%sthe solution %s %.2g times the emitted light: its rows are those of "
            "single points, which conserve none; give accuracy.tolerance, or a finer mesh\n",
            c->deck.path, b->n_band > 1 ? c->scene.band[k] : "", b->n_band > 1 ? ": " : "",
            b->imbalance[k] > 0 ? "loses" : "makes up", part);
}

static void print_balance_of(const struct rad_case *c, const struct rad_balance *b, int k,
                             FILE *out) {
  char absorbed[64], rest[64], backs[64];
  rad_number_with_error(b->absorbed[k], b->error[k], absorbed, sizeof absorbed);
  fprintf(out, "  balance  %s%semitted %.7g W, absorbed %s W",
          b->n_band > 1 ? c->scene.band[k] : "", b->n_band > 1 ? ": " : "", b->emitted[k],
          absorbed);
  if (isnan(b->on_backs[k])) {
    rad_number_with_error(b->rest[k], b->error[k], rest, sizeof rest);
    fprintf(out, ", escaped or lost on backs %s W", rest);
  } else {
    rad_number_with_error(b->rest[k] - b->on_backs[k], b->error[k] + b->backs_error[k], rest,
                          sizeof rest);
    rad_number_with_error(b->on_backs[k], b->backs_error[k] + b->error[k] * (b->on_backs[k] > 0),
                          backs, sizeof backs);
    fprintf(out, ", %s %s W, lost on backs %s W", b->is_enclosed ? "missing" : "escaped", rest,
            backs);
  }
  if (isnan(b->error[k]))
    fprintf(out, "; imbalance %.2g W of %.4g W that the faces send", b->imbalance[k],
            c->means.sent[k]);
  fprintf(out, "\n");
}

static void print_balance(const struct rad_case *c, FILE *out, FILE *log) {
  for (int k = 0; k < c->balance.n_band; k++) {
    if (out)
      print_balance_of(c, &c->balance, k, out);
    warn_imbalance(c, &c->balance, k, log);
  }
}

enum rad_code rad_print_solution(const struct rad_case *c, const struct rad_result *r, FILE *out,
                                 FILE *log, struct rad_error *e) {
  enum rad_code code = RAD_OK;
  if (out) {
    print_run(c, r, out);
    if (r->means)
      code = print_means(c, out, e);
    print_probes(c, r, out);
    print_view_factors(&r->view_factors, out);
  }
  if (!code && r->means)
    code = print_heat(c, out, log, e);
  if (!code && r->balance)
    print_balance(c, out, log);
  return code;
}
