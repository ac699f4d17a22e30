/* A case to a checkpoint, and from one. */
#ifndef RAD_APP_CHECKPOINT_H
#define RAD_APP_CHECKPOINT_H

#include "app/case.h"
#include "app/command.h"
#include "system/part.h"

/* What a case holds after RAD_ESTOPPED, for a run that goes on from there. */
enum rad_code rad_case_save(struct rad_case *c, const char *path, const char *command,
                            double started, struct rad_error *e);

/**
 * Go on from a checkpoint: see that it is whole and of this deck, and take the matrix' form from
 * it where the deck leaves that open. After rad_case_prepare and before rad_case_solve.
 *
 * @param[in] path  kept by the case
 */
enum rad_code rad_case_restart(struct rad_case *c, const char *path, struct rad_error *e);

/**
 * Take the matrix from parts that were assembled before: see that all are there, whole and of this
 * deck. After rad_case_prepare and before rad_case_solve.
 *
 * @param[in] file  [n_file] kept by the case
 */
enum rad_code rad_case_join(struct rad_case *c, int n_file, const char *const *file,
                            struct rad_error *e);

/* The mesh of an adaptive run is not known before it is solved: RAD_EINPUT. */
enum rad_code rad_refuse_parts(const struct rad_case *c, struct rad_error *e);

/* Assemble one part of the matrix and write it; instead of rad_case_solve. */
enum rad_code rad_case_write_part(struct rad_case *c, struct rad_part_number part, const char *path,
                                  const char *command, double started, struct rad_error *e);

/* Part of rad_case_solve: what c->restart has of the matrix, just begun, and of the iterate; or
 * what c->part has of the matrix. */
enum rad_code rad_case_restore(struct rad_case *c, struct rad_error *e);

/* Where an adaptive run with c->restart goes on; to be freed with rad_stage_free, also after an
 * error. Without leaves: from the beginning. */
enum rad_code rad_case_stage(struct rad_case *c, struct rad_stage *stage, struct rad_error *e);

/* The checkpoint that a command goes on from, or NULL. One that is not there yet, but would be
 * written, is none: it is the first time that this command runs. */
const char *rad_restart_find(const struct rad_command *command);

/**
 * Write the checkpoint of a command, but never less than what the run went on from: stopped before
 * it had that again, the old file stays, or is copied.
 *
 * @param[out] is_old  1: it is the old one
 */
enum rad_code rad_case_keep(struct rad_case *c, const struct rad_command *command, double started,
                            int *is_old, struct rad_error *e);

/* After RAD_ESTOPPED: keep what was done, if a checkpoint is asked for.
 *
 * @return RAD_ECHECKPOINT when it is written, RAD_ESTOPPED if none is asked for
 */
enum rad_code rad_case_stopped(struct rad_case *c, const struct rad_command *command,
                               double started, struct rad_error *e);

#endif
