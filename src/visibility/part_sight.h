/* What parts of two triangles see of one another. */
#ifndef RAD_VISIBILITY_PART_SIGHT_H
#define RAD_VISIBILITY_PART_SIGHT_H

#include "visibility/occluder.h"

enum { RAD_MAX_PART_CORNER = 10 };

/* A convex part of a triangle. */
struct rad_part {
  int n;
  double corner[RAD_MAX_PART_CORNER][3]; /* in order [m] */
};

/**
 * What convex parts p of triangle i and q of triangle j, each in front of the other's plane, see of
 * one another, given the occluders that may stand between the triangles.
 *
 * RAD_FREE and RAD_HIDDEN are certain for every pair of points but for overlaps and gaps below
 * o->slack, which are rounding; RAD_PARTLY is conservative.
 *
 * @param[in]     list  [*n] occluders, as rad_sight_between lists them for i and j or for parts
 *                      that hold p and q
 * @param[in,out] n     their number; out: of those that may stand between p and q, kept in list
 */
enum rad_sight rad_sight_parts(const struct rad_occluders *o, const struct rad_part *p,
                               const struct rad_part *q, int *list, int *n);

#endif
