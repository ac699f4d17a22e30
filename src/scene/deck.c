#include "scene/deck.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "scene/deck_read.h"

#define MAX_FILE 1e9 /* bytes */

static const struct rad_key part_key[RAD_N_PART] = {
    [RAD_PART_TITLE] = {.name = "title",
                        .type = RAD_KEY_TEXT,
                        .offset = offsetof(struct rad_deck, title)},
    [RAD_PART_BANDS] = {.name = "bands"},
    [RAD_PART_SCENE] = {.name = "scene"},
    [RAD_PART_ACCURACY] = {.name = "accuracy"},
    [RAD_PART_METHOD] = {.name = "method"},
    [RAD_PART_PROBES] = {.name = "probes"},
    [RAD_PART_OUTPUT] = {.name = "output"},
    [RAD_PART_STUDY] = {.name = "study"},
};

unsigned rad_deck_parts_of(const char *key) {
  size_t n = strcspn(key, ".");
  unsigned parts = 0;
  for (int i = 0; i < RAD_N_PART; i++)
    if (strlen(part_key[i].name) == n && !strncmp(part_key[i].name, key, n))
      parts |= 1u << i;
  /* bands give the length of lists in the scene; a graded mesh needs whole exponents there */
  if (!strcmp(key, "bands") || !strncmp(key, "bands.", 6) || !strcmp(key, "method") ||
      !strcmp(key, "method.mesh"))
    parts |= 1u << RAD_PART_SCENE;
  return parts;
}

enum rad_code rad_deck_interpret(struct rad_yaml *y, struct rad_yaml_node *root, unsigned parts,
                                 struct rad_deck *deck) {
  static enum rad_code (*const read_part[RAD_N_PART])(
      struct rad_yaml *, const struct rad_yaml_node *, struct rad_deck *) = {
      [RAD_PART_SCENE] = rad_deck_read_scene,
      [RAD_PART_ACCURACY] = rad_deck_read_accuracy,
      [RAD_PART_PROBES] = rad_deck_read_probes,
      [RAD_PART_OUTPUT] = rad_deck_read_output,
  };
  const struct rad_yaml_node *seen[RAD_N_PART];
  enum rad_code code = rad_read_map(y, root, "the deck", RAD_N_PART, part_key, deck, seen);
  if (!code && !deck->title)
    code = rad_copy_text(y, "", &deck->title);
  if (!code && !seen[RAD_PART_SCENE])
    code = rad_yaml_fail(y, root, "there is no 'scene'; give one with 'triangles' or 'mesh'");
  if (!code)
    code = rad_deck_read_bands(y, seen[RAD_PART_BANDS], deck);
  if (!code)
    code = rad_deck_read_method(y, seen[RAD_PART_METHOD], deck);
  for (int i = 0; i < RAD_N_PART && !code; i++)
    if (read_part[i] && parts & 1u << i)
      code = read_part[i](y, seen[i], deck);
  if (!code && parts & 1u << RAD_PART_STUDY)
    code = rad_deck_read_study(y, root, (struct rad_yaml_node *)seen[RAD_PART_STUDY], deck);
  return code;
}

enum rad_code rad_deck_name_mesh(struct rad_yaml *y, const char *file, struct rad_deck *deck) {
  for (int i = 0; i < deck->n_named_mesh && file; i++)
    if (!strcmp(deck->named_mesh[i], file))
      return RAD_OK;
  if (!file)
    return RAD_OK;
  char **grown = realloc(deck->named_mesh, (size_t)(deck->n_named_mesh + 1) * sizeof *grown);
  if (!grown)
    return rad_fail_memory(y->e, "the deck", (double)sizeof *grown * deck->n_named_mesh);
  deck->named_mesh = grown;
  const enum rad_code code = rad_copy_text(y, file, &grown[deck->n_named_mesh]);
  deck->n_named_mesh += !code;
  return code;
}

/* Value of a key of a mapping, or NULL. */
static const struct rad_yaml_node *member(const struct rad_yaml_node *map, const char *key) {
  if (map && map->kind == RAD_YAML_MAP)
    for (const struct rad_yaml_node *k = map->first; k; k = k->next->next)
      if (!strcmp(k->text, key))
        return k->next;
  return NULL;
}

/* The mesh as written: an override may put another in its place. */
static enum rad_code name_written_mesh(struct rad_yaml *y, const struct rad_yaml_node *root,
                                       struct rad_deck *deck) {
  const struct rad_yaml_node *file = member(member(member(root, "scene"), "mesh"), "file");
  return file && file->kind == RAD_YAML_SCALAR ? rad_deck_name_mesh(y, file->text, deck) : RAD_OK;
}

enum rad_code rad_deck_read(const char *path, int n_set, const char *const *set,
                            struct rad_deck *deck, struct rad_error *e) {
  *deck = (struct rad_deck){0};
  struct rad_yaml y = {.path = path, .set = set, .e = e};
  struct rad_yaml_node *root = NULL;
  size_t n = 0;
  enum rad_code code = rad_copy_text(&y, path, &deck->path);
  if (!code)
    code = rad_file_read(path, "the deck", (size_t)MAX_FILE,
                         "put the triangles into a mesh file (scene.mesh)", &deck->text, &n, e);
  if (!code)
    code = rad_yaml_parse(&y, 0, deck->text, n, &root);
  if (!code && root->kind != RAD_YAML_MAP)
    code = rad_yaml_fail(&y, root,
                         "the deck is %s; write sections, at least 'scene:' (docs/format.md)",
                         rad_yaml_is_nothing(root) ? "empty" : "no mapping");
  if (!code)
    code = name_written_mesh(&y, root, deck);
  if (!code)
    code = rad_override_all(&y, root, n_set);
  if (!code)
    code = rad_deck_interpret(&y, root, ~0u, deck);
  if (!code)
    code = rad_deck_name_mesh(&y, deck->mesh_file, deck);
  rad_yaml_free(&y);
  return code;
}

static void free_vary(struct rad_deck_vary *vary, int n) {
  for (int k = 0; k < n; k++) {
    for (int i = 0; i < vary[k].n; i++)
      free(vary[k].value[i]);
    free(vary[k].value);
    free(vary[k].key);
  }
  free(vary);
}

void rad_deck_free(struct rad_deck *deck) {
  free(deck->path);
  free(deck->text);
  free(deck->title);
  for (int i = 0; i < RAD_MAX_BAND; i++)
    free(deck->band[i]);
  for (int i = 0; i < deck->n_triangle; i++)
    free(deck->triangle[i].name);
  free(deck->triangle);
  free(deck->mesh_file);
  for (int i = 0; i < deck->n_named_mesh; i++)
    free(deck->named_mesh[i]);
  free(deck->named_mesh);
  for (int i = 0; i < deck->n_surface; i++)
    free(deck->surface[i].name);
  free(deck->surface);
  for (int i = 0; i < deck->n_probe; i++) {
    free(deck->probe[i].name);
    free(deck->probe[i].surface);
  }
  free(deck->probe);
  free(deck->output.file);
  free_vary(deck->study.vary, deck->study.n_vary);
  free_vary(deck->study.reference, deck->study.n_reference);
  *deck = (struct rad_deck){0};
}
