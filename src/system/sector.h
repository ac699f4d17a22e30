/* Sectors of fans: what their points receive is smooth in the angle, and few points know it. */
#ifndef RAD_SYSTEM_SECTOR_H
#define RAD_SYSTEM_SECTOR_H

#include "system/interpolate.h"

enum { RAD_MAX_PLACES = RAD_MAX_INTERPOLATION * RAD_GAUSS_MAX };

/**
 * The points of a cluster of one fan lie on k_r lines v + r_j (a + t b), t in [t_0, t_1]. From
 * sources that are far from each line, for its length, they receive nearly the polynomial in t
 * through what q places of the line receive, the Chebyshev points of [t_0, t_1] (theory 14.10).
 */
struct rad_sector {
  const struct rad_patch *patch;
  double t[2];
  int n_radius;
  double radius[RAD_GAUSS_MAX];
};

void rad_sector_set(const struct rad_tree *tree, const struct rad_cluster *c,
                    struct rad_sector *sector);

/* The least distance of a line from a cluster, over the length of the line; 0 for lines that are
 * shorter than rounding allows. */
double rad_sector_distance(const struct rad_tree *tree, const struct rad_sector *sector,
                           const struct rad_cluster *source);

/* Places: number l + q j at Chebyshev point l of line j. */
static inline int rad_sector_places(const struct rad_tree *tree, int q,
                                    const struct rad_cluster *c) {
  return q * tree->mesh->element[tree->element[c->element]].k_r;
}

/* A place, as mu from the vertex patch->base. */
void rad_sector_place(const struct rad_interpolation *p, const struct rad_sector *sector, int place,
                      double mu[2]);

/* spread[i + n place]: the share of a place in the value at unknown i of the cluster's n. */
void rad_sector_spread(const struct rad_interpolation *p, const struct rad_tree *tree,
                       const struct rad_cluster *c, const struct rad_sector *sector,
                       double *spread);

#endif
