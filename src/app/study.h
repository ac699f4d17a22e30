/* Parts of polyrad study, and what polyrad run does for it. */
#ifndef RAD_APP_STUDY_H
#define RAD_APP_STUDY_H

#include "app/case.h"
#include "app/study_plan.h"
#include "app/study_table.h"

/* A run that is the task of a study. */
struct rad_study_task {
  struct rad_task task;
  enum rad_grid grid;
  int is_written; /* its result is in a file */
};

/* What the table needs of a case that is solved; run's arrays are owned, n is left alone.
 *
 * @param[in] is_reference  compared with, and no row of the table: without norms of the inverse */
enum rad_code rad_study_take(const struct rad_case *c, enum rad_grid grid, double seconds,
                             int is_reference, struct rad_task_run *run, struct rad_error *e);

/* One run of the study, by polyrad run, into a file of its own: that of command->task. */
enum rad_code rad_study_task(const struct rad_study_plan *plan, struct rad_error *e);

/* The files of all tasks, one a line. */
enum rad_code rad_study_list(const struct rad_study_plan *plan, struct rad_error *e);

/* The table from the files of all tasks: command->file. */
enum rad_code rad_study_collect(const struct rad_command *command, struct rad_error *e);

/* Compare the runs, print the table, and write it to command->output, or to `file`. */
enum rad_code rad_study_report(struct rad_study_table *table, const struct rad_command *command,
                               const char *file, struct rad_error *e);

#endif
