/* One case: a deck carried through scene, mesh, system and solution. */
#ifndef RAD_APP_CASE_H
#define RAD_APP_CASE_H

#include "estimate/adapt.h"
#include "estimate/balance.h"
#include "estimate/iterate.h"
#include "output/result.h"
#include "system/solve.h"
#include "visibility/visibility.h"

struct rad_plan {
  struct rad_system_plan system;
  double bytes;      /* memory that the run takes at once, from here on */
  double base_bytes; /* held already: libraries, scene, visibility */
  double rest_bytes; /* of mesh and picture */
  double halved;     /* cells that halving may add to the picture; 0 before there is a mesh */
  double available;  /* memory that there is */
  double seconds;    /* predicted, whole run */
  double unknowns;
  double pairs, skipped; /* point-element pairs; those that see nothing of each other */
};

struct rad_case {
  struct rad_deck deck;
  int n_set;              /* overrides of the deck */
  const char *const *set; /* borrowed [n_set] */
  struct rad_scene scene; /* points to visibility: a case must not move */
  struct rad_visibility visibility;
  struct rad_notes notes;
  struct rad_mesh *mesh; /* owned */
  struct rad_rules rules;
  struct rad_dense dense; /* one of these two */
  struct rad_h2 h2;
  struct rad_plan plan;
  double *rho, *emission; /* owned [n_band, n_point] at the collocation points */
  double *u, *h;          /* owned [n_band, n_point] radiosity and irradiance [W/m2] */
  struct rad_balance balance;
  struct rad_means means; /* of u*; where there is no estimate, without errors */
  struct rad_solve_report report;
  const char *restart;          /* borrowed: a checkpoint to go on from, or NULL */
  int n_part;                   /* the matrix is in that many files; 0: to be assembled */
  const char *const *part;      /* borrowed [n_part] */
  struct rad_iterate iterate;   /* where the solver goes on, or would */
  int is_adaptive;              /* no mesh was asked for by hand: the tolerance decides */
  int is_restored;              /* what the checkpoint `restart` had of a mesh by hand is here */
  int wants_bound, has_bound;   /* the error is estimated and bounded, and u* is reported */
  double tolerance;             /* of max |u - u*| over max |u| */
  struct rad_adaptive adaptive; /* its layout, indicator and bound; the rest moves to this struct */
  double compression;           /* tolerance of a hierarchical matrix made by hand */
  double memory_limit;          /* bytes for the matrix and what belongs to it; 0: what there is */
  double seconds_scene, seconds_mesh, seconds_assemble, seconds_estimate;
  double seconds_levels; /* adaptive levels before the last; the other times are of the last one */
};

/* Only the deck. progress: of this and all later steps, or NULL. */
enum rad_code rad_case_read(const char *deck, int n_set, const char *const *set,
                            struct rad_progress *progress, struct rad_case *c, struct rad_error *e);

/* A deck that was read -> scene -> visibility -> plan -> mesh; refuses what does not fit into
 * memory before anything large is made. */
enum rad_code rad_case_build(struct rad_progress *progress, struct rad_case *c,
                             struct rad_error *e);

/* Both, one after the other. */
enum rad_code rad_case_prepare(const char *deck, int n_set, const char *const *set,
                               struct rad_progress *progress, struct rad_case *c,
                               struct rad_error *e);

/* True if the deck was read, whatever came after. */
int rad_case_is_read(const struct rad_case *c);

/* mesh -> system -> solution; an adaptive case makes its meshes here. When the tolerance could not
 * be reached, c->adaptive.reason says why and report.converged is 0. */
enum rad_code rad_case_solve(struct rad_case *c, struct rad_error *e);

/* What the user should know about a result that is there all the same. */
void rad_case_warn(const struct rad_case *c, struct rad_notes *notes);

void rad_case_free(struct rad_case *c); /* safe twice */

/* Part of rad_case_solve: rules, and the matrix with nothing of it done. */
enum rad_code rad_case_begin_matrix(struct rad_case *c, struct rad_error *e);

/* The matrix' form is this one, whatever memory there is. */
enum rad_code rad_case_keep_form(struct rad_case *c, enum rad_matrix form, struct rad_error *e);

/* Predicted time, from samples of the real work on this machine. */
enum rad_code rad_case_predict(struct rad_case *c, struct rad_error *e);

/**
 * Everything that goes into a result file: picture, means, probes, diagnostics.
 *
 * @param[out] result  to be freed with rad_result_free
 */
enum rad_code rad_case_result(const struct rad_case *c, const char *command,
                              struct rad_result *result, struct rad_error *e);

/* Parts of rad_case_result. */
enum rad_code rad_case_picture(const struct rad_case *c, struct rad_picture *picture,
                               struct rad_error *e);
/* Where a point is in a triangle: mu counts from the vertex `base` that weighs most, as in
 * rad_patch, and is at least RAD_LIMIT: on an edge it means the limit from inside the face. */
struct rad_place {
  int triangle, base;
  double mu[2], off; /* off: distance from the triangle's plane or outside of it, over its size */
};

struct rad_place rad_place_weighted(int triangle, const double weight[3]); /* barycentric */
struct rad_place rad_place_in(const struct rad_scene *scene, int triangle, const double at[3]);

/* The limit from inside the face where mu is 0. It is taken beside the point of the edge, by 1e-13
 * of the distance to the vertex, which no value shows. */
void rad_place_limit(double mu[2]);

/* A point with more `off` is not on the triangle. */
#define RAD_OFF 1e-6

/* Refuse probes that lie on no triangle, before anything is solved. */
enum rad_code rad_case_check_probes(const struct rad_case *c, struct rad_error *e);
enum rad_code rad_case_probes(const struct rad_case *c, struct rad_result *result,
                              struct rad_error *e);

#endif
