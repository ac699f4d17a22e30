#include "app/study_table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "output/result.h"

/* ratio and EOC of a row against the one before, when only N changed. */
static void compare_rows(struct rad_study_table *t, int i, double n_reference) {
  struct rad_study_row *now = &t->row[i];
  now->ratio = now->eoc = NAN;
  if (i % t->n_inner == 0)
    return;
  const struct rad_study_row *before = now - 1;
  if (!(now->error > 0 && before->error > 0))
    return;
  now->ratio = before->error / now->error;
  now->eoc = rad_eoc(before->run.n, now->run.n, n_reference, now->ratio);
}

enum rad_code rad_study_compare(struct rad_study_table *t, struct rad_error *e) {
  const struct rad_task_run *last = &t->row[t->is_named ? t->n_row : t->n_row - 1].run;
  if (!last->value)
    return rad_fail(e, RAD_ENUMERIC, "%s: error: the reference run of the study did not converge",
                    t->path);
  for (int i = 0; i < t->n_row; i++)
    if (t->row[i].run.value && t->row[i].run.n_value != last->n_value)
      return rad_fail(e, RAD_EINPUT,
                      "%s: error: the runs of a study must share triangles and bands, or their "
                      "solutions cannot be compared",
                      t->path);
  for (int i = 0; i < t->n_row; i++) {
    struct rad_study_row *row = &t->row[i];
    row->error = row->run.value ? 0 : NAN;
    for (size_t g = 0; g < row->run.n_value; g++)
      row->error = fmax(row->error, fabs(row->run.value[g] - last->value[g]));
    compare_rows(t, i, t->is_named ? INFINITY : last->n);
  }
  return RAD_OK;
}

static void print_number(FILE *out, const char *format, double x, int width) {
  if (isnan(x) || x == 0)
    fprintf(out, " %*s", width, "-");
  else
    fprintf(out, format, x);
}

void rad_study_print(const struct rad_study_table *t, FILE *out) {
  for (int k = 0; k < t->n_key; k++)
    fprintf(out, " %16s", t->key[k]);
  fprintf(out, " %9s %12s %8s %6s %10s %10s %10s\n", "unknowns", "error", "ratio", "EOC",
          "assemble s", "solve s", "total s");
  for (int i = 0; i < t->n_row; i++) {
    const struct rad_study_row *r = &t->row[i];
    for (int k = 0; k < t->n_key; k++)
      fprintf(out, " %16s", r->set[k]);
    fprintf(out, " %9.0f", r->run.unknowns);
    print_number(out, " %12.5e", r->error, 12);
    print_number(out, " %8.4f", r->ratio, 8);
    print_number(out, " %6.3f", r->eoc, 6);
    fprintf(out, " %10.3f %10.3f %10.3f\n", r->run.seconds_assemble,
            r->run.seconds_factor + r->run.seconds_solve, r->run.seconds_total);
  }
  fprintf(out, "error: max |%s - reference| [W/m2] over %s of every sub-triangle; reference: %s\n",
          t->grid == RAD_GRID_CLOSED ? "u_h" : "reported u",
          t->grid == RAD_GRID_CLOSED ? "the closed 100 x 100 grid" : "24 x 24 points from 1e-6 on",
          t->is_named ? "the named run" : "the last run");
}

/* The table's own numbers stand after the first two of the runs: unknowns and elements. */
enum { N_BEFORE = 2, N_OWN = 3, N_NUMBER = RAD_N_TASK_NUMBER + N_OWN };
static const struct rad_task_number own[N_OWN] = {
    {"error", "W/m2", "max |u_h - reference| over the comparison grid",
     offsetof(struct rad_study_row, error)},
    {"ratio", "1", "error of the row before over this one", offsetof(struct rad_study_row, ratio)},
    {"eoc", "1", "estimated order of convergence", offsetof(struct rad_study_row, eoc)}};

/* Column k, and where in a row its number is. */
static const struct rad_task_number *column_of(int k, size_t *offset) {
  if (k >= N_BEFORE && k < N_BEFORE + N_OWN) {
    *offset = own[k - N_BEFORE].offset;
    return &own[k - N_BEFORE];
  }
  const struct rad_task_number *number = &rad_task_number[k < N_BEFORE ? k : k - N_OWN];
  *offset = offsetof(struct rad_study_row, run) + number->offset;
  return number;
}

enum rad_code rad_study_write(const struct rad_study_table *t, const char *path,
                              const char *command, struct rad_error *e) {
  size_t n_key = (size_t)t->n_key, n_row = (size_t)t->n_row;
  struct rad_column *column = rad_calloc(n_key + N_NUMBER, sizeof *column);
  const char **text = rad_calloc(n_key * n_row, sizeof *text);
  double *number = rad_calloc(N_NUMBER * n_row, sizeof *number);
  enum rad_code code = RAD_OK;
  if (!column || !text || !number)
    code = rad_fail_memory(e, "the table", 8.0 * (double)((n_key + N_NUMBER) * n_row));
  for (size_t k = 0; k < n_key && !code; k++) {
    for (size_t i = 0; i < n_row; i++)
      text[k * n_row + i] = t->row[i].set[k];
    column[k] =
        (struct rad_column){t->key[k], "1", "varied key of the deck", NULL, text + k * n_row};
  }
  for (size_t k = 0; k < N_NUMBER && !code; k++) {
    size_t offset;
    const struct rad_task_number *c = column_of((int)k, &offset);
    for (size_t i = 0; i < n_row; i++)
      memcpy(&number[k * n_row + i], (const char *)&t->row[i] + offset, sizeof *number);
    column[n_key + k] =
        (struct rad_column){c->name, c->unit, c->description, number + k * n_row, NULL};
  }
  struct rad_table table = {t->n_row, t->n_key + N_NUMBER, column};
  if (!code)
    code = rad_table_write(path, &table, t->deck, command, t->threads, e);
  free(column);
  free(text);
  free(number);
  return code;
}
