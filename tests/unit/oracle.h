#ifndef POLYRAD_TEST_ORACLE_H
#define POLYRAD_TEST_ORACLE_H

/*
 * An independent oracle for the integrals of one point and one mesh element. It shares no code and
 * no method with src/integrate. Geometry, nodes and differences are in quadruple precision; the
 * values, which by then have lost nothing, are multiplied and summed in 64-bit-mantissa long
 * double.
 */

/**
 * The point x = vertex + mu1 edge1 + mu2 edge2, combined in quadruple precision, so that a distance
 * of 1e-10 to an edge or vertex keeps its digits. n_x = unit(edge1 x edge2), signed by `normal`.
 *
 * The doubles are taken as exact. Faces that should meet must therefore do so exactly: choose
 * coordinates whose differences (and for sub-triangles: halves and thirds) are representable.
 */
struct oracle_point {
  double vertex[3], edge1[3], edge2[3]; /* [m] */
  double mu1, mu2;                      /* [-] */
  double normal[3];                     /* only its sign against edge1 x edge2 is used */
};

/**
 * Element y(phi,r) = v + r (a + t(phi) b), phi = sigma^p_phi, r = tau^p_r, (sigma,tau) in a box.
 * t = sqrt(3) tan(pi phi/6) if `polar`, else t = phi. n_y = +-unit(a x b), signed by `normal`.
 */
struct oracle_element {
  double v[3], a[3], b[3]; /* [m] */
  double normal[3];        /* only its sign against a x b is used */
  int polar;               /* angle map */
  double p_phi, p_r;       /* grading, real, >= 1; whole numbers are much faster */
  double sigma[2], tau[2]; /* box, within [0,1] */
  int k_phi, k_r;          /* Gauss points a side, 1..16 */
};

/** Effort: `n` Gauss points a cell (<= 40); cells at most `ratio` times their distance to x. */
struct oracle_rule {
  int n;
  double ratio;
};

/** Gauss-Legendre nodes z (ascending) and weights w on [-1,1], n <= 40, right to the last bit. */
void oracle_gauss(int n, long double *z, long double *w);

/**
 * All integrals of one point and one element,
 *
 *   I[a + k_phi*c] = (1/pi) int_e [n_x.(y-x)]_+ [n_y.(x-y)]_+ / |x-y|^4 La(sigma) Lc(tau) dS(y).
 *
 * La, Lc are the Lagrange polynomials on the Gauss points of the box. Dyadic subdivision until each
 * cell is small against its distance to x, then a tensor Gauss rule; the radial range is clipped
 * at the horizon of x exactly. Measured on 4000 random visible cases, distances
 * 3 to 1e-10: within 5e-18 of sum |I| of a run with more points and smaller cells.
 *
 * @param[out] I  [k_phi, k_r] column-major [-]
 * @return number of cells used (0: nothing seen), or -1 if x touches the element (I is then
 * useless)
 */
long oracle_integrate(const struct oracle_point *x, const struct oracle_element *e, long double *I);

/** The same with a chosen effort; the default is {20, 1}. */
long oracle_integrate_with(const struct oracle_rule *rule, const struct oracle_point *x,
                           const struct oracle_element *e, long double *I);

/**
 * Closed form (Lambert) for the constant 1 on a plane convex polygon, clipped at the horizon of x:
 * (1/2pi) |sum_i theta_i n_x.Gamma_i|; 0 if x is behind the polygon.
 *
 * @param[in] y       [n_vertex <= 16] corners in order, either sense [m]
 * @param[in] normal  the radiating side; only its sign is used
 */
long double oracle_lambert(const struct oracle_point *x, int n_vertex, const double (*y)[3],
                           const double normal[3]);

/** The same for an element, whose corners are formed in quadruple precision. */
long double oracle_lambert_element(const struct oracle_point *x, const struct oracle_element *e);

#endif
