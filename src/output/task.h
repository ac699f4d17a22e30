/* One run of a study, in a file of its own: what its row of the table is made of. */
#ifndef RAD_OUTPUT_TASK_H
#define RAD_OUTPUT_TASK_H

#include <math.h>
#include <stddef.h>

#include "output/hdf.h"
#include "scene/deck.h"

/* What a run adds to the table of its study. */
struct rad_task_run {
  double n; /* value of the last varied key if it is method.elements, else NAN */
  double unknowns, elements, residual, matrix_bytes;
  double error_bound, kappa, inverse_w;                            /* NAN: not known */
  double inverse_norm, inverse_matrix, condition, spectral_radius; /* NAN: not asked for */
  double seconds_assemble, seconds_factor, seconds_solve, seconds_total;
  size_t n_area, n_value;
  double *area; /* owned [n_area] of the triangles [m2] */
  double *
      value; /* owned [n_value] the solution where runs are compared [W/m2]; NULL: none was found */
};

/* A run of which nothing is known yet. */
#define RAD_TASK_RUN_UNKNOWN                                                                       \
  (struct rad_task_run) {                                                                          \
    .error_bound = NAN, .kappa = NAN, .inverse_w = NAN, .inverse_norm = NAN,                       \
    .inverse_matrix = NAN, .condition = NAN, .spectral_radius = NAN                                \
  }

struct rad_task {
  int number, n_task; /* from 1; of all runs: those of the table, then named references */
  int n_row;          /* of the table */
  int n_inner;        /* values of the last varied key */
  char *grid;         /* owned; name of the points where runs are compared */
  char *overrides;    /* owned; those of the command line, one a line */
  char *table;        /* owned; file of the table, where none is named */
  int n_key;
  char **key, **set; /* owned [n_key] varied keys and this run's values */
  struct rad_task_run run;
};

void rad_task_run_free(struct rad_task_run *run); /* its values; safe twice */
void rad_task_free(struct rad_task *task);        /* safe twice */

/* Numbers of a run, by their places in struct rad_task_run: columns of the table. */
struct rad_task_number {
  const char *name, *unit, *description;
  size_t offset;
};
enum { RAD_N_TASK_NUMBER = 15, RAD_N_NORM = 4 }; /* the last of them are norms of the inverse */
extern const struct rad_task_number rad_task_number[RAD_N_TASK_NUMBER];

/* /polyrad/task of a file being written; root: its /polyrad. */
void rad_task_put(struct rad_hdf *h, hid_t root, const struct rad_task *task);

/* A file of a run that has no result: where it comes from, and the task. Saved like a result. */
enum rad_code rad_task_write(const char *path, const struct rad_task *task,
                             const struct rad_deck *deck, const char *command, int threads,
                             struct rad_error *e);

/**
 * Read a task back.
 *
 * @param[out] task     to be freed with rad_task_free, also after an error
 * @param[out] deck     only what rad_stamp needs: title, bands, text; to be freed with
 * rad_deck_free
 * @param[out] threads  of its run
 * @return RAD_OK, or RAD_ESYSTEM: cannot be read, not HDF5, no task of a study, damaged
 */
enum rad_code rad_task_read(const char *path, struct rad_task *task, struct rad_deck *deck,
                            int *threads, struct rad_error *e);

#endif
