/* Convex polygons in a plane, cut by half-planes. */
#ifndef RAD_VISIBILITY_CLIP_H
#define RAD_VISIBILITY_CLIP_H

enum { RAD_MAX_CORNER = 24 };

struct rad_polygon {
  int n; /* corners, in order; 0 if nothing is left */
  double corner[RAD_MAX_CORNER][2];
};

/* Keep the part where c0 + c1 x + c2 y >= 0; corners on the line stay as they are. */
void rad_clip(struct rad_polygon *polygon, double c0, double c1, double c2);

/**
 * Cut a polygon of less than RAD_MAX_CORNER corners into the part where f = c0 + c1 x + c2 y >= 0
 * and that where f <= 0. Both have the same new corners, bit by bit.
 *
 * @param[out] above  n = 0 if f > 0 at no corner;  below: n = 0 if f < 0 at none. Neither may be
 * the polygon; below may be NULL
 */
void rad_split(const struct rad_polygon *polygon, double c0, double c1, double c2,
               struct rad_polygon *above, struct rad_polygon *below);

/* Of either orientation; relative accuracy needs corners that are accurate relative to one another.
 */
double rad_polygon_area(const struct rad_polygon *polygon);

#endif
