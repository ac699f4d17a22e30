/* Whole triangles as sources for targets that touch them. */
#ifndef RAD_INTEGRATE_TURN_H
#define RAD_INTEGRATE_TURN_H

#include "integrate/element.h"

/**
 * A whole triangle is one patch, from its vertex 0: only there and along one edge are positions
 * relative to it exact. So a target that touches it elsewhere has the triangle seen from the vertex
 * that they share. The functions of that view are others: results are right for densities that both
 * have, constants and linear ones, which is all that such elements carry (rad_layout).
 */
struct rad_turn {
  struct rad_patch patch;
  struct rad_element element;
  struct rad_mesh mesh; /* of this one element, which borrows from the other mesh */
  struct rad_rules rules;
  int first[2], zero[1];
  int angular[1], radial[1];
  double value[4][4]; /* [point of the turned element][function of the element] */
};

/* True if a patch is a whole triangle of such an element, and the target touches it. */
int rad_turn_wanted(const struct rad_mesh *mesh, int target, int patch);

/* The source as it is seen from vertex `base` of the target. Returns 0 if they do not share it:
 * then the patch serves as it is. The struct must not move. */
int rad_turn_set(const struct rad_mesh *mesh, const struct rad_rules *rules, int target, int base,
                 int patch, struct rad_turn *turn);

#endif
