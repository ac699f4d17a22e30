#include "integrate/near.h"

#include <complex.h>
#include <math.h>
#include <string.h>

#include "integrate/ray.h"

enum { MAX_RAY = 48, MAX_DEPTH = 60 };

static double complex sigma_of(const struct rad_near *w, double complex t) {
  double complex phi = w->patch->angle == RAD_ANGLE_POLAR ? 6 / M_PI * catan(t / sqrt(3)) : t;
  return w->element->p_phi == 1 ? phi : cpow(phi, 1 / w->element->p_phi);
}

static double t_of(const struct rad_near *w, double sigma) {
  double p = w->element->p_phi;
  return rad_angle_t(w->patch->angle, whole_power(sigma, (int)p));
}

/* Within the element: a side that almost is a ray may leave it by rounding. */
static double side_r(const struct rad_near *w, const struct rad_side_line *s, double t) {
  return fmin(fmax(s->g / (s->c1 + s->c2 * t), w->r[0]), w->r[1]);
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

/* A side that almost is a ray passes x near the real axis, and by rounding on it. */
static double complex off_axis(double complex sigma) {
  return creal(sigma) + I * fmax(fabs(cimag(sigma)), 1e-30);
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
  if (foot >= side_r(w, &strip->lower, tf) && foot <= side_r(w, &strip->upper, tf))
    pole[n++] = sigma_of(w, t);
  if (strip->lower.g != 0)
    pole[n++] = off_axis(sigma_of(w, side_pole(w, &strip->lower)));
  pole[n++] = off_axis(sigma_of(w, side_pole(w, &strip->upper)));
  return n;
}

/* Set the radial data of the ray at t; dt is t - t_c, exact near the pole. */
INLINE void set_ray(const struct rad_near *w, const struct rad_strip *strip, double t, double dt2,
                    double q, struct ray *ray) {
  const struct rad_patch *p = w->patch;
  double d1 = p->a1 + t * p->b1, d2 = t * p->b2, a = d1 * d1 + d2 * d2;
  double r0 = (d1 * w->x[0] + d2 * w->x[1]) / a, delta = sqrt(q * dt2) / a;
  double r_lo = side_r(w, &strip->lower, t), r_hi = side_r(w, &strip->upper, t),
         pr = w->element->p_r;
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
    for (int i = 0; i < n_pole; i++) { /* sinh has this value in z and in i pi - z */
      double complex z = casinh((pole[i] - re) / im);
      double x = creal(z), y = fabs(cimag(z));
      rho = fmin(rho, bernstein((x - r.mid) / r.half, y / r.half));
      rho = fmin(rho, bernstein((-x - r.mid) / r.half, (M_PI - y) / r.half));
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
  for (int i = 0; i < 2; i++)
    w->r[i] = rad_graded(w->element->tau[i], w->element->p_r);
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
