/* What a point receives past other triangles, by inclusion and exclusion, in long double.
 *
 * It shares no code and no method with src/visibility and src/integrate: the shadow of a triangle
 * on a source is a convex polygon, cut from it in space, and
 *
 *   int over (S minus all B_k) = sum over subsets of blockers (-1)^|s| int over (S and all B in s),
 *
 * so only integrals over convex polygons are needed. */
#ifndef POLYRAD_TEST_SHADOW_ORACLE_H
#define POLYRAD_TEST_SHADOW_ORACLE_H

enum { MOST_CORNER = 48 };

struct flat {
  int n; /* corners of a plane convex polygon */
  long double corner[MOST_CORNER][3];
};

struct eye {
  long double x[3], normal[3];
};

/* x = V_base + mu1 F1 + mu2 F2 (see rad_patch), with the unit normal. */
struct eye eye_at(const double v[3][3], int base, const double mu[2], const double normal[3]);

/* Takes the integral over one polygon times `sign`. */
typedef void shadow_visitor(void *context, const struct flat *polygon, int sign);

/**
 * Visit the polygons of the sum for the part of a polygon in front of the eye.
 *
 * Cost 2^m for m shadows that overlap. Blockers in the plane of eye or polygon must be left out.
 */
void shadow_visit(const struct eye *eye, const struct flat *polygon, int n,
                  const double (*blocker)[3][3], shadow_visitor *visit, void *context);

/* Lambert's formula: form factor from the eye to a polygon that it sees all of. */
long double flat_form_factor(const struct eye *eye, const struct flat *polygon);

/* Form factor to the part of a triangle that the blockers leave; its normal decides what is seen.
 */
long double shadow_form_factor(const struct eye *eye, const double source[3][3],
                               const double normal[3], int n, const double (*blocker)[3][3]);

#endif
