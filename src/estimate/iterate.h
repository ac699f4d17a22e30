/* The iterated (Sloan) solution u* = E + rho K u_h at any point of the scene. */
#ifndef RAD_ESTIMATE_ITERATE_H
#define RAD_ESTIMATE_ITERATE_H

#include "system/h2_once.h"

/* Points on triangles, positions as in rad_patch; runs of one triangle are worked on together. */
struct rad_point_list {
  int n;
  const int *triangle;   /* [n] */
  const int *base;       /* [n] */
  const double (*mu)[2]; /* [n] */
};

/* What is done with rows of K: `row` holds [m, n_point] column-major, m points from `first` on of
 * the list; only the columns of triangles that the points' triangle sees are set. */
typedef void rad_row_visitor(void *context, int thread, int first, int m, const double *row);

/**
 * Rows of K at points, batch by batch, in parallel; a batch is a run of points of one triangle.
 *
 * @param[in]  sees  [n_triangle, n_triangle] of the scene's visibility
 * @param      visit called once a batch, from the thread that made it
 * @return RAD_ESTOPPED once rad_stop_asked(); then some batches were not visited
 */
enum rad_code rad_visit_rows(const struct rad_mesh *mesh, const struct rad_rules *rules,
                             const unsigned char *sees, const struct rad_point_list *points,
                             rad_row_visitor *visit, void *context, struct rad_error *e);

/**
 * Irradiance h = K u at points, by the integrator that made the matrix, in parallel.
 *
 *   u*(x) = E(x) + rho h(x)                                                          (theory 6.1)
 *
 * @param[in]  u     [n_band, n_point] radiosity at the collocation points [W/m2]
 * @param[out] h     [n, n_band] [W/m2]
 */
enum rad_code rad_irradiance_at(const struct rad_mesh *mesh, const struct rad_rules *rules,
                                const struct rad_point_list *points, int n_band, const double *u,
                                double *h, struct rad_error *e);

enum { RAD_ONCE_LEAF = 64 }; /* unknowns of a leaf, for products made once */

/**
 * The same at many points of the mesh's elements, far parts by interpolation to rules->tolerance
 * times max |u| (theory 14.9): cost about that of n rows of near integrals.
 *
 * @param[in]  n       size of a band in h, points of no element included
 * @param[in]  u       [n_band, mesh->n_point]
 * @param[out] h       [n_band, n], written where points are [W/m2]
 */
enum rad_code rad_irradiance_on(const struct rad_mesh *mesh, const struct rad_rules *rules,
                                const struct rad_element_points *points, int n, int n_band,
                                const double *u, double *h, struct rad_error *e);

/* What no integral should be. */
enum rad_code rad_fail_integral(const struct rad_scene *s, int triangle, struct rad_error *e);

/* u* = E + rho h at points (theory 6.1); h and u [n, n_band] may be the same array. */
void rad_iterated(const struct rad_scene *scene, const struct rad_point_list *points,
                  const double *h, double *u);

#endif
