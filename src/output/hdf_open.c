/* Opening files that this program wrote, and saying why others are none. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "output/hdf.h"

/* Open /polyrad and see that this program wrote it. */
static hid_t open_root(hid_t file) {
  const hid_t root = rad_hdf_has(file, "polyrad") ? H5Gopen2(file, "polyrad", H5P_DEFAULT) : -1;
  char *version = root >= 0 ? rad_hdf_get_text(root, "version") : NULL;
  const bool ours = version != NULL;
  free(version);
  if (root >= 0 && !ours)
    H5Gclose(root);
  return ours ? root : H5I_INVALID_HID;
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

enum rad_code rad_hdf_open(const char *path, hid_t *file, hid_t *root, struct rad_error *e) {
  struct stat is;
  if (stat(path, &is) == 0 && S_ISFIFO(is.st_mode)) /* HDF5 would wait for who writes to it */
    return rad_fail(e, RAD_ESYSTEM,
                    "cannot read %s: it is a pipe; name a file that `polyrad run` wrote", path);
  *file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  if (*file < 0)
    return refuse(path, e);
  if ((*root = open_root(*file)) >= 0)
    return RAD_OK;
  H5Fclose(*file);
  return rad_fail(e, RAD_ESYSTEM,
                  "%s is an HDF5 file but not from polyrad (no /polyrad with a version); name a "
                  "file that `polyrad run` or `polyrad study` wrote",
                  path);
}

void rad_hdf_close(hid_t file, hid_t root) {
  H5Gclose(root);
  H5Fclose(file);
}
