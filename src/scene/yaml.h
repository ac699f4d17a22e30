/* A strict YAML reader: text to a tree of nodes that know where they come from. */
#ifndef RAD_SCENE_YAML_H
#define RAD_SCENE_YAML_H

#include <stdbool.h>
#include <stddef.h>

#include "base/error.h"

enum rad_yaml_kind { RAD_YAML_SCALAR, RAD_YAML_LIST, RAD_YAML_MAP };

enum { RAD_YAML_MAX_DEPTH = 32 }; /* containers in containers stay below this */

struct rad_yaml_node {
  struct rad_yaml_node *next; /* sibling; in a map keys and values alternate */
  union {
    struct rad_yaml_node *first; /* list, map: NULL when empty */
    const char *text;            /* scalar: zero at the end, none within */
  };
  int n;                 /* list: items; scalar: bytes; map: unused */
  int line, column;      /* 1-based */
  unsigned short source; /* 0: the deck; k: override k-1 */
  unsigned char kind;    /* enum rad_yaml_kind */
  bool plain : 1;        /* scalar without quotes */
  bool study : 1;        /* written in section `study` */
};

/* One deck being read: where its nodes live and where complaints go. */
struct rad_yaml {
  const char *path;       /* of the deck, for messages */
  const char *const *set; /* overrides as typed, for messages */
  struct rad_error *e;
  /* While a study's runs are tried out: an error outside `study` is reported at this value. */
  const struct rad_yaml_node *blame;
  char blame_note[240];         /* which run */
  struct rad_yaml_chunk *chunk; /* owned: nodes and texts */
};

/**
 * Parse one document. Refused: what is not UTF-8, tabs in the indentation, anchors, aliases, tags,
 * further documents, duplicate keys, keys that are not scalars, zero bytes, too deep nesting.
 *
 * @param[in]  source  0 for the deck, k for override k-1
 * @param[in]  text    [n] bytes
 * @param[out] root    the tree, alive until rad_yaml_free; of no text an empty plain scalar
 * @return RAD_OK, RAD_EINPUT, or RAD_ESYSTEM out of memory
 */
enum rad_code rad_yaml_parse(struct rad_yaml *y, unsigned short source, const char *text, size_t n,
                             struct rad_yaml_node **root);

void rad_yaml_free(struct rad_yaml *y); /* safe twice */

/* RAD_EINPUT with the place of `at` in front: "PATH:LINE:COLUMN: error: " or "--set K=V: error: ".
 */
enum rad_code rad_yaml_fail(struct rad_yaml *y, const struct rad_yaml_node *at, const char *fmt,
                            ...) __attribute__((format(printf, 3, 4)));

/* A new node placed where `at` is; its text is copied unless NULL. NULL when out of memory. */
struct rad_yaml_node *rad_yaml_node_new(struct rad_yaml *y, const struct rad_yaml_node *at,
                                        enum rad_yaml_kind kind, const char *text, size_t n);

/* Nothing was written: an empty plain scalar, ~ or null. */
bool rad_yaml_is_nothing(const struct rad_yaml_node *node);

#endif
