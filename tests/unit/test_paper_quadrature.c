/* The paper's Table 3.1: points of the trapezoidal rule for a nearly singular integral, with and
 * without its transformation. The exact integral is evaluated in quadruple precision. */
#include <check.h>
#include <math.h>
#include <quadmath.h>
#include <stdio.h>

#include "paper_map.h"
#include "suite.h"

enum { N_A = 21, MOST = 20 };

static const double eps[3] = {1e-2, 1e-4, 1e-6};

/* Printed: [eps][a = -0.5, -0.4 .. 1.5] with the transformation, and plain; 21 stands for ">20". */
static const int with_map[3][N_A] = {
    {14, 14, 13, 13, 12, 7, 13, 11, 10, 10, 10, 10, 10, 11, 13, 7, 12, 13, 13, 14, 14},
    {14, 14, 13, 13, 12, 10, 9, 9, 9, 9, 9, 9, 9, 9, 9, 10, 12, 13, 13, 14, 14},
    {14, 14, 13, 13, 12, 12, 10, 10, 10, 10, 10, 10, 10, 10, 10, 12, 12, 13, 13, 14, 14}};
static const int plain[3][N_A] = {
    {17, 17, 17, 18, 19, 11, 13, 11, 11, 11, 11, 11, 11, 11, 13, 11, 19, 18, 17, 17, 17},
    {17, 17, 17, 18, 19, 18, 18, 18, 18, 18, 18, 18, 18, 18, 18, 18, 19, 18, 17, 17, 17},
    {17, 17, 17, 18, 19, 21, 21, 21, 21, 21, 21, 21, 21, 21, 21, 21, 19, 18, 17, 17, 17}};

/* int_0^1 e / ((x-a)^2 + e^2)^2 dx = [s / (2 e (s^2+e^2)) + atan(s/e) / (2 e^2)], s = x - a: 18
 * digits cancel outside [0, 1]. */
static double exact(double a, double e) {
  __float128 low = -(__float128)a, high = 1 - (__float128)a, q = e;
  __float128 end = high / (2 * q * (high * high + q * q)) + atanq(high / q) / (2 * q * q);
  return (double)(end - low / (2 * q * (low * low + q * q)) - atanq(low / q) / (2 * q * q));
}

static double value(double a, double e, const struct paper_map *m, double y) {
  double slope = 1, d = (m ? paper_map_at(m, y, &slope) : y) - a;
  return slope * e / ((d * d + e * e) * (d * d + e * e));
}

/* T_K, K = 0 .. MOST: trapezoidal sums with 2^K intervals, each from the one before. */
static void sums(double a, double e, const struct paper_map *m, double t[MOST + 1]) {
  t[0] = 0.5 * (value(a, e, m, 0) + value(a, e, m, 1));
  for (int k = 1; k <= MOST; k++) {
    long n = 1L << (k - 1);
    double sum = 0;
    for (long i = 0; i < n; i++)
      sum += value(a, e, m, (i + 0.5) / (double)n);
    t[k] = 0.5 * (t[k - 1] + sum / (double)n);
  }
}

/* The transformation as it was used: q = 3 for a outside (0, 1), where (3.34) would give 1 for
 * |a| > 0.3, no transformation at all, and ln(eps)/ln(0.3) at the ends. */
static struct paper_map map_used(double a, double e) {
  struct paper_map m = paper_map(a, e);
  if (a <= 0 || a >= 1) {
    m.q = 3;
    m.alpha1 = 1;
    m.alpha2 = a <= 0 ? 0 : 1;
  }
  return m;
}

/* (3.36): the least K with |I - T_K| < 1e-8 I. */
static int by_definition(const double t[MOST + 1], double exact_value) {
  int k = 1;
  while (k <= MOST && fabs(t[k] - exact_value) >= 1e-8 * exact_value)
    k++;
  return k;
}

/* What the printed numbers are: one more than the least K with |T_K - T_{K-1}| < 1e-8 T_K, where a
 * program that doubles its points stops without knowing I. */
static int by_doubling(const double t[MOST + 1]) {
  int k = 1;
  while (k < MOST && fabs(t[k] - t[k - 1]) >= 1e-8 * t[k])
    k++;
  return k + 1;
}

START_TEST(table_3_1) {
  for (int i = 0; i < N_A; i++) {
    double a = (i - 5) / 10.0, e = eps[_i], t[MOST + 1], v = exact(a, e);
    struct paper_map m = map_used(a, e);
    sums(a, e, &m, t);
    int k = by_doubling(t), least = by_definition(t, v);
    ck_assert_msg(k == with_map[_i][i], "eps %g, a %g: %d, printed %d", e, a, k, with_map[_i][i]);
    ck_assert_msg(least == k - 1 || least == k - 2, "eps %g, a %g: %d by (3.37), %d", e, a, least,
                  k);
    sums(a, e, NULL, t);
    k = by_doubling(t);
    ck_assert_msg(k == plain[_i][i], "plain, eps %g, a %g: %d, printed %d", e, a, k, plain[_i][i]);
  }
}
END_TEST

/* As printed, (3.34) has q = 1 at a = -0.5: not the 14 against 17 of the table. */
START_TEST(exponent_as_printed) {
  struct paper_map m = paper_map(-0.5, 1e-4);
  ck_assert_int_eq(m.q, 1);
  ck_assert_int_eq(paper_map(0.5, 1e-4).q, 9);
  ck_assert_int_eq(paper_odd(7.65), 9);
  ck_assert_int_eq(paper_odd(7), 7);
  for (int k = 0; k <= 10; k++) { /* onto [0, 1], increasing, with the right slope */
    double slope, slope2, y = k / 10.0;
    m = paper_map(0.3, 1e-3);
    double x = paper_map_at(&m, y, &slope), x2 = paper_map_at(&m, y + 1e-6, &slope2);
    ck_assert_double_eq_tol((x2 - x) / 1e-6, 0.5 * (slope + slope2), 1e-6);
    if (k % 10 == 0)
      ck_assert_double_eq_tol(x, y, 1e-14);
  }
}
END_TEST

int main(void) {
  Suite *s = suite_create("paper quadrature");
  TCase *c = tcase_create("table 3.1");
  tcase_set_timeout(c, 120);
  tcase_add_loop_test(c, table_3_1, 0, 3);
  tcase_add_test(c, exponent_as_printed);
  suite_add_tcase(s, c);
  return run_suite(s);
}
