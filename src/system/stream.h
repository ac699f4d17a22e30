/* Products with small dense matrices that lie one after another in memory. */
#ifndef RAD_SYSTEM_STREAM_H
#define RAD_SYSTEM_STREAM_H

#include <stddef.h>

enum { RAD_MOST_COLUMNS = 1024 }; /* of a matrix that is summed at a time, and of a cluster */

/**
 * y [m] += A x; y [n] = A^T x with m <= RAD_MOST_COLUMNS. A [m, n] column-major, in double or
 * single precision, from pages with RAD_BEYOND bytes after their end (base/memory.h).
 */
void rad_add_product(size_t m, size_t n, const double *a, const double *x, double *y);
void rad_add_product_narrow(size_t m, size_t n, const float *a, const double *x, double *y);
void rad_set_transposed(size_t m, size_t n, const double *a, const double *x, double *y);

#endif
