#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/stop.h"

enum { FIRST_READ = 1 << 16 };

/* Up to size bytes, fewer only at the end; *got of them. 0, an errno, or EINTR: stopped. A pipe
 * that nobody writes to would keep a program for ever that was asked to stop. */
static int read_block(int fd, char *to, size_t size, size_t *got) {
  for (*got = 0; *got < size;) {
    if (!rad_stop_await(fd))
      return EINTR;
    const ssize_t n = read(fd, to + *got, size - *got);
    if (n == 0)
      return 0;
    if (n > 0)
      *got += (size_t)n;
    else if (errno != EINTR && errno != EAGAIN)
      return errno;
  }
  return 0;
}

static enum rad_code read_stream(int fd, const char *path, const char *what, size_t limit,
                                 const char *too_large, char **text, size_t *n,
                                 struct rad_error *e) {
  for (size_t size = FIRST_READ;; size *= 2) {
    char *grown = realloc(*text, size + 1);
    if (!grown)
      return rad_fail_memory(e, what, (double)size);
    *text = grown;
    size_t got;
    const int cause = read_block(fd, *text + *n, size - *n, &got);
    int is_text = !memchr(*text + *n, 0, got);
    *n += got;
    (*text)[*n] = '\0';
    if (cause == EINTR)
      return rad_fail_stopped(e);
    if (cause)
      return rad_fail(e, RAD_ESYSTEM, "%.400s: error: cannot read %s: %s; give a text file", path,
                      what, strerror(cause));
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
  const int fd =
      open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* no wait for a pipe's writer here */
  if (fd < 0)
    return rad_fail(e, RAD_ESYSTEM,
                    "%.400s: error: cannot open %s: %s; check its name and permissions", path, what,
                    strerror(errno));
  enum rad_code code = read_stream(fd, path, what, limit, too_large, text, n, e);
  close(fd);
  return code;
}
