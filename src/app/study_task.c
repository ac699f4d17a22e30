/* polyrad study --task: one run of a study, so that many machines may share them. */
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "app/study.h"
#include "base/memory.h"
#include "base/text.h"

/* Where runs are compared, and by what; owned, or NULL. */
static char *grid_name(const struct rad_study_plan *p) {
  char name[64];
  snprintf(name, sizeof name, "%s%s", rad_grid_name[p->grid],
           rad_values_name[p->deck.study.values]);
  return strdup(name);
}

static enum rad_code refuse_number(const struct rad_study_plan *p, struct rad_error *e) {
  const struct rad_command *c = p->command;
  int n = p->n_row + p->n_reference;
  if (c->n_task == n)
    return RAD_OK;
  return rad_fail(e, RAD_EINPUT,
                  "%s: error: the study has %d run%s%s, but --task %d/%d says %d; give 1/%d to "
                  "%d/%d",
                  p->deck.path, n, n > 1 ? "s" : "",
                  p->n_reference > 1 ? " with its references"
                  : p->n_reference   ? " with its reference"
                                     : "",
                  c->task, c->n_task, c->n_task, n, n, n);
}

/* All but what is solved for. */
static enum rad_code describe(const struct rad_study_plan *p, struct rad_task *t,
                              struct rad_error *e) {
  const struct rad_deck_study *d = &p->deck.study;
  int i = p->command->task - 1, failed;
  *t = (struct rad_task){.number = i + 1,
                         .n_task = p->n_row + p->n_reference,
                         .n_row = p->n_row,
                         .n_inner = p->n_inner,
                         .grid = grid_name(p),
                         .overrides = rad_join_lines(p->command->n_set, p->command->set),
                         .table = rad_study_file(p, "_study", ".h5"),
                         .n_key = d->n_vary,
                         .key = rad_calloc((size_t)d->n_vary, sizeof *t->key),
                         .set = rad_calloc((size_t)d->n_vary, sizeof *t->set),
                         .run = RAD_TASK_RUN_UNKNOWN};
  t->run.n = rad_study_n(p, i);
  failed = !t->grid || !t->overrides || !t->table || !t->key || !t->set;
  for (int k = 0; k < d->n_vary && !failed; k++) {
    t->key[k] = strdup(d->vary[k].key);
    t->set[k] = strdup(i < p->n_row ? rad_study_value(p, i, k) : "reference");
    failed = !t->key[k] || !t->set[k];
  }
  return failed ? rad_fail_memory(e, "the study", 1000) : RAD_OK;
}

/* NAME_task_02_of_12.ENDING: the names of all tasks in order. */
static char *name_file(const struct rad_study_plan *p, int task) {
  char tail[64];
  int n = p->n_row + p->n_reference, width = snprintf(NULL, 0, "%d", n);
  snprintf(tail, sizeof tail, "_task_%0*d_of_%d", width, task, n);
  return rad_study_file(p, tail, NULL);
}

enum rad_code rad_study_list(const struct rad_study_plan *p, struct rad_error *e) {
  for (int task = 1; task <= p->n_row + p->n_reference; task++) {
    char *file = name_file(p, task);
    if (!file)
      return rad_fail_memory(e, "the study", 1000);
    fprintf(p->command->out, "%s\n", file);
    free(file);
  }
  return RAD_OK;
}

enum rad_code rad_study_task(const struct rad_study_plan *p, struct rad_error *e) {
  struct rad_study_task within = {.grid = p->grid};
  struct rad_study_set s = {0};
  struct rad_command c = *p->command;
  char *file = name_file(p, c.task);
  enum rad_code code = refuse_number(p, e);
  if (!code)
    code = file ? describe(p, &within.task, e) : rad_fail_memory(e, "the study", 1000);
  if (!code)
    code = rad_study_set(p, c.task - 1, &s, e);
  if (!code) {
    c.n_set = s.n;
    memcpy(c.set, s.set, sizeof c.set);
    c.output = c.output ? c.output : file;
    c.within = &within;
    code = rad_app_run(&c, e);
  }
  if (code == RAD_ENUMERIC && !within.is_written) {
    struct rad_error second; /* the first error is the one to report */
    rad_task_write(c.output, &within.task, &p->deck, c.line, omp_get_max_threads(), &second);
  }
  rad_task_free(&within.task);
  free(s.text);
  free(file);
  return code;
}
