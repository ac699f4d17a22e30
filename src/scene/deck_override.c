/* Overrides: a value put at a dotted key of the tree, and a tree value written as text. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "scene/deck_read.h"

/* The keys of study.vary hold dots themselves. */
static const char vary_prefix[] = "study.vary.";

static size_t part_length(const char *key, const char *rest) {
  size_t done = (size_t)(rest - key);
  if (done == strlen(vary_prefix) && !strncmp(key, vary_prefix, done))
    return strlen(rest);
  return strcspn(rest, ".");
}

/* The slot of the value whose name starts `rest`, the longest such name; its length in *n. */
static struct rad_yaml_node **find_in_map(struct rad_yaml_node *map, const char *rest, size_t *n) {
  struct rad_yaml_node **slot = NULL;
  for (struct rad_yaml_node *k = map->first; k; k = k->next->next) {
    size_t length = (size_t)k->n;
    if ((!slot || length > *n) && !strncmp(rest, k->text, length) &&
        (rest[length] == '.' || rest[length] == '\0')) {
      slot = &k->next;
      *n = length;
    }
  }
  return slot;
}

static struct rad_yaml_node **find_in_list(struct rad_yaml_node *list, const char *rest, size_t n) {
  char *end;
  long index = *rest >= '0' && *rest <= '9' ? strtol(rest, &end, 10) : -1;
  if (index < 0 || index >= list->n || end != rest + n)
    return NULL;
  struct rad_yaml_node **slot = &list->first;
  while (index-- > 0)
    slot = &(*slot)->next;
  return slot;
}

/* {rest: value}, with a mapping in each mapping; value itself when nothing is left. */
static struct rad_yaml_node *nest(struct rad_yaml *y, const char *key, const char *rest,
                                  const struct rad_yaml_node *at, struct rad_yaml_node *value,
                                  bool only_pair) {
  size_t n = part_length(key, rest);
  struct rad_yaml_node *name = rad_yaml_node_new(y, at, RAD_YAML_SCALAR, rest, n);
  if (!name)
    return NULL;
  name->plain = true;
  name->next = rest[n] ? nest(y, key, rest + n + 1, at, value, false) : value;
  if (!name->next || only_pair)
    return name->next ? name : NULL;
  struct rad_yaml_node *map = rad_yaml_node_new(y, at, RAD_YAML_MAP, NULL, 0);
  if (map)
    map->first = name;
  return map;
}

static enum rad_code replace(struct rad_yaml_node **slot, struct rad_yaml_node *with,
                             struct rad_override *undo) {
  if (!with)
    return RAD_ESYSTEM;
  *undo = (struct rad_override){.slot = slot, .old = *slot};
  if (*slot)
    with->next = (*slot)->next;
  *slot = with;
  return RAD_OK;
}

static enum rad_code check_key(struct rad_yaml *y, const struct rad_yaml_node *at,
                               const char *key) {
  int parts = 1;
  for (const char *s = key; *s; s++)
    parts += *s == '.';
  size_t n = strlen(key);
  if (n == 0 || key[0] == '.' || key[n - 1] == '.' || strstr(key, ".."))
    return rad_yaml_fail(y, at, "'%.60s' is no dotted key; write SECTION.KEY", key);
  if (parts >= RAD_YAML_MAX_DEPTH)
    return rad_yaml_fail(y, at, "the key has %d parts; at most %d are allowed", parts,
                         RAD_YAML_MAX_DEPTH - 1);
  return RAD_OK;
}

enum rad_code rad_override_apply(struct rad_yaml *y, struct rad_yaml_node *root, const char *key,
                                 const struct rad_yaml_node *at, const struct rad_yaml_node *value,
                                 struct rad_override *undo) {
  *undo = (struct rad_override){NULL, NULL};
  enum rad_code code = check_key(y, at, key);
  if (code)
    return code;
  struct rad_yaml_node *copy = rad_yaml_node_new(y, value, RAD_YAML_MAP, NULL, 0);
  if (!copy)
    return RAD_ESYSTEM;
  *copy = *value; /* the siblings will be others; children are shared */
  copy->next = NULL;
  struct rad_yaml_node *here = root;
  for (const char *rest = key;;) {
    size_t n = part_length(key, rest);
    int before = rest == key ? 0 : (int)(rest - key) - 1; /* length of the part walked so far */
    struct rad_yaml_node **slot = NULL;
    if (here->kind == RAD_YAML_SCALAR)
      return rad_yaml_fail(y, at, "'%.*s' is a single value and has no '%.60s'; shorten the key",
                           before, key, rest);
    if (here->kind == RAD_YAML_MAP)
      slot = find_in_map(here, rest, &n);
    else if (!(slot = find_in_list(here, rest, n)))
      return rad_yaml_fail(y, at, "'%.*s' is a list of %d, numbered from 0; '%.*s' is not in it",
                           before, key, here->n, (int)n, rest);
    if (!slot) { /* a new key at the end of the mapping */
      slot = &here->first;
      while (*slot)
        slot = &(*slot)->next->next;
      return replace(slot, nest(y, key, rest, at, copy, true), undo);
    }
    if (!rest[n])
      return replace(slot, copy, undo);
    rest += n + 1;
    if (rad_yaml_is_nothing(*slot))
      return replace(slot, nest(y, key, rest, at, copy, false), undo);
    here = *slot;
  }
}

void rad_override_undo(const struct rad_override *undo) {
  if (undo->slot)
    *undo->slot = undo->old;
}

enum rad_code rad_override_all(struct rad_yaml *y, struct rad_yaml_node *root, int n_set) {
  enum rad_code code = RAD_OK;
  if (n_set > USHRT_MAX)
    return rad_fail(y->e, RAD_EINPUT, "%d overrides are too many; edit the deck instead", n_set);
  for (int i = 0; i < n_set && !code; i++) {
    const char *text = y->set[i], *equal = strchr(text, '=');
    struct rad_yaml_node at = {.line = 1, .column = 1, .source = (unsigned short)(i + 1)}, *value;
    if (!equal)
      return rad_yaml_fail(y, &at, "there is no '='; write --set KEY=VALUE");
    struct rad_yaml_node *key =
        rad_yaml_node_new(y, &at, RAD_YAML_SCALAR, text, (size_t)(equal - text));
    if (!key)
      return RAD_ESYSTEM;
    code = rad_yaml_parse(y, at.source, equal + 1, strlen(equal + 1), &value);
    struct rad_override undo;
    if (!code)
      code = rad_override_apply(y, root, key->text, key, value, &undo);
  }
  return code;
}

/* Plain where that is safe in any context, else in double quotes with escapes. */
static void write_scalar(FILE *f, const struct rad_yaml_node *node) {
  static const char safe[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./+-~ ";
  const char *s = node->text;
  size_t n = (size_t)node->n;
  if (node->plain && n == 0)
    s = "~", n = 1; /* nothing, visible also inside lists */
  if (node->plain && strspn(s, safe) == n && strncmp(s, "---", 3) && strncmp(s, "...", 3)) {
    fputs(s, f);
    return;
  }
  putc('"', f);
  for (size_t i = 0; i < n;) {
    unsigned c = 0;
    int length = rad_utf8_decode(s + i, n - i, &c);
    if (length == 0)
      length = 1;
    if (c < 0x20 || (c >= 0x7F && c < 0xA0) || c == 0x2028 || c == 0x2029 || c == 0xFEFF ||
        (c >= 0xFFFE && c <= 0xFFFF))
      fprintf(f, "\\u%04X", c);
    else
      fprintf(f, "%s%.*s", c == '"' || c == '\\' ? "\\" : "", length, s + i);
    i += (size_t)length;
  }
  putc('"', f);
}

static void write_node(FILE *f, const struct rad_yaml_node *node) {
  if (node->kind == RAD_YAML_SCALAR) {
    write_scalar(f, node);
    return;
  }
  bool is_map = node->kind == RAD_YAML_MAP;
  putc(is_map ? '{' : '[', f);
  for (const struct rad_yaml_node *item = node->first; item; item = item->next) {
    write_node(f, item);
    if (is_map) {
      fputs(": ", f);
      item = item->next;
      write_node(f, item);
    }
    fputs(item->next ? ", " : "", f);
  }
  putc(is_map ? '}' : ']', f);
}

char *rad_yaml_to_text(const struct rad_yaml_node *node) {
  char *text = NULL;
  size_t n;
  FILE *f = open_memstream(&text, &n);
  if (!f)
    return NULL;
  write_node(f, node);
  bool bad = ferror(f);
  if (fclose(f) || bad) {
    free(text);
    return NULL;
  }
  return text;
}
