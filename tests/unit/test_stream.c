/* Products with small matrices against sums in long double, up to the last byte of their pages. */
#include <check.h>
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "scene_help.h"
#include "suite.h"
#include "system/stream.h"

enum { ROWS = 150, COLUMNS = 40, ROOM = ROWS * COLUMNS };

/* A, single and double, x and y; A's last number is the last of its pages' bytes. */
struct sample {
  size_t m, n, bytes;
  double *pages, *a, x[ROOM], y[ROWS];
  float *narrow_pages, *narrow;
};

static void begin(struct sample *s, size_t m, size_t n) {
  s->m = m;
  s->n = n;
  s->bytes = 1 << 16;
  s->pages = rad_pages_alloc(s->bytes);
  s->narrow_pages = rad_pages_alloc(s->bytes);
  ck_assert(s->pages && s->narrow_pages);
  s->a = s->pages + s->bytes / sizeof *s->a - m * n;
  s->narrow = s->narrow_pages + s->bytes / sizeof *s->narrow - m * n;
  for (size_t i = 0; i < m * n; i++)
    s->narrow[i] = (float)(s->a[i] = uniform(-1, 1));
  for (size_t i = 0; i < ROWS; i++)
    s->y[i] = s->x[i] = uniform(-1, 1);
}

static void release(struct sample *s) {
  rad_pages_free(s->pages, s->bytes);
  rad_pages_free(s->narrow_pages, s->bytes);
}

/* Rounding of a sum of n products of numbers below 1, with one more at the end. */
static double rounding(size_t n) {
  return 1.2e-16 * (double)(n + 2) * (double)(n + 1);
}

START_TEST(rows_of_all_counts) {
  start_random();
  for (size_t m = 1; m <= ROWS; m++)
    for (size_t n = 0; n <= COLUMNS; n += 1 + m % 3) {
      struct sample s;
      double y[ROWS], narrow[ROWS];
      begin(&s, m, n);
      memcpy(y, s.y, sizeof y);
      memcpy(narrow, s.y, sizeof y);
      rad_add_product(m, n, s.a, s.x, y);
      rad_add_product_narrow(m, n, s.narrow, s.x, narrow);
      for (size_t r = 0; r < m; r++) {
        long double exact = s.y[r], single = s.y[r];
        for (size_t c = 0; c < n; c++) {
          exact += (long double)s.a[c * m + r] * s.x[c];
          single += (long double)s.narrow[c * m + r] * s.x[c];
        }
        ck_assert_msg(fabsl(y[r] - exact) <= rounding(n), "%zu x %zu, seed %llu", m, n, seed());
        ck_assert_msg(fabsl(narrow[r] - single) <= rounding(n), "%zu x %zu", m, n);
      }
      for (size_t r = m; r < ROWS; r++) /* nothing beyond is touched */
        ck_assert(y[r] == s.y[r] && narrow[r] == s.y[r]);
      release(&s);
    }
}
END_TEST

START_TEST(transposed) {
  start_random();
  for (size_t m = 1; m <= ROWS; m++)
    for (size_t n = 1; n <= COLUMNS; n += 1 + m % 3) {
      struct sample s;
      double y[COLUMNS + 1] = {0};
      begin(&s, m, n);
      s.x[m] = NAN; /* not read */
      rad_set_transposed(m, n, s.a, s.x, y);
      for (size_t c = 0; c < n; c++) {
        long double exact = 0;
        for (size_t r = 0; r < m; r++)
          exact += (long double)s.a[c * m + r] * s.x[r];
        ck_assert_msg(fabsl(y[c] - exact) <= rounding(m), "%zu x %zu, seed %llu", m, n, seed());
      }
      ck_assert(y[n] == 0);
      release(&s);
    }
}
END_TEST

int main(void) {
  Suite *suite = suite_create("stream");
  TCase *c = tcase_create("products");
  tcase_add_test(c, rows_of_all_counts);
  tcase_add_test(c, transposed);
  tcase_set_timeout(c, 60);
  suite_add_tcase(suite, c);
  return run_suite(suite);
}
