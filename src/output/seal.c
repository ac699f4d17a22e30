#include "output/seal.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/checksum.h"

enum { STEP = 1 << 20 };

/* Checksum of all behind the seal, and the length of the whole; returns 0 or an errno. */
static int measure(int fd, uint64_t *sum, int64_t *size) {
  char *bytes = malloc(STEP);
  int cause = bytes ? 0 : ENOMEM;
  *sum = 0;
  *size = RAD_SEAL;
  while (!cause) {
    size_t got = 0;
    while (got < STEP && !cause) { /* whole steps, however the system divides them */
      ssize_t n = pread(fd, bytes + got, STEP - got, *size + (int64_t)got);
      if (n < 0 && errno != EINTR)
        cause = errno;
      if (n == 0)
        break;
      got += n > 0 ? (size_t)n : 0;
    }
    if (got == 0)
      break;
    *sum = rad_checksum(*sum, bytes, got);
    *size += (int64_t)got;
  }
  free(bytes);
  return cause;
}

static void write_text(const char *kind, int64_t size, uint64_t sum, char text[RAD_SEAL]) {
  memset(text, 0, RAD_SEAL);
  snprintf(text, RAD_SEAL, "polyrad %s\nbytes %" PRId64 "\nchecksum %016" PRIx64 "\n", kind, size,
           sum);
}

int rad_seal_write(int fd, const char *kind) {
  char text[RAD_SEAL];
  uint64_t sum;
  int64_t size;
  int cause = measure(fd, &sum, &size);
  write_text(kind, size, sum, text);
  for (ssize_t done = 0, n = 0; !cause && done < RAD_SEAL; done += n > 0 ? n : 0)
    if ((n = pwrite(fd, text + done, (size_t)(RAD_SEAL - done), done)) < 0 && errno != EINTR)
      cause = errno;
  return cause;
}

static enum rad_code look(int fd, const char *path, const char *kind, struct rad_error *e) {
  char found[RAD_SEAL] = "", right[RAD_SEAL], start[32];
  uint64_t sum;
  int64_t size;
  const ssize_t n = pread(fd, found, RAD_SEAL, 0);
  const int length = snprintf(start, sizeof start, "polyrad %s\n", kind);
  if (n > 0 && strncmp(found, start, (size_t)length) != 0)
    return rad_fail(e, RAD_ESYSTEM, "%.400s is not a polyrad %s%s; name a file that polyrad %s",
                    path, kind, memcmp(found, "\211HDF", 4) == 0 ? " (a result?)" : "",
                    strcmp(kind, "part") == 0 ? "assemble wrote"
                                              : "run --checkpoint wrote when it was stopped");
  const int cause = n < 0 ? errno : measure(fd, &sum, &size);
  if (cause)
    return rad_fail(e, RAD_ESYSTEM, "cannot read %.400s: %s; name a file", path, strerror(cause));
  write_text(kind, size, sum, right);
  if (memcmp(found, right, RAD_SEAL) == 0)
    return RAD_OK;
  return rad_fail(e, RAD_ESYSTEM,
                  "%.400s is damaged: cut, or changed since it was written; make it again, or "
                  "begin without it",
                  path);
}

enum rad_code rad_seal_check(const char *path, const char *kind, struct rad_error *e) {
  const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* no wait for a pipe's writer */
  if (fd < 0)
    return rad_fail(e, RAD_ESYSTEM, "cannot read %.400s: %s; check the name and its permissions",
                    path, strerror(errno));
  const enum rad_code code = look(fd, path, kind, e);
  close(fd);
  return code;
}
