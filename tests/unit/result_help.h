/* Shared by the tests of result files. */
#ifndef POLYRAD_TEST_RESULT_HELP_H
#define POLYRAD_TEST_RESULT_HELP_H

#include <hdf5.h>

#include "output/result.h"

static const double STARTED = 1700000000.25; /* 2023-11-14T22:13:20Z */
enum { N_TRIANGLE = 3, N_SURFACE = 2, N_PROBE = 2, N_UNKNOWN = 5 };

/* A made-up result. */
struct fixture {
  struct rad_deck deck;
  struct rad_scene scene;
  struct rad_result result;
  struct rad_means means;
  struct rad_deck_probe probe[N_PROBE];
  struct rad_triangle triangle[N_TRIANGLE];
  char *name[N_SURFACE];
  double rho[N_TRIANGLE * 2], emission[N_TRIANGLE * 3 * 2];
};

/* A picture of n_copy times the same two cells, of 7 points. */
struct fixture *make(int n_band, int n_copy);
void discard(struct fixture *f);

/* --- a folder of our own, as a fixture of the test case --- */

extern char folder[64];
void folder_make(void);
void folder_remove(void);
const char *in_folder(const char *name, char path[128]);
int count_files(void);
void write_ok(const char *path, struct fixture *f);
char *slurp(const char *path, size_t *size); /* to be freed */

/* --- reading, by HDF5 alone --- */

hid_t open_file(const char *path);
void check_shape(hid_t file, const char *name, int rank, const int *shape);
double number(hid_t file, const char *name, int i);
void check_text(hid_t file, const char *object, const char *name, const char *expected);

#endif
