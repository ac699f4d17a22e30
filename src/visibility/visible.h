/* The visible part of a convex polygon: itself without the shadows that fall on it. */
#ifndef RAD_VISIBILITY_VISIBLE_H
#define RAD_VISIBILITY_VISIBLE_H

#include "visibility/clip.h"
#include "visibility/shadow.h"

/* c[s][0] + c[s][1] x + c[s][2] y > 0 for all s < n: a shadow in the polygon's coordinates. */
struct rad_half_planes {
  int n; /* at least 1 */
  double c[RAD_MAX_SHADOW_SIDE][3];
};

/**
 * A shadow, n > 0, in the coordinates of polygons of the source triangle.
 *
 * (x, y) is the point mu = mu0 + x mu_x + y mu_y, counted from the source's vertex base; with mu0 =
 * (0, 0) borders through that vertex are exact, and with mu_x = (1, 0) or (0, 1) also those along
 * an edge there.
 */
static inline void rad_half_planes_set(const struct rad_shadow *shadow, int base,
                                       const double mu0[2], const double mu_x[2],
                                       const double mu_y[2], struct rad_half_planes *h) {
  h->n = shadow->n;
  for (int s = 0; s < shadow->n; s++) {
    const double *f = shadow->value[s];
    double at = f[base], f1 = f[(base + 1) % 3] - at, f2 = f[(base + 2) % 3] - at;
    h->c[s][0] = at + (f1 * mu0[0] + f2 * mu0[1]);
    h->c[s][1] = f1 * mu_x[0] + f2 * mu_x[1];
    h->c[s][2] = f1 * mu_y[0] + f2 * mu_y[1];
  }
}

/* Convex polygons, disjoint but for their sides. */
struct rad_parts {
  int n, room;
  struct rad_polygon *part; /* owned [room] */
};

void rad_parts_free(struct rad_parts *parts); /* safe twice */
double rad_parts_area(const struct rad_parts *parts);

/**
 * What a shadow leaves of a polygon, without cutting it.
 *
 * @return RAD_FREE if a border of the shadow keeps it off the polygon, RAD_HIDDEN if it covers the
 *         polygon, else RAD_PARTLY: most of these are cut, and some missed at a slant
 */
enum rad_sight rad_shadow_over(const struct rad_polygon *polygon,
                               const struct rad_half_planes *shadow);

/**
 * parts = polygon minus the union of the shadows.
 *
 * One shadow after another is taken off each piece it falls on, by one half-plane after another,
 * the deepest cut first; what is left then is hidden. Pieces below 1e-30 of the polygon's area are
 * dropped. The same input gives the same bits.
 *
 * @param[in]     polygon  at most RAD_MAX_CORNER corners, either orientation
 * @param[in,out] parts    grows as needed, zero at first; to be freed with rad_parts_free
 * @return RAD_FREE if no shadow falls on the polygon (then parts holds just it), RAD_HIDDEN (n =
 *         0; also if the polygon has no area), RAD_PARTLY; -1 without memory
 */
int rad_visible(const struct rad_polygon *polygon, int n_shadow,
                const struct rad_half_planes *shadow, struct rad_parts *parts);

#endif
