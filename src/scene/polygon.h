/* Plane polygons cut into triangles. */
#ifndef RAD_SCENE_POLYGON_H
#define RAD_SCENE_POLYGON_H

enum rad_polygon_fault {
  RAD_POLYGON_FINE,
  RAD_POLYGON_LINE,   /* the corners lie on a line, to 1e-14 */
  RAD_POLYGON_CROSSED /* the outline crosses or touches itself, to 1e-12 of the diameter */
};

struct rad_polygon_corner {
  double at[2];      /* in the plane, right-handed about the normal */
  int before, after; /* neighbours among the corners that are left */
  double fatness;    /* of the triangle with its neighbours; 0 if that cannot be cut off */
};

struct rad_polygon {
  int n;                             /* corners, >= 3 */
  double (*x)[3];                    /* [n] corners in order [m] */
  int *vertex;                       /* [n] their numbers; where splits are equally good, the one at
                                        the lowest number is taken, from either side */
  struct rad_polygon_corner *corner; /* [n] scratch */
  int (*triangle)[3]; /* out [n - 2] corners of the triangles, oriented as the polygon */
  double bend;        /* out: largest distance from the mean plane, over the diameter */
};

/**
 * Triangulate by ear clipping, the fattest ear first; of four corners the better split.
 *
 * Fatness is 4 sqrt(3) area / (sum of squared edges): 1 for an equilateral triangle. Concave
 * outlines and corners amid a straight side are fine; every corner is used. Corners are projected
 * along the largest component of Newell's normal, so slightly bent polygons work as well.
 *
 * Cost n^2. No allocation; thread-safe.
 */
enum rad_polygon_fault rad_polygon_triangulate(struct rad_polygon *p);

#endif
