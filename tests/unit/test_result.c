/* Result files: layout, VTKHDF rules, values, equal bytes. */
#define _GNU_SOURCE /* memmem */
#include <check.h>
#include <hdf5.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "output/hdf.h"
#include "result_help.h"
#include "suite.h"

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

START_TEST(test_layout) {
  static const struct {
    const char *name;
    int rank, shape[3];
  } expected[] = {{"/polyrad/surfaces/name", 1, {2}},
                  {"/polyrad/surfaces/area", 1, {2}},
                  {"/polyrad/surfaces/mean_radiosity", 2, {2, 2}},
                  {"/polyrad/surfaces/mean_irradiance", 2, {2, 2}},
                  {"/polyrad/surfaces/error_radiosity", 2, {2, 2}},
                  {"/polyrad/surfaces/error_irradiance", 2, {2, 2}},
                  {"/polyrad/triangles/vertices", 3, {3, 3, 3}},
                  {"/polyrad/triangles/normal", 2, {3, 3}},
                  {"/polyrad/triangles/surface", 1, {3}},
                  {"/polyrad/triangles/rho", 2, {3, 2}},
                  {"/polyrad/triangles/emission", 2, {3, 2}},
                  {"/polyrad/triangles/area", 1, {3}},
                  {"/polyrad/triangles/mean_radiosity", 2, {3, 2}},
                  {"/polyrad/triangles/error_radiosity", 2, {3, 2}},
                  {"/polyrad/triangles/error_irradiance", 2, {3, 2}},
                  {"/polyrad/solution/point", 2, {5, 3}},
                  {"/polyrad/solution/triangle", 1, {5}},
                  {"/polyrad/solution/value", 2, {5, 2}},
                  {"/polyrad/probes/name", 1, {2}},
                  {"/polyrad/probes/position", 2, {2, 3}},
                  {"/polyrad/probes/normal", 2, {2, 3}},
                  {"/polyrad/probes/radiosity", 2, {2, 2}},
                  {"/polyrad/probes/irradiance", 2, {2, 2}},
                  {"/polyrad/probes/error_irradiance", 2, {2, 2}},
                  {"/VTKHDF/Points", 2, {7, 3}},
                  {"/VTKHDF/Connectivity", 1, {7}},
                  {"/VTKHDF/Offsets", 1, {3}},
                  {"/VTKHDF/Types", 1, {2}},
                  {"/VTKHDF/PointData/radiosity", 2, {7, 2}},
                  {"/VTKHDF/PointData/emission", 2, {7, 2}},
                  {"/VTKHDF/PointData/surface", 1, {7}},
                  {"/VTKHDF/CellData/irradiance", 2, {2, 2}},
                  {"/VTKHDF/CellData/rho", 2, {2, 2}},
                  {"/VTKHDF/CellData/surface", 1, {2}},
                  {"/VTKHDF/CellData/triangle", 1, {2}}};
  char path[128];
  struct fixture *f = make(2, 1);
  write_ok(in_folder("a.vtkhdf", path), f);
  ck_assert_int_eq(count_files(), 1);
  const hid_t file = open_file(path);
  for (size_t k = 0; k < sizeof expected / sizeof *expected; k++)
    check_shape(file, expected[k].name, expected[k].rank, expected[k].shape);
  int n_dataset = 0;
  H5Lvisit(file, H5_INDEX_NAME, H5_ITER_INC, check_labels, &n_dataset);
  ck_assert_int_eq(n_dataset, 6 + 10 + 3 + 6 + 7 + 5 + 6 + 1);
  check_text(file, "/polyrad/surfaces/area", "unit", "m2");
  check_text(file, "/polyrad/solution/value", "unit", "W/m2");
  H5Fclose(file);
  discard(f);
}
END_TEST

START_TEST(test_provenance) {
  static const char *const text[] = {"version", "git_revision", "compiler", "flags", "blas",
                                     "hdf5",    "machine",      "started",  "deck",  "command"};
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
      "unknowns",         "elements",         "kappa",          "error_indicator",
      "error_bound",      "residual",         "iterations",     "condition_estimate",
      "converged",        "matrix_bytes",     "pairs_near",     "peak_memory_bytes",
      "kernel_values",    "pairs_far",        "pairs_skipped",  "seconds_scene",
      "seconds_mesh",     "seconds_assemble", "seconds_factor", "seconds_solve",
      "seconds_output",   "seconds_estimate", "seconds_total",  "seconds_levels",
      "compression_error"};
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
  f->result.means = NULL;
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

static void blank(char *bytes, size_t n, const char *sum) {
  char *at = memmem(bytes, n, sum, 16);
  ck_assert_ptr_nonnull(at);
  memset(at, 0, 16);
}

/* The bytes of a file without the checksums of these times, and that of all checksums. */
static char *slurp_alike(const char *path, size_t *size) {
  char *bytes = slurp(path, size);
  const hid_t file = open_file(path), root = H5Gopen2(file, "polyrad", H5P_DEFAULT);
  int n = 0, n_time = 0;
  char *sum = rad_hdf_get_text(root, "checksum");
  char **line = rad_hdf_read_texts(root, "checksums", &n);
  ck_assert(sum && line);
  blank(bytes, *size, sum);
  for (int i = 0; i < n; i++)
    if (strstr(line[i], " seconds_output of") || strstr(line[i], " seconds_total of")) {
      blank(bytes, *size, line[i]);
      n_time++;
    }
  ck_assert_int_eq(n_time, 2);
  rad_hdf_texts_free(line, n);
  free(sum);
  H5Gclose(root);
  H5Fclose(file);
  return bytes;
}

static void check_equal_bytes(const char *a, const char *b) {
  size_t size_a, size_b;
  char *bytes_a = slurp_alike(a, &size_a), *bytes_b = slurp_alike(b, &size_b);
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

int main(void) {
  const TTest *const test[] = {
      test_layout,      test_provenance,        test_diagnostics,
      test_values,      test_vtkhdf_rules,      test_fields_and_empty_picture,
      test_equal_bytes, test_compressed_values, test_long_deck};
  Suite *suite = suite_create("result");
  TCase *all = tcase_create("all");
  tcase_add_checked_fixture(all, folder_make, folder_remove);
  tcase_set_timeout(all, 60);
  for (size_t k = 0; k < sizeof test / sizeof *test; k++)
    tcase_add_test(all, test[k]);
  suite_add_tcase(suite, all);
  return run_suite(suite);
}
