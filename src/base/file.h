/* Whole files in memory. */
#ifndef RAD_BASE_FILE_H
#define RAD_BASE_FILE_H

#include <stddef.h>

#include "base/error.h"

/**
 * Read a text file.
 *
 * Reading stops after a block that holds a zero byte: no text has one, and devices have no end.
 * A pipe is waited for, until a signal asks to stop. Messages: `PATH: error: cannot open WHAT:
 * ...`.
 *
 * @param[in]  what      "the deck", for messages
 * @param[in]  limit     largest size [bytes]
 * @param[in]  too_large what to do with a larger file
 * @param[out] text      owned, with a zero byte behind its n bytes; to be freed also after an error
 * @return RAD_OK, RAD_EINPUT for a file that is too large, RAD_ESYSTEM if it cannot be read,
 * RAD_ESTOPPED
 */
enum rad_code rad_file_read(const char *path, const char *what, size_t limit, const char *too_large,
                            char **text, size_t *n, struct rad_error *e);

#endif
