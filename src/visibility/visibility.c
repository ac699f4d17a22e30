#include "visibility/visibility.h"

#include <stdlib.h>

#include "base/memory.h"

/* Part of the memory that lists of blockers may take; they only save time. */
#define MEMORY_PART 0.05

enum rad_code rad_visibility_build(struct rad_scene *scene, struct rad_visibility *v,
                                   struct rad_error *e) {
  *v = (struct rad_visibility){0};
  size_t n = (size_t)scene->n_triangle;
  enum rad_code code = rad_occluders_build(scene, &v->occluders, e);
  int64_t most = (int64_t)(MEMORY_PART * rad_memory_available() / sizeof(int));
  v->row = rad_calloc(n, sizeof *v->row);
  if (!code && (!v->row || !(v->sight = rad_sight_matrix(&v->occluders, most, v->row))))
    code = rad_fail_memory(e, "the table of triangles that see each other", (double)(n * n));
  for (size_t i = 0; i < n && !code; i++)
    for (size_t j = i + 1; j < n; j++)
      v->n_partly += v->sight[i * n + j] == RAD_PARTLY;
  scene->visibility = code ? NULL : v;
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
