/* polyrad study: one deck run over a product of keys, compared with a reference. */
#include <math.h>
#include <omp.h>
#include <stdlib.h>

#include "app/files.h"
#include "app/study.h"
#include "base/clock.h"
#include "base/memory.h"
#include "system/stability.h"

/* Norms of the inverse, the largest of all bands. */
static enum rad_code take_norms(const struct rad_case *c, struct rad_task_run *run,
                                struct rad_error *e) {
  enum rad_code code = RAD_OK;
  if (!c->dense.k || c->mesh->n_point > RAD_STABILITY_MOST)
    return RAD_OK;
  run->inverse_norm = run->inverse_matrix = run->condition = run->spectral_radius = 0;
  for (int b = 0; b < c->scene.n_band && !code; b++) {
    struct rad_stability s;
    code = rad_stability(&c->dense, c->rho + (size_t)b * (size_t)c->mesh->n_point, &s, e);
    run->inverse_norm = fmax(run->inverse_norm, s.inverse_norm);
    run->inverse_matrix = fmax(run->inverse_matrix, s.inverse_matrix);
    run->condition = fmax(run->condition, s.condition);
    run->spectral_radius = fmax(run->spectral_radius, s.spectral_radius);
  }
  return code;
}

/* The solution where runs are compared, and the triangles' areas. */
static enum rad_code take_values(const struct rad_case *c, enum rad_grid grid, int is_reference,
                                 struct rad_task_run *run, struct rad_error *e) {
  enum rad_study_values values = c->deck.study.values;
  int star =
      values == RAD_VALUES_AUTO ? c->is_adaptive : is_reference || values == RAD_VALUES_REPORTED;
  run->n_area = (size_t)c->scene.n_triangle;
  run->n_value = rad_grid_size(&c->scene, grid);
  run->area = rad_alloc(run->n_area, sizeof(double));
  run->value = rad_alloc(run->n_value, sizeof(double));
  if (!run->value || !run->area)
    return rad_fail_memory(e, "the comparison grid", 8.0 * (double)run->n_value);
  for (int t = 0; t < c->scene.n_triangle; t++)
    run->area[t] = c->scene.triangle[t].area;
  return rad_grid_evaluate(c, grid, star, run->value, e);
}

/* All but the solution and norms. */
static void take_numbers(const struct rad_case *c, double seconds, struct rad_task_run *run) {
  /* a bound on a mesh by hand is no part of the solution */
  run->seconds_total = seconds - (c->is_adaptive ? 0 : c->seconds_estimate);
  run->unknowns = c->mesh->n_point;
  run->elements = c->mesh->n_element;
  run->residual = c->report.residual;
  run->matrix_bytes = c->plan.system.matrix_bytes;
  run->kappa = c->report.kappa;
  run->inverse_w = c->report.inverse_norm;
  if (c->is_adaptive)
    run->error_bound =
        c->adaptive.bound * rad_indicator_scale(&c->adaptive.indicator, c->scene.n_band);
  run->seconds_assemble = c->seconds_assemble;
  run->seconds_factor = c->report.seconds_factor;
  run->seconds_solve = c->report.seconds_solve;
}

enum rad_code rad_study_take(const struct rad_case *c, enum rad_grid grid, double seconds,
                             int is_reference, struct rad_task_run *run, struct rad_error *e) {
  take_numbers(c, seconds, run);
  enum rad_code code = take_values(c, grid, is_reference, run, e);
  if (!code && c->deck.study.stability && !is_reference)
    code = take_norms(c, run, e);
  if (code)
    rad_task_run_free(run);
  return code;
}

/* What the log says of run i. */
static void say(const struct rad_study_plan *p, int i, const char *what) {
  fprintf(p->command->log, "study, %s %d: %s\n", i < p->n_row ? "run" : "reference",
          i < p->n_row ? i + 1 : i - p->n_row + 1, what);
}

/* What the user should know of a run that has a solution. */
static void warn(const struct rad_study_plan *p, int i, const struct rad_case *c) {
  struct rad_notes notes = {0};
  rad_case_warn(c, &notes);
  for (int n = 0; n < notes.n; n++)
    say(p, i, notes.text[n]);
  if (c->adaptive.reason[0])
    say(p, i, c->adaptive.reason);
  rad_notes_free(&notes);
}

/* Once more for the times, if it is not the first time. */
static enum rad_code run_row(const struct rad_study_plan *p, int i, int is_first,
                             struct rad_task_run *run, struct rad_error *e) {
  struct rad_study_set s;
  struct rad_case c = {0};
  double start = rad_seconds();
  enum rad_code code = rad_study_set(p, i, &s, e);
  if (!code)
    code = rad_case_prepare(p->deck.path, s.n, s.set, p->progress, &c, e);
  rad_progress_clear(p->progress);
  for (int n = 0; n < c.notes.n && i == 0 && is_first; n++)
    fprintf(p->command->log, "%s\n", c.notes.text[n]);
  c.wants_bound = c.is_adaptive;
  if (!code)
    code = rad_case_solve(&c, e);
  double seconds = rad_seconds() - start;
  if (!code && is_first)
    code = rad_study_take(&c, p->grid, seconds, i >= p->n_row, run, e);
  else if (!code)
    take_numbers(&c, seconds, run);
  if (!code && is_first)
    warn(p, i, &c);
  rad_case_free(&c);
  free(s.text);
  return code;
}

static int by_size(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* The middle of n times. */
static double median(int n, double *seconds) {
  qsort(seconds, (size_t)n, sizeof *seconds, by_size);
  return 0.5 * (seconds[(n - 1) / 2] + seconds[n / 2]);
}

/* Row i as often as asked for, a reference once: the times are medians, all else is the same every
 * time. */
static enum rad_code repeat_row(const struct rad_study_plan *p, int i, struct rad_task_run *run,
                                struct rad_error *e) {
  enum { N_TIME = 4, MOST = 99 };
  double seconds[N_TIME][MOST], *time[N_TIME] = {&run->seconds_assemble, &run->seconds_factor,
                                                 &run->seconds_solve, &run->seconds_total};
  int n = i < p->n_row ? p->deck.study.repeats : 1;
  enum rad_code code = RAD_OK;
  for (int r = 0; r < n && !code; r++) {
    code = run_row(p, i, r == 0, run, e);
    for (int t = 0; t < N_TIME; t++)
      seconds[t][r] = *time[t];
  }
  for (int t = 0; t < N_TIME && !code; t++)
    *time[t] = median(n, seconds[t]);
  return code;
}

/* Runs one after the other; row i's values are at set + i n_key. */
static enum rad_code run_all(const struct rad_study_plan *p, struct rad_study_table *t, char **set,
                             struct rad_error *e) {
  for (int i = 0; i < p->n_row + p->n_reference; i++) {
    struct rad_study_row *row = &t->row[i];
    row->run = RAD_TASK_RUN_UNKNOWN;
    row->run.n = rad_study_n(p, i);
    row->set = set + (size_t)i * (size_t)t->n_key;
    for (int k = 0; k < t->n_key && i < p->n_row; k++)
      row->set[k] = (char *)rad_study_value(p, i, k);
    rad_progress_run(p->progress, i + 1, p->n_row + p->n_reference);
    enum rad_code code = repeat_row(p, i, &row->run, e);
    rad_progress_clear(p->progress);
    if (code == RAD_ENUMERIC) /* one run that fails does not lose the others */
      say(p, i, e->text);
    else if (code)
      return code;
  }
  return RAD_OK;
}

enum rad_code rad_study_report(struct rad_study_table *t, const struct rad_command *command,
                               const char *file, struct rad_error *e) {
  const char *path = command->output ? command->output : file;
  enum rad_code code = rad_study_compare(t, e);
  if (code)
    return code;
  if (!command->quiet)
    rad_study_print(t, command->out);
  code = rad_study_write(t, path, command->line, e);
  if (!code && !command->quiet)
    fprintf(command->out, "written %s\n", path);
  return code;
}

/* All runs in this process. */
static enum rad_code whole(const struct rad_study_plan *p, struct rad_error *e) {
  size_t n_key = (size_t)p->deck.study.n_vary, n_run = (size_t)(p->n_row + p->n_reference);
  char **key = rad_calloc(n_key, sizeof *key), **set = rad_calloc(n_key * n_run, sizeof *set);
  char *file = rad_study_file(p, "_study", ".h5");
  struct rad_study_table t = {.path = p->deck.path,
                              .deck = &p->deck,
                              .n_key = (int)n_key,
                              .key = key,
                              .n_row = p->n_row,
                              .n_inner = p->n_inner,
                              .n_reference = p->n_reference,
                              .row = rad_calloc(n_run, sizeof *t.row),
                              .grid = p->grid,
                              .is_solution = p->grid == RAD_GRID_CLOSED ||
                                             p->deck.study.values == RAD_VALUES_SOLUTION,
                              .threads = omp_get_max_threads()};
  enum rad_code code = RAD_OK;
  if (!key || !set || !file || !t.row)
    code = rad_fail_memory(e, "the study", (double)(n_run * sizeof *t.row));
  for (size_t k = 0; k < n_key && !code; k++)
    key[k] = p->deck.study.vary[k].key;
  if (!code)
    code = rad_files_check(p->command, &p->deck, p->command->output ? p->command->output : file, e);
  if (!code)
    code = run_all(p, &t, set, e);
  if (!code)
    code = rad_study_report(&t, p->command, file, e);
  for (size_t i = 0; i < n_run && t.row; i++)
    rad_task_run_free(&t.row[i].run);
  free(t.row);
  free(file);
  free(set);
  free(key);
  return code;
}

enum rad_code rad_app_study(const struct rad_command *command, struct rad_error *e) {
  struct rad_study_plan p;
  if (command->collects)
    return rad_study_collect(command, e);
  enum rad_code code = rad_study_plan(command, &p, e);
  if (!code && command->lists)
    code = rad_study_list(&p, e);
  else if (!code)
    code = command->task ? rad_study_task(&p, e) : whole(&p, e);
  rad_study_plan_free(&p);
  return code;
}
