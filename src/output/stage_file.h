/* Where an adaptive run goes on, in a checkpoint. */
#ifndef RAD_OUTPUT_STAGE_FILE_H
#define RAD_OUTPUT_STAGE_FILE_H

#include "estimate/stage.h"
#include "output/hdf.h"

/* What a file being written borrows. */
struct rad_stage_arrays {
  int32_t *leaf; /* owned */
  double *place; /* owned */
};

/* Group `stage` in a large file; the arrays are to be freed when the file is ended. */
void rad_stage_write(struct rad_hdf *h, hid_t root, const struct rad_stage *s,
                     struct rad_stage_arrays *arrays);
void rad_stage_arrays_free(struct rad_stage_arrays *arrays); /* safe twice */

/* Read it; false: not as it was written, or without memory. Whether the leaves fit the scene is
 * seen by rad_stage_restore. */
bool rad_stage_read(hid_t root, struct rad_stage *s);

#endif
