#include "paper_map.h"

#include <math.h>

int paper_odd(double z) {
  int n = z <= 1 ? 1 : (int)ceil(z);
  return n % 2 ? n : n + 1;
}

struct paper_map paper_map(double a, double eps) {
  double off = a < 0 ? hypot(eps, a) : a > 1 ? hypot(eps, 1 - a) : fabs(eps);
  struct paper_map m = {.a = a, .q = paper_odd(log(off) / log(0.3))};
  if (a >= 0 && a <= 1) {
    m.alpha2 = pow(a, 1.0 / m.q);
    m.alpha1 = pow(1 - a, 1.0 / m.q) + m.alpha2;
  }
  return m;
}

static double power(double x, int n) {
  double y = 1;
  for (; n > 0; n--)
    y *= x;
  return y;
}

double paper_map_at(const struct paper_map *m, double y, double *slope) {
  int inside = m->a >= 0 && m->a <= 1;
  double z = inside ? m->alpha1 * y - m->alpha2 : y, p = power(z, m->q - 1);
  *slope = m->q * p * (inside ? m->alpha1 : 1);
  return inside ? p * z + m->a : m->a < 0 ? p * z : 1 - p * z;
}
