/* What the command line asks for; the verbs of the program. */
#ifndef RAD_APP_COMMAND_H
#define RAD_APP_COMMAND_H

#include <stdio.h>

#include "base/error.h"

enum { RAD_MAX_SET = 256 };

struct rad_command {
  const char *verb, *deck, *output; /* output: NULL if not given */
  int n_set;
  const char *set[RAD_MAX_SET];
  int threads; /* 0: OMP_NUM_THREADS decides */
  int quiet;
  const char *checkpoint, *restart; /* run: where to write one, where to go on from; or NULL */
  int n_file;
  const char **file;             /* owned [n_file] as named; deck is the first */
  int collects;                  /* study --collect: the files are those of tasks */
  int task, n_task;              /* study --task I/N; 0: all runs in one */
  int lists;                     /* study --tasks: only name their files */
  int part, n_part;              /* assemble --part I/N */
  int joins;                     /* solve --parts: the files after the deck are parts */
  struct rad_study_task *within; /* run: the task of a study that it is, or NULL */
  const char *line;              /* the command as typed, for provenance */
  FILE *out, *log;               /* summary; messages */
};

/* Each verb prints its summary to out, its warnings to log, and leaves its error in e. */
enum rad_code rad_app_run(const struct rad_command *command, struct rad_error *e);
enum rad_code rad_app_assemble(const struct rad_command *command, struct rad_error *e);
enum rad_code rad_app_solve(const struct rad_command *command, struct rad_error *e);
enum rad_code rad_app_check(const struct rad_command *command, struct rad_error *e);
enum rad_code rad_app_study(const struct rad_command *command, struct rad_error *e);
enum rad_code rad_app_info(const struct rad_command *command, struct rad_error *e);

#endif
