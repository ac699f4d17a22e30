/* The adaptive mesh as a list of leaves: where each lies, its degrees, where it came from. */
#ifndef RAD_ESTIMATE_LAYOUT_H
#define RAD_ESTIMATE_LAYOUT_H

#include "mesh/exponents.h"
#include "mesh/mesh.h"

/* One element to be: a rectangle of its patch. Graded variables only where it touches phi = 0 or
 * r = 0 of a patch that is singular there. */
struct rad_leaf {
  int patch;
  double phi[2], r[2];
  int k_phi, k_r; /* points per direction */
  int origin;     /* the same element in the mesh before, or -1 */
};

/* Why a triangle needs no unknowns. */
enum rad_passive { RAD_ACTIVE, RAD_BLACK, RAD_UNLIT, RAD_ALONE };

struct rad_layout {
  const struct rad_scene *scene; /* borrowed */
  int n_patch, n_leaf, room;
  struct rad_patch *patch; /* owned [n_patch], by triangle */
  int *p_phi, *p_r;        /* owned [n_patch] grading exponents; 1: nothing singular there */
  struct rad_leaf *leaf;   /* owned [n_leaf], by patch */
  unsigned char *passive;  /* owned [n_triangle] enum rad_passive: u = E is known, no rows needed */
  struct rad_exponents exponents; /* owned: what the gradings come from */
};

enum { RAD_MAX_POINTS_1D = 18 }; /* largest k of an adaptive element */

/**
 * The least that makes sense for a tolerance: one element of low degree per sub-triangle of a
 * triangle with a singular edge or vertex, one plain element per triangle where nothing is, one for
 * the emission of a passive face: black, unlit, or seeing nothing, where u = E and no row is
 * needed. Where E is a function (emission_at) no face is passive, since its E has to be resolved,
 * and all have sub-triangles, since E may depend on the direction from a vertex.
 *
 * @param[in]  sees  [n_triangle, n_triangle] of the scene's visibility
 * @param[out] l     to be freed with rad_layout_free, also after an error
 */
enum rad_code rad_layout_begin(const struct rad_scene *scene, const unsigned char *sees,
                               double tolerance, struct rad_layout *l, struct rad_error *e);
void rad_layout_free(struct rad_layout *l); /* safe twice */

/* Unknowns: points of the triangles that are not passive. */
double rad_layout_unknowns(const struct rad_layout *l);

/* The grading exponent p for a singularity s^exponent; 1 if there is none. */
int rad_layout_grading(double exponent, double tolerance);

enum rad_code rad_layout_mesh(const struct rad_layout *l, struct rad_mesh *mesh,
                              struct rad_error *e);

/* What is to be done with a leaf. */
struct rad_refinement {
  int k_phi, k_r;         /* new numbers of points */
  int split_phi, split_r; /* 1: also in two, at the place that suits a graded or plain leaf */
};

/* Replace leaves by their refinements; origins are set for those that stay as they are. */
enum rad_code rad_layout_refine(struct rad_layout *l, const struct rad_refinement *what,
                                struct rad_error *e);

#endif
