/* Checkpoints: what a run that was stopped has done so far. */
#ifndef RAD_OUTPUT_CHECKPOINT_H
#define RAD_OUTPUT_CHECKPOINT_H

#include "estimate/stage.h"
#include "output/origin.h"
#include "system/solve.h"

/* What a run holds. Of dense and h2 the one that was begun is not NULL; none: nothing is done. */
struct rad_checkpoint {
  struct rad_dense *dense;
  struct rad_h2 *h2;
  struct rad_iterate *iterate;
  const struct rad_stage *stage; /* of an adaptive run, or NULL; see rad_checkpoint_read_stage */
};

/* See that a checkpoint is whole and of this origin, and what form of matrix it holds;
 * RAD_MATRIX_AUTO: none yet. Returns like rad_origin_open. */
enum rad_code rad_checkpoint_look(const char *path, const struct rad_origin *origin,
                                  enum rad_matrix *form, struct rad_error *e);

/* Write one, uncompressed and without a copy in memory; saved like a result (see rad_save). */
enum rad_code rad_checkpoint_write(const char *path, const struct rad_origin *origin,
                                   const struct rad_checkpoint *c, struct rad_error *e);

/* Read one into a matrix that was just begun, and an empty iterate. Returns like rad_origin_open,
 * and RAD_ESYSTEM without memory. */
enum rad_code rad_checkpoint_read(const char *path, const struct rad_origin *origin,
                                  const struct rad_checkpoint *c, struct rad_error *e);

/* Where an adaptive run goes on: to be freed with rad_stage_free, also after an error; without
 * leaves if no level was done. Returns like rad_checkpoint_read. */
enum rad_code rad_checkpoint_read_stage(const char *path, const struct rad_origin *origin,
                                        struct rad_stage *stage, struct rad_error *e);

#endif
