#include "base/streams.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

void rad_streams_begin(void) {
  for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++)
    if (fcntl(fd, F_GETFD) < 0 && errno == EBADF)
      (void)open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY); /* the lowest free one */
}

enum rad_code rad_streams_end(struct rad_error *e) {
  errno = 0;
  const int is_lost = ferror(stdout) != 0, is_left = fflush(stdout) != 0, cause = errno;
  if (!is_lost && !is_left)
    return RAD_OK;
  return rad_fail(e, RAD_ESYSTEM,
                  "error: what was printed could not be written to standard output%s%s; give it a "
                  "file or pipe that takes it",
                  is_left ? ": " : "", is_left ? strerror(cause) : "");
}
