/* rho K d at check points, and what each element has to do with it. */
#ifndef RAD_ESTIMATE_CHECKS_H
#define RAD_ESTIMATE_CHECKS_H

#include "system/h2_once.h"

enum { RAD_CHECKS = 36 }; /* most points of an element */

/* Distance of the check points nearest to edges and vertices, as phi or r. */
#define RAD_NEAREST 1e-7

/**
 * Check points of one pass, element by element, and K d there. Bands apart: arrays [n_band, n].
 *
 * A part is |rho K d_e|, d_e being d on element e and 0 elsewhere.
 */
struct rad_checks {
  int n, n_band;
  int *first, *count;   /* owned [n_element] points of each element */
  int *base;            /* owned [n] */
  double (*mu)[2];      /* owned [n] */
  unsigned char *limit; /* owned [n] right at an edge or vertex */
  double *total;        /* owned K d */
  double *far;          /* owned far blocks with the parts all of one sign */
  double *sum;          /* owned sum of |K d_e| */
  double *largest;      /* owned the largest of them */
  double *part;         /* owned [threads, n_element] largest part over the points but limits */
};

/**
 * 5 x 5 points of each element that crowd at its rim, and limits at edges and
 * vertices of triangles: every other one in each direction first, then the rest.
 *
 * @param[in]  checked  [n_triangle] 0: no points there
 * @param[out] c     to be freed with rad_checks_free, also after an error
 */
enum rad_code rad_checks_set(const struct rad_mesh *mesh, const unsigned char *checked, int rest,
                             struct rad_checks *c, struct rad_error *e);
void rad_checks_free(struct rad_checks *c); /* safe twice */

/**
 * What the points see of d, whose 2 n_band vectors o has gathered: d, then d with the signs of its
 * elements' integrals.
 *
 * Parts of near elements are exact. Of far ones: the sum is that of the signed vectors, the largest
 * |integral of d_e| times the mean kernel of the block; and an element's own largest part over all
 * points is found at the nodes of the far block where the kernel is largest.
 *
 * @param[in]  integral  [n_band, n_element] of d_e
 * @param[in]  weight    [n_triangle, n_band] rho, or what else weighs K d
 */
enum rad_code rad_checks_run(struct rad_once *o, const double *integral, const double *weight,
                             struct rad_checks *c, struct rad_error *e);

#endif
