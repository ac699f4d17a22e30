/* HDF5 files of gigabytes: HDF5 lays them out, their arrays go straight to the disk. */
#define _GNU_SOURCE /* memfd_create */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "output/hdf.h"
#include "output/save.h"
#include "output/seal.h"

enum { STEP = 1 << 20 };

void rad_hdf_begin_large(struct rad_hdf *h) {
  *h = (struct rad_hdf){.file = H5I_INVALID_HID, .memory = -1};
  rad_hdf_silence_begin(&h->silence);
  const hid_t access = rad_hdf_check(h, H5Pcreate(H5P_FILE_ACCESS), "file");
  h->memory = memfd_create("polyrad", MFD_CLOEXEC);
  if (h->memory < 0)
    rad_hdf_fail(h, "no memory for a file (%s)", strerror(errno));
  char name[48];
  snprintf(name, sizeof name, "/proc/self/fd/%d", h->memory);
  if (!h->failed) /* its usual driver asks for the name behind the link, which there is none */
    rad_hdf_check(h, H5Pset_fapl_stdio(access), "file");
  h->file = rad_hdf_create(h, name, access, RAD_SEAL);
  H5Pclose(access);
}

static int by_place(const void *a, const void *b) {
  const uint64_t x = ((const struct rad_hdf_piece *)a)->at,
                 y = ((const struct rad_hdf_piece *)b)->at;
  return (x > y) - (x < y);
}

static int is_zero(const char *bytes, size_t n) {
  return n == 0 || (bytes[0] == 0 && memcmp(bytes, bytes + 1, n - 1) == 0);
}

/* Blocks of zeros, such as those between triangles that do not see each other, are left as holes.
 */
static int put(int fd, const struct rad_hdf_piece *p) {
  const char *bytes = p->data;
  int cause = 0;
  for (size_t at = 0; at < p->bytes && !cause;) {
    const size_t n = p->bytes - at < STEP ? p->bytes - at : STEP;
    if (is_zero(bytes + at, n))
      cause = 0;
    else if (lseek(fd, (off_t)(p->at + at), SEEK_SET) < 0)
      cause = errno;
    else
      cause = rad_write_all(fd, bytes + at, n);
    at += n;
  }
  return cause;
}

struct source {
  const struct rad_hdf *h;
  const char *kind;
};

/* Pieces, and what is between them; then the seal. */
static int fill(int fd, void *context) {
  const struct source *s = context;
  const struct rad_hdf *h = s->h;
  struct stat is;
  off_t at = 0;
  int cause = fstat(h->memory, &is) || ftruncate(fd, is.st_size) ? errno : 0;
  for (size_t i = 0; i < h->n_piece && !cause; i++) {
    cause = rad_copy_part(h->memory, fd, at, (off_t)h->piece[i].at);
    if (!cause)
      cause = put(fd, &h->piece[i]);
    at = (off_t)(h->piece[i].at + h->piece[i].bytes);
  }
  if (!cause)
    cause = rad_copy_part(h->memory, fd, at, is.st_size);
  return cause ? cause : rad_seal_write(fd, s->kind);
}

enum rad_code rad_hdf_end_large(struct rad_hdf *h, const char *path, const char *kind,
                                struct rad_error *e) {
  if (h->file >= 0)
    rad_hdf_check(h, H5Fclose(h->file), "file");
  h->file = H5I_INVALID_HID;
  enum rad_code code = RAD_OK;
  if (h->failed) {
    code = rad_fail(e, RAD_ESYSTEM, "cannot write %s: %s; free some memory", path, h->cause);
  } else {
    struct source s = {h, kind};
    if (h->n_piece)
      qsort(h->piece, h->n_piece, sizeof *h->piece, by_place);
    code = rad_save_by(path, fill, &s, e);
  }
  if (h->memory >= 0)
    close(h->memory);
  free(h->piece);
  rad_hdf_silence_end(&h->silence);
  return code;
}
