/* Checksums of what files hold: whatever changes is found and named; what others add does not
 * matter.
 *
 * POLYRAD_TEST_SEED sets the seed of the random bits, which is printed when a bit is not found. */
#include <check.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/scramble.h"
#include "output/hdf.h"
#include "result_help.h"
#include "suite.h"

static char path[128];

static void begin(void) {
  folder_make();
  struct fixture *f = make(2, 100); /* some arrays are compressed */
  free(f->result.value);
  f->result.value = NULL; /* NaN in the file */
  write_ok(in_folder("a.vtkhdf", path), f);
  discard(f);
}

static void put_back(const char *bytes, size_t size) {
  FILE *f = fopen(path, "wb");
  ck_assert_uint_eq(fwrite(bytes, 1, size, f), size);
  fclose(f);
}

static hid_t open_to_change(void) {
  const hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  ck_assert(file >= 0);
  return file;
}

static void check_good(void) {
  char *text = NULL;
  struct rad_error e = {0};
  ck_assert_msg(rad_result_describe(path, &text, &e) == RAD_OK, "%s", e.text);
  free(text);
}

static void check_damaged(const char *name) {
  char *text = NULL;
  struct rad_error e = {0};
  ck_assert_msg(rad_result_describe(path, &text, &e) == RAD_ESYSTEM, "%s is not missed", name);
  ck_assert_ptr_null(text);
  ck_assert_msg(strstr(e.text, path) && strstr(e.text, "is damaged: ") && strstr(e.text, name) &&
                    !strchr(e.text, '\n'),
                "%s: %s", name, e.text);
}

/* Change the last of n values of a type; a text that was there is returned. */
static char *change(hid_t type, size_t n, char *data) {
  static char other[] = "another";
  if (H5Tis_variable_str(type) <= 0) {
    data[n * H5Tget_size(type) - 1] ^= 1;
    return NULL;
  }
  char *before = ((char **)data)[n - 1];
  ((char **)data)[n - 1] = other;
  return before;
}

/* Free values that HDF5 read. */
static void release(hid_t type, hid_t space, size_t n, char *data, char *before) {
  if (H5Tis_variable_str(type) > 0) {
    ((char **)data)[n - 1] = before;
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, data);
  }
  free(data);
}

static void change_dataset(hid_t file, const char *name) {
  const hid_t set = H5Dopen2(file, name, H5P_DEFAULT), type = H5Dget_type(set),
              space = H5Dget_space(set);
  const size_t n = (size_t)H5Sget_simple_extent_npoints(space);
  char *data = calloc(n, H5Tget_size(type));
  ck_assert(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0);
  char *before = change(type, n, data);
  ck_assert(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0);
  release(type, space, n, data, before);
  H5Sclose(space);
  H5Tclose(type);
  H5Dclose(set);
}

static void change_attribute(hid_t file, const char *object, const char *name) {
  /* not H5Aopen_by_name: HDF5 1.10 cannot write what it opened so */
  const hid_t group = H5Gopen2(file, object, H5P_DEFAULT), at = H5Aopen(group, name, H5P_DEFAULT),
              type = H5Aget_type(at), space = H5Aget_space(at);
  const size_t n = (size_t)H5Sget_simple_extent_npoints(space);
  char *data = calloc(n, H5Tget_size(type));
  ck_assert(H5Aread(at, type, data) >= 0);
  char *before = change(type, n, data);
  ck_assert(H5Awrite(at, type, data) >= 0);
  release(type, space, n, data, before);
  H5Sclose(space);
  H5Tclose(type);
  H5Aclose(at);
  H5Gclose(group);
}

static char **read_list(int *n) {
  const hid_t file = open_file(path), root = H5Gopen2(file, "polyrad", H5P_DEFAULT);
  char **line = rad_hdf_read_texts(root, "checksums", n);
  ck_assert_ptr_nonnull(line);
  H5Gclose(root);
  H5Fclose(file);
  return line;
}

/* The list has all that is in a file but itself. */
static herr_t count_object(hid_t at, const char *name, const H5O_info_t *info, void *count) {
  (void)at;
  if (info->type == H5O_TYPE_DATASET)
    ++*(int *)count;
  else if (strcmp(name, ".") != 0)
    *(int *)count += (int)info->num_attrs;
  return 0;
}

START_TEST(list_is_whole) {
  int n = 0, count = 0;
  char **line = read_list(&n);
  const hid_t file = open_file(path);
  H5Ovisit(file, H5_INDEX_NAME, H5_ITER_NATIVE, count_object, &count);
  H5Fclose(file);
  ck_assert_int_eq(n, count - 2); /* checksum, checksums */
  ck_assert_int_gt(n, 60);
  rad_hdf_texts_free(line, n);
  check_good();
}
END_TEST

START_TEST(every_object) {
  int n = 0;
  size_t size;
  char **line = read_list(&n), *bytes = slurp(path, &size);
  for (int i = 0; i < n; i++) {
    char *name = strchr(line[i], ' ') + 1, *of = strstr(name, " of ");
    const hid_t file = open_to_change();
    if (!strncmp(name, "dataset ", 8)) {
      change_dataset(file, name + 8);
    } else {
      *of = '\0';
      change_attribute(file, of + 4, name + strlen("attribute "));
      *of = ' ';
    }
    H5Fclose(file);
    /* without the version it is nobody's; it is read before all */
    check_damaged(name);
    put_back(bytes, size);
  }
  check_good();
  free(bytes);
  rad_hdf_texts_free(line, n);
}
END_TEST

START_TEST(what_is_gone) {
  size_t size;
  char *bytes = slurp(path, &size);
  static const char *const gone[] = {"/polyrad/checksums", "/polyrad/triangles/rho",
                                     "/polyrad/solution", "/VTKHDF/CellData/radiosity", "/VTKHDF"};
  for (size_t k = 0; k < sizeof gone / sizeof *gone; k++) {
    const hid_t file = open_to_change();
    ck_assert(H5Ldelete(file, gone[k], H5P_DEFAULT) >= 0);
    H5Fclose(file);
    check_damaged(k ? gone[k] : "the list of its checksums");
    put_back(bytes, size);
  }
  for (int both = 0; both < 2; both++) {
    const hid_t file = open_to_change();
    ck_assert(H5Adelete_by_name(file, "polyrad", "checksum", H5P_DEFAULT) >= 0);
    if (both)
      ck_assert(H5Ldelete(file, "/polyrad/checksums", H5P_DEFAULT) >= 0);
    H5Fclose(file);
    if (both)
      check_good(); /* as older versions wrote it */
    else
      check_damaged("the list of its checksums");
    put_back(bytes, size);
  }
  free(bytes);
}
END_TEST

/* A script opens a file, labels what is there, adds groups and datasets. */
START_TEST(what_is_added) {
  const double mine = 42;
  hid_t file = open_to_change();
  H5Fclose(file);
  check_good();
  file = open_to_change();
  struct rad_hdf h = {.file = file, .memory = -1};
  static const char *const group[] = {"/", "/polyrad", "/polyrad/triangles", "/VTKHDF/CellData"};
  for (int k = 0; k < 4; k++) {
    const hid_t at = H5Gopen2(file, group[k], H5P_DEFAULT);
    rad_hdf_set_real(&h, at, "mine", mine);
    rad_hdf_set_text(&h, at, "remark", "a text for the heap");
    rad_hdf_array(
        &h, at, &(struct rad_hdf_array){"added", "1", "by a script", RAD_HDF_REAL, 1, {1}, &mine});
    rad_hdf_group_close(&h, rad_hdf_group(&h, at, "more"));
    H5Gclose(at);
  }
  const hid_t rho = H5Dopen2(file, "/polyrad/triangles/rho", H5P_DEFAULT);
  rad_hdf_set_text(&h, rho, "remark", "measured");
  H5Dclose(rho);
  ck_assert_msg(!h.failed, "%s", h.cause);
  rad_hdf_texts_free(h.content, (int)h.n_content);
  H5Fclose(file);
  check_good();
}
END_TEST

/* Objects in other places of the file; h5repack is for tests/cli. */
START_TEST(another_place) {
  hid_t file = open_to_change();
  ck_assert(H5Ocopy(file, "VTKHDF", file, "copy", H5P_DEFAULT, H5P_DEFAULT) >= 0);
  ck_assert(H5Ldelete(file, "VTKHDF", H5P_DEFAULT) >= 0);
  ck_assert(H5Lmove(file, "copy", file, "VTKHDF", H5P_DEFAULT, H5P_DEFAULT) >= 0);
  H5Fclose(file);
  check_good();
  file = open_to_change();
  change_dataset(file, "/VTKHDF/Points");
  H5Fclose(file);
  check_damaged("/VTKHDF/Points");
}
END_TEST

/* A bit of the file: found, or where nothing is. */
START_TEST(any_bit) {
  enum { N_BIT = 150 };
  const char *given = getenv("POLYRAD_TEST_SEED");
  const uint64_t seed = given ? strtoull(given, NULL, 10) : (uint64_t)time(NULL) % 1000000;
  size_t size;
  char *bytes = slurp(path, &size), *whole = NULL;
  struct rad_error e;
  int n_found = 0;
  ck_assert_int_eq(rad_result_describe(path, &whole, &e), RAD_OK);
  for (uint64_t k = 0; k < N_BIT; k++) {
    const uint64_t random = rad_scramble(seed * N_BIT + k), at = random / 8 % size;
    char *text = NULL;
    bytes[at] ^= (char)(1 << random % 8);
    put_back(bytes, size);
    const enum rad_code code = rad_result_describe(path, &text, &e);
    n_found += code == RAD_ESYSTEM;
    ck_assert_msg(code == RAD_ESYSTEM || (code == RAD_OK && !strcmp(text, whole)),
                  "seed %llu, bit %llu of byte %llu", (unsigned long long)seed,
                  (unsigned long long)random % 8, (unsigned long long)at);
    bytes[at] ^= (char)(1 << random % 8);
    free(text);
  }
  ck_assert_int_gt(n_found, N_BIT / 2);
  free(whole);
  free(bytes);
}
END_TEST

int main(void) {
  const TTest *const test[] = {list_is_whole, every_object,  what_is_gone,
                               what_is_added, another_place, any_bit};
  Suite *suite = suite_create("contents");
  TCase *all = tcase_create("all");
  tcase_add_checked_fixture(all, begin, folder_remove);
  tcase_set_timeout(all, 300);
  for (size_t k = 0; k < sizeof test / sizeof *test; k++)
    tcase_add_test(all, test[k]);
  suite_add_tcase(suite, all);
  return run_suite(suite);
}
