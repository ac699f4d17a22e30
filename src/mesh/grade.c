#include "mesh/grade.h"

#include <math.h>

static double grid(int i, int n, double p) {
  return i == n ? 1 : pow((double)i / n, p);
}

/* Equal parts of one leg of layer i. */
static double leg(int i, int n, double p) {
  double lo = grid(i, n, p), hi = grid(i + 1, n, p);
  return floor((1 - hi) / (hi - lo) + 0.5);
}

double rad_grade_count(int n, double p) {
  double count = 0;
  for (int i = 0; i < n; i++)
    count += 1 + 2 * leg(i, n, p);
  return count;
}

double rad_grade_constants(int n, double p, int constant_layers) {
  double count = 0;
  for (int i = 0; i < n && rad_grade_constant(i, n, p, constant_layers); i++)
    count += 1 + 2 * leg(i, n, p);
  return count;
}

void rad_grade_fill(int n, double p, struct rad_rectangle *out) {
  for (int i = 0; i < n; i++) {
    double lo = grid(i, n, p), hi = grid(i + 1, n, p);
    int parts = (int)leg(i, n, p);
    *out++ = (struct rad_rectangle){{lo, hi}, {lo, hi}, i};
    for (int along_r = 0; along_r < 2; along_r++)
      for (int m = 0; m < parts; m++) {
        double c0 = hi + (1 - hi) * m / parts,
               c1 = m + 1 == parts ? 1 : hi + (1 - hi) * (m + 1) / parts;
        *out++ = along_r ? (struct rad_rectangle){{lo, hi}, {c0, c1}, i}
                         : (struct rad_rectangle){{c0, c1}, {lo, hi}, i};
      }
  }
}

int rad_grade_constant(int layer, int n, double p, int constant_layers) {
  return constant_layers > 0 && layer < pow(constant_layers, 1 / (1 + p)) * pow(n, p / (1 + p));
}
