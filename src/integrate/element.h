/* The integrals of one source patch for many targets: far or near, whole or cut at the horizon. */
#ifndef RAD_INTEGRATE_ELEMENT_H
#define RAD_INTEGRATE_ELEMENT_H

#include <stdint.h>

#include "integrate/rule.h"
#include "integrate/shade.h"

/* Target points on one triangle, positions as in rad_patch. */
struct rad_targets {
  int triangle, n;
  const int *base;       /* [n] */
  const double (*mu)[2]; /* [n] */
  const int *row;        /* [n] rows of the result, or NULL: 0 .. n-1 */
};

struct rad_counters {
  int64_t kernel_values, near, far; /* near, far: pairs of a point and an element */
};

/* Memory of one thread. */
struct rad_scratch {
  struct rad_counters counters;
  double *far;         /* owned */
  double *frame;       /* owned [3, RAD_BATCH] targets in the frame of the patch */
  int *list;           /* owned [(2 RAD_N_ORDER + 2), RAD_BATCH] targets by rule */
  int *count;          /* owned [2 RAD_N_ORDER + 2] */
  int n;               /* targets */
  int *row;            /* owned [RAD_BATCH] rows of the targets */
  double *frame_whole; /* owned, and row_whole: the targets that see all of an element */
  int *row_whole;
  struct rad_shade shade;
};

enum { RAD_BATCH = 512 }; /* most targets at once */

enum rad_code rad_scratch_init(const struct rad_mesh *mesh, struct rad_scratch *s,
                               struct rad_error *e);
void rad_scratch_free(struct rad_scratch *s); /* safe twice */

/**
 * K[row i, b] = int G(x_i, y) L_b(y) dS for all trial functions b of one patch (theory 3.3)
 *
 * @param[in]  targets  at most RAD_BATCH
 * @param[in]  wanted   [mesh->n_element] which elements of the patch, or NULL: all
 * @param[out] k        k[row + ld * unknown], written for the unknowns of the patch only
 * Every entry to rules->tolerance of the row's sum over its element. Thread-safe with its own
 * scratch; no allocation. Pairs that see nothing of each other are set to 0. Left early once
 * rad_stop_asked(): what is returned then is to be thrown away.
 */
void rad_patch_block(const struct rad_mesh *mesh, const struct rad_rules *rules,
                     const struct rad_targets *targets, int patch, const unsigned char *wanted,
                     double *k, int64_t ld, struct rad_scratch *s);

/**
 * The same for n elements of one patch, with columns of the caller's choice: function f of
 * element[i] in k[row + ld (column[i] + f)].
 */
void rad_element_list_block(const struct rad_mesh *mesh, const struct rad_rules *rules,
                            const struct rad_targets *targets, int n, const int *element,
                            const int64_t *column, double *k, int64_t ld, struct rad_scratch *s);

#endif
