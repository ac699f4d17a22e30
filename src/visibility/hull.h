/* What lies between two triangles, and whether a plane keeps a polygon out of it. */
#ifndef RAD_VISIBILITY_HULL_H
#define RAD_VISIBILITY_HULL_H

#include "scene/scene.h"

enum { RAD_MAX_HULL = 8 }; /* two triangles, each cut once */

/* Corners of the convex hull of triangles i and j, each cut at the other's plane: the union of all
 * segments between them. */
struct rad_hull {
  int n, n_first; /* corners; those of i come first */
  double corner[RAD_MAX_HULL][3];
  int vertex[RAD_MAX_HULL]; /* scene vertex, or -1 where an edge is cut */
  double low[3], high[3];
};

/* Fill in the hull; 0, and nothing filled in, if i and j do not face each other (rad_faces). */
int rad_hull_make(struct rad_hull *hull, const struct rad_triangle *i,
                  const struct rad_triangle *j);

/**
 * True if a plane separates the hull, weakly, from a convex polygon.
 *
 * Separating-axis theorem: the faces of the Minkowski difference hull - polygon are faces of the
 * hull, the polygon, and edge times edge. Which corners span faces and edges of the hull is not
 * worked out: all do as candidates, at most 56 + 28 n.
 *
 * @param[in] slack   overlaps up to this are none [m]
 * @param[in] normal  of the polygon;  corner: [n]
 */
int rad_hull_separated(const struct rad_hull *hull, double slack, const double normal[3], int n,
                       const double (*corner)[3]);

#endif
