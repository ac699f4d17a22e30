#include "base/file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST_READ = 1 << 16 };

static enum rad_code read_stream(FILE *f, const char *path, const char *what, size_t limit,
                                 const char *too_large, char **text, size_t *n,
                                 struct rad_error *e) {
  for (size_t size = FIRST_READ;; size *= 2) {
    char *grown = realloc(*text, size + 1);
    if (!grown)
      return rad_fail_memory(e, what, (double)size);
    *text = grown;
    errno = 0;
    size_t got = fread(*text + *n, 1, size - *n, f);
    int is_text = !memchr(*text + *n, 0, got);
    *n += got;
    (*text)[*n] = '\0';
    if (ferror(f))
      return rad_fail(e, RAD_ESYSTEM, "%.400s: error: cannot read %s: %s; give a text file", path,
                      what, strerror(errno));
    if (*n > limit)
      return rad_fail(e, RAD_EINPUT, "%.400s: error: %s is larger than %.3g GB; %s", path, what,
                      (double)limit / 1e9, too_large);
    if (*n < size || !is_text)
      return RAD_OK;
  }
}

enum rad_code rad_file_read(const char *path, const char *what, size_t limit, const char *too_large,
                            char **text, size_t *n, struct rad_error *e) {
  *text = NULL;
  *n = 0;
  FILE *f = fopen(path, "rb");
  if (!f)
    return rad_fail(e, RAD_ESYSTEM,
                    "%.400s: error: cannot open %s: %s; check its name and permissions", path, what,
                    strerror(errno));
  enum rad_code code = read_stream(f, path, what, limit, too_large, text, n, e);
  fclose(f);
  return code;
}
