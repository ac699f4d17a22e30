#include "result_help.h"

#include <check.h>
#include <glob.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "output/hdf.h"

/* --- a made-up result: a unit square of two triangles, "floor", and one above it, "lamp" --- */

static const double CORNER[N_TRIANGLE][3][3] = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                                                {{1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                                                {{0, 0, 2}, {0, 2, 2}, {2, 0, 2}}};
static const double AREA[N_TRIANGLE] = {0.5, 0.5, 2};

static double *ramp(size_t n, double first, double step) {
  double *x = malloc((n ? n : 1) * sizeof *x);
  ck_assert_ptr_nonnull(x);
  for (size_t i = 0; i < n; i++)
    x[i] = first + step * (double)i;
  return x;
}

static void make_scene(struct fixture *f, int n_band) {
  for (int j = 0; j < N_TRIANGLE; j++) {
    struct rad_triangle *t = &f->triangle[j];
    memcpy(t->v, CORNER[j], sizeof t->v);
    t->normal[2] = j < 2 ? 1 : -1;
    t->area = AREA[j];
    t->surface = j < 2 ? 0 : 1;
  }
  for (int i = 0; i < N_TRIANGLE * n_band; i++)
    f->rho[i] = 0.1 * (i + 1);
  for (int i = 0; i < N_TRIANGLE * 3 * n_band; i++)
    f->emission[i] = i + 1;
  f->name[0] = "floor";
  f->name[1] = "l\303\244mp"; /* UTF-8 */
  f->scene = (struct rad_scene){.n_triangle = N_TRIANGLE,
                                .n_surface = N_SURFACE,
                                .n_band = n_band,
                                .triangle = f->triangle,
                                .surface_name = f->name,
                                .rho = f->rho,
                                .emission = f->emission};
}

/* n copies of: the triangle 0 as one cell, and half of triangle 1 as a quadrilateral. */
static void make_picture(struct rad_picture *p, int n, int n_band) {
  static const double x[7][3] = {{0, 0, 0}, {1, 0, 0},  {0, 1, 0},  {1, 0, 0},
                                 {1, 1, 0}, {.5, 1, 0}, {.5, .5, 0}};
  const size_t m = (size_t)n;
  *p = (struct rad_picture){.n_point = 7 * n, .n_cell = 2 * n};
  p->point = malloc(7 * m * sizeof x[0] + 1);
  p->connectivity = malloc(7 * m * sizeof(int64_t) + 1);
  p->offset = malloc((2 * m + 1) * sizeof(int64_t));
  p->type = malloc(2 * m + 1);
  p->triangle = malloc(2 * m * sizeof(int) + 1);
  p->offset[0] = 0;
  for (int c = 0; c < n; c++) {
    memcpy(p->point + 21 * c, x, sizeof x);
    for (int k = 0; k < 7; k++)
      p->connectivity[7 * c + k] = 7 * c + k;
    p->offset[2 * c + 1] = 7 * c + 3;
    p->offset[2 * c + 2] = 7 * c + 7;
    p->type[2 * c] = 5;
    p->type[2 * c + 1] = 9;
    p->triangle[2 * c] = 0;
    p->triangle[2 * c + 1] = 1;
  }
  p->radiosity = ramp(7 * m * (size_t)n_band, 0, 1);
  p->irradiance = ramp(7 * m * (size_t)n_band, 100, 1);
}

struct fixture *make(int n_band, int n_copy) {
  struct fixture *f = calloc(1, sizeof *f);
  const size_t band = (size_t)n_band;
  make_scene(f, n_band);
  f->probe[0].name = "a";
  f->probe[1].name = "b";
  f->deck = (struct rad_deck){.title = "A made-up room",
                              .text = "title: A made-up room\n# \303\251t\303\251\n",
                              .n_band = n_band,
                              .band = {"red", "blue"},
                              .n_probe = N_PROBE,
                              .probe = f->probe,
                              .output.fields = RAD_FIELD_RADIOSITY | RAD_FIELD_IRRADIANCE};
  struct rad_result *r = &f->result;
  *r = (struct rad_result){.deck = &f->deck,
                           .scene = &f->scene,
                           .command = "polyrad run room.yml",
                           .matrix = "dense",
                           .solver = "lu",
                           .threads = 2,
                           .n_point = N_UNKNOWN};
  make_picture(&r->picture, n_copy, n_band);
  f->means = (struct rad_means){.n = N_TRIANGLE,
                                .n_band = n_band,
                                .radiosity = ramp(N_TRIANGLE * band, 1, 1),
                                .irradiance = ramp(N_TRIANGLE * band, 10, 1),
                                .error_radiosity = ramp(N_TRIANGLE * band, 0.25, 0),
                                .error_irradiance = ramp(N_TRIANGLE * band, 0.5, 0),
                                .integration = ramp(N_TRIANGLE * band, 0, 0)};
  r->means = &f->means;
  r->point = ramp(N_UNKNOWN * 3, 0, .125);
  r->point_triangle = calloc(N_UNKNOWN, sizeof(int));
  r->value = ramp(N_UNKNOWN * band, 3, 1);
  r->probe_position = ramp(N_PROBE * 3, 0, 1);
  r->probe_normal = ramp(N_PROBE * 3, 0, 0);
  r->probe_radiosity = ramp(N_PROBE * band, 7, 1);
  r->probe_irradiance = ramp(N_PROBE * band, 8, 1);
  r->diagnostics = (struct rad_diagnostics){.unknowns = N_UNKNOWN,
                                            .elements = 18,
                                            .kappa = 0.75,
                                            .error_indicator = 1e-4,
                                            .error_bound = NAN,
                                            .residual = 1e-13,
                                            .condition_estimate = 42,
                                            .converged = 1,
                                            .kernel_values = 5000000000};
  return f;
}

void discard(struct fixture *f) {
  rad_result_free(&f->result);
  rad_result_free(&f->result); /* safe twice */
  rad_means_free(&f->means);
  free(f);
}

/* --- a folder of our own --- */

char folder[64];

void folder_make(void) {
  strcpy(folder, "/tmp/test_result.XXXXXX");
  ck_assert_ptr_nonnull(mkdtemp(folder));
}

void folder_remove(void) {
  char pattern[80];
  glob_t found;
  snprintf(pattern, sizeof pattern, "%s/*", folder);
  if (glob(pattern, 0, NULL, &found) == 0) {
    for (size_t i = 0; i < found.gl_pathc; i++)
      unlink(found.gl_pathv[i]);
    globfree(&found);
  }
  rmdir(folder);
}

const char *in_folder(const char *name, char path[128]) {
  snprintf(path, 128, "%s/%s", folder, name);
  return path;
}

int count_files(void) {
  char pattern[80];
  glob_t found;
  snprintf(pattern, sizeof pattern, "%s/*", folder);
  const int n = glob(pattern, 0, NULL, &found) == 0 ? (int)found.gl_pathc : 0;
  if (n)
    globfree(&found);
  return n;
}

void write_ok(const char *path, struct fixture *f) {
  struct rad_error e = {0};
  ck_assert_msg(rad_result_write(path, &f->result, STARTED, &e) == RAD_OK, "%s", e.text);
}

char *slurp(const char *path, size_t *size) {
  FILE *file = fopen(path, "rb");
  ck_assert_ptr_nonnull(file);
  fseek(file, 0, SEEK_END);
  *size = (size_t)ftell(file);
  rewind(file);
  char *bytes = malloc(*size + 1);
  ck_assert_uint_eq(fread(bytes, 1, *size, file), *size);
  fclose(file);
  return bytes;
}

/* --- reading, by HDF5 alone --- */

hid_t open_file(const char *path) {
  const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  ck_assert_msg(file >= 0, "cannot open %s", path);
  return file;
}

void check_shape(hid_t file, const char *name, int rank, const int *shape) {
  hsize_t found[8] = {0};
  const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT);
  ck_assert_msg(dataset >= 0, "%s is missing", name);
  const hid_t space = H5Dget_space(dataset);
  ck_assert_msg(H5Sget_simple_extent_ndims(space) == rank, "rank of %s", name);
  H5Sget_simple_extent_dims(space, found, NULL);
  for (int k = 0; k < rank; k++)
    ck_assert_msg(found[k] == (hsize_t)shape[k], "shape[%d] of %s is %llu", k, name,
                  (unsigned long long)found[k]);
  H5Sclose(space);
  H5Dclose(dataset);
}

double number(hid_t file, const char *name, int i) {
  hsize_t shape[RAD_HDF_MAX_RANK];
  double *x = rad_hdf_read_numbers(file, name, shape);
  ck_assert_msg(x != NULL, "%s is missing", name);
  const double value = x[i];
  free(x);
  return value;
}

void check_text(hid_t file, const char *object, const char *name, const char *expected) {
  const hid_t at = H5Oopen(file, object, H5P_DEFAULT);
  char *text = rad_hdf_get_text(at, name);
  ck_assert_msg(text && !strcmp(text, expected), "%s of %s is '%s'", name, object,
                text ? text : "(missing)");
  free(text);
  H5Oclose(at);
}
