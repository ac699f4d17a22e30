#include "factors/contour.h"

#include <math.h>

#define TINY 1e-13  /* lengths over the size of the pair that are rounding */
#define DIGITS 32.2 /* -ln of the relative truncation error of Gauss's rule */
#define ERROR 2e-14 /* of the product of two edges: truncation, rounding */
enum { MOST_POINTS = 20, MOST_DEPTH = 60 };

/* Two edges, in units of the pair's size: x = a + s c, 0 <= s <= length; y = b + t d. The foot of x
 * on the line of y is at t = u0 + s cd, its distance from that line |w + s cp|. */
struct edges {
  const struct rad_gauss *gauss;
  double length, other; /* of x's edge, of y's */
  double cd, u0, w[3], cp[3];
  int n;                        /* singularities */
  double real[3], imaginary[3]; /* of s: y's first and last corner, and where the lines meet */
};

static double at_end(double x) { /* x^2/2 ln x - x^2/4 */
  return x > 0 ? 0.5 * x * x * (log(x) - 0.5) : 0;
}

/* Second antiderivative of ln |x| */
static double twice(double x) {
  double a = fabs(x);
  return a > 0 ? 0.5 * a * a * (log(a) - 1.5) : 0;
}

/* Both edges on one line. */
static double on_one_line(const struct edges *e) {
  double low = e->cd > 0 ? -e->u0 : e->u0 - e->other; /* y's interval as seen along c */
  double high = low + e->other;
  return twice(e->length - low) - twice(-low) - twice(e->length - high) + twice(-high);
}

static void find_singularities(struct edges *e) {
  double cp2 = rad_dot(e->cp, e->cp), wcp = rad_dot(e->w, e->cp);
  for (int k = 0; k < 2; k++) { /* |x - y_k|^2 = (u0 - t_k + s cd)^2 + |w + s cp|^2 */
    double u = e->u0 - (k ? e->other : 0), s = -(u * e->cd + wcp), d2 = 0;
    for (int d = 0; d < 3; d++) {
      double r = e->w[d] + s * e->cp[d];
      d2 += r * r;
    }
    double along = u + s * e->cd;
    e->real[k] = s;
    e->imaginary[k] = sqrt(d2 + along * along);
  }
  e->n = 2;
  if (cp2 > TINY * TINY) {
    double cross[3], s = -wcp / cp2, u = e->u0 + s * e->cd;
    rad_cross(e->w, e->cp, cross);
    double im = rad_norm(cross) / cp2;
    if (u > -im - TINY && u < e->other + im + TINY) {
      e->real[2] = s;
      e->imaginary[2] = im;
      e->n = 3;
    }
  }
}

/* ln rho of the largest ellipse with foci first and last that does not hold the singularity. */
static double log_rho(double first, double last, double re, double im) {
  double half = 0.5 * (last - first), x = (re - 0.5 * (first + last)) / half, y = im / half;
  double sum = 0.5 * (sqrt((x - 1) * (x - 1) + y * y) + sqrt((x + 1) * (x + 1) + y * y));
  return log(sum + sqrt(sum > 1 ? sum * sum - 1 : 0));
}

/* The integral over y's edge at s, without the terms of the corners in `skip`. */
static double inner(const struct edges *e, double s, int skip) {
  double u = e->u0 + s * e->cd, v = e->other - u, h2 = 0;
  for (int d = 0; d < 3; d++) {
    double r = e->w[d] + s * e->cp[d];
    h2 += r * r;
  }
  double h = sqrt(h2), sum = h * rad_atan2(e->other * h, h2 - u * v) - e->other;
  if (!(skip & 1) && u * u + h2 > 0)
    sum += 0.5 * u * log(u * u + h2);
  if (!(skip & 2) && v * v + h2 > 0)
    sum += 0.5 * v * log(v * v + h2);
  return sum;
}

/* An interval without singularities but for corners at its ends, whose terms are closed. */
static double gauss(const struct edges *e, double first, double last, int n) {
  double half = 0.5 * (last - first), middle = 0.5 * (last + first), sum = 0, closed = 0;
  int skip = 0;
  for (int k = 0; k < 2; k++) {
    if (e->imaginary[k] > TINY)
      continue;
    double sign = k ? -e->cd : e->cd; /* of u or v after the corner */
    if (fabs(e->real[k] - first) <= TINY)
      closed += sign * at_end(last - first);
    else if (fabs(e->real[k] - last) <= TINY)
      closed -= sign * at_end(last - first);
    else
      continue;
    skip |= 1 << k;
  }
  const double *x = rad_gauss_node(e->gauss, n), *w = rad_gauss_weight(e->gauss, n);
  for (int q = 0; q < n; q++)
    sum += w[q] * inner(e, middle + half * x[q], skip);
  return half * sum + closed;
}

/* True if a singularity is met at an end, exactly: what it does to the integrand is known there. */
static int is_at_end(const struct edges *e, int k, double first, double last) {
  return e->imaginary[k] <= TINY &&
         (fabs(e->real[k] - first) <= TINY || fabs(e->real[k] - last) <= TINY);
}

static double interval(const struct edges *e, double first, double last, int depth) {
  double least = INFINITY, cut = 0.5 * (first + last);
  for (int k = 0; k < e->n; k++) {
    if (is_at_end(e, k, first, last))
      continue;
    double l = log_rho(first, last, e->real[k], e->imaginary[k]);
    if (l < least) {
      least = l;
      double at = (e->real[k] - first) / (last - first);
      int inside = e->imaginary[k] <= TINY ? e->real[k] - first > TINY && last - e->real[k] > TINY
                                           : at > 0.1 && at < 0.9;
      cut = inside && e->imaginary[k] < 0.1 * (last - first) ? e->real[k] : 0.5 * (first + last);
    }
  }
  double n = ceil(0.5 * DIGITS / least);
  if (n <= MOST_POINTS || depth == MOST_DEPTH || last - first <= TINY)
    return gauss(e, first, last, n < 2 ? 2 : n > MOST_POINTS ? MOST_POINTS : (int)n);
  return interval(e, first, cut, depth + 1) + interval(e, cut, last, depth + 1);
}

/* int_e int_f ln |x - y| ds dt times e.f, in units of the size; edges from a0 to a1, b0 to b1. */
static double edge_pair(const struct rad_gauss *g, const double *const a[2],
                        const double *const b[2], double size, double *scale) {
  struct edges e = {.gauss = g};
  double c[3], d[3], r[3];
  for (int m = 0; m < 3; m++) {
    c[m] = (a[1][m] - a[0][m]) / size;
    d[m] = (b[1][m] - b[0][m]) / size;
    r[m] = (a[0][m] - b[0][m]) / size;
  }
  e.length = rad_norm(c);
  e.other = rad_norm(d);
  double product = rad_dot(c, d);
  *scale = e.length * e.other;
  if (!(*scale > 0) || fabs(product) <= 1e-16 * *scale)
    return 0;
  for (int m = 0; m < 3; m++) {
    c[m] /= e.length;
    d[m] /= e.other;
  }
  e.cd = rad_dot(c, d);
  e.u0 = rad_dot(r, d);
  double far2 = 0;
  for (int m = 0; m < 3; m++) {
    e.w[m] = r[m] - e.u0 * d[m];
    e.cp[m] = c[m] - e.cd * d[m];
    double end = e.w[m] + e.length * e.cp[m];
    far2 += end * end;
  }
  if (rad_dot(e.w, e.w) <= TINY * TINY && far2 <= TINY * TINY)
    return e.cd * on_one_line(&e);
  find_singularities(&e);
  return e.cd * interval(&e, 0, e.length, 0);
}

double rad_contour(const struct rad_gauss *g, const struct rad_flat *p, const struct rad_flat *q,
                   double *error) {
  double size = 0, sum = 0, scales = 0;
  for (int a = 0; a < p->n; a++)
    for (int b = 0; b < q->n; b++)
      size = fmax(size, rad_distance2(p->corner[a], q->corner[b]));
  size = sqrt(size);
  if (!(size > 0))
    return *error = 0;
  for (int a = 0; a < p->n; a++)
    for (int b = 0; b < q->n; b++) {
      const double *x[2] = {p->corner[a], p->corner[a + 1 < p->n ? a + 1 : 0]};
      const double *y[2] = {q->corner[b], q->corner[b + 1 < q->n ? b + 1 : 0]};
      double scale;
      sum += edge_pair(g, x, y, size, &scale);
      scales += scale;
    }
  *error = ERROR * scales * size * size / (2 * M_PI);
  return fmax(0, sum) * size * size / (2 * M_PI);
}
