/* Where files are, whatever they are called. */
#ifndef RAD_BASE_PLACE_H
#define RAD_BASE_PLACE_H

#include <stdbool.h>

/**
 * Whether two names mean one file: through links, hard and symbolic, and by any spelling.
 *
 * Files that exist are told by device and inode; names of files that do not, by their folder and
 * what follows it. Devices and folders are never one file: nothing in them can be written over.
 */
bool rad_is_same_file(const char *a, const char *b);

/* `file` beside `path`: in its folder, unless file starts at the root. Owned; NULL without memory.
 */
char *rad_path_beside(const char *path, const char *file);

#endif
