/* A matrix in parts: every unit has one owner, joined parts are the whole one to the last bit, and
 * what does not belong together is refused. */
#include <check.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "app/checkpoint.h"
#include "checkpoint_help.h"
#include "suite.h"

enum { MOST_PARTS = 5 };

static const char *part_path(int i) {
  static char name[MOST_PARTS][80];
  snprintf(name[i], sizeof name[i], "%s/part_%d.h5", folder, i);
  return name[i];
}

static void write_part(const struct deck_text *d, int number, int n, const char *name) {
  struct rad_case c;
  struct rad_error e;
  const struct rad_part_number part = {number, n};
  ck_assert_msg(deck_prepare(d, &c, &e) == RAD_OK, "%s", e.text);
  ck_assert_msg(rad_case_write_part(&c, part, name, "test", 0, &e) == RAD_OK, "%s", e.text);
  rad_case_free(&c);
}

static const struct {
  int problem, n;
} part_runs[] = {{0, 1}, {0, 2}, {0, 4}, {1, 1}, {1, 2}, {1, 4}, {4, 1},
                 {4, 2}, {4, 4}, {2, 3}, {3, 4}, {5, 3}, {6, 2}, {6, MOST_PARTS}};

/* Assembled in parts, read in the wrong order: the same matrix, solution and counters. */
START_TEST(in_parts) {
  struct deck_text *d = deck_of(&problems[part_runs[_i].problem]);
  const char *name[MOST_PARTS];
  struct rad_case a, b;
  struct rad_error e;
  int n = part_runs[_i].n;
  begin_folder();
  for (int i = 0; i < n; i++) {
    name[n - 1 - i] = part_path(i);
    write_part(d, i + 1, n, part_path(i));
  }
  solve(d, NULL, &a);
  ck_assert_int_eq(deck_prepare(d, &b, &e), RAD_OK);
  ck_assert_msg(rad_case_join(&b, n, name, &e) == RAD_OK, "%s", e.text);
  ck_assert_msg(rad_case_solve(&b, &e) == RAD_OK, "%s", e.text);
  check_same(&a, &b);
  check_counters(&a, &b);
  for (int i = 0; i < n; i++)
    ck_assert_int_eq(unlink(name[i]), 0);
  rad_case_free(&a);
  rad_case_free(&b);
  free(d);
  end_folder();
}
END_TEST

/* Every unit has one owner, whatever the number of parts. */
START_TEST(parts_cover) {
  struct deck_text *d = deck_of(&problems[_i]);
  struct rad_case c;
  struct rad_error e;
  ck_assert_int_eq(deck_prepare(d, &c, &e), RAD_OK);
  ck_assert_int_eq(rad_case_begin_matrix(&c, &e), RAD_OK);
  for (int n = 1; n < 40; n += 3) {
    int at = 0, end = c.dense.done ? c.mesh->n_point : c.h2.tree.n_cluster;
    for (int i = 1; i <= n; i++) {
      const struct rad_part_number p = {i, n};
      struct rad_part_range r =
          c.dense.done ? rad_part_columns(&c.dense, p) : rad_part_clusters(&c.h2, p);
      ck_assert_int_le(r.first, r.end);
      if (r.first < r.end)
        ck_assert_int_eq(r.first, at);
      at = r.first < r.end ? r.end : at;
    }
    ck_assert_int_eq(at, end);
  }
  rad_case_free(&c);
  free(d);
}
END_TEST

static void check_parts_refused(struct rad_case *c, int n, const char *const *name,
                                enum rad_code code, const char *words) {
  struct rad_error e = {0};
  ck_assert_int_eq(rad_case_join(c, n, name, &e), code);
  ck_assert_msg(strstr(e.text, words) && !strchr(e.text, '\n'), "%s", e.text);
}

/* Missing, given twice, of another number, of another form, of another deck, damaged. */
START_TEST(parts_refused) {
  struct deck_text *d = deck_of(&problems[6]), *other = deck_of(&problems[0]);
  struct rad_case c;
  struct rad_error e;
  begin_folder();
  for (int i = 0; i < 3; i++)
    write_part(d, i + 1, 3, part_path(i));
  write_part(d, 1, 2, part_path(3));
  write_part(other, 2, 3, part_path(4));
  const char *name[] = {part_path(0), part_path(1), part_path(2)};
  ck_assert_int_eq(deck_prepare(d, &c, &e), RAD_OK);
  check_parts_refused(&c, 2, name, RAD_EINPUT, "part 3 of 3 is missing");
  name[2] = name[0];
  check_parts_refused(&c, 3, name, RAD_EINPUT, "part_0.h5 are both part 1 of 3");
  name[2] = part_path(3);
  check_parts_refused(&c, 3, name, RAD_EINPUT, "part_3.h5 one of 2");
  name[2] = part_path(4);
  check_parts_refused(&c, 3, name, RAD_EINPUT, "part_4.h5 was made from another deck");
  ck_assert_int_eq(truncate(part_path(2), 600), 0);
  name[2] = part_path(2);
  check_parts_refused(&c, 3, name, RAD_ESYSTEM, "part_2.h5 is damaged");
  save(&c);
  name[2] = path;
  check_parts_refused(&c, 3, name, RAD_ESYSTEM, "run.ck is not a polyrad part");
  for (int i = 0; i < MOST_PARTS; i++)
    unlink(part_path(i));
  rad_case_free(&c);
  free(d);
  free(other);
  end_folder();
}
END_TEST

int main(void) {
  Suite *s = suite_create("parts");
  TCase *c = tcase_create("parts");
  tcase_set_timeout(c, 300);
  tcase_add_loop_test(c, in_parts, 0, sizeof part_runs / sizeof *part_runs);
  tcase_add_loop_test(c, parts_cover, 0, N_PROBLEM);
  tcase_add_test(c, parts_refused);
  suite_add_tcase(s, c);
  return run_suite(s);
}
