#include "integrate/near.h"

#include <complex.h>
#include <math.h>
#include <string.h>

#include "base/simd_math.h"

enum { MAX_RAY = 48, MAX_RADIAL = 64, MAX_DEPTH = 60, LANES = 8 };

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

/* ---- along a ray -------------------------------------------------------------------------- */

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

/* ---- across the rays ---------------------------------------------------------------------- */

/* Poles of the ray integral in sigma: a position and the real part's place in t. */
struct pole {
  double re, im;
};

static double complex sigma_of(const struct rad_near *w, double complex t) {
  double complex phi = w->patch->angle == RAD_ANGLE_POLAR ? 6 / M_PI * catan(t / sqrt(3)) : t;
  return w->element->p_phi == 1 ? phi : cpow(phi, 1 / w->element->p_phi);
}

static double t_of(const struct rad_near *w, double sigma) {
  double p = w->element->p_phi;
  return rad_angle_t(w->patch->angle, whole_power(sigma, (int)p));
}

static double side_r(const struct rad_side_line *s, double t) {
  return s->g / (s->c1 + s->c2 * t);
}

/* t_c: |x - ray(t)|^2 = Q |t - t_c|^2 / A, the ray that passes x in complex t (theory 3.7) */
static double complex ray_pole(const struct rad_near *w, double *q) {
  const struct rad_patch *p = w->patch;
  double x = w->x[0], y = w->x[1], z = w->x[2];
  double e = x * p->b2 - y * p->b1, b = p->b1 * p->b1 + p->b2 * p->b2;
  *q = e * e + z * z * b;
  return (p->a1 * (e * y - z * z * p->b1) + I * p->a1 * p->b2 * z * sqrt(x * x + y * y + z * z)) /
         *q;
}

/* t at which the line of a side passes x in complex t (theory 3.8) */
static double complex side_pole(const struct rad_near *w, const struct rad_side_line *s) {
  const struct rad_patch *p = w->patch;
  double alpha = s->c1 / p->a1, beta = (s->c2 - alpha * p->b1) / p->b2;
  double norm = sqrt(alpha * alpha + beta * beta);
  double off = (alpha * w->x[0] + beta * w->x[1] - s->g) / norm, far = hypot(off, w->x[2]);
  double complex y1 = w->x[0] - off * alpha / norm - I * far * beta / norm;
  double complex y2 = w->x[1] - off * beta / norm + I * far * alpha / norm;
  return p->a1 * y2 / (p->b2 * y1 - p->b1 * y2);
}

/* The poles that matter for a strip; returns their number. */
static int find_poles(const struct rad_near *w, const struct rad_strip *strip,
                      double complex *pole) {
  const struct rad_patch *p = w->patch;
  double q;
  double complex t = ray_pole(w, &q);
  double tf = fmin(fmax(creal(t), 0), 1);
  double d1 = p->a1 + tf * p->b1, d2 = tf * p->b2;
  double foot = (d1 * w->x[0] + d2 * w->x[1]) / (d1 * d1 + d2 * d2);
  int n = 0;
  if (foot >= side_r(&strip->lower, tf) && foot <= side_r(&strip->upper, tf))
    pole[n++] = sigma_of(w, t);
  if (strip->lower.g > 0)
    pole[n++] = sigma_of(w, side_pole(w, &strip->lower));
  pole[n++] = sigma_of(w, side_pole(w, &strip->upper));
  return n;
}

/* Set the radial data of the ray at t; dt is t - t_c, exact near the pole. */
INLINE void set_ray(const struct rad_near *w, const struct rad_strip *strip, double t, double dt2,
                    double q, struct ray *ray) {
  const struct rad_patch *p = w->patch;
  double d1 = p->a1 + t * p->b1, d2 = t * p->b2, a = d1 * d1 + d2 * d2;
  double r0 = (d1 * w->x[0] + d2 * w->x[1]) / a, delta = sqrt(q * dt2) / a;
  double r_lo = side_r(&strip->lower, t), r_hi = side_r(&strip->upper, t), pr = w->element->p_r;
  ray->n0 = w->n0;
  ray->slope = w->na + t * w->nb;
  ray->scale = w->x[2] * p->a1 * p->b2 / (M_PI * a * a);
  if (pr == 1) {
    ray->re = r0;
    ray->im = delta;
    ray->tau[0] = r_lo;
    ray->tau[1] = r_hi;
    return;
  }
  double size = whole_root(sqrt(r0 * r0 + delta * delta), (int)pr), turn = atan2(delta, r0) / pr;
  ray->re = size * cos(turn);
  ray->im = size * sin(turn);
  ray->tau[0] = whole_root(r_lo, (int)pr);
  ray->tau[1] = whole_root(r_hi, (int)pr);
}

/* |t - t_c|^2 from offset = sigma - sigma_c, which the map knows exactly: nothing cancels. For t_c
 * near the real range; the formula breaks down at t_c = i sqrt(3), where phi_c is infinite. */
static double distance2(const struct rad_near *w, double sigma, double complex sigma_c,
                        double complex offset, double t, double complex t_c) {
  double complex sum = 1;
  double power = 1;
  for (int m = 1; m < (int)w->element->p_phi; m++) {
    power *= sigma;
    sum = sum * sigma_c + power;
  }
  double complex dphi = offset * sum;
  if (w->patch->angle != RAD_ANGLE_POLAR)
    return creal(dphi) * creal(dphi) + cimag(dphi) * cimag(dphi);
  /* tan u - tan v = sin(u - v) / (cos u cos v), 1/cos^2 = 1 + tan^2 */
  double x = sin(M_PI / 6 * creal(dphi)), y = sinh(M_PI / 6 * cimag(dphi));
  return 3 * (x * x + y * y) * (1 + t * t / 3) * cabs(1 + t_c * t_c / 3);
}

/* Mapped range of sigma: sigma = re + im sinh(z), or sigma = z. */
struct range {
  int mapped;
  double re, im, mid, half;
  int n; /* Gauss points wanted */
};

/* Choose the map for [lo, hi] around the nearest pole and the number of points for all. */
static struct range choose(const struct rad_near *w, double lo, double hi, int n_pole,
                           const double complex *pole) {
  double degree = w->element->k_phi + 3 * w->element->p_phi; /* functions, dt/dsigma, kernel */
  struct range r = {.mid = 0.5 * (lo + hi), .half = 0.5 * (hi - lo)};
  double rho = INFINITY;
  int nearest = 0;
  for (int i = 0; i < n_pole; i++) {
    double b = bernstein((creal(pole[i]) - r.mid) / r.half, cimag(pole[i]) / r.half);
    if (b < rho) {
      rho = b;
      nearest = i;
    }
  }
  if (rho < RHO_PLAIN) {
    double re = creal(pole[nearest]), im = fabs(cimag(pole[nearest]));
    double z0 = asinh((lo - re) / im), z1 = asinh((hi - re) / im);
    r = (struct range){1, re, im, 0.5 * (z0 + z1), 0.5 * (z1 - z0), 0};
    rho = bernstein(r.mid / r.half, 0.5 * M_PI / r.half);
    for (int i = 0; i < n_pole; i++) {
      double complex z = casinh((pole[i] - re) / im);
      rho = fmin(rho, bernstein((creal(z) - r.mid) / r.half, cimag(z) / r.half));
    }
  }
  r.n = points_for(rho, degree, r.mapped ? 2 : 0, r.half, w->digits);
  return r;
}

/* All rays of one range. */
static RAD_CLONES void sweep(struct rad_near *w, const struct rad_strip *strip,
                             const struct range *range, double complex t_c, double q_c,
                             double *restrict moment) {
  const struct rad_element *e = w->element;
  const double *x = rad_gauss_node(w->gauss, range->n), *wt = rad_gauss_weight(w->gauss, range->n);
  double complex sigma_c = sigma_of(w, t_c);
  int at_pole = range->mapped && range->re == creal(sigma_c) && range->im == cimag(sigma_c) &&
                cimag(t_c) < 0.01;
  for (int i = 0; i < range->n; i++) {
    double z = range->mid + range->half * x[i], ez = rad_exp(range->mapped ? z : 0);
    double sh = 0.5 * (ez - 1 / ez), ch = 0.5 * (ez + 1 / ez);
    double sigma = range->mapped ? range->re + range->im * sh : z;
    double slope = range->mapped ? range->im * ch : 1;
    double t = t_of(w, sigma);
    double complex dt = t - t_c;
    double d2 = creal(dt) * creal(dt) + cimag(dt) * cimag(dt);
    if (at_pole)
      d2 = distance2(w, sigma, sigma_c, range->im * (sh - I), t, t_c);
    struct ray ray;
    set_ray(w, strip, t, d2, q_c, &ray);
    double phi_slope = e->p_phi * whole_power(sigma, (int)e->p_phi - 1);
    ray.scale *= wt[i] * range->half * slope * phi_slope * rad_angle_dt(w->patch->angle, t);
    double radial[RAD_GAUSS_MAX] = {0}, angular[RAD_GAUSS_MAX];
    along_ray(w, &ray, radial);
    rad_legendre(e->k_phi, (2 * sigma - e->sigma[0] - e->sigma[1]) / (e->sigma[1] - e->sigma[0]),
                 angular);
    for (int a = 0; a < e->k_phi; a++)
      for (int c = 0; c < e->k_r; c++)
        moment[a * e->k_r + c] += angular[a] * radial[c];
  }
}

/* Sweep [lo, hi], halving it in the mapped variable while it would need too many rays. */
static void across(struct rad_near *w, const struct rad_strip *strip, double lo, double hi,
                   int n_pole, const double complex *pole, int depth, double *moment) {
  if (hi <= lo)
    return;
  struct range range = choose(w, lo, hi, n_pole, pole);
  double split = range.mapped ? range.re + range.im * sinh(range.mid) : range.mid;
  if (range.n > MAX_RAY && depth < MAX_DEPTH && split > lo && split < hi) {
    across(w, strip, lo, split, n_pole, pole, depth + 1, moment);
    across(w, strip, split, hi, n_pole, pole, depth + 1, moment);
    return;
  }
  range.n = range.n < MAX_RAY ? range.n : MAX_RAY;
  double q;
  double complex t_c = ray_pole(w, &q);
  sweep(w, strip, &range, t_c, q, moment);
}

void rad_near(struct rad_near *w, const struct rad_strip *strip, int n_strip, double *out) {
  int k_phi = w->element->k_phi, k_r = w->element->k_r;
  double moment[RAD_GAUSS_MAX * RAD_GAUSS_MAX], half_done[RAD_GAUSS_MAX];
  memset(moment, 0, sizeof(double) * (size_t)(k_phi * k_r));
  for (int s = 0; s < n_strip; s++) {
    double complex pole[3];
    int n_pole = find_poles(w, &strip[s], pole);
    across(w, &strip[s], strip[s].sigma[0], strip[s].sigma[1], n_pole, pole, 0, moment);
  }
  for (int a = 0; a < k_phi; a++) { /* I = T_phi M T_r^T */
    for (int c = 0; c < k_r; c++) {
      half_done[c] = 0;
      for (int m = 0; m < k_phi; m++)
        half_done[c] += w->to_lagrange_phi[a * k_phi + m] * moment[m * k_r + c];
    }
    for (int c = 0; c < k_r; c++) {
      double sum = 0;
      for (int m = 0; m < k_r; m++)
        sum += half_done[m] * w->to_lagrange_r[c * k_r + m];
      out[a + k_phi * c] = sum;
    }
  }
}
