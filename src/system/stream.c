#include "system/stream.h"

#include <string.h>

#include "base/memory.h"
#include "base/simd_math.h"

/* A matrix has 8 to 60 rows, and its numbers come from memory once, in the order in which they lie.
 * So what counts is to ask for them in time, and to lose nothing where the rows are no multiple of
 * a register: whole registers are read, beyond a column's end as well, and what does not belong to
 * it is dropped. */

#define INLINE static inline __attribute__((always_inline))

enum {
  AHEAD = 4096, /* bytes from where is read to what is asked for */
  LANES = 4,    /* numbers of a register */
  MOST = 16     /* registers of rows that are summed at a time */
};

_Static_assert(RAD_BEYOND >= LANES * sizeof(double), "a register from the last number on");

/* Four numbers at any address. Eight would suit AVX-512, but GCC 12 makes slow code of them where
 * registers are shorter. */
typedef double four __attribute__((vector_size(32), aligned(8)));

#define WIDE(at) (*(const four *)(at))
/* __builtin_convertvector would go through memory. */
#define NARROW(at) ((four){(at)[0], (at)[1], (at)[2], (at)[3]})

INLINE void fetch(const void *at, size_t bytes) {
  for (size_t i = 0; i < bytes; i += 64)
    __builtin_prefetch((const char *)at + i);
}

/* y [rows] += A x for k registers of rows, k a constant. Sums over even and over odd columns, as
 * far as there are registers for both: else each sum would wait for itself. */
#define ADD_BAND(name, type, load)                                                                 \
  INLINE void name(size_t stride, size_t n, const type *a, const double *x, double *y,             \
                   size_t rows, size_t k) {                                                        \
    four even[MOST], odd[MOST / 2];                                                                \
    double sum[LANES * MOST];                                                                      \
    size_t c = 0, both = 2 * k <= MOST;                                                            \
    for (size_t i = 0; i < k; i++)                                                                 \
      even[i] = (four){0};                                                                         \
    for (size_t i = 0; i < k * both; i++)                                                          \
      odd[i] = (four){0};                                                                          \
    for (; both && c + 2 <= n; c += 2, a += 2 * stride) {                                          \
      fetch(a + AHEAD / sizeof *a, 2 * rows * sizeof *a);                                          \
      for (size_t i = 0; i < k; i++)                                                               \
        even[i] += load(a + LANES * i) * x[c];                                                     \
      for (size_t i = 0; i < k * both; i++)                                                        \
        odd[i] += load(a + stride + LANES * i) * x[c + 1];                                         \
    }                                                                                              \
    for (; c < n; c++, a += stride) {                                                              \
      fetch(a + AHEAD / sizeof *a, rows * sizeof *a);                                              \
      for (size_t i = 0; i < k; i++)                                                               \
        even[i] += load(a + LANES * i) * x[c];                                                     \
    }                                                                                              \
    for (size_t i = 0; i < k; i++)                                                                 \
      *(four *)(sum + LANES * i) = both ? even[i] + odd[i * both] : even[i];                       \
    for (size_t i = 0; i < rows; i++)                                                              \
      y[i] += sum[i];                                                                              \
  }
ADD_BAND(add_band, double, WIDE)
ADD_BAND(add_band_narrow, float, NARROW)

#define CASE(band, k)                                                                              \
  case k:                                                                                          \
    band(m, n, a + r, x, y + r, rows, k);                                                          \
    break;
#define CASES(band, k) CASE(band, k) CASE(band, k + 1) CASE(band, k + 2) CASE(band, k + 3)

#define ADD_PRODUCT(name, type, band)                                                              \
  RAD_CLONES void name(size_t m, size_t n, const type *a, const double *x, double *y) {            \
    for (size_t r = 0; r < m; r += LANES * MOST) {                                                 \
      size_t rows = m - r < LANES * MOST ? m - r : LANES * MOST;                                   \
      switch ((rows + LANES - 1) / LANES) {                                                        \
        CASES(band, 1) CASES(band, 5) CASES(band, 9) CASES(band, 13)                               \
      }                                                                                            \
    }                                                                                              \
  }
ADD_PRODUCT(rad_add_product, double, add_band)
ADD_PRODUCT(rad_add_product_narrow, float, add_band_narrow)

INLINE double sum_of(four s) {
  return (s[0] + s[2]) + (s[1] + s[3]);
}

/* y [4] = A^T x for four columns, x followed by zeros, which meet what is beyond a column's end. */
INLINE void set_four(size_t m, const double *a, const double *x, double *y) {
  four s0 = {0}, s1 = {0}, s2 = {0}, s3 = {0};
  fetch(a + AHEAD / sizeof *a, 4 * m * sizeof *a);
  for (size_t r = 0; r < m; r += LANES) {
    four part = WIDE(x + r);
    s0 += WIDE(a + r) * part;
    s1 += WIDE(a + m + r) * part;
    s2 += WIDE(a + 2 * m + r) * part;
    s3 += WIDE(a + 3 * m + r) * part;
  }
  y[0] = sum_of(s0);
  y[1] = sum_of(s1);
  y[2] = sum_of(s2);
  y[3] = sum_of(s3);
}

/* What is left after fours is done with the three before it once more. */
RAD_CLONES void rad_set_transposed(size_t m, size_t n, const double *a, const double *x,
                                   double *y) {
  double padded[RAD_MOST_COLUMNS + LANES];
  memcpy(padded, x, sizeof *x * m);
  memset(padded + m, 0, sizeof *x * LANES);
  size_t c = 0;
  for (; c + 4 <= n; c += 4)
    set_four(m, a + c * m, padded, y + c);
  if (c < n && n >= 4)
    set_four(m, a + (n - 4) * m, padded, y + n - 4);
  for (; n < 4 && c < n; c++) {
    four s = {0};
    for (size_t r = 0; r < m; r += LANES)
      s += WIDE(a + c * m + r) * WIDE(padded + r);
    y[c] = sum_of(s);
  }
}
