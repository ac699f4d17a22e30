#include "app/study_plan.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"

enum { MAX_TEXT = 1024 };

/* Points at edges have no u*. Adaptive runs take part if a tolerance is given or varied, or no run
 * has a mesh by hand. */
static enum rad_grid choose_grid(const struct rad_deck *deck) {
  const struct rad_deck_study *d = &deck->study;
  int by_hand = (deck->method.given & RAD_GIVEN_ANY_MESH) != 0;
  if (d->values != RAD_VALUES_AUTO)
    return RAD_GRID_CROWDED;
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
  p->n_reference = d->n_reference > 0;
  for (int k = 0; k < d->n_vary; k++)
    p->n_reference *= rad_study_is_of_problem(d->vary[k].key) ? d->vary[k].n : 1;
  return RAD_OK;
}

void rad_study_plan_free(struct rad_study_plan *p) {
  rad_deck_free(&p->deck);
}

char *rad_study_file(const struct rad_study_plan *p, const char *tail, const char *ending) {
  return rad_path_of(p->deck.output.file, tail, ending);
}

int rad_study_is_of_problem(const char *key) {
  return strncmp(key, "method.", 7) && strcmp(key, "method") && strncmp(key, "accuracy", 8);
}

/* The first run of a problem, problems numbered like the runs. */
static int first_of(const struct rad_deck_study *d, int problem) {
  int i = 0, stride = 1;
  for (int k = d->n_vary - 1; k >= 0; k--) {
    if (rad_study_is_of_problem(d->vary[k].key)) {
      i += problem % d->vary[k].n * stride;
      problem /= d->vary[k].n;
    }
    stride *= d->vary[k].n;
  }
  return i;
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

/* One more override, in the text at place n of the set's own; returns 0 if there is no room. */
static int add(struct rad_study_set *s, int n, const char *key, const char *value) {
  char *text = s->text + (size_t)n * MAX_TEXT;
  if (s->n == RAD_MAX_SET || snprintf(text, MAX_TEXT, "%s=%s", key, value) >= MAX_TEXT)
    return 0;
  s->set[s->n++] = text;
  return 1;
}

enum rad_code rad_study_set(const struct rad_study_plan *p, int i, struct rad_study_set *s,
                            struct rad_error *e) {
  const struct rad_deck_study *d = &p->deck.study;
  int is_reference = i >= p->n_row, like = is_reference ? first_of(d, i - p->n_row) : i;
  int n = 0, fits = 1;
  size_t most = (size_t)(d->n_vary + d->n_reference);
  *s = (struct rad_study_set){.text = rad_alloc(most, MAX_TEXT)};
  if (!s->text)
    return rad_fail_memory(e, "the study", (double)most * MAX_TEXT);
  for (; s->n < p->command->n_set; s->n++)
    s->set[s->n] = p->command->set[s->n];
  for (int k = 0; k < d->n_vary && fits; k++)
    if (!is_reference || rad_study_is_of_problem(d->vary[k].key))
      fits = add(s, n++, d->vary[k].key, rad_study_value(p, like, k));
  for (int k = 0; k < d->n_reference && is_reference && fits; k++)
    fits = add(s, n++, d->reference[k].key, d->reference[k].value[0]);
  return fits ? RAD_OK
              : rad_fail(e, RAD_EINPUT,
                         "%s: error: more than %d overrides, or a study value longer than %d "
                         "characters; give fewer --set options",
                         p->deck.path, RAD_MAX_SET, MAX_TEXT - 1);
}
