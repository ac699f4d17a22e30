/* The table of a study: runs, their errors against a reference, estimated orders. */
#ifndef RAD_APP_STUDY_TABLE_H
#define RAD_APP_STUDY_TABLE_H

#include <stdio.h>

#include "app/grid.h"
#include "output/task.h"

struct rad_study_row {
  char **set; /* borrowed [n_key] values of the varied keys */
  struct rad_task_run run;
  struct rad_difference error; /* from the reference */
  double ratio, eoc;
};

struct rad_study_table {
  const char *path;            /* of the deck or the file it came from, for messages */
  const struct rad_deck *deck; /* for provenance: title, bands, text */
  int n_key;
  char *const *key;          /* borrowed [n_key] varied keys, the first slowest */
  int n_row, n_inner;        /* runs; values of the last key */
  int n_reference;           /* named ones, from row n_row on; 0: the last run of a problem */
  struct rad_study_row *row; /* [n_row + n_reference] */
  int n_problem;             /* set by rad_study_compare */
  enum rad_grid grid;
  int is_solution; /* u_h is compared, not the reported u */
  int threads;
};

/* Errors, ratios and orders from the runs. Only runs of one problem are compared, that is, those
 * that agree in all keys but method and accuracy. RAD_EINPUT if they cannot be, RAD_ENUMERIC if no
 * reference has a solution; rows without one, or without a reference, get NAN. */
enum rad_code rad_study_compare(struct rad_study_table *t, struct rad_error *e);

void rad_study_print(const struct rad_study_table *t, FILE *out);

/* Saved like a result, see rad_table_write. */
enum rad_code rad_study_write(const struct rad_study_table *t, const char *path,
                              const char *command, struct rad_error *e);

#endif
