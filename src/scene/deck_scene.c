/* Sections `bands` and `scene` of the deck. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/deck_read.h"

static const struct rad_range any = {-INFINITY, INFINITY, false};
static const struct rad_range exponents = {1, 8, false};
static const struct rad_range subdivisions = {1, 4096, false};

enum rad_code rad_deck_read_bands(struct rad_yaml *y, const struct rad_yaml_node *node,
                                  struct rad_deck *deck) {
  if (!node) {
    deck->n_band = 1;
    return rad_copy_text(y, "all", &deck->band[0]);
  }
  if (node->kind != RAD_YAML_LIST || node->n < 1 || node->n > RAD_MAX_BAND) {
    char want[60];
    snprintf(want, sizeof want, "a list of 1 to %d names", RAD_MAX_BAND);
    return rad_fail_value(y, node, "bands", want);
  }
  for (const struct rad_yaml_node *item = node->first; item; item = item->next) {
    enum rad_code code = rad_read_text(y, item, "bands", &deck->band[deck->n_band]);
    if (code)
      return code;
    for (int i = 0; i < deck->n_band; i++)
      if (!strcmp(deck->band[i], deck->band[deck->n_band]))
        return rad_yaml_fail(y, item, "band '%.60s' is named twice; give distinct names",
                             deck->band[i]);
    deck->n_band++;
  }
  return RAD_OK;
}

static enum rad_code read_vertices(struct rad_yaml *y, const struct rad_yaml_node *node,
                                   struct rad_deck_triangle *t) {
  if (node->kind != RAD_YAML_LIST || node->n != 3)
    return rad_fail_value(y, node, "vertices", "3 points, [[x,y,z], [x,y,z], [x,y,z]]");
  enum rad_code code = RAD_OK;
  int v = 0;
  for (const struct rad_yaml_node *item = node->first; item && !code; item = item->next)
    code = rad_read_reals(y, item, "vertices", 3, any, t->vertex[v++]);
  return code;
}

/* One exponent, three or six. */
static enum rad_code read_grading(struct rad_yaml *y, const struct rad_yaml_node *node, bool whole,
                                  struct rad_deck_triangle *t) {
  bool is_list = node->kind == RAD_YAML_LIST;
  if (is_list && node->n != 3 && node->n != 6)
    return rad_fail_value(y, node, "grading", "1, 3 (edges) or 6 (sub-triangles) numbers");
  t->n_grading = is_list ? node->n : 3;
  const struct rad_yaml_node *item = is_list ? node->first : node;
  for (int i = 0; i < t->n_grading; i++) {
    enum rad_code code = rad_read_real(y, item, "grading", exponents, &t->grading[i]);
    if (code)
      return code;
    if (whole && t->grading[i] != floor(t->grading[i]))
      return rad_fail_value(y, item, "grading", "a whole number, as 'mesh: graded' needs");
    if (is_list)
      item = item->next;
  }
  return RAD_OK;
}

static enum rad_code read_elements(struct rad_yaml *y, const struct rad_yaml_node *node,
                                   struct rad_deck_triangle *t) {
  bool is_list = node->kind == RAD_YAML_LIST;
  if (is_list && node->n != 6)
    return rad_fail_value(y, node, "elements", "1 or 6 (sub-triangles) whole numbers");
  t->n_elements = is_list ? 6 : 1;
  enum rad_code code = RAD_OK;
  const struct rad_yaml_node *item = is_list ? node->first : node;
  for (int i = 0; i < t->n_elements && !code; i++) {
    code = rad_read_whole(y, item, "elements", subdivisions, &t->elements[i]);
    item = item->next;
  }
  return code;
}

static enum rad_code read_triangle(struct rad_yaml *y, const struct rad_yaml_node *node, int number,
                                   const struct rad_deck *deck, struct rad_deck_triangle *t) {
  enum { NAME = RAD_N_OPTICS, VERTICES, NORMAL, GRADING, ELEMENTS, N };
  static const struct rad_key key[N] = {
      RAD_OPTICS_KEYS,
      [NAME] = {.name = "name",
                .type = RAD_KEY_TEXT,
                .offset = offsetof(struct rad_deck_triangle, name)},
      [VERTICES] = {.name = "vertices"},
      [NORMAL] = {.name = "normal"},
      [GRADING] = {.name = "grading"},
      [ELEMENTS] = {.name = "elements"},
  };
  const struct rad_yaml_node *seen[N];
  t->line = node->source ? 0 : node->line;
  enum rad_code code = rad_read_map(y, node, "a triangle", N, key, t, seen);
  if (!code && !seen[VERTICES])
    return rad_yaml_fail(y, node, "the triangle has no 'vertices'; give 3 points, [[x,y,z], ...]");
  if (!code)
    code = read_vertices(y, seen[VERTICES], t);
  if (!code)
    code = rad_deck_read_optics(y, seen, deck->n_band, &t->optics);
  if (!code && seen[NORMAL])
    code = rad_deck_read_normal(y, seen[NORMAL], seen[RAD_OPTICS_SIDE], &t->optics);
  if (!code && seen[GRADING])
    code = read_grading(y, seen[GRADING], deck->method.mesh == RAD_MESH_GRADED, t);
  if (!code && seen[ELEMENTS])
    code = read_elements(y, seen[ELEMENTS], t);
  if (code || seen[NAME])
    return code;
  char name[32];
  snprintf(name, sizeof name, "triangle_%d", number);
  return rad_copy_text(y, name, &t->name);
}

static enum rad_code read_triangles(struct rad_yaml *y, const struct rad_yaml_node *node,
                                    struct rad_deck *deck) {
  if (node->kind != RAD_YAML_LIST || node->n == 0)
    return rad_fail_value(y, node, "triangles", "a list of at least one triangle");
  deck->triangle = calloc((size_t)node->n, sizeof *deck->triangle);
  if (!deck->triangle)
    return rad_fail_memory(y->e, "the triangles", (double)node->n * sizeof *deck->triangle);
  enum rad_code code = RAD_OK;
  for (const struct rad_yaml_node *item = node->first; item && !code; item = item->next) {
    int i = deck->n_triangle++;
    code = read_triangle(y, item, i + 1, deck, &deck->triangle[i]);
  }
  return code;
}

static enum rad_code read_mesh(struct rad_yaml *y, const struct rad_yaml_node *node,
                               struct rad_deck *deck) {
  enum { FILE_NAME, SCALE, N };
  static const struct rad_key key[N] = {
      [FILE_NAME] = {.name = "file",
                     .type = RAD_KEY_TEXT,
                     .offset = offsetof(struct rad_deck, mesh_file)},
      [SCALE] = {.name = "scale",
                 .type = RAD_KEY_REAL,
                 .offset = offsetof(struct rad_deck, mesh_scale),
                 .range = {0, INFINITY, true}},
  };
  const struct rad_yaml_node *seen[N];
  enum rad_code code = rad_read_map(y, node, "'scene.mesh'", N, key, deck, seen);
  if (!code && !seen[FILE_NAME])
    return rad_yaml_fail(y, node, "'scene.mesh' has no 'file'; write mesh: {file: NAME.obj}");
  return code;
}

static enum rad_code read_surface(struct rad_yaml *y, const struct rad_yaml_node *name, int n_band,
                                  struct rad_deck_surface *surface) {
  static const struct rad_key key[RAD_N_OPTICS] = {RAD_OPTICS_KEYS};
  const struct rad_yaml_node *seen[RAD_N_OPTICS], *emission;
  surface->line = name->source ? 0 : name->line;
  enum rad_code code = rad_read_text(y, name, "surfaces", &surface->name);
  if (!code)
    code = rad_read_map(y, name->next, "a surface", RAD_N_OPTICS, key, surface, seen);
  if (!code && (emission = seen[RAD_OPTICS_EMISSION]) && emission->kind == RAD_YAML_MAP)
    return rad_fail_value(y, emission, "emission",
                          "a number or a list, values by vertex belong to a triangle");
  if (!code)
    code = rad_deck_read_optics(y, seen, n_band, &surface->optics);
  return code;
}

static enum rad_code read_surfaces(struct rad_yaml *y, const struct rad_yaml_node *node,
                                   struct rad_deck *deck) {
  if (rad_yaml_is_nothing(node))
    return RAD_OK;
  if (node->kind != RAD_YAML_MAP)
    return rad_fail_value(y, node, "surfaces", "a mapping, NAME: {rho: ..., emission: ...}");
  size_t n = 0;
  for (const struct rad_yaml_node *k = node->first; k; k = k->next->next)
    n++;
  deck->surface = calloc(n + 1, sizeof *deck->surface);
  if (!deck->surface)
    return rad_fail_memory(y->e, "the surfaces", (double)(n * sizeof *deck->surface));
  enum rad_code code = RAD_OK;
  for (const struct rad_yaml_node *k = node->first; k && !code; k = k->next->next)
    code = read_surface(y, k, deck->n_band, &deck->surface[deck->n_surface++]);
  return code;
}

enum rad_code rad_deck_read_scene(struct rad_yaml *y, const struct rad_yaml_node *node,
                                  struct rad_deck *deck) {
  enum { TRIANGLES, MESH, SURFACES, N };
  static const struct rad_key key[N] = {[TRIANGLES] = {.name = "triangles"},
                                        [MESH] = {.name = "mesh"},
                                        [SURFACES] = {.name = "surfaces"}};
  const struct rad_yaml_node *seen[N];
  deck->mesh_scale = 1;
  enum rad_code code = rad_read_map(y, node, "section 'scene'", N, key, deck, seen);
  if (!code && !seen[TRIANGLES] && !seen[MESH])
    return rad_yaml_fail(y, node,
                         "the scene is empty; give 'triangles', or 'mesh: {file: NAME.obj}'");
  if (!code && seen[TRIANGLES])
    code = read_triangles(y, seen[TRIANGLES], deck);
  if (!code && seen[MESH])
    code = read_mesh(y, seen[MESH], deck);
  if (!code && seen[SURFACES])
    code = read_surfaces(y, seen[SURFACES], deck);
  return code;
}
