/* Progress lines where there is no terminal; on one they are tested by tests/cli. */
#include <check.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/progress.h"
#include "suite.h"

static char text[1 << 16];

static struct rad_progress begin(double first, double every) {
  struct rad_progress p;
  rad_progress_init(&p, tmpfile());
  ck_assert(p.out && !p.terminal && p.first == 60 && p.every == 60);
  p.every = every;
  atomic_store(&p.next, (int_fast64_t)(1e3 * first));
  return p;
}

static const char *written(struct rad_progress *p) {
  rewind(p->out);
  text[fread(text, 1, sizeof text - 1, p->out)] = 0;
  fclose(p->out);
  return text;
}

START_TEST(null_is_silence) {
  rad_progress_run(NULL, 1, 2);
  rad_progress_phase(NULL, "matrix");
  rad_progress_begin(NULL, "blocks", 3);
  rad_progress_add(NULL, 1);
  rad_progress_clear(NULL);
}
END_TEST

START_TEST(nothing_before_its_time) {
  struct rad_progress p = begin(60, 60);
  rad_progress_phase(&p, "matrix");
  rad_progress_begin(&p, "blocks", 1000);
  for (int i = 0; i < 1000; i++)
    rad_progress_add(&p, 1);
  rad_progress_clear(&p);
  ck_assert_str_eq(written(&p), "");
}
END_TEST

START_TEST(one_line_at_a_time) {
  struct rad_progress p = begin(0, 60);
  rad_progress_run(&p, 2, 5);
  rad_progress_phase(&p, "level %d, matrix", 3); /* the first line */
  rad_progress_begin(&p, "blocks", 5000);
  p.begin -= 1; /* as if a second ago; more if the machine is busy with something else */
  rad_progress_add(&p, 1249);
  atomic_store(&p.next, 0);
  rad_progress_add(&p, 1);
  rad_progress_add(&p, 1);
  unsigned rate, left;
  double memory;
  char *line = strchr(written(&p), '\n') + 1;
  ck_assert_msg(!strncmp(text, "progress: run 2 of 5, level 3, matrix; ", 39), "%s", text);
  ck_assert_int_eq(sscanf(line,
                          "progress: run 2 of 5, level 3, matrix: 1250 of 5000 blocks (25 %%), "
                          "%u/s, %u s left; %*[^,], %lf GB\n",
                          &rate, &left, &memory),
                   3);
  ck_assert_uint_le(rate, 1250);
  ck_assert_double_eq_tol(left, 3750.0 / rate, 0.6 + 3750.0 / rate / rate);
  ck_assert_ptr_eq(strchr(line, '\n')[1] ? line : NULL, NULL); /* and no third */
}
END_TEST

/* Nothing is lost, and lines are whole, however many threads count. */
START_TEST(threads_count_together) {
  enum { TOTAL = 200000 };
  struct rad_progress p = begin(0, 0.002), *q = &p;
  rad_progress_phase(q, "estimate");
  rad_progress_begin(q, "points", TOTAL);
#pragma omp parallel for num_threads(4) default(none) shared(q)
  for (int i = 0; i < TOTAL; i++)
    rad_progress_add(q, 1);
  ck_assert_int_eq(atomic_load(&p.done), TOTAL);
  written(&p);
  int n = 0;
  for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n"), n++)
    ck_assert_msg(!strncmp(line, "progress: estimate", 18) &&
                      !strcmp(line + strlen(line) - 3, " GB"),
                  "%s", line);
  ck_assert_int_ge(n, 1);
}
END_TEST

int main(void) {
  Suite *s = suite_create("progress");
  TCase *t = tcase_create("log");
  tcase_add_test(t, null_is_silence);
  tcase_add_test(t, nothing_before_its_time);
  tcase_add_test(t, one_line_at_a_time);
  tcase_add_test(t, threads_count_together);
  suite_add_tcase(s, t);
  return run_suite(s);
}
