#include "base/place.h"

#include <libgen.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/memory.h"

static bool is_same(const struct stat *a, const struct stat *b) {
  return a->st_dev == b->st_dev && a->st_ino == b->st_ino;
}

/* Names of files that are not there yet. */
static bool is_same_place(const char *a, const char *b) {
  struct stat x, y;
  char *copy[4] = {strdup(a), strdup(b), strdup(a), strdup(b)};
  bool same = copy[0] && copy[1] && copy[2] && copy[3] && !stat(dirname(copy[0]), &x) &&
              !stat(dirname(copy[1]), &y) && is_same(&x, &y) &&
              !strcmp(basename(copy[2]), basename(copy[3]));
  for (int i = 0; i < 4; i++)
    free(copy[i]);
  return same;
}

bool rad_is_same_file(const char *a, const char *b) {
  struct stat x, y;
  const bool has_a = !stat(a, &x), has_b = !stat(b, &y);
  if (has_a && has_b)
    return is_same(&x, &y) && S_ISREG(x.st_mode);
  return !has_a && !has_b && (!strcmp(a, b) || is_same_place(a, b));
}

char *rad_path_beside(const char *path, const char *file) {
  const char *slash = strrchr(path, '/');
  const size_t n_folder = *file != '/' && slash ? (size_t)(slash - path) + 1 : 0;
  char *beside = rad_alloc(n_folder + strlen(file) + 1, 1);
  if (beside) {
    memcpy(beside, path, n_folder);
    strcpy(beside + n_folder, file);
  }
  return beside;
}
