/* polyrad study: one deck run over a product of keys, compared with a reference. */
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include <stddef.h>

#include "app/case.h"
#include "app/command.h"
#include "app/grid.h"
#include "base/clock.h"
#include "base/memory.h"

enum { MAX_TEXT = 1024 };

/* One row of the table. */
struct row {
  double n;     /* value of the last varied key if it is method.elements, else NAN */
  double *grid; /* owned [n_grid]: u_h on the comparison grid; NULL if the run failed */
  size_t n_grid;
  double unknowns, elements, error, ratio, eoc, residual, bytes;
  double seconds_assemble, seconds_factor, seconds_solve, seconds_total;
};

struct study {
  const struct rad_command *command;
  struct rad_deck deck;
  int n_row;
  struct row *row; /* owned [n_row + 1]; the last is a named reference */
  int threads;
  enum rad_grid grid;
  struct rad_progress *progress; /* NULL: quiet */
};

/* Index of key v's value in run i; the first key varies slowest. */
static int value_index(const struct rad_deck_study *s, int i, int v) {
  for (int k = s->n_vary - 1; k > v; k--)
    i /= s->vary[k].n;
  return i % s->vary[v].n;
}

/* Overrides of run i (or of the reference), after those of the command line. */
static int overrides(const struct study *s, int i, char (*text)[MAX_TEXT], const char **set) {
  const struct rad_deck_study *d = &s->deck.study;
  int n = 0, reference = i == s->n_row;
  for (; n < s->command->n_set; n++)
    set[n] = s->command->set[n];
  int n_key = reference ? d->n_reference : d->n_vary;
  for (int k = 0; k < n_key; k++) {
    const struct rad_deck_vary *v = reference ? &d->reference[k] : &d->vary[k];
    const char *value = v->value[reference ? 0 : value_index(d, i, k)];
    if (n == RAD_MAX_SET || snprintf(text[k], MAX_TEXT, "%s=%s", v->key, value) >= MAX_TEXT)
      return -1;
    set[n++] = text[k];
  }
  return n;
}

static enum rad_code run_row(struct study *s, int i, struct rad_error *e) {
  struct row *row = &s->row[i];
  char(*text)[MAX_TEXT] = rad_alloc(RAD_MAX_SET, MAX_TEXT);
  const char *set[RAD_MAX_SET];
  struct rad_case c = {0};
  double start = rad_seconds();
  if (!text)
    return rad_fail_memory(e, "the study", RAD_MAX_SET * (double)MAX_TEXT);
  int n_set = overrides(s, i, text, set);
  enum rad_code code =
      n_set >= 0 ? rad_case_prepare(s->deck.path, n_set, set, s->progress, &c, e)
                 : rad_fail(e, RAD_EINPUT,
                            "%s: error: more than %d overrides, or a study value longer than %d "
                            "characters; give fewer --set options",
                            s->deck.path, RAD_MAX_SET, MAX_TEXT - 1);
  rad_progress_clear(s->progress);
  for (int n = 0; n < c.notes.n && i == 0; n++)
    fprintf(s->command->log, "%s\n", c.notes.text[n]);
  c.wants_bound = c.is_adaptive;
  if (!code)
    code = rad_case_solve(&c, e);
  if (!code) {
    row->seconds_total = rad_seconds() - start;
    row->unknowns = c.mesh->n_point;
    row->elements = c.mesh->n_element;
    row->residual = c.report.residual;
    row->bytes = c.plan.matrix_bytes;
    row->seconds_assemble = c.seconds_assemble;
    row->seconds_factor = c.report.seconds_factor;
    row->seconds_solve = c.report.seconds_solve;
    row->n_grid = rad_grid_size(&c.scene, s->grid);
    row->grid = rad_alloc(row->n_grid, sizeof(double));
    if (row->grid)
      code = rad_grid_evaluate(&c, s->grid, row->grid, e);
    else
      code = rad_fail_memory(e, "the comparison grid", 8.0 * (double)row->n_grid);
  }
  rad_case_free(&c);
  free(text);
  return code;
}

/* ratio and EOC of a row against the one before, when only N changed. */
static void compare(struct study *s, int i, double n_reference) {
  struct row *now = &s->row[i];
  now->ratio = now->eoc = NAN;
  int inner = s->deck.study.n_vary ? s->deck.study.vary[s->deck.study.n_vary - 1].n : 1;
  if (i % inner == 0)
    return;
  const struct row *before = now - 1;
  if (!(now->error > 0 && before->error > 0))
    return;
  now->ratio = before->error / now->error;
  now->eoc = rad_eoc(before->n, now->n, n_reference, now->ratio);
}

static enum rad_code evaluate(struct study *s, struct rad_error *e) {
  int named = s->deck.study.n_reference > 0, last = named ? s->n_row : s->n_row - 1;
  for (int i = 0; i < s->n_row; i++)
    if (!s->row[last].grid || (s->row[i].grid && s->row[i].n_grid != s->row[last].n_grid))
      return rad_fail(e, s->row[last].grid ? RAD_EINPUT : RAD_ENUMERIC,
                      s->row[last].grid
                          ? "%s: error: the runs of a study must share triangles and bands, or "
                            "their solutions cannot be compared"
                          : "%s: error: the reference run of the study did not converge",
                      s->deck.path);
  for (int i = 0; i < s->n_row; i++) {
    struct row *row = &s->row[i];
    row->error = row->grid ? 0 : NAN;
    for (size_t g = 0; row->grid && g < row->n_grid; g++)
      row->error = fmax(row->error, fabs(row->grid[g] - s->row[last].grid[g]));
    compare(s, i, named ? INFINITY : s->row[last].n);
  }
  return RAD_OK;
}

static void print_number(FILE *out, const char *format, double x, int width) {
  if (isnan(x) || x == 0)
    fprintf(out, " %*s", width, "-");
  else
    fprintf(out, format, x);
}

static void print_table(const struct study *s, FILE *out) {
  const struct rad_deck_study *d = &s->deck.study;
  for (int v = 0; v < d->n_vary; v++)
    fprintf(out, " %16s", d->vary[v].key);
  fprintf(out, " %9s %12s %8s %6s %10s %10s %10s\n", "unknowns", "error", "ratio", "EOC",
          "assemble s", "solve s", "total s");
  for (int i = 0; i < s->n_row; i++) {
    const struct row *r = &s->row[i];
    for (int v = 0; v < d->n_vary; v++)
      fprintf(out, " %16s", d->vary[v].value[value_index(d, i, v)]);
    fprintf(out, " %9.0f", r->unknowns);
    print_number(out, " %12.5e", r->error, 12);
    print_number(out, " %8.4f", r->ratio, 8);
    print_number(out, " %6.3f", r->eoc, 6);
    fprintf(out, " %10.3f %10.3f %10.3f\n", r->seconds_assemble,
            r->seconds_factor + r->seconds_solve, r->seconds_total);
  }
  fprintf(out, "error: max |%s - reference| [W/m2] over %s of every sub-triangle; reference: %s\n",
          s->grid == RAD_GRID_CLOSED ? "u_h" : "reported u",
          s->grid == RAD_GRID_CLOSED ? "the closed 100 x 100 grid" : "24 x 24 points from 1e-6 on",
          d->n_reference ? "the named run" : "the last run");
}

/* One numeric column, gathered from the rows. */
static double *gather(const struct study *s, size_t offset) {
  double *x = rad_alloc((size_t)s->n_row, sizeof(double));
  for (int i = 0; x && i < s->n_row; i++)
    memcpy(&x[i], (const char *)&s->row[i] + offset, sizeof(double));
  return x;
}

static const struct {
  const char *name, *unit, *description;
  size_t offset;
} columns[] = {
    {"unknowns", "1", "number of unknowns", offsetof(struct row, unknowns)},
    {"elements", "1", "number of elements", offsetof(struct row, elements)},
    {"error", "W/m2", "max |u_h - reference| over the comparison grid",
     offsetof(struct row, error)},
    {"ratio", "1", "error of the row before over this one", offsetof(struct row, ratio)},
    {"eoc", "1", "estimated order of convergence", offsetof(struct row, eoc)},
    {"residual", "W/m2", "max norm of the residual", offsetof(struct row, residual)},
    {"matrix_bytes", "byte", "size of the matrix", offsetof(struct row, bytes)},
    {"seconds_assemble", "s", "time to assemble", offsetof(struct row, seconds_assemble)},
    {"seconds_factor", "s", "time of dgetrf", offsetof(struct row, seconds_factor)},
    {"seconds_solve", "s", "time to solve without dgetrf", offsetof(struct row, seconds_solve)},
    {"seconds_total", "s", "time from deck to solution", offsetof(struct row, seconds_total)}};

enum { N_NUMBER = sizeof columns / sizeof *columns };

static enum rad_code write(const struct study *s, struct rad_error *e) {
  const struct rad_deck_study *d = &s->deck.study;
  struct rad_column *column = rad_calloc((size_t)d->n_vary + N_NUMBER, sizeof *column);
  const char **text = rad_calloc((size_t)(d->n_vary * s->n_row), sizeof *text);
  double *number[N_NUMBER] = {0};
  enum rad_code code = column && text ? RAD_OK : rad_fail_memory(e, "the table", 0);
  for (int v = 0; v < d->n_vary && !code; v++) {
    for (int i = 0; i < s->n_row; i++)
      text[v * s->n_row + i] = d->vary[v].value[value_index(d, i, v)];
    column[v] = (struct rad_column){d->vary[v].key, "1", "varied key of the deck", NULL,
                                    text + v * s->n_row};
  }
  for (int k = 0; k < N_NUMBER && !code; k++) {
    if (!(number[k] = gather(s, columns[k].offset)))
      code = rad_fail_memory(e, "the table", 8.0 * s->n_row);
    column[d->n_vary + k] = (struct rad_column){columns[k].name, columns[k].unit,
                                                columns[k].description, number[k], NULL};
  }
  char path[4096];
  const char *file = s->deck.output.file, *slash = strrchr(file, '/');
  const char *name = slash ? slash + 1 : file, *dot = strrchr(name, '.');
  snprintf(path, sizeof path, "%.*s_study.h5",
           (int)(dot && dot > name ? dot - file : (long)strlen(file)), file);
  const char *target = s->command->output ? s->command->output : path;
  struct rad_table table = {s->n_row, d->n_vary + N_NUMBER, column};
  if (!code)
    code = rad_table_write(target, &table, &s->deck, s->command->line, s->threads, e);
  if (!code && !s->command->quiet)
    fprintf(s->command->out, "written %s\n", target);
  for (int k = 0; k < N_NUMBER; k++)
    free(number[k]);
  free(column);
  free(text);
  return code;
}

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

static enum rad_code run_all(struct study *s, struct rad_error *e) {
  const struct rad_deck_study *d = &s->deck.study;
  s->grid = choose_grid(&s->deck);
  s->n_row = 1;
  for (int v = 0; v < d->n_vary; v++)
    s->n_row *= d->vary[v].n;
  s->row = rad_calloc((size_t)s->n_row + 1, sizeof *s->row);
  if (!s->row)
    return rad_fail_memory(e, "the study", 0);
  int n = s->n_row + (d->n_reference > 0);
  for (int i = 0; i < n; i++) {
    rad_progress_run(s->progress, i + 1, n);
    enum rad_code code = run_row(s, i, e);
    rad_progress_clear(s->progress);
    if (code == RAD_ENUMERIC) /* one run that fails does not lose the others */
      fprintf(s->command->log, "study, run %d: %s\n", i + 1, e->text);
    else if (code)
      return code;
    const struct rad_deck_vary *last = &d->vary[d->n_vary - 1];
    s->row[i].n = i < s->n_row && !strcmp(last->key, "method.elements")
                      ? strtod(last->value[value_index(d, i, d->n_vary - 1)], NULL)
                      : NAN;
  }
  return RAD_OK;
}

enum rad_code rad_app_study(const struct rad_command *command, struct rad_error *e) {
  struct rad_progress line;
  struct study s = {.command = command,
                    .threads = omp_get_max_threads(),
                    .progress = command->quiet ? NULL : &line};
  rad_progress_init(&line, command->log);
  enum rad_code code = rad_deck_read(command->deck, command->n_set, command->set, &s.deck, e);
  if (!code && !s.deck.study.present)
    code =
        rad_fail(e, RAD_EINPUT,
                 "%s: error: the deck has no section `study`; add study: {vary: {method.elements: "
                 "[1, 2, 4]}} or use polyrad run",
                 command->deck);
  if (!code)
    code = run_all(&s, e);
  if (!code)
    code = evaluate(&s, e);
  if (!code) {
    if (!command->quiet)
      print_table(&s, command->out);
    code = write(&s, e);
  }
  for (int i = 0; s.row && i <= s.n_row; i++)
    free(s.row[i].grid);
  free(s.row);
  rad_deck_free(&s.deck);
  return code;
}
