/* The local problems: groups of unknowns that exchange most light, each solved by itself
 * (theory 5.7). */
#ifndef RAD_SYSTEM_LOCAL_H
#define RAD_SYSTEM_LOCAL_H

#include "system/groups.h"

/* Inverses of the blocks of I - D K of one system. */
struct rad_local_inverse {
  const double *rho; /* borrowed [n] of the system */
  float *inverse;    /* owned, pages: blocks [rows, columns] column-major */
};

struct rad_local {
  struct rad_groups groups;
  size_t *at; /* owned [groups + 1] where a block begins in the inverses */
  int n_inverse;
  struct rad_local_inverse *inverse; /* owned */
};

/**
 * Groups, and the inverse of each group's block, in single precision: B need not be exact. Of a
 * hierarchical operator far blocks are left out.
 *
 * @param[in]  tree   of the operator
 * @param[in]  rho    [n_system] of [n]; equal pointers share inverses
 * @param[out] local  to be freed with rad_local_free, also after an error
 * In parallel over groups; the same bits for any number of threads.
 */
enum rad_code rad_local_build(const struct rad_operator *k, const struct rad_tree *tree,
                              int n_system, const double *const *rho, struct rad_local *local,
                              struct rad_error *e);
void rad_local_free(struct rad_local *local); /* safe twice */

/* z = B v at the unknowns of one group, for the system with that rho; z and v [n], no aliases. Each
 * group by one thread. */
void rad_local_apply(const struct rad_local *local, const double *rho, int group, const double *v,
                     double *z);

/* Bytes of the inverses, at most. */
double rad_local_bytes(double n, int n_band);

#endif
