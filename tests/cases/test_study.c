/* The paper's tables, recomputed: errors of a sweep against its last run, from the decks in
 * inputs/. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/command.h"
#include "app/grid.h"
#include "suite.h"

#ifndef POLYRAD_INPUTS
#error "POLYRAD_INPUTS: the folder of the decks"
#endif

/* Runs a study and reads unknowns and errors from its printed table. */
static int table(const char *deck, int n_set, const char *const *set, double (*row)[2], int most) {
  char path[4096], line[1024];
  snprintf(path, sizeof path, "%s/%s", POLYRAD_INPUTS, deck);
  struct rad_command c = {.verb = "study",
                          .deck = path,
                          .output = "/dev/null",
                          .n_set = n_set,
                          .line = "",
                          .out = tmpfile(),
                          .log = stderr};
  for (int i = 0; i < n_set; i++)
    c.set[i] = set[i];
  struct rad_error e;
  enum rad_code code = rad_app_study(&c, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
  rewind(c.out);
  int n = 0;
  while (fgets(line, sizeof line, c.out) && n < most) {
    double key;
    row[n][1] = 0; /* the reference prints "-" */
    n += sscanf(line, "%lf %lf %lf", &key, &row[n][0], &row[n][1]) >= 2;
  }
  fclose(c.out);
  return n;
}

static void hold(const char *what, const double (*row)[2], int n, const double *unknowns,
                 const double *error, double tolerance) {
  for (int i = 0; i < n; i++) {
    ck_assert_double_eq(row[i][0], unknowns[i]);
    if (error[i] > 0)
      ck_assert_msg(fabs(row[i][1] / error[i] - 1) <= tolerance,
                    "%s, row %d: error %.6e, expected %.6e", what, i, row[i][1], error[i]);
  }
}

START_TEST(cube_corner_without_grading) {
  static const double unknowns[] = {72, 288, 1152, 4608, 18432};
  static const double error[] = {2.72059e-2, 1.26344e-2, 5.68040e-3, 2.01127e-3, 0};
  static const char *const set[] = {"study.vary.method.elements=[1,2,4,8,16]"};
  double row[8][2];
  ck_assert_int_eq(table("studies/cube_corner_p1.yml", 1, set, row, 8), 5);
  hold("S1, p = 1", (const double(*)[2])row, 5, unknowns, error, 0.002);
}
END_TEST

/* The paper's tables against its own finest meshes, as an independent program recomputed them
 * (shared/reference/paper.json). That has four digits in most entries; asked for: 0.3 %. */
struct paper_table {
  const char *name, *deck;
  int n_set, n;
  const char *set[2];
  double unknowns[6], error[6];
};

static const struct paper_table paper[] = {
    {"Table 4.2",
     "studies/cube_corner_p1.yml",
     0,
     6,
     {NULL},
     {72, 288, 1152, 4608, 18432, 73728},
     {0.02833175, 0.01376113, 0.006807135, 0.003211537, 0.001200269, 0}},
    {"Table 4.3",
     "studies/cube_corner_p2.yml",
     0,
     5,
     {NULL},
     {72, 576, 3168, 16272, 77760},
     {0.02956264, 0.01279864, 0.005023219, 0.00129565, 0}},
    {"Table 4.6",
     "studies/wedge_p1.yml",
     0,
     6,
     {NULL},
     {72, 288, 1152, 4608, 18432, 73728},
     {0.134305, 0.0651203, 0.0387982, 0.0210788, 0.00841548, 0}},
    {"S2, exchanged",
     "studies/wedge_p1.yml",
     2,
     6,
     {"scene.triangles.0.emission=0.2", "scene.triangles.1.emission=1"},
     {72, 288, 1152, 4608, 18432, 73728},
     {0.10039, 0.0506772, 0.0312108, 0.0164566, 0.00649223, 0}},
};

START_TEST(paper_tables) {
  const struct paper_table *t = &paper[_i];
  double row[8][2];
  ck_assert_int_eq(table(t->deck, t->n_set, t->set, row, 8), t->n);
  hold(t->name, (const double(*)[2])row, t->n, t->unknowns, t->error, 0.0005);
}
END_TEST

START_TEST(order_formula) {
  /* Table 4.2: EOC .99 .90 .81 .73 from the ratios 2.06 2.02 2.11 2.66 against N = 32 */
  static const double ratio[] = {2.06, 2.02, 2.11, 2.66}, eoc[] = {0.99, 0.90, 0.81, 0.73};
  for (int i = 0; i < 4; i++)
    ck_assert_double_eq_tol(rad_eoc(1 << i, 2 << i, 32, ratio[i]), eoc[i], 0.012);
  ck_assert_double_eq_tol(rad_eoc(2, 4, INFINITY, 8), 3, 1e-6);
  ck_assert(isnan(rad_eoc(4, 2, INFINITY, 8)));
  ck_assert(isnan(rad_eoc(1, 2, 32, NAN)));
}
END_TEST

int main(void) {
  Suite *s = suite_create("study");
  TCase *c = tcase_create("study");
  tcase_set_timeout(c, 600);
  tcase_add_test(c, cube_corner_without_grading);
  tcase_add_loop_test(c, paper_tables, 0, sizeof paper / sizeof *paper);
  tcase_add_test(c, order_formula);
  suite_add_tcase(s, c);
  return run_suite(s);
}
