/* Near blocks: integrals as for a dense matrix. */
#ifndef RAD_SYSTEM_H2_NEAR_H
#define RAD_SYSTEM_H2_NEAR_H

#include "system/h2.h"

/* Memory for the near blocks, none of which is done; narrow: single precision. */
enum rad_code rad_h2_near_begin(struct rad_h2 *h, int narrow, struct rad_error *e);

/* Integrate the near blocks that are not done, in parallel over target leaves. RAD_ESTOPPED once
 * rad_stop_asked(). */
enum rad_code rad_h2_near(struct rad_h2 *h, const struct rad_rules *rules, struct rad_error *e);

/* An element of a leaf's sources, and the column that it begins at if the blocks stand side by
 * side. */
struct rad_near_piece {
  int element;
  int64_t column;
};

/* The elements of some source clusters, ascending; zero at first, used again and again. */
struct rad_near_list {
  int n;
  int *element;                 /* owned [n] */
  int64_t *column;              /* owned [n] */
  size_t room;                  /* of each array */
  struct rad_near_piece *piece; /* owned, for sorting */
};

/* 0 without memory. */
int rad_near_list(const struct rad_tree *tree, size_t n_source, const int *source,
                  struct rad_near_list *list);
void rad_near_list_free(struct rad_near_list *list); /* safe twice */

/* One integrator for each thread, or none at all. */
struct rad_scratch *rad_scratch_make(const struct rad_mesh *mesh, int n_thread,
                                     struct rad_error *e);

/* Adds their counters, if not NULL; RAD_ESYSTEM if one of them ran out of memory. */
enum rad_code rad_scratch_end(struct rad_scratch *scratch, int n_thread,
                              struct rad_counters *counters, struct rad_error *e);

#endif
