/* The table of a study: runs, their errors against a reference, estimated orders. */
#ifndef RAD_APP_STUDY_TABLE_H
#define RAD_APP_STUDY_TABLE_H

#include <stdio.h>

#include "app/grid.h"
#include "output/task.h"

struct rad_study_row {
  char **set; /* borrowed [n_key] values of the varied keys */
  struct rad_task_run run;
  double error, ratio, eoc;
};

struct rad_study_table {
  const char *path;            /* of the deck or the file it came from, for messages */
  const struct rad_deck *deck; /* for provenance: title, bands, text */
  int n_key;
  char *const *key;          /* borrowed [n_key] varied keys, the first slowest */
  int n_row, n_inner;        /* runs; values of the last key */
  int is_named;              /* the reference is row n_row, not the last run */
  struct rad_study_row *row; /* [n_row + is_named] */
  enum rad_grid grid;
  int threads;
};

/* Errors, ratios and orders from the runs. RAD_EINPUT if they cannot be compared, RAD_ENUMERIC if
 * the reference has no solution; other rows without one get NAN. */
enum rad_code rad_study_compare(struct rad_study_table *t, struct rad_error *e);

void rad_study_print(const struct rad_study_table *t, FILE *out);

/* Saved like a result, see rad_table_write. */
enum rad_code rad_study_write(const struct rad_study_table *t, const char *path,
                              const char *command, struct rad_error *e);

#endif
