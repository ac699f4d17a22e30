/* Connected pieces of a scene's surface, and which of them enclose a volume. */
#ifndef RAD_SCENE_SHELL_H
#define RAD_SCENE_SHELL_H

#include "scene/scene.h"

struct rad_shells {
  int n;
  int *shell;            /* owned [n_triangle] shell of each triangle, by first triangles */
  unsigned char *closed; /* owned [n] */
  double *volume;        /* owned [n] enclosed; above 0 if it radiates outwards [m3] */
};

/**
 * Triangles that share vertices are one shell.
 *
 * A shell is closed if its oriented rims cancel: line integrals of smooth fields around all its
 * triangles sum to zero, to rounding. So vertices within edges of others do no harm, and the two
 * sides of a sheet add nothing.
 *
 * @param[out] s  to be freed with rad_shells_free, also after an error
 * @return RAD_OK, or RAD_ESYSTEM without memory. Cost proportional to n_triangle
 */
enum rad_code rad_shells_find(const struct rad_scene *scene, struct rad_shells *s,
                              struct rad_error *e);

/**
 * The same of other parts than those: s->n and s->shell are given.
 *
 * @param[out] s  closed and volume; to be freed with rad_shells_free, also after an error
 */
enum rad_code rad_shells_measure(const struct rad_scene *scene, struct rad_shells *s,
                                 struct rad_error *e);

void rad_shells_free(struct rad_shells *s); /* safe twice */

#endif
