/* What passes a rectangular hole between two parallel triangles: an oracle that shares nothing with
 * src. */
#ifndef TESTS_HOLE_ORACLE_H
#define TESTS_HOLE_ORACLE_H

/* Hole [x0, x1] x [y0, y1] in the plane z between triangles `low` in the plane 0 and `high` in h.
 */
struct hole {
  double low[3][2], high[3][2]; /* counterclockwise as seen from above */
  double h, z, x0, x1, y0, y1;
};

/**
 * int int G V dS dS of the two triangles [m2].
 *
 * A ray through p of the hole meets y of the lower plane and z = p + (p - y)(h - z)/z of the upper
 * one. So the y that p joins to the upper triangle are its image through p, cut by the lower one: a
 * convex polygon, whose factor from p is Lambert's. The outer integral runs over the hole, n x n
 * squares of 2 x 2 points: nothing is small against it.
 */
double hole_exchange(const struct hole *hole, int n);

#endif
