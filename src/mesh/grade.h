/* The paper's partition P(N,p) of the unit square [H, (3.6)-(3.8)]. */
#ifndef RAD_MESH_GRADE_H
#define RAD_MESH_GRADE_H

struct rad_rectangle {
  double phi[2], r[2];
  int layer; /* i of the L-shaped layer */
};

/* Number of rectangles of P(N,p); may be beyond any int for large p. */
double rad_grade_count(int n, double p);

/* Number of them that carry constants for i* (3.17). */
double rad_grade_constants(int n, double p, int constant_layers);

/**
 * The rectangles of P(N,p): layer i = { min(phi, r) in [(i/N)^p, ((i+1)/N)^p] } holds one square
 * and in each leg nint((1 - g_{i+1}) / (g_{i+1} - g_i)) equal rectangles         (theory 2.3)
 *
 * @param[out] rectangle  [rad_grade_count(n, p)], layer by layer: square, leg along phi, leg along
 * r
 */
void rad_grade_fill(int n, double p, struct rad_rectangle *rectangle);

/* Rectangles in layers i < (i*)^(1/(1+p)) N^(p/(1+p)) carry constants [H, (3.17)]. */
int rad_grade_constant(int layer, int n, double p, int constant_layers);

#endif
