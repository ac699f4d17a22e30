/* Sections `probes` and `output` of the deck: what the user wants to see. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/deck_read.h"

static enum rad_code read_probe(struct rad_yaml *y, const struct rad_yaml_node *node, int number,
                                struct rad_deck_probe *probe) {
  enum { NAME, SURFACE, AT, N };
  static const struct rad_key key[N] = {
      [NAME] = {.name = "name",
                .type = RAD_KEY_TEXT,
                .offset = offsetof(struct rad_deck_probe, name)},
      [SURFACE] = {.name = "surface",
                   .type = RAD_KEY_TEXT,
                   .offset = offsetof(struct rad_deck_probe, surface)},
      [AT] = {.name = "at"},
  };
  static const struct rad_range any = {-INFINITY, INFINITY, false};
  const struct rad_yaml_node *seen[N];
  probe->line = node->source ? 0 : node->line;
  enum rad_code code = rad_read_map(y, node, "a probe", N, key, probe, seen);
  if (!code && !seen[AT])
    return rad_yaml_fail(y, node, "the probe has no 'at'; give its point, at: [x, y, z]");
  if (!code)
    code = rad_read_reals(y, seen[AT], "at", 3, any, probe->at);
  if (code || seen[NAME])
    return code;
  char name[32];
  snprintf(name, sizeof name, "probe_%d", number);
  return rad_copy_text(y, name, &probe->name);
}

enum rad_code rad_deck_read_probes(struct rad_yaml *y, const struct rad_yaml_node *node,
                                   struct rad_deck *deck) {
  if (!node || rad_yaml_is_nothing(node))
    return RAD_OK;
  if (node->kind != RAD_YAML_LIST)
    return rad_fail_value(y, node, "probes", "a list, - {name: a, at: [x, y, z]}");
  deck->probe = calloc((size_t)node->n + 1, sizeof *deck->probe);
  if (!deck->probe)
    return rad_fail_memory(y->e, "the probes", (double)node->n * sizeof *deck->probe);
  enum rad_code code = RAD_OK;
  for (const struct rad_yaml_node *item = node->first; item && !code; item = item->next) {
    int i = deck->n_probe++;
    code = read_probe(y, item, i + 1, &deck->probe[i]);
  }
  return code;
}

static enum rad_code read_fields(struct rad_yaml *y, const struct rad_yaml_node *node,
                                 unsigned *fields) {
  static const char *const choice[] = {"radiosity", "irradiance", "net_flux", "temperature",
                                       NULL}; /* bits RAD_FIELD_* */
  if (node->kind != RAD_YAML_LIST || node->n == 0)
    return rad_fail_value(y, node, "fields",
                          "a list of radiosity, irradiance, net_flux, temperature");
  *fields = 0;
  for (const struct rad_yaml_node *item = node->first; item; item = item->next) {
    int number = 0;
    enum rad_code code = rad_read_choice(y, item, "fields", choice, &number);
    if (code)
      return code;
    if (*fields & 1u << number)
      return rad_yaml_fail(y, item, "field '%s' is named twice; remove one", item->text);
    *fields |= 1u << number;
  }
  return RAD_OK;
}

/* node may be NULL. */
static enum rad_code read_camera(struct rad_yaml *y, const struct rad_yaml_node *node,
                                 struct rad_deck_camera *c) {
  enum { FROM, TO, UP, ANGLE, N };
  static const struct rad_key key[N] = {
      [FROM] = {.name = "from"},
      [TO] = {.name = "to"},
      [UP] = {.name = "up"},
      [ANGLE] = {.name = "angle",
                 .type = RAD_KEY_REAL,
                 .offset = offsetof(struct rad_deck_camera, angle),
                 .range = {0.1, 170, false}},
  };
  static const struct rad_range any = {-INFINITY, INFINITY, false};
  double *point[] = {c->from, c->to, c->up};
  c->given = node != NULL;
  c->angle = NAN;
  const struct rad_yaml_node *seen[N] = {NULL};
  enum rad_code code =
      node ? rad_read_map(y, node, "section 'output.camera'", N, key, c, seen) : RAD_OK;
  for (int k = FROM; k <= UP; k++) {
    for (int d = 0; d < 3; d++)
      point[k][d] = NAN;
    if (!code && seen[k])
      code = rad_read_reals(y, seen[k], key[k].name, 3, any, point[k]);
  }
  return code;
}

/* In the working folder: runs/corner.yml gives corner.vtkhdf. */
static enum rad_code default_file(struct rad_yaml *y, char **file) {
  const char *slash = strrchr(y->path, '/'), *base = slash ? slash + 1 : y->path;
  const char *dot = strrchr(base, '.');
  size_t n = dot && dot != base ? (size_t)(dot - base) : strlen(base);
  *file = malloc(n + sizeof ".vtkhdf");
  if (!*file)
    return rad_fail_memory(y->e, "the deck", (double)n);
  memcpy(*file, base, n);
  memcpy(*file + n, ".vtkhdf", sizeof ".vtkhdf");
  return RAD_OK;
}

enum rad_code rad_deck_read_output(struct rad_yaml *y, const struct rad_yaml_node *node,
                                   struct rad_deck *deck) {
  enum { FILE_NAME, SAMPLING, CELLS, FIELDS, VIEW_FACTORS, CAMERA, N };
  static const char *const cells[] = {"linear", "lagrange", NULL}; /* in the order of rad_cells */
  static const struct rad_key key[N] = {
      [FILE_NAME] = {.name = "file",
                     .type = RAD_KEY_TEXT,
                     .offset = offsetof(struct rad_deck_output, file)},
      [SAMPLING] = {.name = "sampling",
                    .type = RAD_KEY_WHOLE,
                    .offset = offsetof(struct rad_deck_output, sampling),
                    .range = {1, 64, false}},
      [CELLS] = {.name = "cells",
                 .type = RAD_KEY_CHOICE,
                 .offset = offsetof(struct rad_deck_output, cells),
                 .choice = cells},
      [FIELDS] = {.name = "fields"},
      [VIEW_FACTORS] = {.name = "view_factors"},
      [CAMERA] = {.name = "camera"},
  };
  deck->output.sampling = 4;
  const struct rad_yaml_node *seen[N] = {NULL};
  enum rad_code code =
      node ? rad_read_map(y, node, "section 'output'", N, key, &deck->output, seen) : RAD_OK;
  if (!code && seen[FIELDS])
    code = read_fields(y, seen[FIELDS], &deck->output.fields);
  if (!code && seen[VIEW_FACTORS])
    code = rad_read_bool(y, seen[VIEW_FACTORS], "view_factors", &deck->output.view_factors);
  if (!code)
    code = read_camera(y, seen[CAMERA], &deck->output.camera);
  if (!code && !deck->output.file)
    code = default_file(y, &deck->output.file);
  return code;
}
