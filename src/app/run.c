/* polyrad run and polyrad check: one deck, solved or only looked at. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/case.h"
#include "app/checkpoint.h"
#include "app/command.h"
#include "app/files.h"
#include "app/study.h"
#include "base/memory.h"
#include "output/stamp.h"
#include "output/thermal.h"

static const char *mesh_name[] = {"paper", "graded", "uniform", "geometric"};
static const char *solver_name[] = {"auto", "lu", "gmres", "neumann"};

static void print_notes(const struct rad_case *c, FILE *log) {
  for (int i = 0; i < c->notes.n; i++)
    fprintf(log, "%s\n", c->notes.text[i]);
}

static void print_head(const struct rad_case *c, FILE *out) {
  const struct rad_deck_method *m = &c->deck.method;
  fprintf(out, "%s\n", c->deck.title[0] ? c->deck.title : c->deck.path);
  fprintf(out, "  scene    %d triangles, %d surfaces, %d band%s\n", c->scene.n_triangle,
          c->scene.n_surface, c->scene.n_band, c->scene.n_band > 1 ? "s" : "");
  if (c->is_adaptive) {
    fprintf(out, "  accuracy %.3g of the largest radiosity\n", c->tolerance);
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
static void print_passive(const struct rad_layout *l, FILE *out) {
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

static void print_exponent(FILE *out, double x, double tolerance) {
  if (x < 1)
    fprintf(out, " %8.6f p=%d", x, rad_layout_grading(x, tolerance));
  else
    fprintf(out, " %12s", "-");
}

/* Exponents and gradings, for scenes that a person can read. */
static void print_exponents(const struct rad_case *c, const struct rad_layout *l, FILE *out) {
  enum { READABLE = 24 };
  int n = c->scene.n_triangle < READABLE ? c->scene.n_triangle : READABLE;
  fprintf(out, "  exponents of triangles: edges v0v1, v1v2, v2v0; vertices v0, v1, v2\n");
  for (int t = 0; t < n; t++) {
    fprintf(out, "  %4d %-12.12s", t + 1, c->scene.surface_name[c->scene.triangle[t].surface]);
    for (int i = 0; i < 3; i++)
      print_exponent(out, l->exponents.beta[t][i], c->tolerance);
    fprintf(out, "  |");
    for (int i = 0; i < 3; i++)
      print_exponent(out, l->exponents.alpha[t][i], c->tolerance);
    fprintf(out, "\n");
  }
  if (n < c->scene.n_triangle)
    fprintf(out, "  and %d more triangles\n", c->scene.n_triangle - n);
}

/* polyrad check of an adaptive run: its start; where it ends, only solving can tell. */
static enum rad_code check_adaptive(const struct rad_case *c, FILE *out, struct rad_error *e) {
  struct rad_layout l = {0};
  rad_progress_phase(c->scene.progress, "exponents");
  enum rad_code code = rad_layout_begin(&c->scene, c->visibility.sight, c->tolerance, &l, e);
  rad_progress_clear(c->scene.progress);
  if (!code) {
    double unknowns = rad_layout_unknowns(&l);
    fprintf(out, "  mesh     adaptive, starts with %d elements, %.0f unknowns, %.4g MB\n", l.n_leaf,
            unknowns, 8e-6 * unknowns * unknowns);
    fprintf(out, "  memory   %.4g MB available\n", rad_memory_available() / 1e6);
    print_passive(&l, out);
    print_exponents(c, &l, out);
  }
  rad_layout_free(&l);
  return code;
}

static void print_means(const struct rad_case *c, const struct rad_result *r, FILE *out) {
  int nb = c->scene.n_band;
  fprintf(out, "  surface %-16s area [m2]   mean radiosity [W/m2]   mean irradiance [W/m2]\n", "");
  for (int s = 0; s < c->scene.n_surface; s++)
    for (int b = 0; b < nb; b++) {
      double area = 0, u = 0, h = 0;
      for (int t = 0; t < c->scene.n_triangle; t++)
        if (c->scene.triangle[t].surface == s) {
          double a = c->scene.triangle[t].area;
          area += a;
          u += a * r->triangle_radiosity[t * nb + b];
          h += a * r->triangle_irradiance[t * nb + b];
        }
      char name[96];
      snprintf(name, sizeof name, nb > 1 ? "%.40s, %.40s" : "%.40s", c->scene.surface_name[s],
               c->scene.band[b]);
      fprintf(out, "          %-16s %9.4g   %21.10g   %22.10g\n", name, area, u / area, h / area);
    }
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

static void print_solution(const struct rad_case *c, const struct rad_result *r, FILE *out) {
  const struct rad_solve_report *s = &c->report;
  const struct rad_diagnostics *d = &r->diagnostics;
  if (c->is_adaptive) {
    fprintf(out, "  mesh     adaptive, %d levels: %d elements, %d unknowns\n", c->adaptive.levels,
            c->mesh->n_element, c->mesh->n_point);
    print_passive(&c->adaptive.layout, out);
  }
  if (c->has_bound)
    fprintf(
        out,
        "  error    at most %.2e W/m2, %.2e of the largest radiosity%s; nearer than 1e-7 to edges "
        "and vertices %.2e\n",
        d->error_bound, c->adaptive.bound,
        c->adaptive.bound <= c->tolerance ? "" : " (NOT THE TOLERANCE)", c->adaptive.bound_limit);
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
  print_means(c, r, out);
  print_probes(c, r, out);
  print_view_factors(&r->view_factors, out);
}

static void print_time(const struct rad_result *r, FILE *out) {
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
static enum rad_code print_heat(const struct rad_case *c, const struct rad_result *r,
                                const struct rad_command *command, struct rad_error *e) {
  struct rad_thermal t;
  enum rad_code code = rad_thermal_make(r, &t, e);
  if (!code && t.cold >= 0)
    fprintf(command->log,
            "%s: warning: triangle %d (%s) has no temperature: its flux draws more heat than "
            "arrives there, and T^4 would be negative\n",
            c->deck.path, t.cold + 1, c->scene.surface_name[c->scene.triangle[t.cold].surface]);
  if (!code && t.surface.n && !command->quiet) {
    fprintf(command->out,
            "  heat    %-16s temperature [K]   net flux u - h [W/m2]   net power [W]\n", "");
    for (int s = 0; s < t.surface.n; s++)
      fprintf(command->out, "          %-16.40s %15.8g   %21.10g   %13.7g\n",
              c->scene.surface_name[s], t.surface.temperature[s], t.surface.flux[s],
              t.surface.power[s]);
    fprintf(command->out,
            "          sum of net powers %.3g W, of %.7g W given off: 0 in a closed scene\n", t.sum,
            t.given);
  }
  rad_thermal_free(&t);
  return code;
}

static const char *output_path(const struct rad_case *c, const struct rad_command *command) {
  return command->output ? command->output : c->deck.output.file;
}

static void warn(const struct rad_case *c, FILE *log) {
  struct rad_notes notes = {0};
  rad_case_warn(c, &notes);
  for (int i = 0; i < notes.n; i++)
    fprintf(log, "%s: warning: %s\n", c->deck.path, notes.text[i]);
  rad_notes_free(&notes);
}

static void warn_view_factors(const struct rad_case *c, const struct rad_view_factors *f,
                              FILE *log) {
  if (f->matrix && !f->converged)
    fprintf(log,
            "%s: warning: the view factors have an estimated error of %.2e and a reciprocity error "
            "of %.2e, not the tolerance %.3g: %s\n",
            c->deck.path, f->worst_error, f->worst_reciprocity, f->tolerance, f->reason);
}

/* Picture, means and file of a case that has a solution, converged or not. */
static enum rad_code output(const struct rad_case *c, const struct rad_command *command,
                            double started, struct rad_error *e) {
  const char *path = output_path(c, command);
  struct rad_result result = {0};
  enum rad_code code = rad_case_result(c, command->line, &result, e);
  result.task = command->within ? &command->within->task : NULL;
  rad_progress_phase(c->scene.progress, "writing");
  if (!code)
    code = rad_result_write(path, &result, started, e);
  if (!code && command->within)
    command->within->is_written = 1;
  rad_progress_clear(c->scene.progress);
  if (!code)
    warn_view_factors(c, &result.view_factors, command->log);
  if (!code && !command->quiet)
    print_solution(c, &result, command->out);
  if (!code)
    code = print_heat(c, &result, command, e);
  if (!code && !command->quiet) {
    print_time(&result, command->out);
    fprintf(command->out, "  written  %s%s\n", path, c->report.converged ? "" : " (NOT CONVERGED)");
  }
  rad_result_free(&result);
  return code;
}

enum rad_code rad_app_run(const struct rad_command *command, struct rad_error *e) {
  struct rad_case c;
  struct rad_progress line, *progress = command->quiet ? NULL : &line;
  double started = rad_stamp_now();
  const char *restart = rad_restart_find(command);
  rad_progress_init(&line, command->log);
  enum rad_code code = rad_case_read(command->deck, command->n_set, command->set, progress, &c, e);
  if (!code)
    code = rad_files_check(command, &c.deck, output_path(&c, command), e);
  if (!code)
    code = rad_case_build(progress, &c, e);
  rad_progress_clear(progress);
  print_notes(&c, command->log);
  if (!code && restart)
    code = rad_case_restart(&c, restart, e);
  else if (!code && command->joins)
    code = rad_case_join(&c, command->n_file - 1, command->file + 1, e);
  if (!code) {
    if (!command->quiet)
      print_head(&c, command->out);
    code = rad_case_solve(&c, e);
    rad_progress_clear(progress);
  }
  if (!code && command->within)
    code = rad_study_take(&c, command->within->grid, rad_stamp_now() - started,
                          command->within->task.number > command->within->task.n_row,
                          &command->within->task.run, e);
  if (!code) {
    warn(&c, command->log);
    code = output(&c, command, started, e);
    if (!code && c.adaptive.reason[0])
      code = rad_fail(e, RAD_ENUMERIC,
                      "%s: error: the tolerance %.3g was not reached, the bound is %.2e: %s",
                      c.deck.path, c.tolerance, c.adaptive.bound, c.adaptive.reason);
  } else if (code == RAD_ENUMERIC && c.report.iterations > 0 && isfinite(c.report.residual)) {
    struct rad_error second; /* the first error is the one to report */
    output(&c, command, started, &second);
  }
  if (code == RAD_ESTOPPED)
    code = rad_case_stopped(&c, command, started, e);
  rad_case_free(&c);
  return code;
}

enum rad_code rad_app_check(const struct rad_command *command, struct rad_error *e) {
  struct rad_case c;
  struct rad_progress line, *progress = command->quiet ? NULL : &line;
  rad_progress_init(&line, command->log);
  enum rad_code code =
      rad_case_prepare(command->deck, command->n_set, command->set, progress, &c, e);
  rad_progress_clear(progress);
  print_notes(&c, command->log);
  if (!code && c.is_adaptive) {
    print_head(&c, command->out);
    code = check_adaptive(&c, command->out, e);
    rad_case_free(&c);
    return code;
  }
  rad_progress_phase(progress, "prediction");
  if (!code)
    code = rad_case_predict(&c, e);
  rad_progress_clear(progress);
  if (!code) {
    const struct rad_plan *p = &c.plan;
    print_head(&c, command->out);
    fprintf(command->out, "  matrix   %.4g MB, %s; the run holds %.4g MB of %.4g MB available\n",
            p->system.matrix_bytes / 1e6,
            p->system.matrix == RAD_MATRIX_DENSE ? "dense" : "hierarchical",
            (p->base_bytes + p->bytes) / 1e6, (p->base_bytes + p->available) / 1e6);
    fprintf(command->out, "  solver   %s\n", solver_name[p->system.solver]);
    fprintf(command->out,
            "  skipped  %.1f %% of %.4g point-element pairs: coplanar or facing away\n",
            100 * p->skipped / p->pairs, p->pairs);
    fprintf(command->out, "  time     about %.2g s\n", p->seconds);
  }
  rad_case_free(&c);
  return code;
}

enum rad_code rad_app_info(const struct rad_command *command, struct rad_error *e) {
  char *text = NULL;
  enum rad_code code = rad_result_describe(command->deck, &text, e);
  if (!code)
    fputs(text, command->out);
  free(text);
  return code;
}
