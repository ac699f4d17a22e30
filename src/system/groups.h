/* Groups of unknowns that exchange most light with one another (theory 5.7). */
#ifndef RAD_SYSTEM_GROUPS_H
#define RAD_SYSTEM_GROUPS_H

#include "system/operator.h"

enum { RAD_GROUP = 256 }; /* unknowns of a group, unless one element has more */

/* Each unknown is in one group; unknowns of an element stay together. */
struct rad_groups {
  int n, most;  /* groups; unknowns of the largest */
  int *first;   /* owned [n + 1] */
  int *unknown; /* owned [n_point] unknowns of one group after another, in the tree's order */
  int *place;   /* owned [n_point] their places in the tree's order, ascending in a group */
};

/**
 * Elements, then groups, in pairs, the strongest exchange first, again and again while two together
 * have RAD_GROUP unknowns at most. The strength of a pair is the light exchanged over the area of
 * the smaller one. Of a hierarchical operator only near and sector blocks are looked at.
 *
 * @param[in]  tree    of the operator
 * @param[out] groups  to be freed with rad_groups_free, also after an error
 * Cost about a product. The same for any number of threads.
 */
enum rad_code rad_groups_build(const struct rad_operator *k, const struct rad_tree *tree,
                               struct rad_groups *groups, struct rad_error *e);
void rad_groups_free(struct rad_groups *groups); /* safe twice */

#endif
