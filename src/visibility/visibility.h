/* Who sees whom: the occluders of a scene and what each pair of triangles sees of one another. */
#ifndef RAD_VISIBILITY_VISIBILITY_H
#define RAD_VISIBILITY_VISIBILITY_H

#include <stdint.h>

#include "visibility/occluder.h"

struct rad_visibility {
  struct rad_occluders occluders;
  unsigned char *sight;      /* owned [n_triangle, n_triangle] enum rad_sight */
  struct rad_sight_row *row; /* owned [n_triangle] */
  int64_t n_partly;          /* pairs i < j that something may stand between */
};

/**
 * Find out, and give it to the scene, which keeps a pointer to v: v must not move.
 *
 * @param[out] v  to be freed with rad_visibility_free, also after an error
 * @return RAD_OK, or RAD_ESYSTEM: the memory for n_triangle^2 bytes is not there, said at once
 * Cost and memory n_triangle^2, in parallel.
 */
enum rad_code rad_visibility_build(struct rad_scene *scene, struct rad_visibility *v,
                                   struct rad_error *e);
/**
 * Occluders that may stand between two triangles with sight RAD_PARTLY.
 *
 * @param[out] list  [occluders.n] used if they have to be looked for;  n: their number
 * @return them: list, or a part of v
 */
const int *rad_blockers(const struct rad_visibility *v, int i, int j, int *list, int *n);

void rad_visibility_free(struct rad_visibility *v); /* safe twice */

#endif
