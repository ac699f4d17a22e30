/* exp for `omp simd` loops: branch-free, same bits in vector and scalar code of one instruction
 * set. glibc offers its vector exp under -ffast-math only, which this project does not use. */
#ifndef RAD_BASE_SIMD_MATH_H
#define RAD_BASE_SIMD_MATH_H

#include <stdint.h>
#include <string.h>

#if defined(__x86_64__) && defined(__linux__) && !defined(RAD_NO_CLONES)
#define RAD_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define RAD_CLONES
#endif

/**
 * exp(x) for |x| <= 600, relative error below 4e-16.
 *
 * x = n ln 2 + f, |f| <= ln(2)/2; Taylor to degree 13 (remainder 2e-17); 2^n from the exponent
 * bits.
 */
static inline double rad_exp(double x) {
  const double shift = 6755399441055744.0; /* 1.5 * 2^52: its low bits hold the rounded integer */
  double k = x * 1.4426950408889634 + shift;
  int64_t bits;
  memcpy(&bits, &k, sizeof bits);
  double n = k - shift;
  double f = (x - n * 0.693147180369123816490) - n * 1.90821492927058770002e-10;
  double p = 1.0 / 6227020800.0;
  p = p * f + 1.0 / 479001600.0;
  p = p * f + 1.0 / 39916800.0;
  p = p * f + 1.0 / 3628800.0;
  p = p * f + 1.0 / 362880.0;
  p = p * f + 1.0 / 40320.0;
  p = p * f + 1.0 / 5040.0;
  p = p * f + 1.0 / 720.0;
  p = p * f + 1.0 / 120.0;
  p = p * f + 1.0 / 24.0;
  p = p * f + 1.0 / 6.0;
  p = p * f + 0.5;
  p = p * f * f + f + 1.0;
  int64_t scale = (int64_t)((uint64_t)(bits + 1023) << 52);
  double two_n;
  memcpy(&two_n, &scale, sizeof two_n);
  return p * two_n;
}

#endif
