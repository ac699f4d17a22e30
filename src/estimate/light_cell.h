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
 * Randomised points, for an error that no feature between them can fool: RAD_REPLICATES copies of
 * a Fibonacci lattice (i/n, i step/n), each shifted by random numbers of its own from the element's
 * number, and folded by the tent 1 - |2 x - 1|, which makes any integrand periodic. In variables in
 * which all points stand for the same area: else a few of them count most, and a spread of copies
 * means nothing.
 */
struct rad_lattice {
  int n, step; /* two Fibonacci numbers that follow each other */
  int at_once; /* copies in one rad_light */
};
enum { RAD_REPLICATES = 16, RAD_N_LATTICE = 4, RAD_SCATTERED = 22 /* lights of all lattices */ };
extern const struct rad_lattice rad_lattice[RAD_N_LATTICE];

/* Copies first .. first + at_once, one after another; the flux of a copy sums to its int w dS. */
void rad_light_scatter(const struct rad_weights *w, const struct rad_light_cell *cell,
                       const struct rad_lattice *lattice, int first, struct rad_light *light);

#endif
