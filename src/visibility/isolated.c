#include "visibility/isolated.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "scene/shell.h"

struct search {
  const struct rad_scene *scene;
  const char *path;
  unsigned char *sees; /* owned [n_triangle] 1: sees another face */
  struct rad_shells shells;
};

static const unsigned char *row_of(const struct rad_scene *s, int t) {
  return s->visibility->sight + (size_t)t * (size_t)s->n_triangle;
}

static int sees_any(const struct rad_scene *s, int t) {
  const unsigned char *row = row_of(s, t);
  for (int j = 0; j < s->n_triangle; j++)
    if (row[j] != RAD_HIDDEN)
      return 1;
  return 0;
}

static const char *name_of(const struct rad_scene *s, int t) {
  return s->surface_name[s->triangle[t].surface];
}

/* --- scenes --- */

static void note_dark(const struct search *q, struct rad_notes *notes) {
  size_t n = (size_t)q->scene->n_triangle;
  if (n > 1 && !memchr(q->sees, 1, n))
    rad_notes_add(notes,
                  "%s: warning: no face of the scene sees another: every radiosity is what the "
                  "face emits, and all of it is lost; turn the faces that should light each other "
                  "(side: back)",
                  q->path);
}

/* --- fluxes --- */

static int has_blind_flux(const struct search *q, int t) {
  const struct rad_heat *heat = q->scene->heat;
  return !q->sees[t] && heat && heat[t].kind == RAD_HEAT_FLUX;
}

static enum rad_code refuse_blind_flux(const struct search *q, struct rad_error *e) {
  for (int t = 0; t < q->scene->n_triangle; t++)
    if (has_blind_flux(q, t) && q->scene->heat[t].flux < 0)
      return rad_fail(e, RAD_EINPUT,
                      "%s: error: surface '%s' takes up %g W/m2 (flux %g) on a face that sees no "
                      "other, so that nothing arrives and no temperature is possible; turn the "
                      "face (side: back), or give its temperature",
                      q->path, name_of(q->scene, t), -q->scene->heat[t].flux,
                      q->scene->heat[t].flux);
  return RAD_OK;
}

struct count {
  int blind, all;
};

static enum rad_code note_blind_flux(const struct search *q, struct rad_notes *notes,
                                     struct rad_error *e) {
  const struct rad_scene *s = q->scene;
  struct count *count = rad_calloc((size_t)s->n_surface, sizeof *count);
  if (!count)
    return rad_fail_memory(e, "the search for faces that see nothing", 8.0 * s->n_surface);
  for (int t = 0; t < s->n_triangle; t++) {
    count[s->triangle[t].surface].blind += has_blind_flux(q, t);
    count[s->triangle[t].surface].all++;
  }
  int n = 0;
  for (int i = 0; i < s->n_surface; i++)
    if (count[i].blind && n++ < RAD_MAX_ISOLATED_NOTES)
      rad_notes_add(notes,
                    "%s: warning: surface '%s' has a flux, but %d of its %d triangles see no other "
                    "face: nothing arrives there, flux and emissivity alone make their "
                    "temperature, and it counts in the surface's mean; turn them (side: back), or "
                    "leave them out",
                    q->path, s->surface_name[i], count[i].blind, count[i].all);
  if (n > RAD_MAX_ISOLATED_NOTES)
    rad_notes_add(notes, "%s: warning: and %d more surfaces have a flux on faces that see nothing",
                  q->path, n - RAD_MAX_ISOLATED_NOTES);
  free(count);
  return RAD_OK;
}

/* --- shells --- */

static int sees_other_shell(const struct search *q, int t) {
  const unsigned char *row = row_of(q->scene, t);
  const int *shell = q->shells.shell;
  for (int j = 0; q->sees[t] && j < q->scene->n_triangle; j++)
    if (row[j] != RAD_HIDDEN && shell[j] != shell[t])
      return 1;
  return 0;
}

/* One pass finds the shells that another shell sees, a second one names the rest by their first
 * triangles. */
static enum rad_code note_shells(const struct search *q, struct rad_notes *notes,
                                 struct rad_error *e) {
  const struct rad_shells *s = &q->shells;
  int *size = rad_calloc((size_t)s->n, sizeof *size), n = 0;
  if (!size)
    return rad_fail_memory(e, "the search for closed shells", 4.0 * s->n);
  for (int t = 0; t < q->scene->n_triangle; t++) {
    int k = s->shell[t];
    if (size[k] >= 0)
      size[k] = s->closed[k] && s->volume[k] > 0 && !sees_other_shell(q, t) ? size[k] + 1 : -1;
  }
  for (int t = 0; t < q->scene->n_triangle; t++) {
    int k = s->shell[t];
    if (size[k] > 0 && n++ < RAD_MAX_ISOLATED_NOTES)
      rad_notes_add(notes,
                    "%s: warning: surface '%s' is part of a closed shell of %d triangles that "
                    "radiates outwards, and no face outside it faces it; if it is a room, make it "
                    "radiate inwards (side: back, or turn the order of the vertices)",
                    q->path, name_of(q->scene, t), size[k]);
    size[k] = -1;
  }
  if (n > RAD_MAX_ISOLATED_NOTES)
    rad_notes_add(notes, "%s: warning: and %d more closed shells that nothing outside them faces",
                  q->path, n - RAD_MAX_ISOLATED_NOTES);
  free(size);
  return RAD_OK;
}

enum rad_code rad_check_isolated(const struct rad_scene *scene, const char *path,
                                 struct rad_notes *notes, struct rad_error *e) {
  struct search q = {scene, path, rad_alloc((size_t)scene->n_triangle, 1), {0}};
  if (!q.sees)
    return rad_fail_memory(e, "the search for faces that see nothing", scene->n_triangle);
  for (int t = 0; t < scene->n_triangle; t++)
    q.sees[t] = (unsigned char)sees_any(scene, t);
  enum rad_code code = refuse_blind_flux(&q, e);
  code = code ? code : rad_shells_find(scene, &q.shells, e);
  code = code ? code : note_shells(&q, notes, e);
  if (!code)
    note_dark(&q, notes);
  code = code ? code : note_blind_flux(&q, notes, e);
  rad_shells_free(&q.shells);
  free(q.sees);
  return code;
}
