#include "visibility/visibility.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/stop.h"

/* Part of the memory that lists of blockers may take; they only save time. */
#define MEMORY_PART 0.05

/* A table that cannot fit is refused before the search, which would take far longer. */
static enum rad_code refuse_too_large(int n_triangle, struct rad_error *e) {
  double bytes = (double)n_triangle * n_triangle, available = rad_memory_available();
  if (bytes <= available)
    return RAD_OK;
  return rad_fail(e, RAD_ESYSTEM,
                  "the scene has %d triangles, and the table of who sees whom takes %.3g GB, but "
                  "only %.3g GB are available; merge triangles that lie in one plane to less than "
                  "%.2g in all, or use a larger machine",
                  n_triangle, bytes / 1e9, available / 1e9, sqrt(available));
}

enum rad_code rad_visibility_build(struct rad_scene *scene, struct rad_visibility *v,
                                   struct rad_error *e) {
  *v = (struct rad_visibility){0};
  scene->visibility = NULL;
  size_t n = (size_t)scene->n_triangle;
  enum rad_code code = refuse_too_large(scene->n_triangle, e);
  if (!code)
    code = rad_occluders_build(scene, &v->occluders, e);
  if (code)
    return code;
  int64_t most = (int64_t)(MEMORY_PART * rad_memory_available() / sizeof(int));
  v->row = rad_calloc(n, sizeof *v->row);
  if (!v->row || !(v->sight = rad_sight_matrix(&v->occluders, most, v->row)))
    code = rad_fail_memory(e, "the table of triangles that see each other", (double)(n * n));
  if (!code && rad_stop_asked())
    code = rad_fail_stopped(e);
  for (size_t i = 0; i < n && !code; i++)
    for (size_t j = i + 1; j < n; j++)
      v->n_partly += v->sight[i * n + j] == RAD_PARTLY;
  if (!code)
    scene->visibility = v;
  return code;
}

const int *rad_blockers(const struct rad_visibility *v, int i, int j, int *list, int *n) {
  const struct rad_sight_row *row = &v->row[i < j ? i : j];
  int other = i < j ? j : i, at = 0;
  while (at < row->n && row->data[at] < other)
    at += 2 + row->data[at + 1];
  if (at < row->n && row->data[at] == other) {
    *n = row->data[at + 1];
    return row->data + at + 2;
  }
  rad_sight_between(&v->occluders, i, j, list, n);
  return list;
}

void rad_visibility_free(struct rad_visibility *v) {
  for (int i = 0; v->row && i < v->occluders.scene->n_triangle; i++)
    free(v->row[i].data);
  free(v->row);
  rad_occluders_free(&v->occluders);
  free(v->sight);
  *v = (struct rad_visibility){0};
}
