#ifndef POLYRAD_TEST_CLIP_ORACLE_H
#define POLYRAD_TEST_CLIP_ORACLE_H

/*
 * An independent oracle for what a point sees of a triangle. It shares no code and no method with
 * src/visibility: blockers are cut to the pyramid between the point and the triangle and projected
 * onto it, in quadruple precision; the area of the union of the projections is summed over strips
 * between all corners and crossings, in long double.
 */

/**
 * Fraction of the source's area that no blocker hides from x.
 *
 * The doubles are taken as exact, and x = V_base + mu1 F1 + mu2 F2 as well (see rad_patch).
 *
 * @param[in] target   its vertices V;  base, mu: x
 * @param[in] n        blockers, all of which count: leave out what is in the plane of either
 * @param[in] blocker  [n][vertex][coordinate]
 * @return 0..1, accurate to about 1e-17
 */
double clip_oracle(const double target[3][3], int base, const double mu[2],
                   const double source[3][3], int n, const double (*blocker)[3][3]);

#endif
