#include "visibility/visibility.h"

#include <stdlib.h>

#include "visibility/facing.h"

enum rad_code rad_visibility_build(struct rad_scene *scene, struct rad_visibility *v,
                                   struct rad_error *e) {
  *v = (struct rad_visibility){0};
  size_t n = (size_t)scene->n_triangle;
  enum rad_code code = rad_occluders_build(scene, &v->occluders, e);
  if (!code && !(v->sight = rad_sight_matrix(&v->occluders)))
    code = rad_fail_memory(e, "the table of triangles that see each other", (double)(n * n));
  for (size_t i = 0; i < n && !code; i++)
    for (size_t j = i + 1; j < n; j++)
      v->n_partly += v->sight[i * n + j] == RAD_PARTLY;
  scene->visibility = code ? NULL : v;
  return code;
}

void rad_visibility_free(struct rad_visibility *v) {
  rad_occluders_free(&v->occluders);
  free(v->sight);
  *v = (struct rad_visibility){0};
}
