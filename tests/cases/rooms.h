/* Scenes with their visibility and a mesh, points on them, and what each point receives of each
 * triangle. */
#ifndef POLYRAD_TEST_ROOMS_H
#define POLYRAD_TEST_ROOMS_H

#include "mesh/mesh.h"
#include "unit/scene_help.h"
#include "visibility/visibility.h"

struct room {
  struct rad_scene scene;
  struct rad_visibility visibility;
};

/* Build the deck's scene, and free the deck. */
void room_make(struct rad_deck *deck, struct room *room);
void room_free(struct room *room);

enum { MOST_SPOT = 1 << 14 };

struct spots {
  int n, triangle[MOST_SPOT], base[MOST_SPOT];
  double mu[MOST_SPOT][2];
};

void add_spot(struct spots *s, int triangle, int base, double mu1, double mu2);

/* At this distance, relative to the triangle, from each edge and each vertex. */
void add_border_spots(struct spots *s, int triangle, double distance);

/* Position of a spot [m]. */
void spot_position(const struct room *room, const struct spots *s, int i, double x[3]);

extern const struct rad_deck_method method_constant, method_folded, method_paper, method_graded;

/**
 * What spots receive of each triangle of radiosity 1: sums of the rows of K.
 *
 * @param[in]  visible  0: as if shadows had not been looked for
 * @return owned [spots, n_triangle]
 */
double *receive(struct room *room, const struct rad_deck_method *method, double tolerance,
                const struct spots *s, int visible);

/* The matrix K of a mesh. */
struct rad_dense;
void assemble(const struct room *room, const struct rad_deck_method *method, double tolerance,
              struct rad_mesh *mesh, struct rad_dense *dense);

/* A box low .. high, before the motion; its front is outside. */
void add_box(struct rad_deck *deck, const struct motion *motion, const double low[3],
             const double high[3], enum rad_side side);

#endif
