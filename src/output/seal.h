/* A seal over a whole file: its length and a checksum, in a block before the HDF5 data, which HDF5
 * skips (its user block). A file that was cut or changed anywhere is refused before HDF5, which
 * trusts what it reads, gets to see it. */
#ifndef RAD_OUTPUT_SEAL_H
#define RAD_OUTPUT_SEAL_H

#include "base/error.h"

enum { RAD_SEAL = 512 }; /* bytes: the smallest user block of HDF5 */

/* Seal an open file, whose first RAD_SEAL bytes are free; kind: "checkpoint", "part". Returns 0 or
 * an errno. */
int rad_seal_write(int fd, const char *kind);

/* RAD_ESYSTEM, with a sentence, unless path has a seal of this kind and is as it was. */
enum rad_code rad_seal_check(const char *path, const char *kind, struct rad_error *e);

#endif
