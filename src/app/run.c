/* polyrad run: one deck, solved and written; and polyrad info. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/case.h"
#include "app/checkpoint.h"
#include "app/command.h"
#include "app/files.h"
#include "app/study.h"
#include "app/summary.h"
#include "output/stamp.h"

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
  if (!code)
    code = rad_print_solution(c, &result, command->quiet ? NULL : command->out, command->log, e);
  if (!code && !command->quiet) {
    rad_print_time(&result, command->out);
    fprintf(command->out, "  written  %s%s\n", path, c->report.converged ? "" : " (NOT CONVERGED)");
  }
  rad_result_free(&result);
  return code;
}

/* The tolerance was not reached: the result is written, and says so as well. */
static enum rad_code refuse_unreached(const struct rad_case *c, struct rad_error *e) {
  const struct rad_scene *s = &c->scene;
  if (c->adaptive.reason[0] && c->adaptive.bound > c->tolerance)
    return rad_fail(e, RAD_ENUMERIC,
                    "%s: error: the tolerance %.3g was not reached, the bound is %.2e: %s",
                    c->deck.path, c->tolerance, c->adaptive.bound, c->adaptive.reason);
  if (c->is_adaptive && c->means.worst > c->tolerance) /* a mesh by hand is as it is: marked only */
    return rad_fail(e, RAD_ENUMERIC,
                    "%s: error: the tolerance %.3g was not reached by the mean over triangle %d "
                    "(%s), whose error is at most %.2e of the largest radiosity; %s",
                    c->deck.path, c->tolerance, c->means.worst_triangle + 1,
                    s->surface_name[s->triangle[c->means.worst_triangle].surface], c->means.worst,
                    c->adaptive.reason);
  return RAD_OK;
}

enum rad_code rad_app_run(const struct rad_command *command, struct rad_error *e) {
  struct rad_case c;
  struct rad_progress line, *progress = command->quiet ? NULL : &line;
  double started = rad_stamp_now();
  const char *restart = rad_restart_find(command);
  rad_progress_init(&line, command->log);
  enum rad_code code = rad_case_read(command->deck, command->n_set, command->set, progress, &c, e);
  if (!code || (code == RAD_ESTOPPED && rad_case_is_read(&c))) {
    enum rad_code wrong = rad_files_check(command, &c.deck, output_path(&c, command), e);
    code = wrong ? wrong : code;
  }
  if (!code)
    code = rad_case_build(progress, &c, e);
  rad_progress_clear(progress);
  rad_print_notes(&c, command->log);
  if (!code && restart)
    code = rad_case_restart(&c, restart, e);
  else if (!code && command->joins)
    code = rad_case_join(&c, command->n_file - 1, command->file + 1, e);
  if (!code) {
    if (!command->quiet)
      rad_print_head(&c, command->out);
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
    if (!code)
      code = refuse_unreached(&c, e);
  } else if (code == RAD_ENUMERIC && c.report.iterations > 0 && isfinite(c.report.residual)) {
    struct rad_error second; /* the first error is the one to report */
    output(&c, command, started, &second);
  }
  if (code == RAD_ESTOPPED)
    code = rad_case_stopped(&c, command, started, e);
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
