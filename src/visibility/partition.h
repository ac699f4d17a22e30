/* The triangles of one plane as few convex polygons. */
#ifndef RAD_VISIBILITY_PARTITION_H
#define RAD_VISIBILITY_PARTITION_H

struct rad_partition {
  int n;           /* polygons */
  int n_crowded;   /* edges with more than one triangle on a side */
  int *first;      /* owned [n + 1] of a polygon's corners */
  int *corner;     /* owned: points, counterclockwise */
  int *line_first; /* owned [first[n] + 1] of the side from corner c to the next */
  int *line;       /* owned: points on that side between its corners, in any order */
};

/**
 * Merge triangles over shared edges to convex polygons that cover the same points.
 *
 * First points are taken away, one at a time, as long as the triangles around one can be replaced
 * by fewer of its neighbours: points with triangles all around, and those in a straight part of the
 * outline (Kirkpatrick 1983). What is left has the outline's corners only and its triangles are
 * merged over the longest edges first (Hertel and Mehlhorn 1983). Every step leaves the union as it
 * is, whatever else overlaps; edges with other than one triangle on either side are kept as they
 * are.
 *
 * @param[in] point     [n_point][2]
 * @param[in] triangle  [n_triangle][3] points, counterclockwise but for rounding
 * @param[in] rounding  distance from a line that counts as zero
 * @param[in] n_most    corners of a polygon, at least 3
 * @param[out] p        to be freed with rad_partition_free, also after an error
 * @return 0, or -1 without memory. Cost n log n, and m^2 for a point with m triangles around.
 */
int rad_partition_make(int n_point, const double (*point)[2], int n_triangle,
                       const int (*triangle)[3], double rounding, int n_most,
                       struct rad_partition *p);
void rad_partition_free(struct rad_partition *p); /* safe twice */

#endif
