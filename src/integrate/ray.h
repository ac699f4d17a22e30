/* One ray of the near integrator: the integral over r, for vector loops within its caller's clones.
 */
#ifndef RAD_INTEGRATE_RAY_H
#define RAD_INTEGRATE_RAY_H

#include <math.h>

#include "base/simd_math.h"
#include "integrate/near.h"

enum { MAX_RADIAL = 64, LANES = 8 };

#define INLINE static inline __attribute__((always_inline))

/* Beyond this Bernstein parameter plain Gauss beats the sinh map. */
#define RHO_PLAIN 3.0

/* x^p for the whole p of graded variables. */
static inline double whole_power(double x, int p) {
  double power = 1;
  for (int m = 0; m < p; m++)
    power *= x;
  return power;
}

/* x^(1/p) for x >= 0. */
static inline double whole_root(double x, int p) {
  return p == 1   ? x
         : p == 2 ? sqrt(x)
         : p == 3 ? cbrt(x)
         : p == 4 ? sqrt(sqrt(x))
                  : pow(x, 1.0 / p);
}

/* To the last bits of 1, which is what positions on a range need. */
static inline double inverse_sinh(double x) {
  double a = fabs(x), z = log(a + sqrt(a * a + 1));
  return x < 0 ? -z : z;
}

/* Parameter of the Bernstein ellipse with foci -1, 1 through re + i im. */
static inline double bernstein(double re, double im) {
  double s = 0.5 * (sqrt((re - 1) * (re - 1) + im * im) + sqrt((re + 1) * (re + 1) + im * im));
  return s + sqrt(fmax(s * s - 1, 0));
}

/* Gauss points for [mid - half, mid + half] of a variable in which the integrand is analytic within
 * the Bernstein ellipse rho, and there at most e^(growth half ((rho' + 1/rho')/2 - 1)) times what
 * it is on the range, on each smaller ellipse rho' (theory 3.12):
 *
 *   rho'^(2n - degree) = e^digits * that growth, for the rho' <= rho that needs the least n
 */
static inline int points_for(double rho, double degree, double growth, double half, double digits) {
  static const double ellipse[] = {1.2, 1.5, 2, 2.7, 3.7, 5.5, 9, 16};
  static const double log_of[] = {0.18232155679395, 0.40546510810816, 0.69314718055995,
                                  0.99325177301028, 1.30833281965018, 1.70474809223843,
                                  2.19722457733622, 2.77258872223978};
  double log_rho = log(rho);
  double least = 0.5 * (digits + growth * half * (0.5 * (rho + 1 / rho) - 1)) / log_rho;
  for (int i = 0; i < 8 && ellipse[i] < rho; i++) {
    double e = ellipse[i];
    double n = 0.5 * (digits + growth * half * (0.5 * (e + 1 / e) - 1)) / log_of[i];
    least = n < least ? n : least;
  }
  double n = least + 0.5 * degree + 1;
  return n < 1000 ? (int)ceil(n) : 1000;
}

/* A ray at fixed t: what the integrand over r needs. */
struct ray {
  double n0, slope; /* n_x.(y-x) = n0 + r slope */
  double re, im;    /* pole in tau: (r0 + i delta)^(1/p) */
  double tau[2];    /* range */
  double scale;     /* weight of this ray's integral */
};

/* Radial integrand times weights at n nodes, for Gauss points z0 + x z1 of the (mapped) variable.
 */
INLINE void radial_nodes(const struct ray *ray, const int p, const int mapped, double mid,
                         double half, int n, const double *restrict x, const double *restrict w,
                         double *restrict tau, double *restrict f) {
  double re = ray->re, im = ray->im, n0 = ray->n0, slope = ray->slope,
         scale = ray->scale * half * p;
#pragma omp simd
  for (int i = 0; i < n; i++) {
    double z = mid + half * x[i], sh, ch2, dtau;
    if (mapped) {
      double e = rad_exp(z), back = 1 / e, ch = 0.5 * (e + back);
      sh = 0.5 * (e - back);
      ch2 = ch * ch;
      dtau = im * ch;
    } else {
      sh = (z - re) / im;
      ch2 = 1 + sh * sh;
      dtau = 1;
    }
    double t = mapped ? re + im * sh : z;
    /* tau^p - tau_c^p = (tau - tau_c) S, S = sum_m tau^m tau_c^(p-1-m) */
    double power = 1, s_re = 1, s_im = 0;
    for (int m = 1; m < p; m++) {
      power *= t;
      double keep = s_re * re - s_im * im + power;
      s_im = s_re * im + s_im * re;
      s_re = keep;
    }
    double r = power * t;
    double q = im * im * ch2 * (s_re * s_re + s_im * s_im); /* |y-x|^2 / A */
    tau[i] = t;
    f[i] = w[i] * scale * dtau * power * r * (n0 + r * slope) / (q * q);
  }
}

/* The same with p and mapped as constants, so that the loop is free of branches. */
INLINE void radial_nodes_by_kind(const struct ray *ray, int p, int mapped, double mid, double half,
                                 int n, const double *restrict x, const double *restrict w,
                                 double *restrict tau, double *restrict f) {
#define CASE(P)                                                                                    \
  case 2 * P:                                                                                      \
    radial_nodes(ray, P, 0, mid, half, n, x, w, tau, f);                                           \
    break;                                                                                         \
  case 2 * P + 1:                                                                                  \
    radial_nodes(ray, P, 1, mid, half, n, x, w, tau, f);                                           \
    break
  switch (2 * p + mapped) {
    CASE(1);
    CASE(2);
    CASE(3);
    CASE(4);
  default:
    radial_nodes(ray, p, mapped, mid, half, n, x, w, tau, f);
  }
#undef CASE
}

/* moment[c] += sum_i f_i P_c(x_i), c < k, with x the position of tau in the element's range. */
INLINE void legendre_moments(int n, const double *restrict tau, const double *restrict f, double lo,
                             double hi, int k, double *restrict moment) {
  double x[MAX_RADIAL], p0[MAX_RADIAL], p1[MAX_RADIAL], sum = 0, sum1 = 0;
#pragma omp simd reduction(+ : sum, sum1)
  for (int i = 0; i < n; i++) {
    x[i] = (2 * tau[i] - lo - hi) / (hi - lo);
    p0[i] = f[i];
    p1[i] = x[i] * f[i];
    sum += p0[i];
    sum1 += p1[i];
  }
  moment[0] += sum;
  if (k > 1)
    moment[1] += sum1;
  for (int c = 2; c < k; c++) {
    double u = (2.0 * c - 1) / c, v = (c - 1.0) / c;
    sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int i = 0; i < n; i++) {
      double p2 = u * x[i] * p1[i] - v * p0[i];
      p0[i] = p1[i];
      p1[i] = p2;
      sum += p2;
    }
    moment[c] += sum;
  }
}

/* Moments of one ray. */
INLINE void along_ray(struct rad_near *w, const struct ray *ray, double *restrict moment) {
  const struct rad_element *e = w->element;
  int p = (int)e->p_r, k = e->k_r;
  double degree = k + 3 * p; /* functions, r dr/dtau, n_x.(y-x) */
  double mid = 0.5 * (ray->tau[0] + ray->tau[1]), half = 0.5 * (ray->tau[1] - ray->tau[0]);
  if (half <= 0)
    return;
  double rho = bernstein((ray->re - mid) / half, ray->im / half);
  int mapped = rho < RHO_PLAIN;
  if (mapped) {
    double z0 = inverse_sinh((ray->tau[0] - ray->re) / ray->im),
           z1 = inverse_sinh((ray->tau[1] - ray->re) / ray->im);
    mid = 0.5 * (z0 + z1);
    half = 0.5 * (z1 - z0);
    rho = bernstein(mid / half, 0.5 * M_PI / half);
  }
  double growth = mapped ? 3 : 0; /* 1/cosh^3 falls, its continuation to smaller |z| grows */
  int n = points_for(rho, degree, growth, half, w->digits), parts = 1;
  while (n > MAX_RADIAL) {
    parts *= 2;
    rho = bernstein(0, 0.5 * M_PI / half * parts);
    n = points_for(rho, degree / parts, growth, half / parts, w->digits);
  }
  n = (n + LANES - 1) / LANES * LANES; /* a loop's scalar rest costs more than full vectors */
  double tau[MAX_RADIAL], f[MAX_RADIAL];
  for (int part = 0; part < parts; part++) {
    double at = mid + half * (2.0 * part + 1 - parts) / parts;
    radial_nodes_by_kind(ray, p, mapped, at, half / parts, n, rad_gauss_node(w->gauss, n),
                         rad_gauss_weight(w->gauss, n), tau, f);
    legendre_moments(n, tau, f, e->tau[0], e->tau[1], k, moment);
  }
  w->n_kernel += (int64_t)n * parts;
}

#endif
