/* The mesh: patches, elements with their trial functions, and collocation points. */
#ifndef RAD_MESH_MESH_H
#define RAD_MESH_MESH_H

#include <math.h>

#include "base/nodes.h"
#include "mesh/patch.h"

/**
 * Trial functions of an element: L_a(sigma) L_c(tau), phi = sigma^p_phi, r = tau^p_r, number
 * a + k_phi c, Lagrange on the k_phi x k_r points of [sigma0, sigma1] x [tau0, tau1] that the
 * mesh's nodes say, Gauss points but for experiments (theory 4.1). With `fold` (uniform mesh,
 * degree 1) they are sums of these: function f = sum_b fold[f,b] L_b (theory 4.2).
 */
struct rad_element {
  int patch;
  double sigma[2], tau[2];
  double p_phi, p_r;  /* exponents of the graded variables; whole numbers unless 1 */
  int k_phi, k_r;     /* points per direction = degree + 1 */
  int first;          /* its first collocation point = unknown */
  int n_function;     /* k_phi k_r, or rows of fold */
  const double *fold; /* [n_function, k_phi k_r] or NULL */
};

struct rad_mesh {
  const struct rad_scene *scene; /* borrowed */
  struct rad_gauss gauss;
  struct rad_nodes nodes;
  int n_patch, n_element, n_point;
  struct rad_patch *patch;     /* owned [n_patch], by triangle */
  struct rad_element *element; /* owned [n_element], by patch */
  int *patch_first;            /* owned [n_triangle + 1] first patch of a triangle */
  int *element_first;          /* owned [n_patch + 1] first element of a patch */
  int *point_first;            /* owned [n_triangle + 1] first point of a triangle */
  int *point_base;             /* owned [n_point] vertex 0..2 that mu counts from */
  double (*point_mu)[2];       /* owned [n_point] (see rad_patch) */
  double fold[12];             /* of the uniform mesh with degree 1 */
  int failed;                  /* while building: out of memory */
};

enum { RAD_MAX_POINT = 2000000000 };

/* phi or r of points that stand for the limit at an edge or vertex. */
#define RAD_LIMIT 1e-25

/* Building by hand: begin, then patches in the order of triangles, each followed by its elements
 * (of which patch, first and n_function are set), then finish. nodes: NULL for Gauss points. */
enum rad_code rad_mesh_begin(const struct rad_scene *scene, const struct rad_node_choice *nodes,
                             struct rad_mesh *mesh, struct rad_error *e);
void rad_mesh_add_patch(struct rad_mesh *mesh, const struct rad_patch *patch);
void rad_mesh_add_element(struct rad_mesh *mesh, struct rad_element element);
enum rad_code rad_mesh_finish(struct rad_mesh *mesh, struct rad_error *e);

/* Unknowns of that mesh, and its elements, counted without building it. */
double rad_mesh_count(const struct rad_scene *scene, const struct rad_deck_method *method,
                      double *n_element);

/**
 * Build the mesh that a deck's `method` asks for.
 *
 * @param[out] mesh  to be freed with rad_mesh_free, also after an error
 */
enum rad_code rad_mesh_build(const struct rad_scene *scene, const struct rad_deck_method *method,
                             struct rad_mesh *mesh, struct rad_error *e);
void rad_mesh_free(struct rad_mesh *mesh); /* safe twice */

/* x^p and x^(1/p): from a graded variable to phi or r, and back. */
static inline double rad_graded(double x, double p) {
  return p == 1 ? x : pow(x, p);
}

static inline double rad_ungraded(double x, double p) {
  return p == 1 ? x : pow(x, 1 / p);
}

/* Local coordinates (phi, r) of collocation point b of an element. */
void rad_element_point(const struct rad_mesh *mesh, const struct rad_element *e, int b, double *phi,
                       double *r);

/* Triangle of an element; position of a point in space [m]. */
int rad_element_triangle(const struct rad_mesh *mesh, int element);
int rad_point_triangle(const struct rad_mesh *mesh, int point);
void rad_point_position(const struct rad_mesh *mesh, int point, double x[3]);

/* E at a point of a triangle given by mu from vertex base: linear between the vertex values, or
 * what emission_at says. */
double rad_emission(const struct rad_scene *scene, int triangle, int band, int base,
                    const double mu[2]);

/* rho and E of the scene at all collocation points, each [n_band, n_point]. */
void rad_mesh_data(const struct rad_mesh *mesh, double *rho, double *emission);

/* Values of the element's n_function trial functions at (phi, r). */
void rad_element_basis(const struct rad_mesh *mesh, int element, double phi, double r,
                       double *value);

/* The element of a patch that holds (phi, r); elements own their lower sides. */
int rad_mesh_locate(const struct rad_mesh *mesh, int patch, double phi, double r);

/* u_h at (phi, r) of a patch from the unknowns u [n_point]. */
double rad_mesh_evaluate(const struct rad_mesh *mesh, const double *u, int patch, double phi,
                         double r);

#endif
