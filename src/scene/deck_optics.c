/* What a triangle or a surface of the deck says of its radiation. */
#include <string.h>

#include "scene/deck_read.h"

static const struct rad_range any = {-INFINITY, INFINITY, false};
static const struct rad_range fraction = {0, 1, false};
static const struct rad_range not_negative = {0, INFINITY, false};

static const char *const sides[] = {"front", "back", "both", NULL}; /* in the order of rad_side */

/* One number for all bands, or a list with one number per band. */
static enum rad_code read_spectrum(struct rad_yaml *y, const struct rad_yaml_node *node,
                                   const char *key, struct rad_range range, int n_band,
                                   double *value) {
  if (node->kind == RAD_YAML_LIST && node->n != n_band)
    return rad_yaml_fail(y, node,
                         "'%s' has %d numbers but there are %d bands; give one number, or a list "
                         "with one per band",
                         key, node->n, n_band);
  if (node->kind == RAD_YAML_LIST)
    return rad_read_reals(y, node, key, n_band, range, value);
  enum rad_code code = rad_read_real(y, node, key, range, &value[0]);
  for (int b = 1; b < n_band && !code; b++)
    value[b] = value[0];
  return code;
}

static enum rad_code read_linear_emission(struct rad_yaml *y, const struct rad_yaml_node *node,
                                          int n_band, struct rad_deck_optics *optics) {
  static const struct rad_key key[] = {{.name = "vertices"}};
  const struct rad_yaml_node *list;
  enum rad_code code = rad_read_map(y, node, "'emission'", 1, key, optics, &list);
  if (code)
    return code;
  if (!list || list->kind != RAD_YAML_LIST || list->n != 3)
    return rad_fail_value(y, list ? list : node, list ? "vertices" : "emission",
                          "a number, one per band, or {vertices: [E0, E1, E2]}");
  int v = 0;
  for (const struct rad_yaml_node *item = list->first; item && !code; item = item->next)
    code = read_spectrum(y, item, "emission", not_negative, n_band, optics->emission[v++]);
  return code;
}

static enum rad_code read_emission(struct rad_yaml *y, const struct rad_yaml_node *node, int n_band,
                                   struct rad_deck_optics *optics) {
  if (node->kind == RAD_YAML_MAP)
    return read_linear_emission(y, node, n_band, optics);
  enum rad_code code =
      read_spectrum(y, node, "emission", not_negative, n_band, optics->emission[0]);
  for (int v = 1; v < 3; v++)
    memcpy(optics->emission[v], optics->emission[0], sizeof optics->emission[0]);
  return code;
}

/* Keys of one mapping that say the same thing in two ways, or of different ways. */
static enum rad_code refuse_mixture(struct rad_yaml *y, const struct rad_yaml_node *const node[]) {
  static const char *const name[] = {"rho", "emissivity", "emission", "temperature", "flux"};
  static const int pair[][2] = {{RAD_OPTICS_RHO, RAD_OPTICS_EMISSIVITY},
                                {RAD_OPTICS_RHO, RAD_OPTICS_TEMPERATURE},
                                {RAD_OPTICS_RHO, RAD_OPTICS_FLUX},
                                {RAD_OPTICS_EMISSION, RAD_OPTICS_EMISSIVITY},
                                {RAD_OPTICS_EMISSION, RAD_OPTICS_TEMPERATURE},
                                {RAD_OPTICS_EMISSION, RAD_OPTICS_FLUX},
                                {RAD_OPTICS_TEMPERATURE, RAD_OPTICS_FLUX}};
  for (size_t i = 0; i < sizeof pair / sizeof *pair; i++)
    if (node[pair[i][0]] && node[pair[i][1]])
      return rad_yaml_fail(y, node[pair[i][1]],
                           "'%s' and '%s' exclude each other; give rho and emission, or "
                           "emissivity and temperature, or emissivity and flux",
                           name[pair[i][0]], name[pair[i][1]]);
  return RAD_OK;
}

/* The keys of heat radiation, which is grey: a temperature says nothing of single bands. */
static enum rad_code read_heat(struct rad_yaml *y, const struct rad_yaml_node *const node[],
                               int n_band, struct rad_deck_optics *o) {
  const struct {
    const char *name;
    const struct rad_yaml_node *node;
    struct rad_range range;
    double *value;
    bool *has;
  } key[] = {
      {"emissivity", node[RAD_OPTICS_EMISSIVITY], fraction, &o->emissivity, &o->has_emissivity},
      {"temperature", node[RAD_OPTICS_TEMPERATURE], not_negative, &o->temperature,
       &o->has_temperature},
      {"flux", node[RAD_OPTICS_FLUX], any, &o->flux, &o->has_flux}};
  enum rad_code code = RAD_OK;
  for (int i = 0; i < 3 && !code; i++) {
    *key[i].has = key[i].node != NULL;
    if (key[i].node && n_band > 1)
      return rad_yaml_fail(y, key[i].node,
                           "'%s' is for grey radiation, but the deck has %d bands; remove 'bands', "
                           "or give rho and emission for each band",
                           key[i].name, n_band);
    if (key[i].node)
      code = rad_read_real(y, key[i].node, key[i].name, key[i].range, key[i].value);
  }
  return code;
}

enum rad_code rad_deck_read_optics(struct rad_yaml *y, const struct rad_yaml_node *const node[],
                                   int n_band, struct rad_deck_optics *optics) {
  optics->has_rho = node[RAD_OPTICS_RHO] != NULL;
  optics->has_emission = node[RAD_OPTICS_EMISSION] != NULL;
  enum rad_code code = refuse_mixture(y, node);
  if (!code)
    code = read_heat(y, node, n_band, optics);
  if (!code && optics->has_rho)
    code = read_spectrum(y, node[RAD_OPTICS_RHO], "rho", fraction, n_band, optics->rho);
  if (!code && optics->has_emission)
    code = read_emission(y, node[RAD_OPTICS_EMISSION], n_band, optics);
  int number = 0;
  if (!code && node[RAD_OPTICS_SIDE]) {
    code = rad_read_choice(y, node[RAD_OPTICS_SIDE], "side", sides, &number);
    optics->side = (enum rad_side)(RAD_SIDE_FRONT + number);
  }
  return code;
}

enum rad_code rad_deck_read_normal(struct rad_yaml *y, const struct rad_yaml_node *node,
                                   const struct rad_yaml_node *side,
                                   struct rad_deck_optics *optics) {
  if (side)
    return rad_yaml_fail(y, side, "both 'normal' and 'side' are given; remove one of them");
  optics->side = RAD_SIDE_NORMAL;
  enum rad_code code = rad_read_reals(y, node, "normal", 3, any, optics->normal);
  const double *n = optics->normal;
  if (!code && n[0] == 0 && n[1] == 0 && n[2] == 0)
    return rad_fail_value(y, node, "normal", "a direction that is not zero");
  return code;
}
