/* Without libFuzzer: every file of the folders given, and every beginning of it. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "target.h"

static char *read_whole(const char *path, size_t *n) {
  FILE *f = fopen(path, "rb");
  char *bytes = NULL;
  REQUIRE(f && fseek(f, 0, SEEK_END) == 0);
  *n = (size_t)ftell(f);
  rewind(f);
  REQUIRE((bytes = malloc(*n + 1)) && fread(bytes, 1, *n, f) == *n);
  fclose(f);
  return bytes;
}

/* The bytes in a block of their own size, so that a read beyond them is seen. */
static void run(const char *bytes, size_t n) {
  uint8_t *own = malloc(n ? n : 1);
  REQUIRE(own);
  memcpy(own, bytes, n);
  LLVMFuzzerTestOneInput(own, n);
  free(own);
}

static int replay(const char *folder) {
  DIR *d = opendir(folder);
  int n_file = 0;
  for (struct dirent *f; d && (f = readdir(d));) {
    if (f->d_name[0] == '.')
      continue;
    char path[512];
    size_t n;
    snprintf(path, sizeof path, "%s/%s", folder, f->d_name);
    puts(path); /* the last one in the log is the one that failed */
    fflush(stdout);
    char *bytes = read_whole(path, &n);
    run(bytes, n);
    for (size_t cut = 0; cut < n; cut += 1 + n / 64)
      run(bytes, cut);
    free(bytes);
    n_file++;
  }
  if (d)
    closedir(d);
  return n_file;
}

int main(int argc, char **argv) {
  int n_file = 0;
  for (int k = 1; k < argc; k++)
    n_file += replay(argv[k]);
  return n_file > 0 ? 0 : 1;
}
