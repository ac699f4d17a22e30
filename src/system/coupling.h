/* Which elements exchange most light: the strongest partners of each (theory 5.7). */
#ifndef RAD_SYSTEM_COUPLING_H
#define RAD_SYSTEM_COUPLING_H

#include "system/operator.h"

enum { RAD_PARTNERS = 24 }; /* of an element, at most */

/* Light that element `one` of the tree's order receives from `other`: area times mean of K [m2]. */
struct rad_partner {
  int other;
  double light;
};

/**
 * The strongest partners of each element, in the tree's order, by light over the smaller area.
 *
 * @param[in]  area     [n_element] in the tree's order [m2]
 * @param[out] count    [n_element] partners found
 * @param[out] partner  [n_element, RAD_PARTNERS]
 * In parallel; each element has one owner.
 */
enum rad_code rad_coupling(const struct rad_operator *k, const struct rad_tree *tree,
                           const double *area, int *count, struct rad_partner *partner,
                           struct rad_error *e);

#endif
