/* The end of every test's main(). */
#ifndef POLYRAD_TEST_SUITE_H
#define POLYRAD_TEST_SUITE_H

#include <check.h>
#include <stdlib.h>

/* Run and free the suite; what main() returns. */
static inline int run_suite(Suite *suite) {
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_ENV);
  int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}

#endif
