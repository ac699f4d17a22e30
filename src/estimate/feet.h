/* Where light may change within less than the estimate's samples see: on a face, below the vertices
 * and edges of what is close above it. */
#ifndef RAD_ESTIMATE_FEET_H
#define RAD_ESTIMATE_FEET_H

#include "integrate/rule.h"

/**
 * A segment near a face. Its foot on the face is the nearest point to it there, and what happens
 * around the foot is about as wide as the distance is long (theory 6.10).
 */
struct rad_feature {
  int face, near;   /* triangles: where the foot is, and the other one */
  int own;          /* the segment is an edge of the face itself; the distance is that to `near` */
  double p[2][3];   /* ends [m]; equal for the middle of `near` */
  double width;     /* least width of what happens at the foot [m]: 0, or the size of `near` */
  double across[3]; /* unit vector in the face, the only direction in which things change there;
                       0 if there is no such direction */
};

/* A foot that the mesh does not resolve. */
struct rad_foot {
  int feature;
  double from, to; /* the part of the segment that it stands for */
  int element;     /* of the mesh, where it is */
  int base;        /* its place, in the triangle and in the element's patch */
  double mu[2], phi, r, x[3];
  double width;  /* [m] */
  double effect; /* of its gap on rho K d, over scale; set by rad_feet_gaps */
  double missed; /* irradiance there that the samples do not show [W/m2]; the same */
};

struct rad_feet {
  int n_feature, n_foot;
  size_t room_feature, room_foot;
  struct rad_feature *feature; /* owned [n_feature], by face */
  struct rad_foot *foot;       /* owned [n_foot], by face */
};

/**
 * The features of a scene and the feet that a mesh does not resolve: those at which the distance
 * between the points of the estimate is more than a part of the width.
 *
 * @param[in]  sees     [n_triangle, n_triangle] of the scene's visibility
 * @param[in]  passive  [n_triangle] faces to leave out, or NULL
 * @param[out] feet     to be freed with rad_feet_free, also after an error
 */
enum rad_code rad_feet_find(const struct rad_mesh *mesh, const unsigned char *sees,
                            const unsigned char *passive, struct rad_feet *feet,
                            struct rad_error *e);
void rad_feet_free(struct rad_feet *feet); /* safe twice */

/* Unresolved feet of one part of a feature in another mesh, appended to `feet`, which has the
 * features. 0 without memory. */
int rad_feet_walk(const struct rad_mesh *mesh, int feature, double from, double to,
                  struct rad_feet *feet);

/**
 * What d beyond its interpolant may do (6.10).
 *
 * @param[in]  fine    mesh with more points per element, in which u* is known
 * @param[in]  u       [n_band, mesh->n_point] solution on mesh
 * @param[in]  star,d  [n_band, fine->n_point] u*, and u* - u_h over scale
 * @param[in]  scale   [n_band]
 * @param[in]  weight  [n_triangle, n_band] of K d
 * @param      feet    their effects, and what is missed, are set
 * @param[out] received  [n_triangle, n_band] most that all gaps together do to K d on a triangle
 */
enum rad_code rad_feet_gaps(const struct rad_mesh *mesh, const struct rad_mesh *fine,
                            const struct rad_rules *rules, const double *u, const double *star,
                            const double *d, const double *scale, const double *weight,
                            struct rad_feet *feet, double *received, struct rad_error *e);

/* Whether an element resolves a width at (phi, r), by direction; across as in rad_feature. */
void rad_unresolved(const struct rad_mesh *mesh, int element, double phi, double r, double width,
                    const double across[3], int *in_phi, int *in_r);

/* The point of a triangle nearest to x, as barycentric weights; returns the distance [m]. */
double rad_nearest_point(const struct rad_triangle *t, const double x[3], double weight[3]);

#endif
