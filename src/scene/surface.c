#include "scene/surface.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"

struct named {
  const char *name;
  int at;
};

static int compare_names(const void *a, const void *b) {
  const struct named *p = a, *q = b;
  int order = strcmp(p->name, q->name);
  return order ? order : (p->at > q->at) - (p->at < q->at);
}

/* The first of the n sorted entries with this name, or NULL. */
static const struct named *find_name(const struct named *sorted, int n, const char *name) {
  int low = 0, high = n;
  while (low < high) {
    int middle = low + (high - low) / 2;
    if (strcmp(sorted[middle].name, name) < 0)
      low = middle + 1;
    else
      high = middle;
  }
  return low < n && !strcmp(sorted[low].name, name) ? &sorted[low] : NULL;
}

static enum rad_code fail_unused(const struct rad_scene *scene, const char *path,
                                 const struct rad_deck_surface *unused, struct rad_error *e) {
  const char *nearest = scene->surface_name[0];
  for (int s = 1; s < scene->n_surface; s++)
    if (rad_edit_distance(unused->name, scene->surface_name[s], false) <
        rad_edit_distance(unused->name, nearest, false))
      nearest = scene->surface_name[s];
  char line[16] = "";
  if (unused->line > 0)
    snprintf(line, sizeof line, ":%d", unused->line);
  return rad_fail(e, RAD_EINPUT,
                  "%s%s: error: scene.surfaces.%s: no triangle has this name; did you mean '%s'? "
                  "rename or remove it",
                  path, line, unused->name, nearest);
}

/* Equal names get one number, by their first places. */
static enum rad_code number(int n, const struct named *sorted, const char *const *name,
                            struct rad_scene *scene, int *surface, int *entry,
                            struct rad_error *e) {
  for (int k = 0, first = 0; k < n; k++) {
    first = strcmp(sorted[k].name, sorted[first].name) ? k : first;
    surface[sorted[k].at] = sorted[first].at; /* the name's first place, for now */
  }
  for (int k = 0; k < n; k++) {
    if (surface[k] != k) {
      surface[k] = surface[surface[k]];
      continue;
    }
    char *copy = strdup(name[k]);
    if (!copy)
      return rad_fail_memory(e, "the scene", 100);
    entry[scene->n_surface] = -1;
    scene->surface_name[scene->n_surface] = copy;
    surface[k] = scene->n_surface++;
  }
  return RAD_OK;
}

enum rad_code rad_surfaces_number(const struct rad_deck *deck, const char *path, int n,
                                  const char *const *name, struct rad_scene *scene, int *surface,
                                  int *entry, struct rad_error *e) {
  struct named *sorted = rad_alloc((size_t)n, sizeof *sorted);
  scene->surface_name = rad_calloc((size_t)n, sizeof *scene->surface_name);
  if (!sorted || !scene->surface_name) {
    free(sorted);
    return rad_fail_memory(e, "the scene", 24.0 * n);
  }
  for (int k = 0; k < n; k++)
    sorted[k] = (struct named){name[k], k};
  qsort(sorted, (size_t)n, sizeof *sorted, compare_names);
  enum rad_code code = number(n, sorted, name, scene, surface, entry, e);
  for (int s = 0; s < deck->n_surface && !code; s++) {
    const struct named *used = find_name(sorted, n, deck->surface[s].name);
    if (used)
      entry[surface[used->at]] = s;
    else
      code = fail_unused(scene, path, &deck->surface[s], e);
  }
  free(sorted);
  return code;
}
