/* Rules of points on triangles: symmetric ones, and products of Gauss's for high degrees. */
#ifndef RAD_FACTORS_TRIANGLE_RULE_H
#define RAD_FACTORS_TRIANGLE_RULE_H

#include "base/gauss.h"

enum { RAD_TRIANGLE_RULES = 7, RAD_TRIANGLE_POINTS = 144 };

/* Points and the degree up to which polynomials are exact, of each rule, rising. */
extern const int rad_triangle_points[RAD_TRIANGLE_RULES]; /* 1, 3, 6, 7, 16, 64, 144 */
extern const int rad_triangle_degree[RAD_TRIANGLE_RULES]; /* 1, 2, 4, 5, 8, 14, 22 */

/* Barycentric points [n][3] and positive weights [n], whose sum is 1. */
void rad_triangle_rule(const struct rad_gauss *g, int rule, double (*lambda)[3], double *weight);

#endif
