/* HDF5 in the words of this program: groups, arrays with unit and description, texts, numbers.
 *
 * Writing. The file is built in memory and saved by rad_save at the end. HDF5 1.10 cannot close a
 * file whose disk is full: H5Fclose fails, and the process dies at exit by a segmentation fault. In
 * memory, errors of the disk are ours to report. The price is memory: one time the (compressed)
 * file.
 *
 * The first error is kept and turns all later calls into nothing, so that callers only check the
 * end. Objects carry no time stamps: equal contents are equal bytes.
 *
 * Large files (rad_hdf_begin_large) are not built in memory: arrays are taken from where they are
 * when the file is ended, uncompressed, and the rest, some kilobytes, is made in a file without a
 * disk.
 *
 * Reading. Plain calls; whatever is absent or of another type is NULL or NAN.
 */
#ifndef RAD_OUTPUT_HDF_H
#define RAD_OUTPUT_HDF_H

#include <hdf5.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"

enum { RAD_HDF_MAX_RANK = 3 };

/* HDF5 prints its errors to stderr unless told not to; an application may have its own wish. */
struct rad_hdf_silence {
  H5E_auto2_t print;
  void *data;
};

void rad_hdf_silence_begin(struct rad_hdf_silence *s);
void rad_hdf_silence_end(const struct rad_hdf_silence *s);

/* Innermost message of HDF5's error stack, without its details; "unknown error" if there is none.
 */
void rad_hdf_message(size_t size, char text[size]);

/* Bytes of a large file that are elsewhere until the end. */
struct rad_hdf_piece {
  uint64_t at; /* in the file */
  size_t bytes;
  const void *data; /* borrowed */
};

/* A file being written. */
struct rad_hdf {
  hid_t file;
  int memory; /* of a large file: descriptor of its small parts; else -1 */
  size_t n_piece, room;
  struct rad_hdf_piece *piece; /* owned */
  size_t n_content, content_room;
  char **content; /* owned [n_content] checksums of what was written (output/contents.h) */
  bool failed;
  char cause[320]; /* when failed */
  struct rad_hdf_silence silence;
};

void rad_hdf_begin(struct rad_hdf *h);

/* A large file: arrays must stay as they are until rad_hdf_end_large. */
void rad_hdf_begin_large(struct rad_hdf *h);

/* The same as rad_hdf_end for a large file, which gets a seal of this kind (output/seal.h). */
enum rad_code rad_hdf_end_large(struct rad_hdf *h, const char *path, const char *kind,
                                struct rad_error *e);

/**
 * Save the file to path (see rad_save) and release it; to be called once after rad_hdf_begin, also
 * after an error. All groups must be closed.
 *
 * @return RAD_OK or RAD_ESYSTEM: the first error since rad_hdf_begin
 */
enum rad_code rad_hdf_end(struct rad_hdf *h, const char *path, struct rad_error *e);

/* For errors met between the calls (out of memory); kept like those of HDF5. */
void rad_hdf_fail(struct rad_hdf *h, const char *fmt, ...) __attribute__((format(printf, 2, 3)));

/* A new HDF5 file with this program's settings, for rad_hdf_begin and rad_hdf_begin_large; negative
 * after an error. */
hid_t rad_hdf_create(struct rad_hdf *h, const char *name, hid_t access, hsize_t user_block);

/* Pass on what an HDF5 call returned; negative is an error about the object `name`. */
hid_t rad_hdf_check(struct rad_hdf *h, hid_t returned, const char *name);

/* A new group, which remembers the order of its members. Negative after an error. */
hid_t rad_hdf_group(struct rad_hdf *h, hid_t parent, const char *name);
void rad_hdf_group_close(struct rad_hdf *h, hid_t group);
void rad_hdf_link(struct rad_hdf *h, const char *target,
                  const char *name); /* soft, from the root */

enum rad_hdf_type { RAD_HDF_REAL, RAD_HDF_INT64, RAD_HDF_INT32, RAD_HDF_UINT8, RAD_HDF_REAL32 };

/* HDF5's types: in memory, and little-endian in the file. */
void rad_hdf_type_of(enum rad_hdf_type type, hid_t *memory, hid_t *file);

struct rad_hdf_array {
  const char *name;
  const char *unit;        /* "1" when it has none */
  const char *description; /* one line */
  enum rad_hdf_type type;  /* of data and, little-endian, of the file */
  int rank;                /* 1 .. RAD_HDF_MAX_RANK */
  hsize_t shape[RAD_HDF_MAX_RANK];
  const void *data; /* row-major; NULL: not known, which RAD_HDF_REAL shows as NaN */
};

/* Arrays above 16 kB are shuffled and deflated, but not those of large files. */
void rad_hdf_array(struct rad_hdf *h, hid_t parent, const struct rad_hdf_array *a);

/* In a large file: a list [n] of the lists data[i] [count[i]] one after another. */
void rad_hdf_lists(struct rad_hdf *h, hid_t parent, const struct rad_hdf_array *a, size_t n,
                   const size_t *count, const double *const *data);

/* text: [n] UTF-8, of any length */
void rad_hdf_texts(struct rad_hdf *h, hid_t parent, const char *name, size_t n,
                   const char *const *text, const char *description);

/* Attributes. Text is UTF-8 of any length, NULL counts as empty; ascii has a fixed length. */
void rad_hdf_set_text(struct rad_hdf *h, hid_t object, const char *name, const char *text);
void rad_hdf_set_texts(struct rad_hdf *h, hid_t object, const char *name, size_t n,
                       const char *const *text);
void rad_hdf_set_ascii(struct rad_hdf *h, hid_t object, const char *name, const char *text);
void rad_hdf_set_real(struct rad_hdf *h, hid_t object, const char *name, double value);
void rad_hdf_set_integer(struct rad_hdf *h, hid_t object, const char *name, int64_t value);
void rad_hdf_set_integers(struct rad_hdf *h, hid_t object, const char *name, size_t n,
                          const int64_t *value);

/**
 * Open a file that this program wrote, and its /polyrad; between rad_hdf_silence_begin and _end.
 *
 * @return RAD_OK, or RAD_ESYSTEM: cannot be read, not HDF5, not from polyrad, damaged
 */
enum rad_code rad_hdf_open(const char *path, hid_t *file, hid_t *root, struct rad_error *e);
void rad_hdf_close(hid_t file, hid_t root);

/* Reading: what is asked for by name is a member or attribute of the open object `at`. */
bool rad_hdf_has(hid_t at, const char *name); /* member */
char *
rad_hdf_get_text(hid_t at,
                 const char *name); /* attribute; owned, or NULL; lists are joined by commas */
char **rad_hdf_get_texts(hid_t at, const char *name, int *n);  /* attribute; owned [n], or NULL */
double rad_hdf_get_number(hid_t at, const char *name);         /* attribute; or NAN */
char **rad_hdf_read_texts(hid_t at, const char *name, int *n); /* dataset; owned [n], or NULL */
void rad_hdf_texts_free(char **text, int n);                   /* NULL is fine */

/* n numbers of a dataset of exactly that many, of that type, into data. */
bool rad_hdf_read_into(hid_t at, const char *name, enum rad_hdf_type type, size_t n, void *data);

/* Dataset as double, row-major, of rank <= RAD_HDF_MAX_RANK; missing dimensions are 1. Owned, or
 * NULL. */
double *rad_hdf_read_numbers(hid_t at, const char *name, hsize_t shape[RAD_HDF_MAX_RANK]);

#endif
