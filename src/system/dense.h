/* The dense matrix K of all pairs of collocation points and trial functions. */
#ifndef RAD_SYSTEM_DENSE_H
#define RAD_SYSTEM_DENSE_H

#include <stdint.h>

#include "integrate/element.h"

/* Rows that a product takes at once: whole triangles, or a part of one. */
struct rad_row_group {
  int triangle, triangle_end, first, n;
  const unsigned char *sees; /* [n_triangle] nonzero if one of these rows may be */
};

/**
 * K[i + n j] = int G(x_i, y) L_j(y) dS, geometry only: the system is (I - diag(rho) K) u = E, so
 * one matrix serves every band (theory 5.1). Blocks of triangles that do not see each other are
 * zero pages that nobody touches.
 */
struct rad_dense {
  const struct rad_mesh *mesh; /* borrowed */
  int n;
  double *k;                 /* owned [n, n] column-major [-] */
  const unsigned char *sees; /* borrowed [n_triangle, n_triangle] of the scene's visibility */
  int n_group;
  struct rad_row_group *group; /* owned [n_group] for products */
  unsigned char *group_sees;   /* owned [n_group, n_triangle] */
  int64_t n_task;
  unsigned char *done;          /* owned [n_task] parts of the assembly that are finished */
  struct rad_counters counters; /* of these parts */
  int64_t pairs_skipped;        /* pairs of a point and an element that see nothing of each other */
};

/* What an assembly may take over from the matrix of a mesh before, and what it may leave out. */
struct rad_reuse {
  const struct rad_dense *old;  /* NULL: nothing */
  const int *origin;            /* [n_element] the same element in the old mesh, or -1 */
  const unsigned char *passive; /* [n_triangle] 1: rows are not needed and stay 0; or NULL */
};

/**
 * Assemble in parallel. The scene knows its visibility (rad_visibility_build). A task is a batch of
 * points of one triangle against one patch; every entry has one writer, so the result is
 * bit-identical for any number of threads.
 *
 * @param[in]  reuse  or NULL
 * @param[out] dense  to be freed with rad_dense_free, also after an error
 */
enum rad_code rad_dense_assemble(const struct rad_mesh *mesh, const struct rad_rules *rules,
                                 const struct rad_reuse *reuse, struct rad_dense *dense,
                                 struct rad_error *e);

/* The two halves of rad_dense_assemble: memory with no part of the assembly done; then the parts
 * that are not done. In between, some may be read from a file. The second is RAD_ESTOPPED once
 * rad_stop_asked(), and can be called again. */
enum rad_code rad_dense_begin(const struct rad_mesh *mesh, const struct rad_reuse *reuse,
                              struct rad_dense *dense, struct rad_error *e);
enum rad_code rad_dense_finish(const struct rad_rules *rules, const struct rad_reuse *reuse,
                               struct rad_dense *dense, struct rad_error *e);

/* Pairs of a point and an element that see nothing of each other, or whose rows are not needed;
 * passive as in rad_reuse, or NULL. */
int64_t rad_pairs_skipped(const struct rad_mesh *mesh, const unsigned char *passive);

void rad_dense_free(struct rad_dense *dense); /* safe twice */

/* done[] of the parts of the assembly whose columns are in first .. end - 1, or with `outside` of
 * all others, becomes 1. */
enum rad_code rad_dense_set_done(struct rad_dense *dense, int first, int end, int outside,
                                 struct rad_error *e);

/* True if the assembly of this mesh is by groups of columns of facets. */
int rad_dense_is_by_facets(const struct rad_dense *dense);

enum { RAD_MAX_PRODUCT = 8 };

/**
 * y_v = K u_v for several vectors in one pass over the matrix, in parallel over rows.
 *
 * @param[in]  n_vector  1..RAD_MAX_PRODUCT
 * @param[in]  u         [n_vector] of [n]; y: likewise, no aliases
 * Bit-identical for any number of threads and for any company of other vectors.
 */
void rad_dense_apply(const struct rad_dense *dense, int n_vector, const double *const *u,
                     double *const *y);

#endif
