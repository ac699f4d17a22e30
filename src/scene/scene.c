#include "scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "base/vec.h"
#include "scene/check.h"
#include "scene/weld.h"

#define PERPENDICULAR 1e-6 /* sine of the angle between the given and the geometric normal */

/* What lives only while a scene is built. */
struct builder {
  const struct rad_deck *deck;
  struct rad_scene *scene;
  struct rad_error *e;
  const char *path;
  int *surface; /* owned [deck->n_triangle] surface number of each deck triangle */
  int *entry;   /* owned [scene->n_surface] its place in deck->surface, or -1 */
  int *number;  /* owned [scene->n_triangle] deck triangle, from 1 */
  struct rad_checked checked;
};

static enum rad_code out_of_memory(struct builder *b, double bytes) {
  return rad_fail_memory(b->e, "the scene", bytes);
}

static enum rad_code refuse_empty(struct builder *b) {
  if (b->deck->mesh_file)
    return rad_fail(b->e, RAD_EINPUT,
                    "%s: error: reading scene.mesh from OBJ is not available in this version; "
                    "give scene.triangles",
                    b->path);
  if (b->deck->n_triangle < 1)
    return rad_fail(b->e, RAD_EINPUT, "%s: error: the scene is empty; give scene.triangles",
                    b->path);
  return RAD_OK;
}

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

static enum rad_code fail_unused(struct builder *b, const struct rad_deck_surface *unused) {
  const char *nearest = b->scene->surface_name[0];
  for (int s = 1; s < b->scene->n_surface; s++)
    if (rad_edit_distance(unused->name, b->scene->surface_name[s], false) <
        rad_edit_distance(unused->name, nearest, false))
      nearest = b->scene->surface_name[s];
  char line[16] = "";
  if (unused->line > 0)
    snprintf(line, sizeof line, ":%d", unused->line);
  return rad_fail(b->e, RAD_EINPUT,
                  "%s%s: error: scene.surfaces.%s: no triangle has this name; did you mean '%s'? "
                  "rename or remove it",
                  b->path, line, unused->name, nearest);
}

/* Number the surfaces in the order of their first triangles. */
static enum rad_code number_surfaces(struct builder *b, const struct named *sorted) {
  const struct rad_deck *deck = b->deck;
  struct rad_scene *scene = b->scene;
  for (int k = 0, first = 0; k < deck->n_triangle; k++) {
    first = strcmp(sorted[k].name, sorted[first].name) ? k : first;
    b->surface[sorted[k].at] = sorted[first].at; /* the group's first triangle, for now */
  }
  for (int t = 0; t < deck->n_triangle; t++) {
    if (b->surface[t] != t) {
      b->surface[t] = b->surface[b->surface[t]];
      continue;
    }
    char *name = strdup(deck->triangle[t].name);
    if (!name)
      return out_of_memory(b, 100);
    b->entry[scene->n_surface] = -1;
    scene->surface_name[scene->n_surface] = name;
    b->surface[t] = scene->n_surface++;
  }
  for (int s = 0; s < deck->n_surface; s++) {
    const struct named *used = find_name(sorted, deck->n_triangle, deck->surface[s].name);
    if (!used)
      return fail_unused(b, &deck->surface[s]);
    b->entry[b->surface[used->at]] = s;
  }
  return RAD_OK;
}

static enum rad_code find_surfaces(struct builder *b) {
  size_t n = (size_t)b->deck->n_triangle;
  struct named *sorted = calloc(n, sizeof *sorted);
  b->surface = calloc(n, sizeof *b->surface);
  b->entry = calloc(n, sizeof *b->entry);
  b->scene->surface_name = calloc(n, sizeof *b->scene->surface_name);
  enum rad_code code = RAD_OK;
  if (!sorted || !b->surface || !b->entry || !b->scene->surface_name)
    code = out_of_memory(b, (double)n * 32);
  if (!code) {
    for (size_t t = 0; t < n; t++)
      sorted[t] = (struct named){b->deck->triangle[t].name, (int)t};
    qsort(sorted, n, sizeof *sorted, compare_names);
    code = number_surfaces(b, sorted);
  }
  free(sorted);
  return code;
}

/* The optics of deck triangle t's surface, or NULL. */
static const struct rad_deck_optics *surface_optics(const struct builder *b, int t) {
  int entry = b->entry[b->surface[t]];
  return entry < 0 ? NULL : &b->deck->surface[entry].optics;
}

/* The optics that decide the side of deck triangle t: its own before its surface's. */
static const struct rad_deck_optics *side_optics(const struct builder *b, int t) {
  const struct rad_deck_optics *own = &b->deck->triangle[t].optics, *shared = surface_optics(b, t);
  return own->side == RAD_SIDE_UNSET && shared ? shared : own;
}

static void copy_triangle(struct builder *b, int from, int to) {
  const struct rad_deck_triangle *deck = &b->deck->triangle[from];
  struct rad_triangle *t = &b->scene->triangle[to];
  memcpy(t->v, deck->vertex, sizeof t->v);
  memcpy(t->grading, deck->grading, sizeof t->grading);
  memcpy(t->elements, deck->elements, sizeof t->elements);
  t->n_grading = deck->n_grading;
  t->n_elements = deck->n_elements;
  t->surface = b->surface[from];
  t->line = deck->line;
  b->number[to] = from + 1;
}

/* Scene triangles in deck order; `side: both` makes the front and, next to it, the back. */
static enum rad_code make_triangles(struct builder *b) {
  struct rad_scene *scene = b->scene;
  int n = b->deck->n_triangle, n_twin = 0;
  for (int t = 0; t < n; t++)
    n_twin += side_optics(b, t)->side == RAD_SIDE_BOTH;
  scene->triangle = calloc((size_t)n + (size_t)n_twin, sizeof *scene->triangle);
  b->number = calloc((size_t)n + (size_t)n_twin, sizeof *b->number);
  if (!scene->triangle || !b->number)
    return out_of_memory(b, ((double)n + n_twin) * sizeof *scene->triangle);
  for (int t = 0; t < n; t++) {
    copy_triangle(b, t, scene->n_triangle++);
    if (side_optics(b, t)->side == RAD_SIDE_BOTH)
      copy_triangle(b, t, scene->n_triangle++);
  }
  b->checked = (struct rad_checked){scene, b->path, b->number};
  return RAD_OK;
}

static enum rad_code copy_bands(struct builder *b) {
  b->scene->n_band = b->deck->n_band;
  for (int band = 0; band < b->deck->n_band; band++) {
    b->scene->band[band] = strdup(b->deck->band[band] ? b->deck->band[band] : "all");
    if (!b->scene->band[band])
      return out_of_memory(b, 100);
  }
  return RAD_OK;
}

static enum rad_code set_optics(struct builder *b) {
  struct rad_scene *scene = b->scene;
  size_t n = (size_t)scene->n_triangle, n_band = (size_t)scene->n_band;
  scene->rho = calloc(n * n_band, sizeof *scene->rho);
  scene->emission = calloc(3 * n * n_band, sizeof *scene->emission);
  if (!scene->rho || !scene->emission)
    return out_of_memory(b, 32.0 * (double)(n * n_band));
  for (int t = 0; t < scene->n_triangle; t++) {
    int from = b->number[t] - 1;
    const struct rad_deck_optics *own = &b->deck->triangle[from].optics;
    const struct rad_deck_optics *shared = surface_optics(b, from);
    const struct rad_deck_optics *rho = own->has_rho || !shared ? own : shared;
    const struct rad_deck_optics *emission = own->has_emission || !shared ? own : shared;
    if (!rho->has_rho || !emission->has_emission) {
      const char *what = rho->has_rho ? "emission" : "rho";
      return rad_check_fail(&b->checked, t, b->e, "no %s; give %s here or in scene.surfaces.%s",
                            what, what, scene->surface_name[scene->triangle[t].surface]);
    }
    memcpy(scene->rho + (size_t)t * n_band, rho->rho, n_band * sizeof *scene->rho);
    for (size_t m = 0; m < 3; m++)
      memcpy(scene->emission + (3 * (size_t)t + m) * n_band, emission->emission[m],
             n_band * sizeof *scene->emission);
  }
  return RAD_OK;
}

/* Area and right-hand normal, from the two shorter edges and with the differences and products in
 * extended precision: a thin triangle's digits would cancel in double. */
static void measure_triangle(struct rad_triangle *t) {
  int apex = 0; /* opposite the longest edge */
  double longest = 0;
  for (int m = 0; m < 3; m++) {
    double edge[3];
    rad_sub(t->v[(m + 2) % 3], t->v[(m + 1) % 3], edge);
    apex = rad_norm(edge) > longest ? m : apex;
    longest = fmax(longest, rad_norm(edge));
  }
  const double *x = t->v[apex], *y = t->v[(apex + 1) % 3], *z = t->v[(apex + 2) % 3];
  long double n[3], length = 0;
  for (int m = 0; m < 3; m++) {
    int o = (m + 1) % 3, p = (m + 2) % 3;
    n[m] = ((long double)y[o] - x[o]) * ((long double)z[p] - x[p]) -
           ((long double)y[p] - x[p]) * ((long double)z[o] - x[o]);
    length += n[m] * n[m];
  }
  length = sqrtl(length);
  t->area = (double)(length / 2);
  for (int m = 0; m < 3; m++)
    t->normal[m] = length > 0 ? (double)(n[m] / length) + 0.0 : 0; /* + 0.0: no negative zero */
}

/* Whether the user's normal has the direction of the triangle's: 1, the opposite: -1. */
static enum rad_code sign_of_normal(struct builder *b, int t, const double given[3], double *sign) {
  double largest = fmax(fabs(given[0]), fmax(fabs(given[1]), fabs(given[2]))), unit[3], across[3];
  for (int m = 0; m < 3; m++)
    unit[m] = given[m] / largest;
  double length = rad_norm(unit);
  if (!isfinite(length))
    return rad_check_fail(&b->checked, t, b->e,
                          "normal [%g, %g, %g] has no direction; give three finite numbers that "
                          "are not all zero, or side: front or back",
                          given[0], given[1], given[2]);
  const double *normal = b->scene->triangle[t].normal;
  rad_cross(unit, normal, across);
  *sign = rad_dot(unit, normal) < 0 ? -1 : 1;
  double sine = rad_norm(across) / length;
  if (sine <= PERPENDICULAR)
    return RAD_OK;
  return rad_check_fail(&b->checked, t, b->e,
                        "normal [%g, %g, %g] is %.3g degrees off the perpendicular; give "
                        "[%.9g, %.9g, %.9g], or side: front or back",
                        given[0], given[1], given[2],
                        57.29577951308232 * atan2(sine, fabs(rad_dot(unit, normal)) / length),
                        *sign * normal[0] + 0.0, *sign * normal[1] + 0.0, *sign * normal[2] + 0.0);
}

static enum rad_code turn_normals(struct builder *b) {
  for (int t = 0; t < b->scene->n_triangle; t++) {
    const struct rad_deck_optics *optics = side_optics(b, b->number[t] - 1);
    double sign = 1;
    if (optics->side == RAD_SIDE_NORMAL) {
      enum rad_code code = sign_of_normal(b, t, optics->normal, &sign);
      if (code)
        return code;
    }
    if (optics->side == RAD_SIDE_BACK ||
        (optics->side == RAD_SIDE_BOTH && t > 0 && b->number[t] == b->number[t - 1]))
      sign = -1;
    double *normal = b->scene->triangle[t].normal;
    for (int m = 0; m < 3; m++)
      normal[m] = sign * normal[m] + 0.0;
  }
  return RAD_OK;
}

static enum rad_code build(struct builder *b, struct rad_notes *notes) {
  enum rad_code code = refuse_empty(b);
  code = code ? code : find_surfaces(b);
  code = code ? code : make_triangles(b);
  code = code ? code : copy_bands(b);
  code = code ? code : set_optics(b);
  code = code ? code : rad_check_numbers(&b->checked, b->e);
  code = code ? code : rad_weld(b->scene, b->path, b->e);
  for (int t = 0; !code && t < b->scene->n_triangle; t++)
    measure_triangle(&b->scene->triangle[t]);
  code = code ? code : rad_check_shapes(&b->checked, b->e);
  code = code ? code : turn_normals(b);
  code = code ? code : rad_check_duplicates(&b->checked, b->e);
  return code ? code : rad_check_contacts(&b->checked, notes, b->e);
}

enum rad_code rad_scene_build(const struct rad_deck *deck, struct rad_scene *scene,
                              struct rad_notes *notes, struct rad_error *e) {
  *scene = (struct rad_scene){0};
  struct builder b = {
      .deck = deck, .scene = scene, .e = e, .path = deck->path ? deck->path : "scene"};
  enum rad_code code = build(&b, notes);
  free(b.surface);
  free(b.entry);
  free(b.number);
  return code;
}

void rad_scene_free(struct rad_scene *scene) {
  for (int s = 0; s < scene->n_surface; s++)
    free(scene->surface_name[s]);
  for (int b = 0; b < scene->n_band; b++)
    free(scene->band[b]);
  free(scene->surface_name);
  free(scene->triangle);
  free(scene->vertex);
  free(scene->rho);
  free(scene->emission);
  *scene = (struct rad_scene){0};
}
