#include "base/checksum.h"

#include <string.h>

static uint64_t add(uint64_t sum, uint64_t word) {
  sum = (sum ^ word) * 0x9e3779b97f4a7c15u;
  return sum ^ (sum >> 32); /* the high bits of words reach the low bits of the sum */
}

uint64_t rad_checksum(uint64_t sum, const void *bytes, size_t n) {
  enum { LANES = 8, STEP = 8 * LANES };
  const unsigned char *at = bytes;
  uint64_t lane[LANES], word[LANES];
  for (int l = 0; l < LANES; l++)
    lane[l] = sum + (uint64_t)l;
  for (size_t rest = n; rest > 0;) {
    size_t step = rest < STEP ? rest : STEP;
    memset(word, 0, sizeof word);
    memcpy(word, at, step);
    for (int l = 0; l < LANES; l++)
      lane[l] = add(lane[l], word[l]);
    at += step;
    rest -= step;
  }
  sum = add(sum, n);
  for (int l = 0; l < LANES; l++)
    sum = add(sum, lane[l]);
  return sum;
}
