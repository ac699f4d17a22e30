/* Parts of a matrix as files: each of them assembled by itself, read where they are solved with. */
#ifndef RAD_OUTPUT_PART_FILE_H
#define RAD_OUTPUT_PART_FILE_H

#include "output/origin.h"
#include "system/part.h"

/* A matrix; one of these is not NULL. */
struct rad_part_matrix {
  struct rad_dense *dense;
  struct rad_h2 *h2;
};

/* Write what a part has assembled, saved like a checkpoint. */
enum rad_code rad_part_write(const char *path, const struct rad_origin *origin,
                             struct rad_part_number part, const struct rad_part_matrix *m,
                             struct rad_error *e);

/**
 * See that the files are all parts of one matrix of this origin, whole, each once.
 *
 * @param[in]  file  [n_file] in any order
 * @param[out] form  of the matrix
 * @return RAD_EINPUT, with names, for parts that are missing, given twice or foreign; RAD_ESYSTEM
 * for files that cannot be read or are damaged
 */
enum rad_code rad_parts_look(int n_file, const char *const *file, const struct rad_origin *origin,
                             enum rad_matrix *form, struct rad_error *e);

/* Read all of them into a matrix that was just begun. */
enum rad_code rad_parts_read(int n_file, const char *const *file, const struct rad_origin *origin,
                             const struct rad_part_matrix *m, struct rad_error *e);

#endif
