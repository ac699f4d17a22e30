/* A block of bytes becomes a file, whole or not at all. */
#ifndef RAD_OUTPUT_SAVE_H
#define RAD_OUTPUT_SAVE_H

#include <stddef.h>
#include <sys/types.h>

#include "base/error.h"

/**
 * Write bytes to path.
 *
 * They go to PATH.<pid>.tmp in the same folder, are synced, then renamed. After an error the .tmp
 * is removed and a file that had the name before is as it was. A device (/dev/null) is written
 * straight away, because renaming would replace it. An existing file without write
 * permission is refused. A symbolic link is replaced, its target is not touched; but for those in
 * /dev and /proc (/dev/stdout), which are written through.
 *
 * A file-size limit (ulimit -f) ends the process by SIGXFSZ unless the application ignores that
 * signal; it then becomes an error like any other.
 *
 * @return RAD_OK, or RAD_ESYSTEM with a sentence that names path, cause and remedy
 */
enum rad_code rad_save(const char *path, const void *bytes, size_t size, struct rad_error *e);

/* Fills an open, empty file; returns 0 or an errno. */
typedef int rad_save_filler(int fd, void *context);

/* The same for what a function writes. */
enum rad_code rad_save_by(const char *path, rad_save_filler *fill, void *context,
                          struct rad_error *e);

/* size bytes to fd, from its position on; returns 0 or an errno. */
int rad_write_all(int fd, const void *bytes, size_t size);

/* Bytes at .. end - 1 of one file to the same place of another; returns 0 or an errno. */
int rad_copy_part(int from, int to, off_t at, off_t end);

/* The name under which a file is written before it gets its own; owned, NULL without memory. */
char *rad_save_temporary(const char *path);

/* What there is at path if no file can be saved there, "a named pipe"; or NULL. Pipes that /dev and
 * /proc link to (/dev/stdout) have a reader. */
const char *rad_save_obstacle(const char *path);

/* The error that rad_save would give if it were called now, as far as an empty file can tell:
 * before hours of work are to be saved. */
enum rad_code rad_save_try(const char *path, struct rad_error *e);

#endif
