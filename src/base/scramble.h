/* Numbers that look random and are the same in every run. */
#ifndef RAD_BASE_SCRAMBLE_H
#define RAD_BASE_SCRAMBLE_H

#include <stdint.h>

/* The i-th number of splitmix64 (Steele, Lea, Flood 2014): all 64 bits look random. */
static inline uint64_t rad_scramble(uint64_t i) {
  i = (i + 1) * 0x9e3779b97f4a7c15u;
  i = (i ^ (i >> 30)) * 0xbf58476d1ce4e5b9u;
  i = (i ^ (i >> 27)) * 0x94d049bb133111ebu;
  return i ^ (i >> 31);
}

/* The same as a number 0 <= x < 1. */
static inline double rad_scramble_unit(uint64_t i) {
  return (double)(rad_scramble(i) >> 11) * 0x1p-53;
}

#endif
