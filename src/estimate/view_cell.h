/* Parts of a triangle for cubature: cells that shrink towards vertices, and points on them. */
#ifndef RAD_ESTIMATE_VIEW_CELL_H
#define RAD_ESTIMATE_VIEW_CELL_H

#include "base/gauss.h"

/* A cell is a triangle within a triangle. Its corners are sums of powers of two, so exact. */
struct rad_view_cell {
  int triangle, depth;
  int at_vertex;       /* corner 0 is a vertex of the triangle, where h depends on the direction */
  double corner[3][3]; /* barycentric */
};

enum { RAD_CELL_CHILDREN = 5 };

/**
 * Halve every side: four cells. The new cell at a vertex is halved once more, from there: its
 * width as seen from the vertex shrinks too, which a similar cell's would not.
 *
 * @param[out] child  [RAD_CELL_CHILDREN]
 * @return 4 or 5
 */
int rad_view_cell_split(const struct rad_view_cell *cell, struct rad_view_cell *child);

/* The whole of a triangle; to be split before use, because a cell may have one vertex only. */
struct rad_view_cell rad_view_cell_whole(int triangle);

/* Area of the cell over that of its triangle. */
double rad_view_cell_share(const struct rad_view_cell *cell);

/**
 * Gauss points on x = (1 - r) c_0 + r (1 - t) c_1 + r t c_2, dS = 2 area r dr dt     (theory 12.2)
 *
 * @param[in]  n       points per direction
 * @param[out] mu      [n n] as in rad_patch, counted from the vertex that is returned, the nearest
 * @param[out] weight  [n n] sum: 1
 */
int rad_view_cell_points(const struct rad_gauss *g, const struct rad_view_cell *cell, int n,
                         double (*mu)[2], double *weight);

#endif
