/* The cone operator K_alpha of a vertex (exponents.h) as a matrix: collocation where v is a
 * polynomial in sigma on panels of each face's angle, with phi = sigma^GRADE towards the face's
 * edges, where v = c + C phi^beta. At Gauss points in sigma the eigenvalue converges twice as fast
 * as v, as K_alpha is symmetric but for rho. */
#ifndef RAD_MESH_CONE_H
#define RAD_MESH_CONE_H

#include "mesh/exponents.h"

enum { RAD_CONE_POINTS = 8 }; /* most unknowns on a panel */

/* Unit directions of a face: end[0] cos phi + across sin phi, 0 <= phi <= angle, to end[1]. */
struct rad_cone_sector {
  double end[2][3], across[3], normal[3], angle, rho;
};

/* phi = anchor + span sigma^p, 0 <= sigma <= 1; span < 0 if the anchor is the face's end[1]. */
struct rad_cone_panel {
  int face;
  double anchor, span;
  int p;
};

/* One quadrature point of one row of the matrix: what does not depend on alpha. */
struct rad_cone_sample {
  double q, sin2q, cos2q; /* q = pi - omega */
  double weight;          /* all but rho and the numerator of I_alpha */
  double basis[RAD_CONE_POINTS];
};

/* The samples of one collocation point and one panel. */
struct rad_cone_block {
  int row, panel, first, n;
};

struct rad_cone {
  int n_face, n_panel;
  int points, n;                /* unknowns on a panel, in all */
  struct rad_cone_sector *face; /* owned [n_face] those with rho > 0 that see another one */
  struct rad_cone_panel *panel; /* owned [n_panel] */
  int n_block, max_block, n_sample, max_sample;
  struct rad_cone_block *block;   /* owned [n_block] */
  struct rad_cone_sample *sample; /* owned [n_sample] */
};

/* Panels and samples of these faces; n_block is 0 if no two see each other. To be freed with
 * rad_cone_free, also after an error. */
enum rad_code rad_cone_build(const struct rad_gauss *g, int n_face,
                             const struct rad_cone_face *face, struct rad_cone *cone,
                             struct rad_error *e);

/* K_alpha, 0 <= alpha < 1, into k [n, n] row-major. */
void rad_cone_assemble(const struct rad_cone *cone, double alpha, double *k);

void rad_cone_free(struct rad_cone *cone); /* safe twice */

#endif
