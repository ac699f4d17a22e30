/* Two triangles, one as seen from points of the other. */
#ifndef RAD_FACTORS_PAIR_H
#define RAD_FACTORS_PAIR_H

#include "factors/engine.h"
#include "factors/flat.h"
#include "visibility/shadow.h"
#include "visibility/visible.h"

/* The source is the outer side: points y run over it, and the target is seen from there. */
struct rad_pair {
  const struct rad_pair_engine *g;
  int source, target;
  const struct rad_triangle *s, *t;
  struct rad_polygon front;       /* of the target in front of the source's plane, in (b1, b2) */
  struct rad_flat face;           /* the same in space */
  double size;                    /* diameter of both [m] */
  int n_blocker;                  /* what may stand between */
  const int *blocker;             /* occluders */
  struct rad_shadow_frame *frame; /* owned [room] */
  int *list;                      /* owned [occluders.n] */
  struct rad_half_planes *shadow; /* owned [room] at one point */
  size_t frame_room, shadow_room;
  struct rad_parts parts; /* owned; visible at one point */
};

/* Set out with a pair; 0 if they do not face each other or the sight is RAD_HIDDEN, -1 without
 * memory, else 1. A pair that was zero or used before; to be freed with rad_pair_free. */
int rad_pair_set(const struct rad_pair_engine *g, int source, int target, struct rad_pair *p);
/* The same without blockers, whatever the sight. */
int rad_pair_set_unobstructed(const struct rad_pair_engine *g, int source, int target,
                              struct rad_pair *p);
void rad_pair_free(struct rad_pair *p); /* safe twice */

/* The part of a cell of the source in front of the target's plane: a convex polygon in (l1, l2),
 * the second and third barycentric coordinate. */
void rad_pair_front(const struct rad_pair *p, const double corner[3][3], struct rad_polygon *part);

/**
 * F(y -> target) with the shadows of the listed blockers, exact.
 *
 * @param[in] n, list  numbers in p->blocker;  lambda: barycentric coordinates of y
 * @return -1 without memory
 */
double rad_pair_seen(struct rad_pair *p, int n, const int *list, const double lambda[3]);

#endif
