/* polyrad study --collect: the table of a study whose runs are in files of their own. */
#include <stdlib.h>
#include <string.h>

#include "app/files.h"
#include "app/study.h"
#include "base/memory.h"

/* What was read so far; tasks in the order of the study. */
struct collection {
  const struct rad_command *command;
  int n;                 /* tasks of the study */
  struct rad_task *task; /* owned [n]; number is 0: not read yet */
  const char **file;     /* owned [n]; where each was */
  const char *first;     /* file of the first that was read: the others are compared with it */
  struct rad_task *like; /* its task, in task */
  struct rad_deck deck;  /* its deck */
  int threads;
};

/* How a task differs from the first one read, or NULL. */
static const char *difference(const struct collection *c, const struct rad_task *t,
                              const struct rad_deck *deck) {
  const struct rad_task *like = c->like;
  if (strcmp(deck->text, c->deck.text) != 0)
    return "its deck is another";
  if (strcmp(t->overrides, like->overrides) != 0)
    return "its --set options are others";
  int same = t->n_task == like->n_task && t->n_row == like->n_row && t->n_inner == like->n_inner &&
             t->n_key == like->n_key && !strcmp(t->grid, like->grid);
  for (int k = 0; k < t->n_key && same; k++)
    same = !strcmp(t->key[k], like->key[k]);
  return same ? NULL : "its runs are others";
}

static enum rad_code begin(struct collection *c, const char *file, const struct rad_task *t,
                           struct rad_error *e) {
  c->n = t->n_task;
  c->task = rad_calloc((size_t)c->n, sizeof *c->task);
  c->file = rad_calloc((size_t)c->n, sizeof *c->file);
  if (!c->task || !c->file)
    return rad_fail_memory(e, "the study", (double)c->n * sizeof *c->task);
  c->first = file;
  c->like = &c->task[t->number - 1];
  return RAD_OK;
}

static enum rad_code add(struct collection *c, const char *file, struct rad_error *e) {
  struct rad_task t;
  struct rad_deck deck;
  int threads;
  enum rad_code code = rad_task_read(file, &t, &deck, &threads, e);
  int is_first = !code && !c->task;
  if (is_first)
    code = begin(c, file, &t, e);
  if (is_first && !code) {
    c->deck = deck;
    c->threads = threads;
    deck = (struct rad_deck){0};
  }
  const char *differs = code || is_first ? NULL : difference(c, &t, &deck);
  if (differs)
    code = rad_fail(e, RAD_EINPUT,
                    "%.400s belongs to another study than %.400s: %s; collect the tasks of one",
                    file, c->first, differs);
  else if (!code && c->task[t.number - 1].number)
    code =
        rad_fail(e, RAD_EINPUT, "%.400s and %.400s are both task %d of %d; leave one of them out",
                 c->file[t.number - 1], file, t.number, t.n_task);
  if (!code) {
    c->task[t.number - 1] = t;
    c->file[t.number - 1] = file;
    t = (struct rad_task){0};
  }
  rad_task_free(&t);
  rad_deck_free(&deck);
  return code;
}

static enum rad_code refuse_missing(const struct collection *c, struct rad_error *e) {
  int n_missing = 0, first = 0;
  for (int i = c->n - 1; i >= 0; i--)
    if (!c->task[i].number) {
      n_missing++;
      first = i + 1;
    }
  if (!n_missing)
    return RAD_OK;
  char more[48] = "";
  if (n_missing > 1)
    snprintf(more, sizeof more, " and %d more", n_missing - 1);
  return rad_fail(
      e, RAD_EINPUT,
      "the study %.300s belongs to has %d tasks, but there is no file of task %d%s; run "
      "polyrad study DECK --task %d/%d",
      c->first, c->n, first, more, first, c->n);
}

static enum rad_code tabulate(const struct collection *c, struct rad_error *e) {
  int n_row = c->like->n_row, is_closed = !strcmp(c->like->grid, rad_grid_name[RAD_GRID_CLOSED]);
  struct rad_study_table t = {
      .path = c->first,
      .deck = &c->deck,
      .n_key = c->like->n_key,
      .key = c->like->key,
      .n_row = n_row,
      .n_inner = c->like->n_inner,
      .n_reference = c->n - n_row,
      .row = rad_calloc((size_t)c->n, sizeof *t.row),
      .grid = is_closed ? RAD_GRID_CLOSED : RAD_GRID_CROWDED,
      .is_solution = is_closed || strstr(c->like->grid, rad_values_name[RAD_VALUES_SOLUTION]),
      .threads = c->threads};
  if (!t.row)
    return rad_fail_memory(e, "the study", (double)c->n * sizeof *t.row);
  for (int i = 0; i < c->n; i++) {
    t.row[i].set = c->task[i].set;
    t.row[i].run = c->task[i].run; /* its values stay the task's */
    if (!t.row[i].run.value)
      fprintf(c->command->log, "%s: task %d has no solution\n", c->file[i], i + 1);
  }
  enum rad_code code = rad_study_report(&t, c->command, c->like->table, e);
  free(t.row);
  return code;
}

enum rad_code rad_study_collect(const struct rad_command *command, struct rad_error *e) {
  struct collection c = {.command = command};
  enum rad_code code =
      command->output ? rad_files_check(command, NULL, command->output, e) : RAD_OK;
  for (int k = 0; k < command->n_file && !code; k++)
    code = add(&c, command->file[k], e);
  if (!code)
    code = refuse_missing(&c, e);
  if (!code && !command->output)
    code = rad_files_check(command, NULL, c.like->table, e);
  if (!code)
    code = tabulate(&c, e);
  for (int i = 0; i < c.n && c.task; i++)
    rad_task_free(&c.task[i]);
  free(c.task);
  free(c.file);
  rad_deck_free(&c.deck);
  return code;
}
