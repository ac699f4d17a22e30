#include "mesh/exponents.h"

#include <math.h>

static const double pi = 3.14159265358979323846, euler = 0.57721566490153286061;

/* psi(x), x > 0: by recurrence to x >= 10, there asymptotically (remainder 1e-17). */
static double digamma(double x) {
  double sum = 0;
  for (; x < 10; x += 1)
    sum -= 1 / x;
  double y = 1 / (x * x);
  return sum + log(x) - 0.5 / x -
         y * (1. / 12 -
              y * (1. / 120 -
                   y * (1. / 252 - y * (1. / 240 - y * (1. / 132 - y * (691. / 32760 - y / 12))))));
}

/* (M/z - 1)/w, z <= 1/2, by the series of F(-beta, 1+beta; 2; z); eps = 1 - beta. */
static double excess_obtuse(double beta, double eps, double z, double w) {
  double term = 1, sum = 1;
  for (int n = 0; n < 200 && fabs(term) > 1e-17; n++) {
    term *= (n == 1 ? eps : n - beta) * (1 + beta + n) / ((2. + n) * (1 + n)) * z;
    sum += term;
  }
  return (pi * beta * (1 + beta) / sin(pi * fmin(beta, eps)) * sum - 1) / w;
}

/* (M/z - 1)/w, w = 1 - z <= 1/2, by Abramowitz and Stegun (15.3.11) with m = 1:
 * beta (1+beta) sum_n (1-beta)_n (2+beta)_n / (n! (n+1)!) w^n
 *   [psi(n+1) + psi(n+2) - psi(n+1-beta) - psi(n+2+beta) - ln w] */
static double excess_acute(double beta, double eps, double w) {
  double bracket = 1 - 2 * euler - digamma(1 + eps) + 1 / eps - digamma(2 + beta) - log(w);
  double term = 1, sum = 0;
  for (int n = 0; n < 200; n++) {
    sum += term * bracket;
    if (fabs(term * bracket) < 1e-17 * fabs(sum))
      break;
    term *= (n + eps) * (2 + beta + n) / ((1. + n) * (2 + n)) * w;
    bracket += 1 / (1. + n) + 1 / (2. + n) - 1 / (n + eps) - 1 / (2 + beta + n);
  }
  return beta * (1 + beta) * sum;
}

/* Solved for y = ln(beta / (1-beta)): ln((M/z - 1)/w) grows like y + const at both ends. */
double rad_edge_exponent(double rho1, double rho2, double gamma) {
  double s = sqrt(rho1 * rho2), z = cos(gamma / 2) * cos(gamma / 2),
         w = sin(gamma / 2) * sin(gamma / 2);
  if (!(s > 0) || !(gamma > 0) || !(gamma < pi))
    return INFINITY;
  double target = log((1 - s + s * w) / (s * z * w)), low = -100, high = 100;
  double y = fmin(fmax(target, -40), 40), last_y = 0, last_f = NAN, beta = 1;
  for (int step = 0; step < 100; step++) {
    double eps = 1 / (1 + exp(y));
    beta = 1 / (1 + exp(-y));
    if (beta == 1)
      return INFINITY;
    double f = log(z > w ? excess_acute(beta, eps, w) : excess_obtuse(beta, eps, z, w)) - target;
    if (f > 0)
      high = y;
    else
      low = y;
    double slope = (f - last_f) / (y - last_y), next = y - f / (slope > 0.1 ? slope : 1);
    if (!(next > low && next < high))
      next = 0.5 * (low + high);
    if (fabs(f) < 1e-15 || fabs(next - y) < 1e-14)
      break;
    last_y = y;
    last_f = f;
    y = next;
  }
  return beta;
}
