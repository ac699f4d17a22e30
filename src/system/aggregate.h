/* Aggregates: the unknowns in groups of neighbours, whose means a coarse problem knows. */
#ifndef RAD_SYSTEM_AGGREGATE_H
#define RAD_SYSTEM_AGGREGATE_H

#include "system/cluster.h"

/* Each aggregate is a cluster of the tree, an element, or one unknown: a range of its order. */
struct rad_aggregates {
  int n;
  int *first;     /* owned [n + 1] in the tree's order */
  int *cluster;   /* owned [n] the cluster that it is, or the leaf that holds it */
  int *of;        /* owned [n_point] aggregate of an unknown, in the tree's order */
  double *weight; /* owned [n_point] part of an unknown in its aggregate's area, likewise */
};

/**
 * As many aggregates as `most` allows, all about equally wide: clusters are divided down to the
 * unknowns where need be. At least one a triangle; one for each unknown if there are no more.
 *
 * @param[out] a  to be freed with rad_aggregates_free, also after an error
 * Cost some tens of passes over the tree.
 */
enum rad_code rad_aggregates_build(const struct rad_tree *tree, int most, struct rad_aggregates *a,
                                   struct rad_error *e);
void rad_aggregates_free(struct rad_aggregates *a); /* safe twice */

#endif
