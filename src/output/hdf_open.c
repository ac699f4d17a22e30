/* Opening files that this program wrote, and saying why others are none. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "output/contents.h"
#include "output/hdf.h"
#include "output/save.h"

/* Open /polyrad and see that this program wrote it. */
static enum rad_code open_root(const char *path, hid_t file, hid_t *root, struct rad_error *e) {
  const htri_t is_there = H5Lexists(file, "polyrad", H5P_DEFAULT);
  *root = is_there > 0 ? H5Gopen2(file, "polyrad", H5P_DEFAULT) : H5I_INVALID_HID;
  const htri_t has_version = *root >= 0 ? H5Aexists(*root, "version") : -1;
  char *version = has_version > 0 ? rad_hdf_get_text(*root, "version") : NULL;
  enum rad_code code = RAD_OK;
  if (is_there == 0 || has_version == 0)
    code = rad_fail(e, RAD_ESYSTEM,
                    "%s is an HDF5 file but not from polyrad (no /polyrad with a version); name a "
                    "file that `polyrad run` or `polyrad study` wrote",
                    path);
  else if (!version)
    code = rad_fail(e, RAD_ESYSTEM, "%s is damaged: /polyrad in it cannot be read; make it again",
                    path);
  free(version);
  if (code && *root >= 0)
    H5Gclose(*root);
  return code;
}

/* HDF5 says "unable to open file" for everything; the system and the first bytes say more. */
static enum rad_code refuse(const char *path, struct rad_error *e) {
  static const char signature[8] = "\211HDF\r\n\032\n";
  char first[8] = "", message[160];
  rad_hdf_message(sizeof message, message);
  FILE *f = fopen(path, "rb");
  if (!f)
    return rad_fail(e, RAD_ESYSTEM, "cannot read %s: %m; check the name and its permissions", path);
  const size_t n = fread(first, 1, sizeof first, f);
  const bool readable = !ferror(f);
  fclose(f);
  if (!readable)
    return rad_fail(e, RAD_ESYSTEM, "cannot read %s: %m; name a file that `polyrad run` wrote",
                    path);
  if (n < sizeof first || memcmp(first, signature, sizeof first) != 0)
    return rad_fail(e, RAD_ESYSTEM,
                    "%s is not a polyrad result file (it is not HDF5); name a file that `polyrad "
                    "run` or `polyrad study` wrote",
                    path);
  return rad_fail(e, RAD_ESYSTEM, "cannot read %s: damaged or in use (HDF5: %s); run polyrad again",
                  path, message);
}

static enum rad_code open_unchecked(const char *path, hid_t *file, hid_t *root,
                                    struct rad_error *e) {
  struct stat is;
  if (stat(path, &is) == 0 && S_ISFIFO(is.st_mode)) /* HDF5 would wait for who writes to it */
    return rad_fail(e, RAD_ESYSTEM,
                    "cannot read %s: it is a pipe; name a file that `polyrad run` wrote", path);
  *file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  if (*file < 0)
    return refuse(path, e);
  const enum rad_code code = open_root(path, *file, root, e);
  if (code)
    H5Fclose(*file);
  return code;
}

static enum rad_code open_and_check(const char *path, struct rad_error *e) {
  hid_t file, root;
  enum rad_code code = open_unchecked(path, &file, &root, e);
  if (!code) {
    code = rad_contents_check(path, root, e);
    rad_hdf_close(file, root);
  }
  return code;
}

/* Many times the processor time [s] that a good file takes, which unpacks to a thousand times its
 * size at most: a wrong length can have HDF5 go round in a circle. */
static struct rlimit enough_time(const char *path) {
  struct stat is;
  const double megabytes = stat(path, &is) ? 0 : (double)is.st_size / 1e6;
  const rlim_t seconds = (rlim_t)(10 + 20 * megabytes);
  return (struct rlimit){seconds, seconds};
}

/* In a child: nothing that HDF5 does to it matters. */
static _Noreturn void check_and_die(const char *path, int to) {
  struct rad_error e = {0};
  const struct rlimit none = {0, 0}, enough = enough_time(path);
  const int quiet = open("/dev/null", O_WRONLY);
  (void)setrlimit(RLIMIT_CORE, &none);
  (void)setrlimit(RLIMIT_CPU, &enough);
  (void)dup2(quiet, STDERR_FILENO);
  (void)open_and_check(path, &e);
  _exit(rad_write_all(to, &e, sizeof e) != 0);
}

/* Whether all is as it was written. HDF5 trusts lengths and places that it finds in a file, and a
 * wrong bit in one of them may end its process: so another one than ours looks first. */
static enum rad_code check(const char *path, struct rad_error *e) {
  int between[2], status = 0;
  if (pipe(between) != 0)
    return open_and_check(path, e);
  const pid_t child = fork();
  if (child == 0)
    check_and_die(path, between[1]);
  close(between[1]);
  struct rad_error told = {0};
  size_t n = 0;
  for (ssize_t got = 1; child > 0 && n < sizeof told && got > 0; n += got > 0 ? (size_t)got : 0)
    got = read(between[0], (char *)&told + n, sizeof told - n);
  close(between[0]);
  if (child < 0)
    return open_and_check(path, e);
  while (waitpid(child, &status, 0) < 0 && errno == EINTR)
    continue;
  if (n < sizeof told)
    return rad_fail(e, RAD_ESYSTEM, "%.400s is damaged: HDF5 breaks down over it; make it again",
                    path);
  if (told.code)
    *e = told;
  return told.code;
}

enum rad_code rad_hdf_open(const char *path, hid_t *file, hid_t *root, struct rad_error *e) {
  const enum rad_code code = check(path, e);
  return code ? code : open_unchecked(path, file, root, e);
}

void rad_hdf_close(hid_t file, hid_t root) {
  H5Gclose(root);
  H5Fclose(file);
}
