#include "scene/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/place.h"
#include "base/vec.h"
#include "scene/check.h"
#include "scene/obj.h"
#include "scene/optics.h"
#include "scene/surface.h"
#include "scene/weld.h"

#define PERPENDICULAR 1e-6 /* sine of the angle between the given and the geometric normal */

/* What lives only while a scene is built. Its sources are the deck's triangles, then the mesh's. */
struct builder {
  const struct rad_deck *deck;
  struct rad_scene *scene;
  struct rad_error *e;
  const char *path;
  char *mesh_path; /* owned, NULL without a mesh */
  struct rad_obj obj;
  int n_source;
  int *surface; /* owned [deck->n_triangle + obj.n_part] surface of each name */
  int *entry;   /* owned, the same length; [n_surface] its place in deck->surface, or -1 */
  int *number;  /* owned [scene->n_triangle] source, from 1 */
  struct rad_checked checked;
};

static enum rad_code out_of_memory(struct builder *b, double bytes) {
  return rad_fail_memory(b->e, "the scene", bytes);
}

/* The mesh file beside the deck, unless its name starts at the root. */
static enum rad_code read_mesh(struct builder *b, struct rad_notes *notes) {
  if (!b->deck->mesh_file)
    return RAD_OK;
  if (!(b->mesh_path = rad_path_beside(b->path, b->deck->mesh_file)))
    return out_of_memory(b, 1000);
  return rad_obj_read(b->mesh_path, &b->obj, notes, b->e);
}

static enum rad_code refuse_empty(struct builder *b) {
  b->n_source = b->deck->n_triangle + b->obj.n_triangle;
  if (b->n_source < 1)
    return rad_fail(b->e, RAD_EINPUT,
                    "%s: error: the scene is empty; give scene.triangles or scene.mesh", b->path);
  return RAD_OK;
}

static enum rad_code find_surfaces(struct builder *b) {
  int n_deck = b->deck->n_triangle, n = n_deck + b->obj.n_part;
  const char **name = rad_alloc((size_t)n, sizeof *name);
  b->surface = rad_calloc((size_t)n, sizeof *b->surface);
  b->entry = rad_calloc((size_t)n, sizeof *b->entry);
  enum rad_code code = RAD_OK;
  if (!name || !b->surface || !b->entry)
    code = out_of_memory(b, 16.0 * n);
  for (int k = 0; k < n && !code; k++)
    name[k] = k < n_deck ? b->deck->triangle[k].name : b->obj.part_name[k - n_deck];
  if (!code)
    code = rad_surfaces_number(b->deck, b->path, n, name, b->scene, b->surface, b->entry, b->e);
  free(name);
  return code;
}

/* The deck's triangle that is source k, or NULL. */
static const struct rad_deck_triangle *in_deck(const struct builder *b, int k) {
  return k < b->deck->n_triangle ? &b->deck->triangle[k] : NULL;
}

static const struct rad_obj_triangle *in_mesh(const struct builder *b, int k) {
  return &b->obj.triangle[k - b->deck->n_triangle];
}

static int surface_of(const struct builder *b, int k) {
  return b->surface[in_deck(b, k) ? k : b->deck->n_triangle + in_mesh(b, k)->part];
}

/* The optics of source k's own; a triangle of the mesh has none. */
static const struct rad_deck_optics *own_optics(const struct builder *b, int k) {
  static const struct rad_deck_optics none = {0};
  return in_deck(b, k) ? &in_deck(b, k)->optics : &none;
}

/* The optics of source k's surface, or NULL. */
static const struct rad_deck_optics *surface_optics(const struct builder *b, int k) {
  int entry = b->entry[surface_of(b, k)];
  return entry < 0 ? NULL : &b->deck->surface[entry].optics;
}

/* The optics that decide the side of source k: its own before its surface's. */
static const struct rad_deck_optics *side_optics(const struct builder *b, int k) {
  const struct rad_deck_optics *own = own_optics(b, k), *shared = surface_optics(b, k);
  return own->side == RAD_SIDE_UNSET && shared ? shared : own;
}

static void copy_triangle(struct builder *b, int from, int to) {
  const struct rad_deck_triangle *deck = in_deck(b, from);
  struct rad_triangle *t = &b->scene->triangle[to];
  t->surface = surface_of(b, from);
  b->number[to] = from + 1;
  if (!deck) {
    const struct rad_obj_triangle *mesh = in_mesh(b, from);
    for (int m = 0; m < 9; m++)
      t->v[m / 3][m % 3] = b->deck->mesh_scale * b->obj.vertex[mesh->vertex[m / 3]][m % 3];
    t->line = mesh->line;
    return;
  }
  memcpy(t->v, deck->vertex, sizeof t->v);
  memcpy(t->grading, deck->grading, sizeof t->grading);
  memcpy(t->elements, deck->elements, sizeof t->elements);
  t->n_grading = deck->n_grading;
  t->n_elements = deck->n_elements;
  t->line = deck->line;
}

/* Scene triangles in the order of the sources; `side: both` makes the front and, next to it, the
 * back. */
static enum rad_code make_triangles(struct builder *b) {
  struct rad_scene *scene = b->scene;
  int n = b->n_source, n_twin = 0;
  for (int k = 0; k < n; k++)
    n_twin += side_optics(b, k)->side == RAD_SIDE_BOTH;
  scene->triangle = calloc((size_t)n + (size_t)n_twin, sizeof *scene->triangle);
  b->number = calloc((size_t)n + (size_t)n_twin, sizeof *b->number);
  if (!scene->triangle || !b->number)
    return out_of_memory(b, ((double)n + n_twin) * sizeof *scene->triangle);
  for (int k = 0; k < n; k++) {
    copy_triangle(b, k, scene->n_triangle++);
    if (side_optics(b, k)->side == RAD_SIDE_BOTH)
      copy_triangle(b, k, scene->n_triangle++);
  }
  b->checked = (struct rad_checked){scene, b->path, b->mesh_path, b->deck->n_triangle, b->number};
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
  enum rad_code code = rad_optics_begin(b->scene, b->e);
  for (int t = 0; t < b->scene->n_triangle && !code; t++) {
    int from = b->number[t] - 1;
    code = rad_optics_set(&b->checked, t, own_optics(b, from), surface_optics(b, from), b->scene,
                          b->e);
  }
  return code;
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
  enum rad_code code = read_mesh(b, notes);
  code = code ? code : refuse_empty(b);
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
  rad_obj_free(&b.obj);
  free(b.mesh_path);
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
  free(scene->heat);
  *scene = (struct rad_scene){0};
}
