#include "target.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/text.h"

void fuzz_broken(const char *condition, const char *file, int line) {
  fprintf(stderr, "%s:%d: not true: %s\n", file, line, condition);
  abort();
}

static char path[64];
static int fd = -1;

static void remove_file(void) {
  unlink(path);
}

const char *fuzz_file(const void *bytes, size_t n) {
  if (fd < 0) {
    strcpy(path,
           access("/dev/shm", W_OK) ? "/tmp/polyrad_fuzz_XXXXXX" : "/dev/shm/polyrad_fuzz_XXXXXX");
    REQUIRE((fd = mkstemp(path)) >= 0);
    atexit(remove_file);
  }
  REQUIRE(ftruncate(fd, 0) == 0);
  REQUIRE(pwrite(fd, bytes, n, 0) == (ssize_t)n);
  return path;
}

void fuzz_check_error(enum rad_code code, const struct rad_error *e) {
  REQUIRE(code == RAD_OK || code == RAD_EINPUT || code == RAD_ESYSTEM);
  if (code == RAD_OK)
    return;
  size_t n = strlen(e->text);
  REQUIRE(e->code == code && n > 0);
  for (size_t i = 0; i < n;) {
    unsigned letter;
    int length = rad_utf8_decode(e->text + i, n - i, &letter);
    REQUIRE(length > 0 && letter >= 0x20 && letter != 0x7F);
    i += (size_t)length;
  }
}
