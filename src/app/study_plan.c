#include "app/study_plan.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum { MAX_TEXT = 1024 };

/* Adaptive runs take part if a tolerance is given or varied, or no run has a mesh by hand. */
static enum rad_grid choose_grid(const struct rad_deck *deck) {
  const struct rad_deck_study *d = &deck->study;
  int by_hand = (deck->method.given & RAD_GIVEN_ANY_MESH) != 0;
  for (int k = 0; k < d->n_vary; k++) {
    if (!strcmp(d->vary[k].key, "accuracy.tolerance"))
      return RAD_GRID_CROWDED;
    by_hand |= !strncmp(d->vary[k].key, "method.", 7);
  }
  return deck->tolerance > 0 || !by_hand ? RAD_GRID_CROWDED : RAD_GRID_CLOSED;
}

enum rad_code rad_study_plan(const struct rad_command *command, struct rad_study_plan *p,
                             struct rad_error *e) {
  *p = (struct rad_study_plan){.command = command, .progress = command->quiet ? NULL : &p->line};
  rad_progress_init(&p->line, command->log);
  enum rad_code code = rad_deck_read(command->deck, command->n_set, command->set, &p->deck, e);
  const struct rad_deck_study *d = &p->deck.study;
  if (code)
    return code;
  if (!d->present)
    return rad_fail(e, RAD_EINPUT,
                    "%s: error: the deck has no section `study`; add study: {vary: "
                    "{method.elements: [1, 2, 4]}} or use polyrad run",
                    command->deck);
  p->grid = choose_grid(&p->deck);
  p->n_row = 1;
  for (int k = 0; k < d->n_vary; k++)
    p->n_row *= d->vary[k].n;
  p->n_inner = d->vary[d->n_vary - 1].n;
  p->is_named = d->n_reference > 0;
  return RAD_OK;
}

void rad_study_plan_free(struct rad_study_plan *p) {
  rad_deck_free(&p->deck);
}

char *rad_study_file(const struct rad_study_plan *p, const char *tail, const char *ending) {
  const char *file = p->deck.output.file, *slash = strrchr(file, '/');
  const char *name = slash ? slash + 1 : file, *dot = strrchr(name, '.');
  size_t n_stem = dot && dot > name ? (size_t)(dot - file) : strlen(file);
  ending = ending ? ending : file + n_stem;
  size_t size = n_stem + strlen(tail) + strlen(ending) + 1;
  char *path = rad_alloc(size, 1);
  if (path)
    snprintf(path, size, "%.*s%s%s", (int)n_stem, file, tail, ending);
  return path;
}

const char *rad_study_value(const struct rad_study_plan *p, int i, int k) {
  const struct rad_deck_study *d = &p->deck.study;
  for (int j = d->n_vary - 1; j > k; j--)
    i /= d->vary[j].n;
  return d->vary[k].value[i % d->vary[k].n];
}

double rad_study_n(const struct rad_study_plan *p, int i) {
  int last = p->deck.study.n_vary - 1;
  return i < p->n_row && !strcmp(p->deck.study.vary[last].key, "method.elements")
             ? strtod(rad_study_value(p, i, last), NULL)
             : NAN;
}

enum rad_code rad_study_set(const struct rad_study_plan *p, int i, struct rad_study_set *s,
                            struct rad_error *e) {
  const struct rad_deck_study *d = &p->deck.study;
  int is_reference = i == p->n_row, n_key = is_reference ? d->n_reference : d->n_vary;
  *s = (struct rad_study_set){.text = rad_alloc((size_t)n_key, MAX_TEXT)};
  if (!s->text)
    return rad_fail_memory(e, "the study", n_key * (double)MAX_TEXT);
  for (; s->n < p->command->n_set; s->n++)
    s->set[s->n] = p->command->set[s->n];
  for (int k = 0; k < n_key; k++) {
    const char *key = is_reference ? d->reference[k].key : d->vary[k].key;
    const char *value = is_reference ? d->reference[k].value[0] : rad_study_value(p, i, k);
    char *text = s->text + (size_t)k * MAX_TEXT;
    if (s->n == RAD_MAX_SET || snprintf(text, MAX_TEXT, "%s=%s", key, value) >= MAX_TEXT)
      return rad_fail(e, RAD_EINPUT,
                      "%s: error: more than %d overrides, or a study value longer than %d "
                      "characters; give fewer --set options",
                      p->deck.path, RAD_MAX_SET, MAX_TEXT - 1);
    s->set[s->n++] = text;
  }
  return RAD_OK;
}
