/* Near targets: rays from the patch's corner, both directions stretched around the kernel's poles.
 */
#ifndef RAD_INTEGRATE_NEAR_H
#define RAD_INTEGRATE_NEAR_H

#include <stdint.h>

#include "integrate/rule.h"
#include "integrate/view.h"

/* A side of the region of integration: r(t) = g / (c1 + c2 t). r = const has c1 = 1, c2 = 0. */
struct rad_side_line {
  double g, c1, c2;
};

/* The part of an element between two sides and two angles. */
struct rad_strip {
  double sigma[2];
  struct rad_side_line lower, upper;
};

/* One target point and one source element, as the integrator sees them. */
struct rad_near {
  const struct rad_gauss *gauss;
  const struct rad_patch *patch;
  const struct rad_element *element;
  const double *to_lagrange_phi, *to_lagrange_r; /* matrices T of (4.3) */
  double digits;                                 /* ln(100 / tolerance) */
  double n0, na, nb;                             /* of rad_view */
  double x[3];                                   /* target in the patch's frame, x[2] > 0 [m] */
  double r[2];                                   /* of the element; set by rad_near */
  int64_t n_kernel;                              /* in, out: kernel values so far */
};

/**
 * I[b] = int over the strips of G(x, y) L_b(y) dS, b = a + k_phi c (theory 3.6)
 *
 * For fixed t the integrand is rational in r with the double poles r0 +- i delta; the integral over
 * r is analytic in t but for poles where the ray, or an end of the range, passes x. Each range is
 * mapped by s = Re + Im sinh(z) around its nearest pole, which then lies at z = +-i pi/2, and Gauss
 * rules take their number of points from the Bernstein ellipse (theory 3.12). Near the pole that a
 * map is centred at, distances to x come from the mapped variable, so that nothing cancels.
 *
 * @param[out] out  [k_phi k_r]
 * Measured error: below twice the tolerance times the row sum (tests/unit/test_integrals.c).
 * Thread-safe; no allocation.
 */
void rad_near(struct rad_near *w, const struct rad_strip *strip, int n_strip, double *out);

#endif
