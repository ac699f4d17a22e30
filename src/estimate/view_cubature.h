/* Integrals over triangles of the factors from points to all surfaces, cell by cell. */
#ifndef RAD_ESTIMATE_VIEW_CUBATURE_H
#define RAD_ESTIMATE_VIEW_CUBATURE_H

#include <stdint.h>

#include "estimate/iterate.h"
#include "estimate/view_cell.h"

/* A cell with what two rules say about it. */
struct rad_view_leaf {
  struct rad_view_cell cell;
  int surface;
  int level;     /* of its rule; 0: not yet evaluated */
  double change; /* largest change of an integral from the rule before; INFINITY at level 0 */
  double before; /* the same of the rule before */
};

/* Column n_surface of n_column is the sum of the others. */
struct rad_view_cubature {
  const struct rad_scene *scene; /* borrowed */
  struct rad_mesh mesh;
  struct rad_rules rules;
  const unsigned char *sees; /* borrowed, of the scene's visibility */
  int n_column;
  double *area;    /* owned [n_surface] */
  double max_cell; /* by memory */
  int n, room;
  struct rad_view_leaf *leaf; /* owned [room] */
  double *value;              /* owned [room, n_column] int h_t dS of the cell over A_s */
  double *change;             /* owned [room, n_column] from the rule before, absolute */
  int64_t points;
};

/* Points per direction; a new cell takes the first two, and level l stands for rule[l]. */
enum { RAD_VIEW_LEVELS = 5 };
extern const int rad_view_rule[RAD_VIEW_LEVELS];

/* Every triangle as its four cells; to be freed with rad_view_cubature_free, also after an error.
 */
enum rad_code rad_view_cubature_begin(const struct rad_scene *scene, double quadrature,
                                      struct rad_view_cubature *c, struct rad_error *e);
void rad_view_cubature_free(struct rad_view_cubature *c); /* safe twice */

/* One step for each listed cell: a new one gets its first two rules, others the next rule. */
enum rad_code rad_view_cubature_step(struct rad_view_cubature *c, int n, int *list,
                                     struct rad_error *e);

/* Points that the next step of a cell takes. */
int rad_view_step_points(const struct rad_view_leaf *leaf);

/**
 * Split a cell: its first child takes its place, the others come last.
 *
 * @param[out] list  [RAD_CELL_CHILDREN] their numbers
 * @param[out] n     number of children
 */
enum rad_code rad_view_cubature_split(struct rad_view_cubature *c, int i, int *list, int *n,
                                      struct rad_error *e);

/* sum [n_surface, n_column] of `of`, which is value or change. */
void rad_view_cubature_sum(const struct rad_view_cubature *c, const double *of, double *sum);

#endif
