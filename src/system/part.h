/* A share of the matrix, so that many machines assemble what one then solves with. */
#ifndef RAD_SYSTEM_PART_H
#define RAD_SYSTEM_PART_H

#include "system/dense.h"
#include "system/h2.h"

/* Part `number` of 1 .. n. */
struct rad_part_number {
  int number, n;
};

/* What is a part's own: whole units from `first` on to before `end`; the same wherever it is asked.
 */
struct rad_part_range {
  int first, end;
};

/**
 * Columns of a dense matrix, of whole source patches (or of whole groups, for facets), shared by
 * the number of points that see them.
 */
struct rad_part_range rad_part_columns(const struct rad_dense *dense, struct rad_part_number p);

/* Target clusters whose near and sector blocks are a part's own, shared by entries. */
struct rad_part_range rad_part_clusters(const struct rad_h2 *h, struct rad_part_number p);

/**
 * What others assemble of a matrix that was just begun is marked, so that rad_dense_finish or
 * rad_h2_part leaves it alone. Of the bases a part has whole subtrees; those above are nobody's,
 * and are made where all parts come together.
 */
enum rad_code rad_part_mark_dense(struct rad_dense *dense, struct rad_part_number p,
                                  struct rad_error *e);
void rad_part_mark_h2(struct rad_h2 *h, struct rad_part_number p);

#endif
