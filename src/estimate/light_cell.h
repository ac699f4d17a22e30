/* Rectangles of an element in its graded variables, and points on them that send light. */
#ifndef RAD_ESTIMATE_LIGHT_CELL_H
#define RAD_ESTIMATE_LIGHT_CELL_H

#include "factors/cells.h"
#include "integrate/point_factor.h"

/* Functions w_k on the elements of a mesh, as values at its points. */
struct rad_weights {
  const struct rad_mesh *mesh;     /* borrowed */
  int n;                           /* at most RAD_MAX_WEIGHT */
  const double *w[RAD_MAX_WEIGHT]; /* borrowed [n_point] each */
};

struct rad_light_cell {
  int element;
  double sigma[2], tau[2];
};

/* What a cell looks like from outside. */
struct rad_cell_shape {
  double corner[4][3], centre[3]; /* [m] */
  double radius;                  /* largest distance of a corner from the centre [m] */
  int vertex;                     /* scene vertex where r = 0, if the cell touches it; else -1 */
};

/* Gauss points of a cell and what they send: flux[k][q] = w_k(y_q) dS_q [W]. */
struct rad_light {
  struct rad_senders senders;
  double dS[RAD_MAX_SENDER]; /* [m2] */
  double flux[RAD_MAX_WEIGHT][RAD_MAX_SENDER];
  double area;                 /* [m2] sum of dS_q */
  double most[RAD_MAX_WEIGHT]; /* max |w_k| at the points */
};

struct rad_light_cell rad_light_cell_whole(const struct rad_mesh *mesh, int element);

void rad_light_cell_shape(const struct rad_mesh *mesh, const struct rad_light_cell *cell,
                          struct rad_cell_shape *shape);

/* Values [n, w->n] at points of the element's triangle, as a rad_weight_at; context: rad_light_at.
 */
struct rad_light_at {
  const struct rad_weights *w;
  int element;
};
void rad_light_at(void *context, int n, const double (*lambda)[3], double *value);

/* The element as triangles; barycentric corners. Returns 1 or 2. */
int rad_light_triangles(const struct rad_mesh *mesh, int element, double corner[2][3][3]);

/* n x n Gauss points in the graded variables, n n <= RAD_MAX_SENDER.             (theory 2.1, 4.1)
 */
void rad_light_set(const struct rad_weights *w, const struct rad_light_cell *cell, int n,
                   struct rad_light *light);

/**
 * Randomised points, for an error that no feature between them can fool: each of RAD_REPLICATES
 * replicates is the R2 sequence with a random shift of its own, from the element's number.
 *
 * A batch holds the next RAD_EACH points of every replicate, one replicate after another; the flux
 * of one replicate sums to its estimate of int w dS.
 */
enum { RAD_REPLICATES = 16, RAD_EACH = 4, RAD_SCATTERED = RAD_REPLICATES * RAD_EACH };
void rad_light_scatter(const struct rad_weights *w, const struct rad_light_cell *cell, int batch,
                       struct rad_light *light);

#endif
