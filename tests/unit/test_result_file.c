/* Result files: errors of the disk, tables of studies, and the description. */
#include <check.h>
#include <errno.h>
#include <hdf5.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "result_help.h"
#include "suite.h"

/* bytes: limit of files while it writes. Check's own messages go to a file as well: nothing is
 * asserted under the limit. */
static void check_refusal_within(rlim_t bytes, const char *path, const char *cause,
                                 const char *remedy) {
  struct rad_error e = {0};
  struct fixture *f = make(1, 2000);
  struct rlimit limit;
  getrlimit(RLIMIT_FSIZE, &limit);
  const struct rlimit small = {bytes, limit.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  enum rad_code code = rad_result_write(path, &f->result, STARTED, &e);
  setrlimit(RLIMIT_FSIZE, &limit);
  ck_assert_int_eq(code, RAD_ESYSTEM);
  ck_assert_int_eq(e.code, RAD_ESYSTEM);
  ck_assert_msg(strstr(e.text, path) && strstr(e.text, cause) && strstr(e.text, remedy), "%s",
                e.text);
  ck_assert_msg(!strchr(e.text, '\n'), "%s", e.text);
  discard(f);
}

static void check_refusal(const char *path, const char *cause, const char *remedy) {
  check_refusal_within(RLIM_INFINITY, path, cause, remedy);
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
  FILE *old = fopen(in_folder("a.vtkhdf", path), "w");
  fputs("precious", old);
  fclose(old);
  signal(SIGXFSZ, SIG_IGN);
  static const rlim_t bytes[] = {1, 1000, 20000};
  for (int k = 0; k < 3; k++) {
    check_refusal_within(bytes[k], path, strerror(EFBIG), "ulimit -f");
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
  const TTest *const test[] = {test_missing_folder,  test_not_permitted, test_disk_full,
                               test_device,          test_study,         test_describe,
                               test_describe_refuses};
  Suite *suite = suite_create("result file");
  TCase *all = tcase_create("all");
  tcase_add_checked_fixture(all, folder_make, folder_remove);
  tcase_set_timeout(all, 60);
  for (size_t k = 0; k < sizeof test / sizeof *test; k++)
    tcase_add_test(all, test[k]);
  suite_add_tcase(suite, all);
  return run_suite(suite);
}
