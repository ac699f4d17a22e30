/* The hierarchical matrix: K in nested bases where it is smooth, dense blocks where it is not. */
#ifndef RAD_SYSTEM_H2_H
#define RAD_SYSTEM_H2_H

#include "integrate/element.h"
#include "system/blocks.h"
#include "system/h2_basis.h"

enum { RAD_MOST_VECTORS = 8 };

/* One side's bases, ready for products: small dense matrices one after another. */
struct rad_h2_side {
  int *rank;     /* owned [n_cluster] */
  size_t *at;    /* owned [n_cluster] where a cluster's matrix begins in data */
  size_t *place; /* owned [n_cluster + 1] where its coefficients begin in a vector of them */
  size_t n_data;
  double *data; /* owned [n_data], pages */
};

/* Dense blocks, in single precision where the tolerance allows it. */
struct rad_h2_dense {
  size_t *at;    /* owned [blocks + 1] where a block begins in the data, in the order of its list */
  size_t n;      /* numbers in all */
  double *wide;  /* owned [n], pages: blocks [rows, sources] column-major, or NULL */
  float *narrow; /* likewise in single precision */
};

/**
 * K ~ sum over far blocks of U_t S_ts W_s^T, over sector blocks of P_t B_ts, plus near blocks
 * (theory 14). U and W are nested; P_t spreads values from the places of a sector to its points.
 */
struct rad_h2 {
  const struct rad_mesh *mesh; /* borrowed */
  const unsigned char *sees;   /* borrowed [n_triangle, n_triangle] of the scene's visibility */
  struct rad_tree tree;
  struct rad_blocks blocks;
  struct rad_h2_side row, column;
  size_t *far_at; /* owned [blocks] where a block begins in its data */
  size_t n_far;
  double *far;                      /* owned [n_far], pages: [row rank, column rank] column-major */
  struct rad_h2_dense near, sector; /* rows: points of the target; its places */
  int *place_count;  /* owned [n_cluster] places of clusters that have sector blocks, else 0 */
  size_t *spread_at; /* owned [n_cluster] where P_t begins in spread */
  size_t n_spread;
  double *spread;            /* owned [n_spread], pages: P_t [points, places] column-major */
  unsigned char *near_done;  /* owned [n_cluster] target leaves whose near blocks are done */
  int far_done;              /* bases and far blocks are done; until then: */
  struct rad_basis basis[2]; /* owned: of rows, of columns, as far as they are done */
  size_t n_work;
  double *work; /* owned [RAD_MOST_VECTORS, n_work], pages: vectors in the tree's order, and
                   coefficients of columns and rows */
  struct rad_counters counters; /* of near and sector blocks */
  double tolerance;             /* asked for: of a row's sum */
  double error;     /* estimate of what compression does to a row's sum, see rad_h2_check */
  double bytes;     /* of all its data */
  double mean_rank; /* of far blocks, both sides */
  double seconds_blocks, seconds_bases, seconds_far, seconds_near, seconds_check;
};

/* Sizes before anything large is made. */
struct rad_h2_plan {
  double bytes;        /* predicted, of the finished matrix */
  double bytes_build;  /* predicted, at most while it is built */
  double near_entries; /* of near and sector blocks, exact */
};

/* Cluster trees with leaves of a size, and blocks for a tolerance; sectors: with sector blocks,
 * which serve the collocation points only. */
enum rad_code rad_h2_divide(const struct rad_mesh *mesh, int leaf, double tolerance, int sectors,
                            struct rad_tree *tree, struct rad_blocks *blocks, struct rad_error *e);

#define RAD_NARROW 0.99e-7 /* single precision errs by 6e-8 of an entry at most */

/* Bytes of an entry of near blocks. */
static inline size_t rad_h2_near_size(double tolerance) {
  return tolerance >= RAD_NARROW ? sizeof(float) : sizeof(double);
}

/* Predict from the cluster trees and blocks alone. Cost about 1 % of a build. */
enum rad_code rad_h2_predict(const struct rad_mesh *mesh, double tolerance,
                             struct rad_h2_plan *plan, struct rad_error *e);

/* Predicted seconds of rad_h2_build: a dozen near targets and leaves are done and timed. */
enum rad_code rad_h2_sample(const struct rad_mesh *mesh, const struct rad_rules *rules,
                            double tolerance, double *seconds, struct rad_error *e);

/**
 * @param[in]  tolerance  of the compression, relative to a row sum of 1
 * @param[out] h          to be freed with rad_h2_free, also after an error
 * In parallel; every result has one owner and a fixed order of summation: the same bits for any
 * number of threads.
 */
enum rad_code rad_h2_build(const struct rad_mesh *mesh, const struct rad_rules *rules,
                           double tolerance, struct rad_h2 *h, struct rad_error *e);

/* The two halves of rad_h2_build: trees, blocks, and memory with nothing done; then what is not
 * done. In between, some may be read from a file. The second is RAD_ESTOPPED once
 * rad_stop_asked(). */
enum rad_code rad_h2_begin(const struct rad_mesh *mesh, double tolerance, struct rad_h2 *h,
                           struct rad_error *e);
enum rad_code rad_h2_finish(struct rad_h2 *h, const struct rad_rules *rules, struct rad_error *e);

/* Of the second half, what can be shared out: the bases that are missing and are not elsewhere, and
 * the near and sector blocks that are not done; no far blocks. RAD_ESTOPPED once
 * rad_stop_asked(). */
enum rad_code rad_h2_part(struct rad_h2 *h, const struct rad_rules *rules, struct rad_error *e);

/* Memory for bases and far blocks, once row.rank and column.rank (owned [n_cluster]) are known. */
enum rad_code rad_h2_far_begin(struct rad_h2 *h, struct rad_error *e);

void rad_h2_free(struct rad_h2 *h); /* safe twice */

/**
 * y_v = K u_v for 1 .. RAD_MOST_VECTORS vectors [n], no aliases, in one pass over the matrix.
 *
 * Not by two threads at once: it uses h->work. The same bits for any number of threads and for any
 * company of other vectors.
 */
void rad_h2_apply(const struct rad_h2 *h, int n_vector, const double *const *u, double *const *y);

/* Pages for products, which cost nothing until they are used. */
enum rad_code rad_h2_workspace(struct rad_h2 *h, struct rad_error *e);

/* Bytes that a product of one vector reads and writes. */
double rad_h2_traffic(const struct rad_h2 *h);

/**
 * h->error: largest |(K - K_H) z|_i over sampled rows i, computed anew, and vectors |z| <= 1:
 * constant, waves, and random signs of points and of elements.
 */
enum rad_code rad_h2_check(struct rad_h2 *h, const struct rad_rules *rules, struct rad_error *e);

#endif
