/* Typed values of a deck: numbers, texts, choices, lists, mappings by table. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "base/text.h"
#include "scene/deck_read.h"

enum { MAX_WORD = 40 };

void rad_suggest(const char *word, const char *const *list, char *out, size_t size) {
  size_t length = strlen(word);
  const char *nearest = NULL;
  int near = length <= 3 ? 1 : length <= 7 ? 2 : 3; /* farther is another word, not a slip */
  for (int i = 0; length <= MAX_WORD && list[i]; i++) {
    int d = rad_edit_distance(word, list[i], true);
    if (d < near || (d == near && !nearest)) {
      near = d;
      nearest = list[i];
    }
  }
  if (nearest) {
    snprintf(out, size, "did you mean '%s'?", nearest);
    return;
  }
  size_t used = (size_t)snprintf(out, size, "allowed are");
  for (int i = 0; list[i] && used < size; i++)
    used += (size_t)snprintf(out + used, size - used, "%s %s", i ? "," : "", list[i]);
}

enum rad_code rad_fail_value(struct rad_yaml *y, const struct rad_yaml_node *node, const char *key,
                             const char *want) {
  char what[80];
  if (node->kind == RAD_YAML_MAP)
    snprintf(what, sizeof what, "a mapping");
  else if (node->kind == RAD_YAML_LIST)
    snprintf(what, sizeof what, "a list of %d", node->n);
  else if (rad_yaml_is_nothing(node))
    snprintf(what, sizeof what, "empty");
  else
    snprintf(what, sizeof what, node->plain ? "%.60s" : "the text \"%.60s\"", node->text);
  return rad_yaml_fail(y, node, "'%s' is %s; give %s", key, what, want);
}

static enum rad_code fail_number(struct rad_yaml *y, const struct rad_yaml_node *node,
                                 const char *key, const char *kind, struct rad_range r) {
  char want[120];
  if (r.lo == -INFINITY)
    snprintf(want, sizeof want, "%s", kind);
  else if (r.hi >= INT_MAX)
    snprintf(want, sizeof want, r.open ? "%s greater than %.9g" : "%s, %.9g or more", kind, r.lo);
  else
    snprintf(want, sizeof want,
             r.open ? "%s greater than %.9g and less than %.9g" : "%s from %.9g to %.9g", kind,
             r.lo, r.hi);
  return rad_fail_value(y, node, key, want);
}

static bool is_number(const struct rad_yaml_node *node, struct rad_range r, double *value) {
  if (node->kind != RAD_YAML_SCALAR || !node->plain ||
      !rad_number_parse(node->text, strlen(node->text), value))
    return false;
  return r.open ? *value > r.lo && *value < r.hi : *value >= r.lo && *value <= r.hi;
}

enum rad_code rad_read_real(struct rad_yaml *y, const struct rad_yaml_node *node, const char *key,
                            struct rad_range range, double *value) {
  double x;
  if (!is_number(node, range, &x))
    return fail_number(y, node, key, "a finite number", range);
  *value = x;
  return RAD_OK;
}

enum rad_code rad_read_whole(struct rad_yaml *y, const struct rad_yaml_node *node, const char *key,
                             struct rad_range range, int *value) {
  double x;
  if (!is_number(node, range, &x) || x != floor(x))
    return fail_number(y, node, key, "a whole number", range);
  *value = (int)x;
  return RAD_OK;
}

enum rad_code rad_read_reals(struct rad_yaml *y, const struct rad_yaml_node *node, const char *key,
                             int n, struct rad_range range, double *value) {
  if (node->kind != RAD_YAML_LIST || node->n != n) {
    char want[40];
    snprintf(want, sizeof want, "a list of %d numbers", n);
    return rad_fail_value(y, node, key, want);
  }
  enum rad_code code = RAD_OK;
  for (const struct rad_yaml_node *item = node->first; item && !code; item = item->next)
    code = rad_read_real(y, item, key, range, value++);
  return code;
}

enum rad_code rad_copy_text(struct rad_yaml *y, const char *text, char **copy) {
  *copy = strdup(text);
  return *copy ? RAD_OK : rad_fail_memory(y->e, "the deck", (double)strlen(text) + 1);
}

enum rad_code rad_read_text(struct rad_yaml *y, const struct rad_yaml_node *node, const char *key,
                            char **text) {
  if (node->kind != RAD_YAML_SCALAR || node->n == 0 || rad_yaml_is_nothing(node))
    return rad_fail_value(y, node, key, "a text");
  for (const char *s = node->text; *s; s++)
    if ((unsigned char)*s < 0x20)
      return rad_yaml_fail(y, node,
                           "'%s' holds a control character or several lines; "
                           "give one line of text",
                           key);
  free(*text);
  return rad_copy_text(y, node->text, text);
}

enum rad_code rad_read_choice(struct rad_yaml *y, const struct rad_yaml_node *node, const char *key,
                              const char *const *choice, int *value) {
  bool is_text = node->kind == RAD_YAML_SCALAR && !rad_yaml_is_nothing(node);
  for (int i = 0; is_text && choice[i]; i++)
    if (!strcmp(choice[i], node->text)) {
      *value = i;
      return RAD_OK;
    }
  char hint[300];
  rad_suggest(is_text ? node->text : "", choice, hint, sizeof hint);
  if (!is_text)
    return rad_yaml_fail(y, node, "'%s' is not a name; %s", key, hint);
  return rad_yaml_fail(y, node, "'%s' cannot be '%.60s'; %s", key, node->text, hint);
}

enum rad_code rad_read_bool(struct rad_yaml *y, const struct rad_yaml_node *node, const char *key,
                            bool *value) {
  static const char *const choice[] = {"false", "true", NULL};
  int number = 0;
  enum rad_code code = rad_read_choice(y, node, key, choice, &number);
  *value = number;
  return code;
}

static enum rad_code read_key(struct rad_yaml *y, const struct rad_yaml_node *node,
                              const struct rad_key *key, char *base) {
  void *to = base + key->offset;
  switch (key->type) {
  case RAD_KEY_REAL:
    return rad_read_real(y, node, key->name, key->range, to);
  case RAD_KEY_WHOLE:
    return rad_read_whole(y, node, key->name, key->range, to);
  case RAD_KEY_TEXT:
    return rad_read_text(y, node, key->name, to);
  case RAD_KEY_CHOICE:
    return rad_read_choice(y, node, key->name, key->choice, to);
  case RAD_KEY_OTHER:
    break;
  }
  return RAD_OK;
}

static enum rad_code fail_unknown(struct rad_yaml *y, const struct rad_yaml_node *node,
                                  const char *where, int n_key, const struct rad_key *key) {
  const char *names[RAD_MAX_KEY + 1] = {NULL};
  for (int i = 0; i < n_key; i++)
    names[i] = key[i].name;
  char hint[300];
  rad_suggest(node->text, names, hint, sizeof hint);
  return rad_yaml_fail(y, node, "unknown key '%.60s' in %s; %s", node->text, where, hint);
}

enum rad_code rad_read_map(struct rad_yaml *y, const struct rad_yaml_node *node, const char *where,
                           int n_key, const struct rad_key *key, void *base,
                           const struct rad_yaml_node *seen[]) {
  for (int i = 0; i < n_key; i++)
    seen[i] = NULL;
  if (rad_yaml_is_nothing(node))
    return RAD_OK;
  if (node->kind != RAD_YAML_MAP)
    return rad_yaml_fail(y, node, "%s is not a mapping; write KEY: VALUE lines there", where);
  for (const struct rad_yaml_node *k = node->first; k; k = k->next->next) {
    int i = 0;
    while (i < n_key && strcmp(key[i].name, k->text))
      i++;
    if (i == n_key)
      return fail_unknown(y, k, where, n_key, key);
    seen[i] = k->next;
    enum rad_code code = read_key(y, k->next, &key[i], base);
    if (code)
      return code;
  }
  return RAD_OK;
}
