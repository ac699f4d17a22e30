/* Checksums of what a file holds, object by object. They do not depend on how HDF5 lays it out: a
 * file that a script opened, repacked or added to stays good, and one that lost a bit does not.
 *
 * /polyrad/checksums [objects] has one line an object, in the order in which they were written:
 *
 *   0123456789abcdef dataset /polyrad/triangles/rho              with its unit and description
 *   0123456789abcdef attribute kappa of /polyrad/diagnostics     attributes of groups
 *
 * and the attribute `checksum` of /polyrad is the sum over these lines. */
#ifndef RAD_OUTPUT_CONTENTS_H
#define RAD_OUTPUT_CONTENTS_H

#include "output/hdf.h"

/* Remember a dataset just written; data NULL: nothing was, and it holds its fill value. */
void rad_contents_dataset(struct rad_hdf *h, hid_t parent, const struct rad_hdf_array *a,
                          hid_t memory);

/* Remember an attribute just written: n values, or a scalar when n is 0. Those of datasets are
 * counted with them. */
void rad_contents_attribute(struct rad_hdf *h, hid_t object, const char *name, hid_t memory,
                            size_t n, const void *data);

/* Write list and sum into /polyrad of a file that is else complete, and free the list. */
void rad_contents_write(struct rad_hdf *h);

/**
 * Read all that is on the list and compare. Files of versions without a list are taken as they are.
 *
 * @return RAD_ESYSTEM with a sentence that calls the file damaged and names the first object
 */
enum rad_code rad_contents_check(const char *path, hid_t root, struct rad_error *e);

#endif
