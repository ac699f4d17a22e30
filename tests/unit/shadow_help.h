/* Shared by the tests of shadows: occluders made by hand, what a point sees, what the oracle says.
 */
#ifndef POLYRAD_TEST_SHADOW_HELP_H
#define POLYRAD_TEST_SHADOW_HELP_H

#include "scene/scene.h"
#include "visibility/occluder.h"
#include "visibility/visible.h"

/* One polygon and one plane per triangle; to be freed with rad_occluders_free. */
struct rad_occluders occluders_by_hand(const struct rad_scene *scene);

/* rad_occluders_build */
struct rad_occluders occluders_merged(const struct rad_scene *scene);

/* A point x = V_base + mu1 F1 + mu2 F2 of a target triangle that looks at a source triangle, or at
 * its copy shrunk towards its vertex `corner`, by a power of two if that is to be exact. */
struct look {
  int target, source, base;
  double mu[2];
  int corner;
  double shrink; /* 1: all of it */
};

/* Fraction of the source's area that x sees past all occluders: rad_shadow_frame_set,
 * rad_shadow_cast, rad_visible. */
double visible_fraction(const struct rad_occluders *o, const struct look *look);

/* The same by clip_oracle, past all triangles but those that are exactly, without rounding, in the
 * plane of the target or the source. */
double oracle_fraction(const struct rad_scene *scene, const struct look *look);

/* What was seen, so that a test can assert that it has seen all sorts. */
struct tally {
  int n, n_free, n_hidden, n_part;
  double worst; /* largest difference */
};

/* Compare and count; a failure names the look. */
void expect_fraction(double got, double expected, double tolerance, const struct look *look,
                     const char *what, struct tally *tally);
void print_tally(const char *what, const struct tally *tally);

/* Random triangles (not the same one twice, unless there is but one), position in the target (base
 * a random vertex), and corner; shrink is 1. */
struct look random_look(int n_triangle);

#endif
