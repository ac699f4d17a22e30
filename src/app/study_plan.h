/* Which runs a study has, and what is set in each. */
#ifndef RAD_APP_STUDY_PLAN_H
#define RAD_APP_STUDY_PLAN_H

#include "app/command.h"
#include "app/grid.h"
#include "scene/deck.h"

struct rad_study_plan {
  const struct rad_command *command; /* borrowed */
  struct rad_deck deck;
  int n_row, n_inner; /* runs of the table; values of the last key, which varies fastest */
  int n_reference;    /* runs from n_row on: a named reference of each problem; 0: not named */
  enum rad_grid grid;
  struct rad_progress line, *progress; /* the line, or NULL: quiet; a plan must not move */
};

/* Read the deck of the command; RAD_EINPUT without a section `study`. To be freed, also after an
 * error. */
enum rad_code rad_study_plan(const struct rad_command *command, struct rad_study_plan *plan,
                             struct rad_error *e);
void rad_study_plan_free(struct rad_study_plan *plan); /* safe twice */

/* The deck's output file with `tail` after its stem and another ending, or its own for NULL; owned,
 * NULL without memory. */
char *rad_study_file(const struct rad_study_plan *plan, const char *tail, const char *ending);

/* True for keys that say what is solved, a problem, and not how. */
int rad_study_is_of_problem(const char *key);

/* Value of varied key k in run i < n_row. */
const char *rad_study_value(const struct rad_study_plan *plan, int i, int k);

/* Value of the last varied key in run i if it is method.elements, else NAN. */
double rad_study_n(const struct rad_study_plan *plan, int i);

/* Overrides of run i, after those of the command line. A reference has the values of its problem,
 * and its own keys. */
struct rad_study_set {
  int n;
  const char *set[RAD_MAX_SET]; /* borrowed, from the command line or text */
  char *text;                   /* owned */
};

enum rad_code rad_study_set(const struct rad_study_plan *plan, int i, struct rad_study_set *set,
                            struct rad_error *e);

#endif
