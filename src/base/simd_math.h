/* exp and atan2 for `omp simd` loops: branch-free, same bits in vector and scalar code of one
 * instruction set. glibc offers its vector functions under -ffast-math only, which this project
 * does not use. */
#ifndef RAD_BASE_SIMD_MATH_H
#define RAD_BASE_SIMD_MATH_H

#include <math.h>
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

#define RAD_TAN_PI_8 0.41421356237309503 /* sqrt(2) - 1 */

/* atan(z) / z of u = z^2 <= 1.001 tan(pi/8)^2, minimax polynomial: relative error below 3e-16, of
 * which 3.3e-17 is the polynomial's. */
static inline double rad_atan_ratio(double u) {
  double p = 0.021174971049058327259;
  p = p * u - 0.043515248542675381094;
  p = p * u + 0.056896431639359538522;
  p = p * u - 0.066405007921196689248;
  p = p * u + 0.076899867493632237693;
  p = p * u - 0.090907756390076815111;
  p = p * u + 0.11111106300826212902;
  p = p * u - 0.1428571418422230878;
  p = p * u + 0.19999999998899570863;
  p = p * u - 0.33333333333328674904;
  return p * u + 0.99999999999999996739;
}

/**
 * Angle of (x, y), y >= 0, in [0, pi], relative error below 5e-16; 0 for x = y = 0.
 *
 * With t = min(y, |x|) / max(y, |x|) <= 1: atan t for t <= tan(pi/8), else pi/4 +
 * atan((t-1)/(t+1)); then pi/2 minus it if y > |x|, and pi minus it if x < 0. One division.
 */
static inline double rad_atan2(double y, double x) {
  double across = fabs(x);
  double low = y < across ? y : across, high = y < across ? across : y;
  int steep = low > RAD_TAN_PI_8 * high;
  double above = steep ? low - high : low, below = steep ? low + high : high;
  double z = above / (below > 0 ? below : 1);
  double angle = z * rad_atan_ratio(z * z) + (steep ? 0.78539816339744831 : 0);
  angle = y > across ? 6.123233995736766e-17 - angle + 1.5707963267948966 : angle;
  return x < 0 ? 1.2246467991473532e-16 - angle + 3.1415926535897931 : angle;
}

#endif
