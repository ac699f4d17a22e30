/* Where what a cell sees of its target is not analytic: lines by construction. */
#ifndef RAD_FACTORS_CRITICAL_H
#define RAD_FACTORS_CRITICAL_H

#include "factors/pair.h"
#include "factors/shaft.h"

enum { RAD_MAX_SILHOUETTE = 24, RAD_MAX_LINE = 8 };

/* An edge of a blocker in the shaft, beyond which light passes. */
struct rad_silhouette {
  const double *p, *q; /* its ends */
  int vertex[2];       /* scene vertices */
  int plane, body;     /* body: convex, or -1 */
};

/* Silhouettes of one convex body never cross. */
static inline int rad_same_body(const struct rad_silhouette *a, const struct rad_silhouette *b) {
  return a->body >= 0 && a->body == b->body;
}

struct rad_critical {
  int n_edge, n_line;
  int crowded; /* more edges or lines than there is room for: nothing is known */
  int skew;    /* edges in two planes: three may meet in one ray, on a curve that is no line */
  struct rad_silhouette edge[RAD_MAX_SILHOUETTE];
  double line[RAD_MAX_LINE][3]; /* values at the cell's corners of a function that is affine on the
                                   cell and 0 on the line: distances [m], but for the sign */
};

/**
 * F(y -> target) has no series where, as seen from y, an edge passes over a vertex: y is on the
 * plane through both. These planes cut the cell in lines; edges are those of the blockers and of
 * the target, and so are vertices. Edges inside a merged surface are none, nor are those of a body
 * beyond which, from all of the cell, another face of it goes on. Lines whose event is not seen
 * from the cell, or not before the target, are left out. Where y crosses the plane of a blocker is
 * a line as well.
 *
 * @param[in]  cell   three corners, oriented;  n, list: blockers in the shaft (numbers in the pair)
 * @param[in]  mark   [occluders.n] equal to `now` for those blockers
 */
void rad_critical_find(const struct rad_pair *p, const struct rad_flat *cell,
                       const struct rad_shaft *shaft, int n, const int *list, const int *mark,
                       int now, struct rad_critical *c);

/* True if the cell is small against its distance from all edges, of the target and the blockers, or
 * touches them: then F is analytic in a neighbourhood that is not small against the cell. */
int rad_critical_far(const struct rad_pair *p, const struct rad_flat *cell,
                     const struct rad_critical *c);

#endif
