/* Where a level of an adaptive run begins: what a run that was stopped goes on from. */
#ifndef RAD_ESTIMATE_STAGE_H
#define RAD_ESTIMATE_STAGE_H

#include "estimate/layout.h"
#include "system/plan.h"

struct rad_stage {
  int levels;           /* that were done before */
  int stuck;            /* levels in a row that hardly lowered the bound */
  double least;         /* bound of them */
  double target;        /* of what refinement lowers */
  double *least_weight; /* owned [n_weight], or NULL; see rad_adaptive */
  int n_weight;         /* triangles times bands */
  double quadrature;    /* tolerance of this level */
  int n_leaf;
  struct rad_leaf *leaf;  /* owned [n_leaf]; NULL: no stage */
  enum rad_matrix matrix; /* of this level */

  /* Where a run goes on: fill the matrix of this level, which has just begun; one is NULL. It is
   * not assembled again, because blocks that came from the level before have other rounding. */
  enum rad_code (*read)(void *context, struct rad_dense *dense, struct rad_h2 *h2,
                        struct rad_error *e);
  void *context;
};

/* A copy of the leaves; the rest is the caller's. */
enum rad_code rad_stage_take(const struct rad_layout *l, struct rad_stage *s, struct rad_error *e);
void rad_stage_free(struct rad_stage *s); /* safe twice */

/**
 * Put the leaves of a stage into the layout of the same scene that has just begun.
 *
 * @return RAD_EINPUT if they do not cover its patches, each once, RAD_ESYSTEM without memory
 */
enum rad_code rad_stage_restore(const struct rad_stage *s, struct rad_layout *l,
                                struct rad_error *e);

#endif
