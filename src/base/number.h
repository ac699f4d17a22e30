/* Decimal numbers in files. */
#ifndef RAD_BASE_NUMBER_H
#define RAD_BASE_NUMBER_H

#include <stdbool.h>
#include <stddef.h>

/**
 * Read all of text[0..n) as a decimal number: 1, -0.5, .5, 1., 1e-3, and Fortran's 1d-3.
 *
 * The nearest double, in every locale. Fast for up to 15 digits and small exponents.
 *
 * @param[out] value  untouched on failure
 * @return false for anything else (0x10, inf, nan, blanks), for numbers that are not finite as
 *         doubles, and for 128 characters or more
 */
bool rad_number_parse(const char *text, size_t n, double *value);

/**
 * Write `value +- error` with as many digits as the error leaves: 0.1360 +- 0.0012.
 *
 * The error has two digits and is rounded up, so that it covers the rounding of the value too. An
 * error of 0 stands for exact numbers, which are written alone; NAN is written as ?.
 */
void rad_number_with_error(double value, double error, char *text, size_t size);

/* The whole number of at most nine digits at *text, which moves behind it; -1 if there is none, or
 * one of more digits. No sign, no blanks. */
int rad_whole_parse(const char **text);

#endif
