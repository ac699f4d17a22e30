/* The result of a run, as it is written to a file: plain arrays, however they were made. */
#ifndef RAD_OUTPUT_RESULT_H
#define RAD_OUTPUT_RESULT_H

#include <stdint.h>

#include "base/error.h"
#include "estimate/balance.h"
#include "factors/view_factors.h"
#include "output/task.h"
#include "scene/scene.h"

/* Cells for pictures: quadrilaterals and triangles with their own points (fields may jump);
 * cells that share a point are of one triangle. With n_cell = 0 every pointer may be NULL. */
struct rad_picture {
  int64_t n_point, n_cell;
  double *point;         /* owned [n_point, 3] [m] */
  int64_t *connectivity; /* owned [offset[n_cell]] */
  int64_t *offset;       /* owned [n_cell + 1] */
  unsigned char *type;   /* owned [n_cell] VTK cell types: 5, 9, or 70 Lagrange quadrilateral */
  int *triangle;         /* owned [n_cell] scene triangle */
  double *radiosity;     /* owned [n_point, n_band] [W/m2]; NULL: left out */
  double *irradiance;    /* owned [n_point, n_band] [W/m2]; NULL: left out */
  double *indicator;     /* owned [n_cell] |rho K (u* - u_h)| near the cell [W/m2], or NULL */
  double *bound;         /* owned [n_cell] bound z of |u - u*| there [W/m2], or NULL */
};

struct rad_diagnostics {
  int64_t unknowns, elements;
  double kappa;           /* max over collocation points of rho * K1 */
  double error_indicator; /* max |u* - u_h| at check points [W/m2]; NAN when not computed */
  double error_bound; /* bound of max |u - u*| from 1e-7 of edges on [W/m2]; NAN: not computed */
  double compression_error;  /* of a row's sum in a hierarchical matrix, estimate; 0: dense */
  double error_bound_limit;  /* the same right up to edges and vertices [W/m2] */
  double residual;           /* max norm of E - u + K u at the collocation points [W/m2] */
  int iterations;            /* of the solver; 0 for LU */
  double condition_estimate; /* in the max norm, from dgecon; NAN without LU */
  int converged;
  double means_error;  /* largest error of a mean over the largest radiosity; NAN: not known */
  int means_converged; /* 1: it is within the tolerance; 0 also if it is not known */
  double matrix_bytes, peak_memory_bytes;
  int64_t kernel_values, pairs_near, pairs_far, pairs_skipped;
  double seconds_scene, seconds_mesh, seconds_assemble, seconds_factor, seconds_solve,
      seconds_estimate, seconds_levels, seconds_output, seconds_total;
};

/* Arrays [.., n_band] are row-major, n_band that of the scene. One that is NULL though it has rows
 * was not computed: doubles then read as NaN. Probes and their names are those of the deck. */
struct rad_result {
  const struct rad_deck *deck;   /* borrowed */
  const struct rad_scene *scene; /* borrowed */
  const char *command;           /* borrowed; the command line */
  const char *matrix, *solver;   /* what was used: "dense"; "lu", "gmres", "neumann" */
  int threads;
  struct rad_picture picture;
  const struct rad_means *means;     /* borrowed: of the triangles; NULL: not computed */
  const struct rad_balance *balance; /* borrowed, or NULL */
  const double *edge_exponent, *vertex_exponent; /* borrowed [n_triangle, 3], or NULL */
  int64_t n_point;                               /* collocation points */
  double *point;                                 /* owned [n_point, 3] [m] */
  int *point_triangle;                           /* owned [n_point] */
  double *value;                                 /* owned [n_point, n_band] u_h [W/m2] */
  double *probe_position;                        /* owned [n_probe, 3] */
  double *probe_normal;                          /* owned [n_probe, 3] */
  double *probe_radiosity;                       /* owned [n_probe, n_band] */
  double *probe_irradiance;                      /* owned [n_probe, n_band] */
  double *probe_error_irradiance;                /* owned [n_probe, n_band]; NaN: not known */
  double *probe_flux;                            /* owned [n_probe] u* - h; thermal scenes only */
  double *probe_temperature;                     /* owned [n_probe] [K]; the same */
  struct rad_view_factors view_factors;          /* owned; matrix is NULL: not asked for */
  struct rad_diagnostics diagnostics;
  const struct rad_task *task; /* borrowed; of a study this is a run of, or NULL */
};

void rad_result_free(struct rad_result *result); /* frees what it owns; safe twice */

/**
 * Write the result as HDF5 that is VTKHDF as well (layout: docs/format.md).
 *
 * The file is built in memory, written to PATH.<pid>.tmp, synced, then renamed: PATH never holds
 * half a file, and after an error what it held before (see rad_save). Equal results give equal
 * bytes, apart from `started` in /polyrad and seconds_* in /polyrad/diagnostics and
 * /polyrad/view_factors. A link PATH is replaced.
 *
 * The application must ignore SIGXFSZ, else a file-size limit kills it instead of giving an error.
 *
 * @param[in,out] result  seconds_output and seconds_total are set just before they are written; the
 *                        time of the disk itself comes after that and is in neither
 * @param[in]     started  when the run began [s since 1970-01-01 UTC, CLOCK_REALTIME; not
 *                         rad_seconds()]; seconds_total counts from there
 * @return RAD_OK or RAD_ESYSTEM: no such folder, no permission, disk full, out of memory
 * Cost: memory for the compressed file and 2 n_band + 1 numbers a picture point.
 */
enum rad_code rad_result_write(const char *path, struct rad_result *result, double started,
                               struct rad_error *e);

/* A study's table: one row a run, columns of numbers or texts with names that differ. */
struct rad_column {
  const char *name, *unit, *description; /* borrowed */
  const double *number;                  /* borrowed [n_row], or NULL */
  const char *const *text;               /* borrowed [n_row], when number is NULL */
};

struct rad_table {
  int n_row, n_column;
  const struct rad_column *column;
};

/**
 * Write a study's table to a file of its own: /polyrad with its provenance, and one dataset a
 * column in /polyrad/study, which is /study as well. Saved like a result. A study is many runs:
 * `started` is the moment of writing here. Columns keep their order (HDF5 link creation order).
 *
 * @return RAD_OK or RAD_ESYSTEM
 */
enum rad_code rad_table_write(const char *path, const struct rad_table *table,
                              const struct rad_deck *deck, const char *command, int threads,
                              struct rad_error *e);

/**
 * Text of `polyrad info FILE`: origin, surfaces, probes, solution, times or a study's table,
 * datasets.
 *
 * @param[out] text  owned, lines ending in newlines, to be printed as it is; NULL after an error
 * @return RAD_OK, or RAD_ESYSTEM: cannot be read, not HDF5, not from polyrad, damaged
 */
enum rad_code rad_result_describe(const char *path, char **text, struct rad_error *e);

#endif
