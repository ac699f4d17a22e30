#include "output/hdf.h"

#include <assert.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "output/contents.h"
#include "output/save.h"

enum { GROWTH = 1 << 22, COMPRESS_FROM = 1 << 14, CHUNK = 1 << 18, DEFLATE = 4 }; /* bytes, level */

void rad_hdf_silence_begin(struct rad_hdf_silence *s) {
  if (H5Eget_auto2(H5E_DEFAULT, &s->print, &s->data) < 0)
    *s = (struct rad_hdf_silence){0};
  (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
}

void rad_hdf_silence_end(const struct rad_hdf_silence *s) {
  (void)H5Eset_auto2(H5E_DEFAULT, s->print, s->data);
}

static herr_t keep_innermost(unsigned n, const H5E_error2_t *error, void *data) {
  if (n == 0 && error->desc)
    *(const char **)data = error->desc;
  return 0;
}

void rad_hdf_message(size_t size, char text[size]) {
  const char *message = NULL;
  (void)H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_innermost, &message);
  snprintf(text, size, "%s", message ? message : "unknown error");
  text[strcspn(text, ":\n")] = '\0'; /* what follows are times and addresses */
}

void rad_hdf_fail(struct rad_hdf *h, const char *fmt, ...) {
  if (h->failed)
    return;
  h->failed = true;
  va_list args;
  va_start(args, fmt);
  vsnprintf(h->cause, sizeof h->cause, fmt, args);
  va_end(args);
}

hid_t rad_hdf_check(struct rad_hdf *h, hid_t returned, const char *name) {
  if (returned < 0 && !h->failed) {
    char message[160];
    rad_hdf_message(sizeof message, message);
    rad_hdf_fail(h, "HDF5 failed at '%.80s' (%s)", name, message);
  }
  return returned;
}

/* A property list of the given class without object times. */
static hid_t timeless(struct rad_hdf *h, hid_t class) {
  const hid_t plist = rad_hdf_check(h, H5Pcreate(class), "property list");
  if (!h->failed)
    rad_hdf_check(h, H5Pset_obj_track_times(plist, false), "property list");
  return plist;
}

hid_t rad_hdf_create(struct rad_hdf *h, const char *name, hid_t access, hsize_t user_block) {
  const hid_t create = timeless(h, H5P_FILE_CREATE);
  hid_t file = H5I_INVALID_HID;
  if (!h->failed) {
    rad_hdf_check(h, H5Pset_userblock(create, user_block), "file");
    rad_hdf_check(h, H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V110), "file");
    file = rad_hdf_check(h, H5Fcreate(name, H5F_ACC_TRUNC, create, access), "file");
  }
  H5Pclose(create);
  return file;
}

void rad_hdf_begin(struct rad_hdf *h) {
  *h = (struct rad_hdf){.file = H5I_INVALID_HID, .memory = -1};
  rad_hdf_silence_begin(&h->silence);
  char name[64]; /* no such file can exist, so HDF5 finds none to look at */
  snprintf(name, sizeof name, "/dev/null/%p", (void *)h);
  const hid_t access = rad_hdf_check(h, H5Pcreate(H5P_FILE_ACCESS), "file");
  if (!h->failed)
    rad_hdf_check(h, H5Pset_fapl_core(access, GROWTH, false), "file");
  h->file = rad_hdf_create(h, name, access, 0);
  H5Pclose(access);
}

/* The file's bytes, lent by HDF5 until the file is closed: no copy. */
static const void *image(struct rad_hdf *h, size_t *size) {
  void **memory = NULL;
  if (!h->failed)
    rad_hdf_check(h, H5Fflush(h->file, H5F_SCOPE_GLOBAL), "file");
  if (!h->failed)
    rad_hdf_check(h, H5Fget_vfd_handle(h->file, H5P_DEFAULT, (void **)&memory), "file");
  const ssize_t n =
      h->failed ? 0 : (ssize_t)rad_hdf_check(h, H5Fget_file_image(h->file, NULL, 0), "file");
  if (h->failed)
    return NULL;
  *size = (size_t)n;
  return *memory;
}

enum rad_code rad_hdf_end(struct rad_hdf *h, const char *path, struct rad_error *e) {
  size_t size = 0;
  rad_contents_write(h);
  const void *bytes = image(h, &size);
  enum rad_code code = RAD_OK;
  if (h->failed)
    code =
        rad_fail(e, RAD_ESYSTEM, "cannot write %s: %s; free some memory, or lower output.sampling",
                 path, h->cause);
  else
    code = rad_save(path, bytes, size, e);
  if (h->file >= 0 && H5Fclose(h->file) < 0 && code == RAD_OK)
    code = rad_fail(e, RAD_ESYSTEM, "%s is written, but HDF5 could not release its memory", path);
  h->file = H5I_INVALID_HID;
  rad_hdf_silence_end(&h->silence);
  return code;
}

hid_t rad_hdf_group(struct rad_hdf *h, hid_t parent, const char *name) {
  if (h->failed)
    return H5I_INVALID_HID;
  const hid_t create = timeless(h, H5P_GROUP_CREATE);
  hid_t group = H5I_INVALID_HID;
  if (!h->failed)
    rad_hdf_check(
        h, H5Pset_link_creation_order(create, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED), name);
  if (!h->failed)
    group = rad_hdf_check(h, H5Gcreate2(parent, name, H5P_DEFAULT, create, H5P_DEFAULT), name);
  H5Pclose(create);
  return group;
}

void rad_hdf_group_close(struct rad_hdf *h, hid_t group) {
  if (group >= 0)
    rad_hdf_check(h, H5Gclose(group), "group");
}

void rad_hdf_link(struct rad_hdf *h, const char *target, const char *name) {
  if (!h->failed)
    rad_hdf_check(h, H5Lcreate_soft(target, h->file, name, H5P_DEFAULT, H5P_DEFAULT), name);
}

void rad_hdf_type_of(enum rad_hdf_type type, hid_t *memory, hid_t *file) {
  switch (type) {
  case RAD_HDF_REAL:
    *memory = H5T_NATIVE_DOUBLE;
    *file = H5T_IEEE_F64LE;
    break;
  case RAD_HDF_INT64:
    *memory = H5T_NATIVE_INT64;
    *file = H5T_STD_I64LE;
    break;
  case RAD_HDF_INT32:
    *memory = H5T_NATIVE_INT;
    *file = H5T_STD_I32LE;
    break;
  case RAD_HDF_UINT8:
    *memory = H5T_NATIVE_UCHAR;
    *file = H5T_STD_U8LE;
    break;
  case RAD_HDF_REAL32:
    *memory = H5T_NATIVE_FLOAT;
    *file = H5T_IEEE_F32LE;
    break;
  }
}

static hid_t text_type(struct rad_hdf *h) {
  const hid_t type = rad_hdf_check(h, H5Tcopy(H5T_C_S1), "text");
  if (type >= 0) {
    rad_hdf_check(h, H5Tset_size(type, H5T_VARIABLE), "text");
    rad_hdf_check(h, H5Tset_cset(type, H5T_CSET_UTF8), "text");
  }
  return type;
}

/* Attribute of n values, or a scalar when n is 0. */
static void set(struct rad_hdf *h, hid_t object, const char *name, hid_t memory, hid_t file,
                size_t n, const void *data) {
  if (h->failed)
    return;
  const hsize_t shape = n;
  const hid_t space =
      rad_hdf_check(h, n ? H5Screate_simple(1, &shape, NULL) : H5Screate(H5S_SCALAR), name);
  const hid_t attribute =
      h->failed
          ? H5I_INVALID_HID
          : rad_hdf_check(h, H5Acreate2(object, name, file, space, H5P_DEFAULT, H5P_DEFAULT), name);
  if (!h->failed)
    rad_hdf_check(h, H5Awrite(attribute, memory, data), name);
  if (attribute >= 0)
    rad_hdf_check(h, H5Aclose(attribute), name);
  if (space >= 0)
    H5Sclose(space);
  rad_contents_attribute(h, object, name, memory, n, data);
}

void rad_hdf_set_texts(struct rad_hdf *h, hid_t object, const char *name, size_t n,
                       const char *const *text) {
  const hid_t type = text_type(h);
  set(h, object, name, type, type, n, text);
  H5Tclose(type);
}

void rad_hdf_set_text(struct rad_hdf *h, hid_t object, const char *name, const char *text) {
  const char *scalar = text ? text : "";
  rad_hdf_set_texts(h, object, name, 0, &scalar);
}

void rad_hdf_set_ascii(struct rad_hdf *h, hid_t object, const char *name, const char *text) {
  const hid_t type = rad_hdf_check(h, H5Tcopy(H5T_C_S1), name);
  if (type >= 0) {
    rad_hdf_check(h, H5Tset_size(type, strlen(text)), name);
    rad_hdf_check(h, H5Tset_strpad(type, H5T_STR_NULLPAD), name);
  }
  set(h, object, name, type, type, 0, text);
  H5Tclose(type);
}

void rad_hdf_set_real(struct rad_hdf *h, hid_t object, const char *name, double value) {
  set(h, object, name, H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE, 0, &value);
}

void rad_hdf_set_integer(struct rad_hdf *h, hid_t object, const char *name, int64_t value) {
  set(h, object, name, H5T_NATIVE_INT64, H5T_STD_I64LE, 0, &value);
}

void rad_hdf_set_integers(struct rad_hdf *h, hid_t object, const char *name, size_t n,
                          const int64_t *value) {
  set(h, object, name, H5T_NATIVE_INT64, H5T_STD_I64LE, n, value);
}

/* Chunks of whole rows, and filters, when the array is worth it. */
static void set_compression(struct rad_hdf *h, hid_t plist, const struct rad_hdf_array *a,
                            hsize_t bytes) {
  if (h->failed || h->memory >= 0 || !a->data || bytes < COMPRESS_FROM ||
      H5Zfilter_avail(H5Z_FILTER_DEFLATE) <= 0)
    return;
  hsize_t chunk[RAD_HDF_MAX_RANK];
  memcpy(chunk, a->shape, sizeof chunk);
  const hsize_t row = bytes / a->shape[0];
  const hsize_t rows = row < CHUNK ? CHUNK / row : 1;
  chunk[0] = rows < a->shape[0] ? rows : a->shape[0];
  rad_hdf_check(h, H5Pset_chunk(plist, a->rank, chunk), a->name);
  rad_hdf_check(h, H5Pset_shuffle(plist), a->name);
  rad_hdf_check(h, H5Pset_deflate(plist, DEFLATE), a->name);
}

/* Room for a dataset's bytes in a large file, which come at its end. */
static void leave_room(struct rad_hdf *h, hid_t plist, const char *name) {
  rad_hdf_check(h, H5Pset_alloc_time(plist, H5D_ALLOC_TIME_EARLY), name);
  rad_hdf_check(h, H5Pset_fill_time(plist, H5D_FILL_TIME_NEVER), name);
}

/* Remember where the lists of an array go. */
static void set_pieces(struct rad_hdf *h, hid_t dataset, const char *name, size_t n,
                       const struct rad_hdf_piece *list) {
  uint64_t at = H5Dget_offset(dataset);
  if (at == HADDR_UNDEF)
    rad_hdf_fail(h, "HDF5 gave '%.80s' no room", name);
  else if (!rad_reserve((void **)&h->piece, h->n_piece + n, &h->room, sizeof *h->piece))
    rad_hdf_fail(h, "out of memory for %zu arrays", h->n_piece + n);
  for (size_t i = 0; i < n && !h->failed; i++) {
    h->piece[h->n_piece] = list[i];
    h->piece[h->n_piece++].at = at;
    at += list[i].bytes;
  }
}

/* Create, write, label and close one dataset. Nothing is written for bytes = 0 or data = NULL.
 * In a large file, from list [n_list]. */
static void put(struct rad_hdf *h, hid_t parent, const struct rad_hdf_array *a, hid_t memory,
                hid_t file, hsize_t bytes, size_t n_list, const struct rad_hdf_piece *list) {
  const hid_t plist = timeless(h, H5P_DATASET_CREATE);
  const int later = h->memory >= 0 && bytes > 0 && n_list > 0;
  if (!h->failed && later)
    leave_room(h, plist, a->name);
  const double unknown = NAN;
  if (!h->failed && !a->data && a->type == RAD_HDF_REAL)
    rad_hdf_check(h, H5Pset_fill_value(plist, H5T_NATIVE_DOUBLE, &unknown), a->name);
  set_compression(h, plist, a, bytes);
  hid_t space = H5I_INVALID_HID, dataset = H5I_INVALID_HID;
  if (!h->failed)
    space = rad_hdf_check(h, H5Screate_simple(a->rank, a->shape, NULL), a->name);
  if (!h->failed)
    dataset = rad_hdf_check(
        h, H5Dcreate2(parent, a->name, file, space, H5P_DEFAULT, plist, H5P_DEFAULT), a->name);
  if (!h->failed && later)
    set_pieces(h, dataset, a->name, n_list, list);
  else if (!h->failed && a->data && bytes > 0)
    rad_hdf_check(h, H5Dwrite(dataset, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, a->data), a->name);
  rad_hdf_set_text(h, dataset, "unit", a->unit);
  rad_hdf_set_text(h, dataset, "description", a->description);
  rad_contents_dataset(h, parent, a, memory);
  if (dataset >= 0)
    rad_hdf_check(h, H5Dclose(dataset), a->name);
  if (space >= 0)
    H5Sclose(space);
  H5Pclose(plist);
}

void rad_hdf_array(struct rad_hdf *h, hid_t parent, const struct rad_hdf_array *a) {
  assert(a->rank >= 1 && a->rank <= RAD_HDF_MAX_RANK);
  if (h->failed)
    return;
  hid_t memory = H5I_INVALID_HID, file = H5I_INVALID_HID;
  rad_hdf_type_of(a->type, &memory, &file);
  hsize_t bytes = H5Tget_size(file);
  for (int k = 0; k < a->rank; k++)
    bytes *= a->shape[k];
  put(h, parent, a, memory, file, bytes, a->data != NULL,
      &(struct rad_hdf_piece){.bytes = bytes, .data = a->data});
}

void rad_hdf_lists(struct rad_hdf *h, hid_t parent, const struct rad_hdf_array *a, size_t n,
                   const size_t *count, const double *const *data) {
  assert(h->memory >= 0 || h->failed);
  struct rad_hdf_array one = *a;
  struct rad_hdf_piece *list = rad_alloc(n, sizeof *list);
  one.rank = 1;
  one.shape[0] = 0;
  if (!list)
    rad_hdf_fail(h, "out of memory for %zu arrays", n);
  for (size_t i = 0; i < n && !h->failed; i++) {
    list[i] = (struct rad_hdf_piece){.bytes = sizeof(double) * count[i], .data = data[i]};
    one.shape[0] += count[i];
  }
  if (!h->failed)
    put(h, parent, &one, H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE, sizeof(double) * one.shape[0], n, list);
  free(list);
}

void rad_hdf_texts(struct rad_hdf *h, hid_t parent, const char *name, size_t n,
                   const char *const *text, const char *description) {
  if (h->failed)
    return;
  const struct rad_hdf_array a = {
      .name = name, .unit = "1", .description = description, .rank = 1, .shape = {n}, .data = text};
  const hid_t type = text_type(h);
  put(h, parent, &a, type, type, n ? 1 : 0, 0, NULL); /* bytes: too few to compress */
  H5Tclose(type);
}
