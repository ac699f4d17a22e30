#define _GNU_SOURCE /* strtod_l */
#include "base/number.h"

#include <locale.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_NUMBER = 128, MAX_DIGIT = 19, MAX_EXACT = 22, MAX_EXPONENT = 100000 };

/* Exact in double, as are whole numbers up to 2^53: their product or quotient is rounded once. */
static const double power_of_ten[MAX_EXACT + 1] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                   1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                   1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

/* Append digits to *value, as long as they fit; *n counts them all. */
static const char *read_digits(const char *s, const char *end, uint64_t *value, int *n) {
  for (; s < end && *s >= '0' && *s <= '9'; s++, ++*n)
    if (*n < MAX_DIGIT)
      *value = *value * 10 + (uint64_t)(*s - '0');
  return s;
}

/* The exponent after its letter, or NULL. */
static const char *read_exponent(const char *s, const char *end, int *exponent) {
  int n = 0, negative = s < end && *s == '-';
  uint64_t value = 0;
  s = read_digits(s + (s < end && (*s == '-' || *s == '+')), end, &value, &n);
  *exponent = n > MAX_DIGIT || value > MAX_EXPONENT ? MAX_EXPONENT : (int)value;
  *exponent = negative ? -*exponent : *exponent;
  return n > 0 ? s : NULL;
}

static bool read_slowly(const char *text, size_t n, double *value) {
  char copy[MAX_NUMBER], *end = copy;
  memcpy(copy, text, n);
  copy[n] = '\0';
  size_t mark = strcspn(copy, "dD");
  if (mark < n)
    copy[mark] = 'e';
  locale_t c = newlocale(LC_ALL_MASK, "C", (locale_t)0); /* glibc: no allocation */
  if (!c)
    return false;
  double x = strtod_l(copy, &end, c);
  freelocale(c);
  if (end != copy + n || !isfinite(x))
    return false;
  *value = x;
  return true;
}

bool rad_number_parse(const char *text, size_t n, double *value) {
  const char *s = text, *end = text + n;
  uint64_t digits = 0;
  int n_digit = 0, n_whole, exponent = 0;
  if (n == 0 || n >= MAX_NUMBER)
    return false;
  s = read_digits(s + (*s == '-' || *s == '+'), end, &digits, &n_digit);
  n_whole = n_digit;
  if (s < end && *s == '.')
    s = read_digits(s + 1, end, &digits, &n_digit);
  if (n_digit == 0)
    return false;
  if (s < end && (*s == 'e' || *s == 'E' || *s == 'd' || *s == 'D'))
    s = read_exponent(s + 1, end, &exponent);
  if (s != end)
    return false;
  exponent -= n_digit - n_whole;
  if (n_digit > MAX_DIGIT || digits > (uint64_t)1 << 53 || abs(exponent) > MAX_EXACT)
    return read_slowly(text, n, value);
  double x = (double)digits;
  x = exponent < 0 ? x / power_of_ten[-exponent] : x * power_of_ten[exponent];
  *value = *text == '-' ? -x : x;
  return true;
}

/* Between these exponents of the last digit a number is written without one of its own. */
enum { LEAST_EXPONENT = -12, MOST_EXPONENT = 6, MOST_DIGITS = 15 };

void rad_number_with_error(double value, double error, char *text, size_t size) {
  if (!isfinite(value) || error == 0) {
    snprintf(text, size, "%.10g", value);
    return;
  }
  if (!isfinite(error)) {
    snprintf(text, size, "%.6g +- ?", value);
    return;
  }
  int last = (int)floor(log10(error)) - 1;          /* exponent of the last digit that is written */
  last += ceil(error / pow(10, last) + 0.5) >= 100; /* 9.97 is rounded up to 11, not to 10.0 */
  double unit = pow(10, last);
  double shown = ceil(error / unit + 0.5) * unit; /* and half a digit for the value's rounding */
  if (fabs(value) < 0.5 * unit)
    value = 0; /* and not -0 */
  if (last >= LEAST_EXPONENT && last <= MOST_EXPONENT) {
    int decimals = last < 0 ? -last : 0;
    double grid = fmax(unit, 1); /* zeros, not digits that mean nothing */
    value = last > 0 ? round(value / grid) * grid : value;
    snprintf(text, size, "%.*f +- %.*f", decimals, value, decimals, shown);
    return;
  }
  double most = fmax(fabs(value), error);
  int digits = (int)fmin(fmax(floor(log10(most)) - last, 0), MOST_DIGITS);
  snprintf(text, size, "%.*e +- %.1e", digits, value, shown);
}

int rad_whole_parse(const char **text) {
  enum { MOST = 9 };
  uint64_t value = 0;
  int n = 0;
  *text = read_digits(*text, *text + strlen(*text), &value, &n);
  return n > 0 && n <= MOST ? (int)value : -1;
}
