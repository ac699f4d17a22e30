/* Shared by the files that read a deck (deck*.c), and by nobody else. */
#ifndef RAD_SCENE_DECK_READ_H
#define RAD_SCENE_DECK_READ_H

#include <limits.h>
#include <math.h>

#include "scene/deck.h"
#include "scene/yaml.h"

/* ---- typed values: deck_value.c ---- */

struct rad_range {
  double lo, hi; /* infinite (or INT_MAX): no bound */
  bool open;     /* the bounds themselves are not allowed */
};

enum rad_key_type {
  RAD_KEY_OTHER, /* only noted in seen[]; the caller reads it */
  RAD_KEY_REAL,
  RAD_KEY_WHOLE,
  RAD_KEY_TEXT,
  RAD_KEY_CHOICE /* one of `choice`; its number goes to an int or enum */
};

/* One key that a mapping may have. */
struct rad_key {
  const char *name;
  enum rad_key_type type;
  size_t offset; /* of the destination */
  struct rad_range range;
  const char *const *choice; /* ends with NULL */
};

enum { RAD_MAX_KEY = 16 };

/**
 * Read a mapping by its table of keys. An empty value is an empty mapping.
 *
 * @param[in]  where  "section 'method'", for messages about unknown keys
 * @param[in]  key    [n_key], n_key <= RAD_MAX_KEY
 * @param[out] base   the struct that the offsets refer to
 * @param[out] seen   [n_key] value of each key, NULL if it was not given
 */
enum rad_code rad_read_map(struct rad_yaml *y, const struct rad_yaml_node *node, const char *where,
                           int n_key, const struct rad_key *key, void *base,
                           const struct rad_yaml_node *seen[]);

enum rad_code rad_read_real(struct rad_yaml *y, const struct rad_yaml_node *node, const char *key,
                            struct rad_range range, double *value);
enum rad_code rad_read_whole(struct rad_yaml *y, const struct rad_yaml_node *node, const char *key,
                             struct rad_range range, int *value);
/* A list of exactly n numbers. */
enum rad_code rad_read_reals(struct rad_yaml *y, const struct rad_yaml_node *node, const char *key,
                             int n, struct rad_range range, double *value);
/* Replaces *text, which is owned. Refuses an empty one. */
enum rad_code rad_read_text(struct rad_yaml *y, const struct rad_yaml_node *node, const char *key,
                            char **text);
enum rad_code rad_read_bool(struct rad_yaml *y, const struct rad_yaml_node *node, const char *key,
                            bool *value);
enum rad_code rad_read_choice(struct rad_yaml *y, const struct rad_yaml_node *node, const char *key,
                              const char *const *choice, int *value);

/* "'KEY' is WHAT STANDS THERE; give WANT" */
enum rad_code rad_fail_value(struct rad_yaml *y, const struct rad_yaml_node *node, const char *key,
                             const char *want);

/* A copy of a text, RAD_ESYSTEM when out of memory. */
enum rad_code rad_copy_text(struct rad_yaml *y, const char *text, char **copy);

/* "did you mean 'elements'?" or "allowed are lu, gmres"; list ends with NULL. */
void rad_suggest(const char *word, const char *const *list, char *out, size_t size);

/* ---- sections; node is NULL when the section is absent ---- */

enum rad_code rad_deck_read_bands(struct rad_yaml *y, const struct rad_yaml_node *node,
                                  struct rad_deck *deck);
/* What a triangle and a surface have in common: the first RAD_N_OPTICS keys of their tables. */
enum {
  RAD_OPTICS_RHO,
  RAD_OPTICS_EMISSIVITY,
  RAD_OPTICS_EMISSION,
  RAD_OPTICS_TEMPERATURE,
  RAD_OPTICS_FLUX,
  RAD_OPTICS_SIDE,
  RAD_N_OPTICS
};
#define RAD_OPTICS_KEYS                                                                            \
  [RAD_OPTICS_RHO] = {.name = "rho"}, [RAD_OPTICS_EMISSIVITY] = {.name = "emissivity"},            \
  [RAD_OPTICS_EMISSION] = {.name = "emission"},                                                    \
  [RAD_OPTICS_TEMPERATURE] = {.name = "temperature"}, [RAD_OPTICS_FLUX] = {.name = "flux"},        \
  [RAD_OPTICS_SIDE] = {.name = "side"}

/* node: [RAD_N_OPTICS] values, NULL where not given. */
enum rad_code rad_deck_read_optics(struct rad_yaml *y, const struct rad_yaml_node *const node[],
                                   int n_band, struct rad_deck_optics *optics);
enum rad_code rad_deck_read_normal(struct rad_yaml *y, const struct rad_yaml_node *node,
                                   const struct rad_yaml_node *side,
                                   struct rad_deck_optics *optics);
/* After bands and method. */
enum rad_code rad_deck_read_scene(struct rad_yaml *y, const struct rad_yaml_node *node,
                                  struct rad_deck *deck);
enum rad_code rad_deck_read_accuracy(struct rad_yaml *y, const struct rad_yaml_node *node,
                                     struct rad_deck *deck);
enum rad_code rad_deck_read_method(struct rad_yaml *y, const struct rad_yaml_node *node,
                                   struct rad_deck *deck);
enum rad_code rad_deck_read_probes(struct rad_yaml *y, const struct rad_yaml_node *node,
                                   struct rad_deck *deck);
enum rad_code rad_deck_read_output(struct rad_yaml *y, const struct rad_yaml_node *node,
                                   struct rad_deck *deck);
/* Last; tries every run of the study on the tree `root`. */
enum rad_code rad_deck_read_study(struct rad_yaml *y, struct rad_yaml_node *root,
                                  struct rad_yaml_node *node, struct rad_deck *deck);

enum rad_part {
  RAD_PART_TITLE,
  RAD_PART_BANDS,
  RAD_PART_SCENE,
  RAD_PART_ACCURACY,
  RAD_PART_METHOD,
  RAD_PART_PROBES,
  RAD_PART_OUTPUT,
  RAD_PART_STUDY,
  RAD_N_PART
};

/* Remember a mesh file that the deck names anywhere; NULL is none. */
enum rad_code rad_deck_name_mesh(struct rad_yaml *y, const char *file, struct rad_deck *deck);

/**
 * Fill a zeroed deck from a tree.
 *
 * @param[in] parts  bits 1 << RAD_PART_x of what to read; bands and method always are
 */
enum rad_code rad_deck_interpret(struct rad_yaml *y, struct rad_yaml_node *root, unsigned parts,
                                 struct rad_deck *deck);

/* Parts of the deck to read again when `key` (dotted) changes. */
unsigned rad_deck_parts_of(const char *key);

/* ---- overrides: deck_override.c ---- */

/* How to take an override back: the last one first. */
struct rad_override {
  struct rad_yaml_node **slot; /* NULL: nothing was changed */
  struct rad_yaml_node *old;
};

/**
 * Put `value` at a dotted key of the tree, e.g. scene.triangles.0.rho, making mappings on the way.
 *
 * Whether the keys are known shows when the tree is interpreted. A name with dots inside is found
 * when it is there already.
 *
 * @param[in]  at     place of new nodes and of errors
 * @param[out] undo   for rad_override_undo, also after an error
 */
enum rad_code rad_override_apply(struct rad_yaml *y, struct rad_yaml_node *root, const char *key,
                                 const struct rad_yaml_node *at, const struct rad_yaml_node *value,
                                 struct rad_override *undo);
void rad_override_undo(const struct rad_override *undo);

/* Parse the overrides of the command line and apply them in turn. */
enum rad_code rad_override_all(struct rad_yaml *y, struct rad_yaml_node *root, int n_set);

/* YAML of a node on one line, such that parsing it gives the node again. NULL when out of memory.
 */
char *rad_yaml_to_text(const struct rad_yaml_node *node);

#endif
