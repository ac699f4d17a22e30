// Random and scrambled numbers of the oracle; points and directions made from them.
#include "oracle.h"

#include <math.h>

// splitmix64's finisher.
uint64_t oracle_hash(uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

double oracle_random(uint64_t *state) {
  *state += 0x9e3779b97f4a7c15u;
  return ((double)(oracle_hash(*state) >> 11) + .5) * 0x1p-53;
}

// Direction numbers of Joe and Kuo (2008): degree, coefficients, first m.
static const struct {
  unsigned degree, a, m[5];
} primitive[oracle_dimensions] = {
    {0, 0, {0}},
    {1, 0, {1}},
    {2, 1, {1, 3}},
    {3, 1, {1, 3, 1}},
    {3, 2, {1, 1, 1}},
    {4, 1, {1, 1, 3, 3}},
    {4, 4, {1, 3, 5, 13}},
    {5, 2, {1, 1, 5, 5, 17}},
    {5, 4, {1, 1, 5, 5, 5}},
};

static uint32_t direction[oracle_dimensions][32];

static void make_directions(void) {
  for (int d = 0; d < oracle_dimensions; d++) {
    const unsigned s = primitive[d].degree;
    uint32_t *v = direction[d];
    for (unsigned k = 0; k < 32; k++) {
      if (!s || k < s) {
        v[k] = (s ? primitive[d].m[k] : 1u) << (31 - k);
        continue;
      }
      v[k] = v[k - s] ^ (v[k - s] >> s);
      for (unsigned j = 1; j < s; j++)
        if (primitive[d].a >> (s - 1 - j) & 1)
          v[k] ^= v[k - j];
    }
  }
}

// Each digit is flipped by a random bit that depends on the digits before it; from 24 digits on all
// are random.
static double scramble(uint32_t x, uint64_t seed) {
  enum { digits = 24 };
  uint32_t y = 0;
  for (int k = 0; k < digits; k++) {
    const uint32_t before = k ? x >> (32 - k) : 0;
    const uint64_t bit = oracle_hash(seed ^ ((uint64_t)(k + 1) << 40) ^ before) >> 63;
    y = y << 1 | ((x >> (31 - k) & 1) ^ (uint32_t)bit);
  }
  uint64_t state = oracle_hash(seed ^ x);
  return (y + oracle_random(&state)) * 0x1p-24;
}

double oracle_sobol(uint32_t index, int dimension, uint64_t seed) {
  if (!direction[0][0])
    make_directions();
  uint32_t x = 0;
  for (int k = 0; index; k++, index >>= 1)
    if (index & 1)
      x ^= direction[dimension][k];
  return scramble(x, oracle_hash(seed + 0x51ed270b * (uint64_t)(dimension + 1)));
}

struct vec oracle_point(const struct face *f, double a, double b) {
  const double r = sqrt(a);
  const struct vec e = sub(f->v[1], f->v[0]), g = sub(f->v[2], f->v[1]);
  return along(along(f->v[0], r, e), r * b, g);
}

struct vec oracle_cosine(struct vec n, double a, double b) {
  const struct vec other = fabs(n.x) < .6 ? (struct vec){1, 0, 0} : (struct vec){0, 1, 0};
  struct vec e = cross(n, other);
  e = along((struct vec){0, 0, 0}, 1 / sqrt(dot(e, e)), e);
  const struct vec f = cross(n, e);
  const double r = sqrt(a), t = 2 * M_PI * b;
  const struct vec flat = along(along((struct vec){0, 0, 0}, r * cos(t), e), r * sin(t), f);
  return along(flat, sqrt(1 - a), n);
}

void oracle_mean(int n, const double *value, double *mean, double *error) {
  double sum = 0, square = 0;
  for (int i = 0; i < n; i++)
    sum += value[i];
  sum /= n;
  for (int i = 0; i < n; i++)
    square += (value[i] - sum) * (value[i] - sum);
  *mean = sum;
  *error = sqrt(square / (n * (n - 1.)));
}
