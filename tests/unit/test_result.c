/* Result files: layout, VTKHDF rules, equal bytes, errors of the disk, and the description. */
#include <check.h>
#include <errno.h>
#include <glob.h>
#include <hdf5.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "output/hdf.h"
#include "output/result.h"

static const double STARTED = 1700000000.25; /* 2023-11-14T22:13:20Z */
enum { N_TRIANGLE = 3, N_SURFACE = 2, N_PROBE = 2, N_UNKNOWN = 5 };

/* --- a made-up result: a unit square of two triangles, "floor", and one above it, "lamp" --- */

struct fixture {
  struct rad_deck deck;
  struct rad_scene scene;
  struct rad_result result;
  struct rad_deck_probe probe[N_PROBE];
  struct rad_triangle triangle[N_TRIANGLE];
  char *name[N_SURFACE];
  double rho[N_TRIANGLE * 2], emission[N_TRIANGLE * 3 * 2];
};

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

static struct fixture *make(int n_band, int n_copy) {
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
  r->triangle_radiosity = ramp(N_TRIANGLE * band, 1, 1);
  r->triangle_irradiance = ramp(N_TRIANGLE * band, 10, 1);
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

static void discard(struct fixture *f) {
  rad_result_free(&f->result);
  rad_result_free(&f->result); /* safe twice */
  free(f);
}

/* --- a folder of our own --- */

static char folder[64];

static void folder_make(void) {
  strcpy(folder, "/tmp/test_result.XXXXXX");
  ck_assert_ptr_nonnull(mkdtemp(folder));
}

static void folder_remove(void) {
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

static const char *in_folder(const char *name, char path[128]) {
  snprintf(path, 128, "%s/%s", folder, name);
  return path;
}

static int count_files(void) {
  char pattern[80];
  glob_t found;
  snprintf(pattern, sizeof pattern, "%s/*", folder);
  const int n = glob(pattern, 0, NULL, &found) == 0 ? (int)found.gl_pathc : 0;
  if (n)
    globfree(&found);
  return n;
}

static void write_ok(const char *path, struct fixture *f) {
  struct rad_error e = {0};
  ck_assert_msg(rad_result_write(path, &f->result, STARTED, &e) == RAD_OK, "%s", e.text);
}

static char *slurp(const char *path, size_t *size) {
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

static hid_t open_file(const char *path) {
  const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  ck_assert_msg(file >= 0, "cannot open %s", path);
  return file;
}

static void check_shape(hid_t file, const char *name, int rank, const int *shape) {
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

static double number(hid_t file, const char *name, int i) {
  hsize_t shape[RAD_HDF_MAX_RANK];
  double *x = rad_hdf_read_numbers(file, name, shape);
  ck_assert_msg(x != NULL, "%s is missing", name);
  const double value = x[i];
  free(x);
  return value;
}

static void check_text(hid_t file, const char *object, const char *name, const char *expected) {
  const hid_t at = H5Oopen(file, object, H5P_DEFAULT);
  char *text = rad_hdf_get_text(at, name);
  ck_assert_msg(text && !strcmp(text, expected), "%s of %s is '%s'", name, object,
                text ? text : "(missing)");
  free(text);
  H5Oclose(at);
}

static herr_t check_labels(hid_t group, const char *name, const H5L_info_t *info, void *count) {
  (void)info;
  const hid_t object = H5Oopen(group, name, H5P_DEFAULT);
  if (H5Iget_type(object) == H5I_DATASET) {
    char *unit = rad_hdf_get_text(object, "unit");
    char *description = rad_hdf_get_text(object, "description");
    ck_assert_msg(unit && *unit && description && *description, "labels of %s", name);
    free(unit);
    free(description);
    ++*(int *)count;
  }
  H5Oclose(object);
  return 0;
}

/* --- tests --- */

START_TEST(test_layout) {
  static const struct {
    const char *name;
    int rank, shape[3];
  } expected[] = {{"/polyrad/surfaces/name", 1, {2}},
                  {"/polyrad/surfaces/area", 1, {2}},
                  {"/polyrad/surfaces/mean_radiosity", 2, {2, 2}},
                  {"/polyrad/surfaces/mean_irradiance", 2, {2, 2}},
                  {"/polyrad/triangles/vertices", 3, {3, 3, 3}},
                  {"/polyrad/triangles/normal", 2, {3, 3}},
                  {"/polyrad/triangles/surface", 1, {3}},
                  {"/polyrad/triangles/rho", 2, {3, 2}},
                  {"/polyrad/triangles/emission", 2, {3, 2}},
                  {"/polyrad/triangles/mean_radiosity", 2, {3, 2}},
                  {"/polyrad/solution/point", 2, {5, 3}},
                  {"/polyrad/solution/triangle", 1, {5}},
                  {"/polyrad/solution/value", 2, {5, 2}},
                  {"/polyrad/probes/name", 1, {2}},
                  {"/polyrad/probes/position", 2, {2, 3}},
                  {"/polyrad/probes/normal", 2, {2, 3}},
                  {"/polyrad/probes/radiosity", 2, {2, 2}},
                  {"/polyrad/probes/irradiance", 2, {2, 2}},
                  {"/VTKHDF/Points", 2, {7, 3}},
                  {"/VTKHDF/Connectivity", 1, {7}},
                  {"/VTKHDF/Offsets", 1, {3}},
                  {"/VTKHDF/Types", 1, {2}},
                  {"/VTKHDF/PointData/radiosity", 2, {7, 2}},
                  {"/VTKHDF/PointData/emission", 2, {7, 2}},
                  {"/VTKHDF/PointData/surface", 1, {7}},
                  {"/VTKHDF/CellData/irradiance", 2, {2, 2}},
                  {"/VTKHDF/CellData/rho", 2, {2, 2}},
                  {"/VTKHDF/CellData/surface", 1, {2}}};
  char path[128];
  struct fixture *f = make(2, 1);
  write_ok(in_folder("a.vtkhdf", path), f);
  ck_assert_int_eq(count_files(), 1);
  const hid_t file = open_file(path);
  for (size_t k = 0; k < sizeof expected / sizeof *expected; k++)
    check_shape(file, expected[k].name, expected[k].rank, expected[k].shape);
  int n_dataset = 0;
  H5Lvisit(file, H5_INDEX_NAME, H5_ITER_INC, check_labels, &n_dataset);
  ck_assert_int_eq(n_dataset, 4 + 7 + 3 + 5 + 7 + 5 + 5);
  check_text(file, "/polyrad/surfaces/area", "unit", "m2");
  check_text(file, "/polyrad/solution/value", "unit", "W/m2");
  H5Fclose(file);
  discard(f);
}
END_TEST

START_TEST(test_provenance) {
  static const char *const text[] = {"version", "git_revision", "compiler", "flags",  "blas",
                                     "hdf5",    "started",      "deck",     "command"};
  char path[128];
  struct fixture *f = make(2, 1);
  write_ok(in_folder("a.vtkhdf", path), f);
  const hid_t file = open_file(path), root = H5Gopen2(file, "polyrad", H5P_DEFAULT);
  for (size_t k = 0; k < sizeof text / sizeof *text; k++) {
    char *found = rad_hdf_get_text(root, text[k]);
    ck_assert_msg(found && *found, "%s is missing", text[k]);
    free(found);
  }
  check_text(file, "polyrad", "started", "2023-11-14T22:13:20Z");
  check_text(file, "polyrad", "deck", f->deck.text);
  check_text(file, "polyrad", "command", "polyrad run room.yml");
  check_text(file, "polyrad", "matrix", "dense");
  check_text(file, "polyrad", "solver", "lu");
  ck_assert_double_eq(rad_hdf_get_number(root, "threads"), 2);
  ck_assert(H5Aexists(root, "blas_parallel") > 0);
  H5Gclose(root);
  H5Fclose(file);
  discard(f);
}
END_TEST

START_TEST(test_diagnostics) {
  static const char *const name[] = {
      "unknowns",       "elements",         "kappa",          "error_indicator",
      "error_bound",    "residual",         "iterations",     "condition_estimate",
      "converged",      "matrix_bytes",     "pairs_near",     "peak_memory_bytes",
      "kernel_values",  "pairs_far",        "pairs_skipped",  "seconds_scene",
      "seconds_mesh",   "seconds_assemble", "seconds_factor", "seconds_solve",
      "seconds_output", "seconds_estimate", "seconds_total"};
  char path[128];
  struct fixture *f = make(1, 1);
  write_ok(in_folder("a.vtkhdf", path), f);
  const hid_t file = open_file(path), at = H5Gopen2(file, "/polyrad/diagnostics", H5P_DEFAULT);
  for (size_t k = 0; k < sizeof name / sizeof *name; k++)
    ck_assert_msg(H5Aexists(at, name[k]) > 0, "%s is missing", name[k]);
  ck_assert_double_eq(rad_hdf_get_number(at, "kernel_values"), 5e9);
  ck_assert_double_eq(rad_hdf_get_number(at, "kappa"), 0.75);
  ck_assert(isnan(rad_hdf_get_number(at, "error_bound")));
  ck_assert_double_eq(rad_hdf_get_number(at, "seconds_total"), f->result.diagnostics.seconds_total);
  ck_assert(f->result.diagnostics.seconds_output > 0);
  H5Gclose(at);
  H5Fclose(file);
  discard(f);
}
END_TEST

START_TEST(test_values) {
  static const double TOLERANCE = 1e-14; /* a few roundings of numbers of order 1..100 */
  char path[128];
  struct fixture *f = make(1, 1);
  write_ok(in_folder("a.vtkhdf", path), f);
  const hid_t file = open_file(path);
  /* means: triangles 0, 1 of equal area make the floor: (1 + 2) / 2 */
  ck_assert_double_eq(number(file, "/polyrad/surfaces/area", 0), 1);
  ck_assert_double_eq_tol(number(file, "/polyrad/surfaces/mean_radiosity", 0), 1.5, TOLERANCE);
  ck_assert_double_eq_tol(number(file, "/polyrad/surfaces/mean_irradiance", 1), 12, TOLERANCE);
  ck_assert_double_eq_tol(number(file, "/polyrad/triangles/emission", 1), 5, TOLERANCE);
  ck_assert_double_eq(number(file, "/polyrad/triangles/vertices", 9 + 3), 1);
  /* E of triangle 1 is 4, 5, 6 at (1,0) (1,1) (0,1): at (.5,1) 5.5, at (.5,.5) 5 */
  for (int k = 0; k < 3; k++)
    ck_assert_double_eq_tol(number(file, "/VTKHDF/PointData/emission", k), 1 + k, TOLERANCE);
  ck_assert_double_eq_tol(number(file, "/VTKHDF/PointData/emission", 5), 5.5, TOLERANCE);
  ck_assert_double_eq_tol(number(file, "/VTKHDF/PointData/emission", 6), 5, TOLERANCE);
  ck_assert_double_eq(number(file, "/VTKHDF/PointData/rho", 6), f->rho[1]);
  ck_assert_double_eq(number(file, "/VTKHDF/CellData/rho", 0), f->rho[0]);
  ck_assert_double_eq_tol(number(file, "/VTKHDF/CellData/radiosity", 0), 1, TOLERANCE);
  ck_assert_double_eq_tol(number(file, "/VTKHDF/CellData/radiosity", 1), 4.5, TOLERANCE);
  ck_assert_double_eq_tol(number(file, "/VTKHDF/CellData/irradiance", 1), 104.5, TOLERANCE);
  check_shape(file, "/VTKHDF/PointData/radiosity", 1, (int[]){7});
  check_shape(file, "/polyrad/solution/value", 2, (int[]){5, 1});
  H5Fclose(file);
  discard(f);
}
END_TEST

START_TEST(test_vtkhdf_rules) {
  char path[128], type[17] = "";
  int version[2] = {-1, -1};
  struct fixture *f = make(1, 1);
  write_ok(in_folder("a.vtkhdf", path), f);
  const hid_t file = open_file(path), root = H5Gopen2(file, "VTKHDF", H5P_DEFAULT);
  const hid_t kind = H5Aopen(root, "Type", H5P_DEFAULT), of = H5Aget_type(kind);
  ck_assert(H5Tget_class(of) == H5T_STRING && H5Tis_variable_str(of) == 0);
  ck_assert(H5Tget_cset(of) == H5T_CSET_ASCII);
  ck_assert_uint_eq(H5Tget_size(of), strlen("UnstructuredGrid"));
  H5Aread(kind, of, type);
  ck_assert_str_eq(type, "UnstructuredGrid");
  const hid_t v = H5Aopen(root, "Version", H5P_DEFAULT);
  H5Aread(v, H5T_NATIVE_INT, version);
  ck_assert(version[0] == 2 && version[1] == 0);
  ck_assert_double_eq(number(root, "NumberOfPoints", 0), 7);
  ck_assert_double_eq(number(root, "NumberOfCells", 0), 2);
  ck_assert_double_eq(number(root, "NumberOfConnectivityIds", 0), 7);
  ck_assert_double_eq(number(root, "Offsets", 1), 3);
  ck_assert_double_eq(number(root, "Offsets", 2), 7);
  ck_assert_double_eq(number(root, "Types", 1), 9);
  H5Aclose(v);
  H5Tclose(of);
  H5Aclose(kind);
  H5Gclose(root);
  H5Fclose(file);
  discard(f);
}
END_TEST

START_TEST(test_fields_and_empty_picture) {
  char path[128];
  struct fixture *f = make(1, 0);
  f->deck.output.fields = RAD_FIELD_RADIOSITY;
  free(f->result.triangle_irradiance);
  f->result.triangle_irradiance = NULL;
  f->deck.n_probe = 0;
  write_ok(in_folder("a.vtkhdf", path), f);
  const hid_t file = open_file(path);
  check_shape(file, "/VTKHDF/Offsets", 1, (int[]){1});
  check_shape(file, "/VTKHDF/Points", 2, (int[]){0, 3});
  check_shape(file, "/VTKHDF/PointData/radiosity", 1, (int[]){0});
  check_shape(file, "/polyrad/probes/name", 1, (int[]){0});
  ck_assert(H5Lexists(file, "/VTKHDF/PointData/irradiance", H5P_DEFAULT) == 0);
  ck_assert(H5Lexists(file, "/VTKHDF/CellData/irradiance", H5P_DEFAULT) == 0);
  ck_assert(isnan(number(file, "/polyrad/surfaces/mean_irradiance", 0)));
  ck_assert(isnan(number(file, "/polyrad/triangles/mean_irradiance", 2)));
  H5Fclose(file);
  discard(f);
}
END_TEST

/* The only two numbers in which equal results differ. */
static void clear_times(const char *path) {
  const double zero = 0;
  const hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t at = H5Gopen2(file, "/polyrad/diagnostics", H5P_DEFAULT);
  static const char *const name[] = {"seconds_output", "seconds_total"};
  for (int k = 0; k < 2; k++) {
    const hid_t attribute = H5Aopen(at, name[k], H5P_DEFAULT);
    ck_assert(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &zero) >= 0);
    H5Aclose(attribute);
  }
  H5Gclose(at);
  H5Fclose(file);
}

static void check_equal_bytes(const char *a, const char *b) {
  size_t size_a, size_b;
  char *bytes_a = slurp(a, &size_a), *bytes_b = slurp(b, &size_b);
  ck_assert_uint_eq(size_a, size_b);
  ck_assert_msg(!memcmp(bytes_a, bytes_b, size_a), "%s and %s differ", a, b);
  free(bytes_b);
  free(bytes_a);
}

START_TEST(test_equal_bytes) {
  char a[128], b[128];
  struct fixture *f = make(2, 2000); /* large enough for chunks */
  write_ok(in_folder("a.vtkhdf", a), f);
  sleep(1); /* object times, were there any, count whole seconds */
  write_ok(in_folder("b.vtkhdf", b), f);
  clear_times(a);
  clear_times(b);
  check_equal_bytes(a, b);
  discard(f);
}
END_TEST

START_TEST(test_compressed_values) {
  char path[128];
  hsize_t shape[RAD_HDF_MAX_RANK];
  struct fixture *f = make(1, 20000);
  write_ok(in_folder("a.vtkhdf", path), f);
  const hid_t file = open_file(path);
  double *u = rad_hdf_read_numbers(file, "/VTKHDF/PointData/radiosity", shape);
  ck_assert_uint_eq(shape[0], 140000);
  ck_assert(!memcmp(u, f->result.picture.radiosity, shape[0] * sizeof *u));
  const hid_t dataset = H5Dopen2(file, "/VTKHDF/Points", H5P_DEFAULT);
  const hid_t plist = H5Dget_create_plist(dataset);
  ck_assert_int_eq(H5Pget_nfilters(plist), 2);
  H5Pclose(plist);
  H5Dclose(dataset);
  H5Fclose(file);
  free(u);
  discard(f);
}
END_TEST

/* HDF5 limits fixed-length attributes to 64 kB; decks are longer. */
START_TEST(test_long_deck) {
  enum { LENGTH = 3000000 };
  char path[128];
  struct fixture *f = make(1, 1);
  f->deck.text = malloc(LENGTH + 1);
  memset(f->deck.text, '#', LENGTH);
  f->deck.text[LENGTH] = '\0';
  write_ok(in_folder("a.vtkhdf", path), f);
  const hid_t file = open_file(path);
  check_text(file, "polyrad", "deck", f->deck.text);
  H5Fclose(file);
  free(f->deck.text);
  discard(f);
}
END_TEST

static void check_refusal(const char *path, const char *cause, const char *remedy) {
  struct rad_error e = {0};
  struct fixture *f = make(1, 2000);
  ck_assert_int_eq(rad_result_write(path, &f->result, STARTED, &e), RAD_ESYSTEM);
  ck_assert_int_eq(e.code, RAD_ESYSTEM);
  ck_assert_msg(strstr(e.text, path) && strstr(e.text, cause) && strstr(e.text, remedy), "%s",
                e.text);
  ck_assert_msg(!strchr(e.text, '\n'), "%s", e.text);
  discard(f);
}

START_TEST(test_missing_folder) {
  char path[128];
  check_refusal(in_folder("nowhere/a.vtkhdf", path), strerror(ENOENT), "create its folder");
  check_refusal(folder, strerror(EISDIR), "not a folder");
  check_refusal("/dev/full", strerror(ENOSPC), "free some space");
  check_refusal("", strerror(ENOENT), "name another file");
  ck_assert_int_eq(count_files(), 0);
}
END_TEST

START_TEST(test_not_permitted) {
  char path[128];
  FILE *old = fopen(in_folder("a.vtkhdf", path), "w");
  fclose(old);
  chmod(path, 0444);
  chmod(folder, 0555);
  const uid_t user = geteuid();
  if (user == 0) /* root may write anything */
    ck_assert_int_eq(seteuid(65534), 0);
  check_refusal(path, strerror(EACCES), "may write to");
  check_refusal(in_folder("b.vtkhdf", path), strerror(EACCES), "may write to");
  if (user == 0)
    ck_assert_int_eq(seteuid(user), 0);
  chmod(folder, 0700);
  ck_assert_int_eq(count_files(), 1);
}
END_TEST

START_TEST(test_disk_full) {
  char path[128];
  size_t size;
  struct rlimit limit;
  FILE *old = fopen(in_folder("a.vtkhdf", path), "w");
  fputs("precious", old);
  fclose(old);
  signal(SIGXFSZ, SIG_IGN);
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlim_t before = limit.rlim_cur;
  static const rlim_t bytes[] = {1, 1000, 20000};
  for (int k = 0; k < 3; k++) {
    limit.rlim_cur = bytes[k];
    setrlimit(RLIMIT_FSIZE, &limit);
    check_refusal(path, strerror(EFBIG), "ulimit -f");
    limit.rlim_cur = before;
    setrlimit(RLIMIT_FSIZE, &limit);
    ck_assert_int_eq(count_files(), 1);
    char *bytes_now = slurp(path, &size);
    ck_assert(size == 8 && !memcmp(bytes_now, "precious", 8));
    free(bytes_now);
  }
  struct fixture *f = make(1, 1); /* and after the errors, all is well */
  write_ok(path, f);
  H5Fclose(open_file(path));
  discard(f);
}
END_TEST

START_TEST(test_device) {
  struct stat is;
  struct fixture *f = make(1, 1);
  write_ok("/dev/null", f);
  ck_assert(stat("/dev/null", &is) == 0 && S_ISCHR(is.st_mode));
  discard(f);
}
END_TEST

static const double ELEMENTS[3] = {1, 2, 4}, EOC[3] = {NAN, 1.97, 2.01};
static const char *const MESH[3] = {"paper", "paper", "graded"};
static const struct rad_column COLUMN[] = {
    {"method.elements", "1", "varied key", ELEMENTS, NULL},
    {"method.mesh", "1", "varied key", NULL, MESH},
    {"eoc", "1", "estimated order of convergence", EOC, NULL}};
static const struct rad_table TABLE = {3, 3, COLUMN};

START_TEST(test_study) {
  char path[128], *text = NULL;
  struct rad_error e = {0};
  struct fixture *f = make(1, 1);
  in_folder("study.h5", path);
  ck_assert_int_eq(rad_table_write(path, &TABLE, &f->deck, "polyrad study x.yml", 1, &e), RAD_OK);
  const hid_t file = open_file(path);
  check_shape(file, "/polyrad/study/method.mesh", 1, (int[]){3});
  check_shape(file, "/study/eoc", 1, (int[]){3}); /* the same, by its short name */
  ck_assert_double_eq(number(file, "/polyrad/study/method.elements", 2), 4);
  check_text(file, "polyrad", "command", "polyrad study x.yml");
  check_text(file, "/polyrad/study/eoc", "unit", "1");
  H5Fclose(file);
  ck_assert_int_eq(rad_result_describe(path, &text, &e), RAD_OK);
  ck_assert_ptr_nonnull(strstr(text, "polyrad study\n"));
  const char *first = strstr(text, "method.elements"), *last = strstr(text, "eoc");
  ck_assert(first && last && first < last); /* the columns' order, not the alphabet's */
  ck_assert_ptr_nonnull(strstr(text, "graded"));
  free(text);
  discard(f);
}
END_TEST

START_TEST(test_describe) {
  static const char *const expected[] = {
      "polyrad result", "red, blue", "A made-up room", "2023-11-14T22:13:20Z", "floor",
      "l\303\244mp",    "unknowns",  "residual",       "not computed",         "total",
      "/VTKHDF/Points", "[7, 3] m",  "converged"};
  char path[128], *text = NULL;
  struct rad_error e = {0};
  struct fixture *f = make(2, 1);
  write_ok(in_folder("a.vtkhdf", path), f);
  ck_assert_msg(rad_result_describe(path, &text, &e) == RAD_OK, "%s", e.text);
  for (size_t k = 0; k < sizeof expected / sizeof *expected; k++)
    ck_assert_msg(strstr(text, expected[k]) != NULL, "no '%s' in\n%s", expected[k], text);
  free(text);
  discard(f);
}
END_TEST

static void check_no_description(const char *path, const char *says) {
  char *text = NULL;
  struct rad_error e = {0};
  ck_assert_int_eq(rad_result_describe(path, &text, &e), RAD_ESYSTEM);
  ck_assert_ptr_null(text);
  ck_assert_msg(strstr(e.text, path) && strstr(e.text, says), "%s", e.text);
}

START_TEST(test_describe_refuses) {
  char path[128];
  size_t size;
  check_no_description(in_folder("absent", path), strerror(ENOENT));
  check_no_description(folder, strerror(EISDIR));
  FILE *other = fopen(in_folder("note.txt", path), "w");
  fputs("not a result\n", other);
  fclose(other);
  check_no_description(path, "not HDF5");
  H5Fclose(H5Fcreate(in_folder("other.h5", path), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
  check_no_description(path, "not from polyrad");
  struct fixture *f = make(1, 1);
  write_ok(in_folder("a.vtkhdf", path), f);
  char *bytes = slurp(path, &size);
  FILE *half = fopen(path, "wb");
  fwrite(bytes, 1, size / 2, half);
  fclose(half);
  free(bytes);
  check_no_description(path, "damaged");
  discard(f);
}
END_TEST

int main(void) {
  const TTest *const test[] = {test_layout,        test_provenance,
                               test_diagnostics,   test_values,
                               test_vtkhdf_rules,  test_fields_and_empty_picture,
                               test_equal_bytes,   test_compressed_values,
                               test_long_deck,     test_missing_folder,
                               test_not_permitted, test_disk_full,
                               test_device,        test_study,
                               test_describe,      test_describe_refuses};
  Suite *suite = suite_create("result");
  TCase *all = tcase_create("all");
  tcase_add_checked_fixture(all, folder_make, folder_remove);
  tcase_set_timeout(all, 60);
  for (size_t k = 0; k < sizeof test / sizeof *test; k++)
    tcase_add_test(all, test[k]);
  suite_add_tcase(suite, all);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed != 0;
}
