/* Nested bases of the clusters, as small as the tolerance allows. */
#ifndef RAD_SYSTEM_H2_BASIS_H
#define RAD_SYSTEM_H2_BASIS_H

#include "system/blocks.h"
#include "system/interpolate.h"

enum rad_basis_kind { RAD_BASIS_ROW, RAD_BASIS_COLUMN };

/**
 * For every cluster a matrix of `rank` columns: a leaf's has a row for each of its unknowns, any
 * other's a row for each column of its first child, then of its second (theory 14.6).
 */
/* Of a cluster's whole subtree: missing; done; done, and its change is not needed any more; left
 * alone, and with it all above it. */
enum rad_basis_state { RAD_BASIS_MISSING, RAD_BASIS_DONE, RAD_BASIS_SPENT, RAD_BASIS_ELSEWHERE };

struct rad_basis {
  const struct rad_tree *tree; /* borrowed */
  int *rank;                   /* owned [n_cluster] */
  double **matrix;             /* owned [n_cluster] owned [rows, rank] column-major */
  double **change;             /* owned [n_cluster] owned [n_node, rank] R^T: the polynomials in the
                                  basis; only of clusters that have far blocks */
  unsigned char *state;        /* owned [n_cluster] enum rad_basis_state */
  int failed;                  /* while building: out of memory, or an SVD that did not converge */
};

struct rad_basis_goal {
  const struct rad_interpolation *interpolation;
  const struct rad_block_list *far; /* partners of each cluster of this side */
  enum rad_basis_kind kind;
  double tolerance; /* of the moments' integrals */
  double cut;       /* of row sums, for each block */
};

/**
 * Nothing done yet.
 *
 * @param[out] basis  to be freed with rad_basis_free, also after an error
 */
enum rad_code rad_basis_begin(const struct rad_tree *tree, struct rad_basis *basis,
                              struct rad_error *e);

/**
 * The bases that are missing. RAD_ESTOPPED once rad_stop_asked().
 *
 * In parallel over subtrees; the same bits for any number of threads, and whatever was there
 * before.
 */
enum rad_code rad_basis_build(const struct rad_tree *tree, const struct rad_basis_goal *goal,
                              struct rad_basis *basis, struct rad_error *e);
void rad_basis_free(struct rad_basis *basis); /* safe twice */

/* Rows of a cluster's matrix, from the ranks of its children. */
int rad_basis_rows(const struct rad_tree *tree, const int *rank, int cluster);

/* Seconds that one thread needs for the basis of a leaf without what it inherits. */
enum rad_code rad_basis_sample(const struct rad_tree *tree, const struct rad_basis_goal *goal,
                               int leaf, double *seconds, struct rad_error *e);

#endif
