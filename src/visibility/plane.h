/* Which triangles form one plane. */
#ifndef RAD_VISIBILITY_PLANE_H
#define RAD_VISIBILITY_PLANE_H

#include "scene/scene.h"

struct rad_planes {
  int n;
  int *plane;        /* owned [n_triangle] */
  int *member_first; /* owned [n + 1] */
  int *member;       /* owned [n_triangle] triangles of each plane, ascending */
  int *largest;      /* owned [n] triangle whose plane it is */
};

/**
 * Join triangles over shared edges (equal scene vertex numbers, whatever side radiates) as long as
 * they lie, within rounding, in the plane of the first, the largest that is left.
 *
 * @param[in]  rounding  of coordinates [m]
 * @param[out] p         to be freed with rad_planes_free, also after an error
 * @return 0, or -1 without memory. Cost n log n.
 */
int rad_planes_find(const struct rad_scene *scene, double rounding, struct rad_planes *p);
void rad_planes_free(struct rad_planes *p); /* safe twice */

#endif
