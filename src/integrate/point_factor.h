/* The share of what leaves a point of one triangle that arrives at another triangle. */
#ifndef RAD_INTEGRATE_POINT_FACTOR_H
#define RAD_INTEGRATE_POINT_FACTOR_H

#include "integrate/constant.h"
#include "integrate/element.h"

enum { RAD_MAX_SENDER = 256 }; /* most points at once; whole groups of RAD_FACET_LANES */

/* All triangles of a scene as receivers. */
struct rad_receivers {
  const struct rad_scene *scene;  /* borrowed */
  struct rad_mesh mesh;           /* one constant a triangle, where Lambert's form is not enough */
  struct rad_rules rules;         /* of mesh */
  struct rad_facet_source *facet; /* owned [n_triangle] */
};

/* To be freed with rad_receivers_free, also after an error. tolerance: relative, of each factor. */
enum rad_code rad_receivers_begin(const struct rad_scene *scene, double tolerance,
                                  struct rad_receivers *r, struct rad_error *e);
void rad_receivers_free(struct rad_receivers *r); /* safe twice */

/* Points of one triangle, positions as in rad_patch, ready for vector loops. */
struct rad_senders {
  int triangle, n;
  int base[RAD_MAX_SENDER];
  double mu[RAD_MAX_SENDER][2];
  double component[9][RAD_MAX_SENDER]; /* vertex, offset, normal: see rad_facet_targets */
};

/* Fill component from triangle, n, base and mu. */
void rad_senders_finish(const struct rad_scene *scene, struct rad_senders *s);

/* One of the triangles, for the points of one sender. */
struct rad_receiver {
  int triangle;
  enum rad_sight sight; /* of the two triangles, not RAD_HIDDEN */
  double rounding;      /* absolute error that rounding may leave; 0: only what tolerance allows */
};

/**
 * F(y_q -> T) = int_T G(y_q, x) dS_x for all points of s, with shadows              (theory 3.9)
 *
 * @param[out] value  [RAD_MAX_SENDER], s->n of them set
 * Each to the receivers' tolerance, or to the rounding allowed. Thread-safe with its own scratch,
 * which is one of r->mesh.
 */
void rad_point_factors(const struct rad_receivers *r, const struct rad_senders *s,
                       const struct rad_receiver *to, double *value, struct rad_scratch *scratch);

#endif
