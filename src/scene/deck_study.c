/* Section `study` of the deck: what is varied, and a trial of every run so that none fails later.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/deck_read.h"

enum { MAX_VARY = 32, MAX_RUN = 10000, MAX_REPEATS = 99 };

struct trial {
  struct rad_yaml *y;
  struct rad_yaml_node *root;
  struct rad_deck *deck; /* gets the names of meshes */
  const struct rad_deck_vary *vary;
  const char *what;     /* for messages */
  int chosen[MAX_VARY]; /* number of the value of each key */
  unsigned parts;
};

static void mark_study(struct rad_yaml_node *node) {
  for (; node; node = node->next) {
    node->study = true;
    if (node->kind != RAD_YAML_SCALAR)
      mark_study(node->first);
  }
}

static enum rad_code keep_value(struct rad_yaml *y, const struct rad_yaml_node *value,
                                struct rad_deck_vary *vary) {
  vary->value[vary->n] = rad_yaml_to_text(value);
  if (!vary->value[vary->n])
    return rad_fail_memory(y->e, "the study", (double)value->n);
  vary->n++;
  return RAD_OK;
}

/* n values, or for n = 0 the node itself as the only one. */
static enum rad_code keep_vary(struct rad_yaml *y, const char *key, int n,
                               const struct rad_yaml_node *values, struct rad_deck_vary *vary) {
  vary->value = calloc((size_t)(n ? n : 1), sizeof *vary->value);
  if (!vary->value)
    return rad_fail_memory(y->e, "the study", (double)n * sizeof *vary->value);
  enum rad_code code = rad_copy_text(y, key, &vary->key);
  if (!code && n == 0)
    return keep_value(y, values, vary);
  for (const struct rad_yaml_node *item = values->first; item && !code; item = item->next)
    code = keep_value(y, item, vary);
  return code;
}

static enum rad_code read_vary(struct rad_yaml *y, const struct rad_yaml_node *node,
                               struct rad_deck_study *study) {
  if (node->kind != RAD_YAML_MAP || !node->first)
    return rad_fail_value(y, node, "vary", "a mapping, {method.elements: [1, 2, 4]}");
  study->vary = calloc(MAX_VARY, sizeof *study->vary);
  if (!study->vary)
    return rad_fail_memory(y->e, "the study", MAX_VARY * sizeof *study->vary);
  double n_run = 1;
  for (const struct rad_yaml_node *k = node->first; k; k = k->next->next) {
    const struct rad_yaml_node *values = k->next;
    if (study->n_vary == MAX_VARY)
      return rad_yaml_fail(y, k, "more than %d varied keys; leave some out", MAX_VARY);
    if (!strncmp(k->text, "study", 5) && (k->text[5] == '.' || k->text[5] == '\0'))
      return rad_yaml_fail(y, k, "a study cannot vary 'study'; vary a key of another section");
    if (strchr(k->text, '='))
      return rad_yaml_fail(y, k, "a varied key cannot hold '='; rename the surface");
    if (values->kind != RAD_YAML_LIST || values->n == 0)
      return rad_fail_value(y, values, k->text, "a list of the values to run");
    n_run *= values->n;
    if (n_run > MAX_RUN)
      return rad_yaml_fail(y, k,
                           "the study has %.0f runs or more, at most %d are allowed; shorten "
                           "the lists",
                           n_run, MAX_RUN);
    enum rad_code code = keep_vary(y, k->text, values->n, values, &study->vary[study->n_vary++]);
    if (code)
      return code;
  }
  return RAD_OK;
}

static enum rad_code read_reference(struct rad_yaml *y, const struct rad_yaml_node *node,
                                    struct rad_deck_study *study) {
  static const char *const choice[] = {"last", NULL};
  int last;
  if (node->kind == RAD_YAML_SCALAR && !rad_yaml_is_nothing(node))
    return rad_read_choice(y, node, "reference", choice, &last);
  if (node->kind != RAD_YAML_MAP || !node->first)
    return rad_fail_value(y, node, "reference",
                          "'last', method keys, {elements: 64}, or {tolerance: 1e-8}");
  study->reference = calloc(MAX_VARY, sizeof *study->reference);
  if (!study->reference)
    return rad_fail_memory(y->e, "the study", MAX_VARY * sizeof *study->reference);
  for (const struct rad_yaml_node *k = node->first; k; k = k->next->next) {
    if (study->n_reference == MAX_VARY)
      return rad_yaml_fail(y, k, "more than %d keys in 'reference'; leave some out", MAX_VARY);
    char key[80];
    const char *section = strcmp(k->text, "tolerance") ? "method" : "accuracy";
    if (snprintf(key, sizeof key, "%s.%s", section, k->text) >= (int)sizeof key)
      return rad_yaml_fail(y, k, "unknown key '%.40s...'; give keys of 'method'", k->text);
    enum rad_code code = keep_vary(y, key, 0, k->next, &study->reference[study->n_reference++]);
    if (code)
      return code;
  }
  return RAD_OK;
}

/* Interpret the tree as it stands now, `value` the last one that was put in. */
static enum rad_code run_trial(struct trial *t, int n_key, const struct rad_yaml_node *value) {
  char *note = t->y->blame_note;
  size_t size = sizeof t->y->blame_note,
         n = (size_t)snprintf(note, size, "in the %s with", t->what);
  for (int k = 0; k < n_key && n < size; k++)
    n += (size_t)snprintf(note + n, size - n, "%s %.40s=%.40s", k ? "," : "", t->vary[k].key,
                          t->vary[k].value[t->chosen[k]]);
  if (n < size)
    snprintf(note + n, size - n, ": ");
  struct rad_deck scratch = {0};
  t->y->blame = value;
  enum rad_code code = rad_deck_interpret(t->y, t->root, t->parts, &scratch);
  t->y->blame = NULL;
  if (!code)
    code = rad_deck_name_mesh(t->y, scratch.mesh_file, t->deck);
  rad_deck_free(&scratch);
  return code;
}

/* Every combination of the values of `key` and of the keys after it. */
static enum rad_code try_vary(struct trial *t, int k, const struct rad_yaml_node *key,
                              const struct rad_yaml_node *last) {
  if (!key)
    return run_trial(t, k, last);
  enum rad_code code = RAD_OK;
  t->chosen[k] = 0;
  for (const struct rad_yaml_node *v = key->next->first; v && !code; v = v->next) {
    struct rad_override undo;
    code = rad_override_apply(t->y, t->root, key->text, key, v, &undo);
    if (!code)
      code = try_vary(t, k + 1, key->next->next, v);
    rad_override_undo(&undo);
    t->chosen[k]++;
  }
  return code;
}

/* All keys of the reference run together. */
static enum rad_code try_reference(struct trial *t, int k, const struct rad_yaml_node *key,
                                   const struct rad_yaml_node *last) {
  if (!key)
    return run_trial(t, k, last);
  struct rad_override undo;
  enum rad_code code = rad_override_apply(t->y, t->root, t->vary[k].key, key, key->next, &undo);
  if (!code)
    code = try_reference(t, k + 1, key->next->next, key->next);
  rad_override_undo(&undo);
  return code;
}

static struct trial trial_of(struct rad_yaml *y, struct rad_yaml_node *root, struct rad_deck *deck,
                             const char *what, int n, const struct rad_deck_vary *vary) {
  struct trial t = {.y = y, .root = root, .deck = deck, .what = what, .vary = vary};
  for (int k = 0; k < n; k++)
    t.parts |= rad_deck_parts_of(vary[k].key);
  return t;
}

enum rad_code rad_deck_read_study(struct rad_yaml *y, struct rad_yaml_node *root,
                                  struct rad_yaml_node *node, struct rad_deck *deck) {
  enum { VARY, REFERENCE, STABILITY, VALUES, REPEATS, N };
  static const char *const values[] = {"auto", "solution", "reported", NULL};
  static const struct rad_key key[N] = {
      [VARY] = {.name = "vary"},
      [REFERENCE] = {.name = "reference"},
      [STABILITY] = {.name = "stability"},
      [VALUES] = {.name = "values",
                  .type = RAD_KEY_CHOICE,
                  .offset = offsetof(struct rad_deck_study, values),
                  .choice = values}, /* in the order of rad_study_values */
      [REPEATS] = {.name = "repeats",
                   .type = RAD_KEY_WHOLE,
                   .offset = offsetof(struct rad_deck_study, repeats),
                   .range = {1, MAX_REPEATS, false}},
  };
  struct rad_deck_study *study = &deck->study;
  const struct rad_yaml_node *seen[N];
  if (!node)
    return RAD_OK;
  study->present = true;
  study->repeats = 1;
  node->study = true;
  if (node->kind != RAD_YAML_SCALAR)
    mark_study(node->first);
  enum rad_code code = rad_read_map(y, node, "section 'study'", N, key, study, seen);
  if (!code && !seen[VARY])
    return rad_yaml_fail(y, node,
                         "the study has no 'vary'; give the keys to vary and their values");
  if (!code && seen[STABILITY])
    code = rad_read_bool(y, seen[STABILITY], "stability", &study->stability);
  if (!code)
    code = read_vary(y, seen[VARY], study);
  if (!code && seen[REFERENCE])
    code = read_reference(y, seen[REFERENCE], study);
  if (code)
    return code;
  struct trial t = trial_of(y, root, deck, "study", study->n_vary, study->vary);
  code = try_vary(&t, 0, seen[VARY]->first, NULL);
  if (code || study->n_reference == 0)
    return code;
  t = trial_of(y, root, deck, "reference run", study->n_reference, study->reference);
  return try_reference(&t, 0, seen[REFERENCE]->first, NULL);
}
