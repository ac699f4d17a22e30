/* What casts shadows: the scene's triangles, merged to convex polygons where they are coplanar. */
#ifndef RAD_VISIBILITY_OCCLUDER_H
#define RAD_VISIBILITY_OCCLUDER_H

#include <stdint.h>

#include "scene/scene.h"

enum { RAD_MAX_OCCLUDER_CORNER = 8 };

/* A plane convex polygon; both sides block light. */
struct rad_occluder {
  int plane;        /* its plane, see rad_occluders.plane */
  int n;            /* corners, 3 .. RAD_MAX_OCCLUDER_CORNER */
  int first;        /* of its corners */
  double normal[3]; /* unit, the same for all polygons of a plane; the corners run counterclockwise
                       about it */
  double low[3], high[3];
};

/**
 * Coplanar triangles that share edges form one plane; its outline, without the corners that lie
 * within straight sides, is cut into convex polygons. So the cost of shadows follows the shapes,
 * not their subdivision.
 */
struct rad_occluders {
  const struct rad_scene *scene; /* borrowed */
  int n, n_plane;
  struct rad_occluder *occluder; /* owned [n] */
  int *corner;                   /* owned [sum of n] scene vertices */
  double (*inward)[3]; /* owned [sum of n]: of the side from corner c to the next, the unit
                          normal in the plane that points into the polygon */
  int *on_line_first;  /* owned [sum of n + 1] of the side from corner c to the next */
  int *on_line;        /* owned: scene vertices of the plane on that side's line, ascending;
                          its two corners among them */
  int *plane;          /* owned [n_triangle] plane that a triangle belongs to */
  int *in_plane_first; /* owned [n_plane + 1] */
  int *in_plane;       /* owned: scene vertices of each plane's triangles, ascending */
  int *plane_of_first; /* owned [n_vertex + 1] */
  int *plane_of;       /* owned: the planes of each scene vertex, ascending */
  double slack;        /* overlaps up to this are none: the welding distance or, far from
                          the origin, the rounding of coordinates [m] */
  double rounding;     /* of coordinates [m] */
  struct rad_bvh *bvh; /* owned: over the polygons that can cast shadows at all */
};

/**
 * Triangles belong to one plane if a chain of shared edges joins them within rounding (1e-12) of
 * the plane of the chain's largest. The polygons of a plane are disjoint but for their sides and
 * cover the same points as its triangles, within rounding; a side keeps on its line the vertices
 * that were dropped from it. A plane with the whole scene on one side shadows nothing: its polygons
 * are not in the bvh, which is empty for a convex scene.
 *
 * @param[out] o  to be freed with rad_occluders_free, also after an error
 * @return RAD_OK, or RAD_ESYSTEM without memory. Cost n log n.
 */
enum rad_code rad_occluders_build(const struct rad_scene *scene, struct rad_occluders *o,
                                  struct rad_error *e);
void rad_occluders_free(struct rad_occluders *o); /* safe twice */

/* True if a scene vertex is on the line of side `side` (numbered as in corner), or in a plane, by
 * topology. */
int rad_on_line(const struct rad_occluders *o, int side, int vertex);
int rad_in_plane(const struct rad_occluders *o, int plane, int vertex);

enum rad_sight { RAD_HIDDEN, RAD_FREE, RAD_PARTLY };

/**
 * What triangles i and j see of one another; RAD_HIDDEN if they do not face each other (rad_faces).
 *
 * RAD_FREE and RAD_HIDDEN are certain for every pair of points (hidden: one polygon is pierced by
 * all segments); RAD_PARTLY is conservative and comes with the polygons that may stand between.
 * Symmetric in i and j. Polygons in the plane of i or of j never block, by topology. Overlaps below
 * o->slack are rounding: touching is no blocking.
 *
 * @param[out] list  [o->n] occluders, ascending; n: their number, 0 unless RAD_PARTLY; both may be
 *                   NULL
 */
enum rad_sight rad_sight_between(const struct rad_occluders *o, int i, int j, int *list, int *n);

/* The blockers of the RAD_PARTLY pairs (i, j), j > i, of one triangle: j, their number, and they,
 * one pair after another, j ascending. */
struct rad_sight_row {
  int n, full; /* numbers in data; 1: some pairs were left out */
  int *data;   /* owned [n] */
};

/**
 * rad_sight_between of all pairs, by all threads.
 *
 * @param[in]  most  numbers that the rows may store in all
 * @param[out] row   [n_triangle], zero at first; what is stored depends on the threads if `most` is
 *                   too small, what is said does not
 * @return owned [n_triangle, n_triangle] enum rad_sight, to be freed with free; symmetric, the
 *         diagonal RAD_HIDDEN; NULL without memory
 */
unsigned char *rad_sight_matrix(const struct rad_occluders *o, int64_t most,
                                struct rad_sight_row *row);

#endif
