/* Where the share of light that arrives at a triangle is a smooth function of where it starts. */
#ifndef RAD_ESTIMATE_SMOOTH_H
#define RAD_ESTIMATE_SMOOTH_H

#include "estimate/light_cell.h"

/* What F(y -> T) is singular at, for y in the plane of the sender: the ends of T's edges, also
 * those where the sender's plane cuts them, and the edges themselves unless they lie in that plane.
 */
struct rad_singular {
  int n_point, n_line;
  double point[6][3], line[3][2][3]; /* [m] */
  int point_vertex[6];               /* vertex of the scene, or -1 */
  int line_vertex[3][2];             /* of the ends */
};

void rad_singular_set(const struct rad_triangle *sender, const struct rad_triangle *receiver,
                      struct rad_singular *s);

/**
 * How smooth F(y -> T) is on a cell, in its two directions.                          (theory 17.1)
 *
 * On a straight line y = m + z h, z in [-1, 1], F(y -> T) is a function of a complex z, singular
 * where the distance of y from a point or a line of s vanishes. The number is half of the longer
 * axis of the least ellipse with foci -1 and 1 through such a z, for the two sides of the cell and
 * its middle line. What touches the cell in the vertex where it begins looks the same at every
 * distance and counts only across.
 *
 * @param[out] axis  [2], >= 1: along phi and along r; INFINITY if nothing is singular
 */
void rad_smoothness(const struct rad_cell_shape *cell, const struct rad_singular *s,
                    double axis[2]);

#endif
