/* Which pair of Gauss rules an element needs for a target, by distance. */
#ifndef RAD_INTEGRATE_CLASSES_H
#define RAD_INTEGRATE_CLASSES_H

#include "integrate/rule.h"

enum { RAD_N_CLASS = 2 * RAD_N_ORDER + 1 };

/* Pairs of rules of one element, nearest last. */
struct rad_classes {
  int n;
  double
      d2[RAD_N_CLASS]; /* squared distance from center from which on a pair suffices, descending */
  int rule[RAD_N_CLASS][2]; /* angular, radial */
  double center[2];
  /* for targets nearer than that: */
  double end[2][2], width[2]; /* ends of the middle ray, and half the element's width there */
  double length, half_t;      /* of the longest ray; half of the longest side across */
  const double *reach_t, *reach_r;
};

/* (theory 3.4) */
void rad_classes_set(const struct rad_patch *patch, const struct rad_element *e,
                     const struct rad_panel *angular, const struct rad_panel *radial,
                     struct rad_classes *c);

/* The class of a target at a squared distance from the center, or RAD_N_CLASS. */
static inline int rad_class_of(const struct rad_classes *c, double d2) {
  int i = 0;
  while (i < c->n && d2 < c->d2[i])
    i++;
  return i < c->n ? i : RAD_N_CLASS;
}

/**
 * Rules for a target x, in the patch's frame, that is near the element but perhaps only for one of
 * its directions.
 *
 * @param[out] rule  angular, radial
 * @return 0 if none suffice
 */
int rad_class_close(const struct rad_classes *c, const double x[3], int rule[2]);

#endif
