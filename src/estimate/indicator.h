/* How far the iterated solution u* is from u: measured element by element, and bounded. */
#ifndef RAD_ESTIMATE_INDICATOR_H
#define RAD_ESTIMATE_INDICATOR_H

#include "estimate/feet.h"

/**
 * With d = u* - u_h:  u - u* = (I - rho K)^{-1} rho K d, so with w = (I - rho K)^{-1} 1
 * (theory 6.2)
 *
 *   |u - u*|(x) <= z(x),  z = (I - rho K)^{-1} |rho K d|,   max z <= max |rho K d| max w
 *
 * d is known at the Gauss points of a finer mesh (MORE points more in each direction), and rho K d
 * at check points that crowd at edges and vertices.
 */
struct rad_indicator {
  double *scale; /* owned [n_band] max |u*| found [W/m2] */
  double worst;  /* max over check points and bands of |rho K d| / scale */
  double wanted; /* the same with the weights that the caller wants */
  double limit;  /* the same with the limits at edges and vertices */
  double spread; /* at the worst points: most of sum |parts of the elements| over the largest */
  double change; /* max |d| / scale */
  double *local; /* owned [n_element] max of |rho K d| / scale at the element's check points */
  double *local_limit; /* owned [n_element] the same with the limits at edges and vertices */
  double *part; /* owned [n_element] max over check points of |rho K d_e| / scale, weighed as wanted
                 */
  double *tail_phi,
      *tail_r;      /* owned [n_element] size of u*'s modes beyond the element's, over scale */
  double *received; /* owned [n_element, n_band] max of |K d| / scale at the element's check points,
                       black faces included: what h of u_h may lack */
  double *received_limit;  /* owned [n_element, n_band] the same with the limits at edges */
  double *unseen_received; /* owned [n_triangle, n_band] the same between the samples (6.10) */
  struct rad_mesh fine;    /* owned: the finer mesh */
  double *star;            /* owned [n_band, fine.n_point] u* there [W/m2] */
  double *unseen; /* owned [n_triangle] most that d between the samples does to rho K d (6.10) */
  double worst_unseen, wanted_unseen; /* the largest, by both weights */
  struct rad_feet feet;               /* where that may be */
  double *rate_phi, *rate_r;          /* owned [n_element] decay of its modes: e^-rate per degree */
};

/* Points more per direction of the finer mesh; in triangles on which shadows may fall, where d has
 * kinks, twice as many. */
enum { RAD_MORE = 2, RAD_MORE_SHADED = 4 };

/**
 * @param[in]  mesh     without folded elements
 * @param[in]  passive  [n_triangle] see rad_layout, or NULL: all triangles have rows
 * @param[in]  wanted   [n_triangle, n_band] or NULL: weights of K d that are to be small, where
 * they are larger than rho
 * @param[in]  u  [n_band, n_point] solution on mesh
 * @param[in]  enough  if a quarter of the check points finds `wanted` above this, the rest is left
 *                     out: such a mesh will be refined anyway
 * @param[out] x  to be freed with rad_indicator_free, also after an error
 */
enum rad_code rad_indicate(const struct rad_mesh *mesh, const struct rad_rules *rules,
                           const unsigned char *passive, const double *wanted, const double *u,
                           double enough, struct rad_indicator *x, struct rad_error *e);
/* Points at which rad_indicate forms u* and K d, all of them. */
double rad_indicate_points(const struct rad_mesh *mesh);

/* Bytes that rad_indicate takes at most, for what is not the mesh. */
double rad_indicate_bytes(const struct rad_mesh *mesh, double tolerance);

/* max |u*| over the bands [W/m2]: what relative numbers refer to. */
double rad_indicator_scale(const struct rad_indicator *x, int n_band);

void rad_indicator_free(struct rad_indicator *x); /* safe twice */

#endif
