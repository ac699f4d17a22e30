/* The median of a benchmark's repeats. */
#ifndef POLYRAD_BENCH_MEDIAN_H
#define POLYRAD_BENCH_MEDIAN_H

#include <stdlib.h>

static inline int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Sorts x [n]. */
static inline double median(double *x, int n) {
  qsort(x, (size_t)n, sizeof *x, ascending);
  return n % 2 ? x[n / 2] : 0.5 * (x[n / 2 - 1] + x[n / 2]);
}

#endif
