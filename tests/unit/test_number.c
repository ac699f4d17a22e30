/* Values with errors as text: what is printed covers what is meant. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "suite.h"

enum { SEED = 20261130 };

static double uniform(double low, double high) {
  return low + (high - low) * (rand() / (RAND_MAX + 1.0));
}

START_TEST(examples) {
  static const struct {
    double value, error;
    const char *text;
  } list[] = {{0.13599, 0.00115, "0.1360 +- 0.0012"},
              {-58.0949, 0.0096, "-58.0949 +- 0.0097"},
              {100, 0, "100"},
              {2.5, NAN, "2.5 +- ?"},
              {1.234e9, 5.6e6, "1234000000 +- 5700000"},
              {0.18, 0.999, "0.2 +- 1.1"}};
  char text[64];
  for (size_t k = 0; k < sizeof list / sizeof *list; k++) {
    rad_number_with_error(list[k].value, list[k].error, text, sizeof text);
    ck_assert_str_eq(text, list[k].text);
  }
}
END_TEST

/* The interval that is printed holds the interval that is meant, and is not much wider. */
START_TEST(covers) {
  srand(SEED);
  for (int k = 0; k < 100000; k++) {
    double value = uniform(-1, 1) * pow(10, uniform(-12, 12));
    double error = fabs(value) * pow(10, uniform(-14, 3));
    char text[64];
    rad_number_with_error(value, error, text, sizeof text);
    char *sign = strstr(text, " +- ");
    ck_assert_msg(sign != NULL, "seed %d: %.17g, %.17g: '%s'", SEED, value, error, text);
    double v = strtod(text, NULL), e = strtod(sign + 4, NULL);
    ck_assert_msg(fabs(v - value) + error <= e + 4e-16 * fabs(value), "seed %d: %.17g, %.17g: '%s'",
                  SEED, value, error, text);
    ck_assert_msg(e <= 1.3 * error + 4e-15 * fabs(value), "seed %d: %.17g, %.17g: '%s'", SEED,
                  value, error, text);
  }
}
END_TEST

int main(void) {
  Suite *s = suite_create("number");
  TCase *c = tcase_create("number");
  tcase_add_test(c, examples);
  tcase_add_test(c, covers);
  suite_add_tcase(s, c);
  return run_suite(s);
}
