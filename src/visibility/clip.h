/* Convex polygons in a plane, cut by half-planes. */
#ifndef RAD_VISIBILITY_CLIP_H
#define RAD_VISIBILITY_CLIP_H

enum { RAD_MAX_CORNER = 16 };

struct rad_polygon {
  int n; /* corners, in order; 0 if nothing is left */
  double corner[RAD_MAX_CORNER][2];
};

/* Keep the part where c0 + c1 x + c2 y >= 0; corners on the line stay as they are. */
void rad_clip(struct rad_polygon *polygon, double c0, double c1, double c2);

#endif
