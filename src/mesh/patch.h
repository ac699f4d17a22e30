/* Patches: a corner, two vectors and an angle map; what carries the local coordinates (phi, r). */
#ifndef RAD_MESH_PATCH_H
#define RAD_MESH_PATCH_H

#include "scene/scene.h"

/**
 * y(phi, r) = v + r (a + t(phi) b),  0 <= phi, r <= 1,  dS = |a x b| r t'(phi) dphi dr (theory 2.1)
 *
 * phi = 0 is the side that `a` runs along, r = 0 the corner. In the patch's own frame the corner is
 * the origin, e1 the direction of a, e2 the in-plane normal to it with b.e2 > 0:
 * a = (a1, 0), b = (b1, b2), so |a x b| = a1 b2.
 *
 * The same point seen from the triangle: y = V_base + mu1 F1 + mu2 F2 with the edge vectors
 * F1 = V_{base+1} - V_base, F2 = V_{base+2} - V_base; mu = mu0 + r (mu_a + t mu_b). Near a vertex
 * or an edge mu keeps its relative accuracy where coordinates would not.
 */
struct rad_patch {
  int triangle;
  int corner; /* scene vertex at the corner, or -1 */
  int toward; /* scene vertex at the other end of the edge that a runs along, or -1 */
  int base;   /* 0..2 */
  enum rad_angle angle;
  double v[3], a[3], b[3]; /* [m] */
  double e1[3], e2[3];
  double a1, b1, b2; /* [m] */
  double mu0[2], mu_a[2], mu_b[2];
};

/* The six sub-triangles, along the boundary: v0->v1, v1->v0, v1->v2, v2->v1, v2->v0, v0->v2. */
enum { RAD_N_SUB = 6 };
void rad_patch_sub_triangle(const struct rad_scene *scene, int triangle, int sub,
                            enum rad_angle angle, struct rad_patch *patch);

/**
 * A triangle of the uniform mesh, with corners at barycentric positions mu of triangle's vertex 0.
 *
 * @param[in] corner  [3][2] mu of the three corners; the first becomes r = 0
 */
void rad_patch_plain(const struct rad_scene *scene, int triangle, const double corner[3][2],
                     struct rad_patch *patch);

/* A whole triangle from one of its vertices, which counts as corner, the edge to another as side.
 */
void rad_patch_from(const struct rad_scene *scene, int triangle, int vertex, int toward,
                    struct rad_patch *patch);

/* The same from vertex 0 towards vertex 1. */
void rad_patch_whole(const struct rad_scene *scene, int triangle, struct rad_patch *patch);

/* t(phi) (2.2) and its inverse and derivative. */
double rad_angle_t(enum rad_angle angle, double phi);
double rad_angle_dt(enum rad_angle angle, double t);
double rad_angle_phi(enum rad_angle angle, double t);

/* Position in space of mu, counted from vertex base of the triangle. */
void rad_triangle_point(const struct rad_triangle *t, int base, const double mu[2], double x[3]);

/* Barycentric weights of the point of the triangle's plane nearest to x; their sum is 1. */
void rad_triangle_weights(const struct rad_triangle *t, const double x[3], double weight[3]);

/* mu of (phi, r). */
void rad_patch_mu(const struct rad_patch *patch, double phi, double r, double mu[2]);

/**
 * Find the sub-triangle patch of a triangle and (phi, r) for a point given by mu from vertex base.
 *
 * @param[in]  patch  [n] the triangle's patches, any order
 * @param[out] phi,r  clipped to [0,1]
 * @return its index in patch
 */
int rad_patch_locate(const struct rad_patch *patch, int n, int base, const double mu[2],
                     double *phi, double *r);

#endif
