/* The operator in files: dense or hierarchical, whole, or as far as it is done. */
#ifndef RAD_OUTPUT_OPERATOR_FILE_H
#define RAD_OUTPUT_OPERATOR_FILE_H

#include "output/hdf.h"
#include "system/part.h"

/* Group `operator` in a large file: what is done of a matrix that rad_dense_begin or rad_h2_begin
 * began. It must stay as it is until the file is ended. */
void rad_operator_write_dense(struct rad_hdf *h, hid_t root, struct rad_dense *dense);
void rad_operator_write_h2(struct rad_hdf *h, hid_t root, struct rad_h2 *h2);

/* The form of the matrix in an open /polyrad; RAD_MATRIX_AUTO: none. */
enum rad_matrix rad_operator_form(hid_t root);

/* Read what is done into a matrix that was just begun on the same mesh; false: it does not fit, or
 * there is no memory. */
bool rad_operator_read_dense(hid_t root, struct rad_dense *dense);
bool rad_operator_read_h2(hid_t root, struct rad_h2 *h2);

/* The same for what one part has assembled (system/part.h); reading adds it to the other parts. */
void rad_operator_write_dense_part(struct rad_hdf *h, hid_t root, struct rad_dense *dense,
                                   struct rad_part_number part);
void rad_operator_write_h2_part(struct rad_hdf *h, hid_t root, struct rad_h2 *h2,
                                struct rad_part_number part);
bool rad_operator_read_dense_part(hid_t root, struct rad_dense *dense, struct rad_part_number part);
bool rad_operator_read_h2_part(hid_t root, struct rad_h2 *h2, struct rad_part_number part);

#endif
