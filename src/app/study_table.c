#include "app/study_table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/study_plan.h"
#include "base/memory.h"
#include "output/result.h"

static int is_one_problem(const struct rad_study_table *t, int i, int j) {
  for (int k = 0; k < t->n_key; k++)
    if (rad_study_is_of_problem(t->key[k]) && strcmp(t->row[i].set[k], t->row[j].set[k]) != 0)
      return 0;
  return 1;
}

/* Rows of the references: owned [n_row], or NULL without memory. Problems are numbered as they
 * appear. */
static int *find_references(const struct rad_study_table *t, int *n_problem) {
  int *reference = rad_alloc((size_t)t->n_row, sizeof *reference);
  *n_problem = 0;
  for (int i = 0; i < t->n_row && reference; i++) {
    int first = 0;
    while (!is_one_problem(t, first, i))
      first++;
    if (first == i)
      reference[i] = t->n_row + (*n_problem)++;
    else
      reference[i] = reference[first];
  }
  for (int i = t->n_row - 1; i >= 0 && reference && !t->n_reference; i--)
    if (reference[i] >= t->n_row) /* the last run of its problem: it and those before it */
      for (int j = 0, problem = reference[i]; j <= i; j++)
        reference[j] = reference[j] == problem ? i : reference[j];
  return reference;
}

/* ratio and EOC of a row against the one before, when only N changed. */
static void compare_rows(struct rad_study_table *t, int i, double n_reference) {
  struct rad_study_row *now = &t->row[i];
  now->ratio = now->eoc = NAN;
  if (i % t->n_inner == 0 || rad_study_is_of_problem(t->key[t->n_key - 1]))
    return;
  const struct rad_study_row *before = now - 1;
  if (!(now->error.largest > 0 && before->error.largest > 0))
    return;
  now->ratio = before->error.largest / now->error.largest;
  now->eoc = rad_eoc(before->run.n, now->run.n, n_reference, now->ratio);
}

/* A row against its reference; both may have failed. */
static enum rad_code compare_row(struct rad_study_table *t, int i, int reference,
                                 struct rad_error *e) {
  struct rad_study_row *row = &t->row[i];
  const struct rad_task_run *run = &row->run, *with = &t->row[reference].run;
  row->error = (struct rad_difference){NAN, NAN};
  if (run->value && with->value && run->n_value != with->n_value)
    return rad_fail(e, RAD_EINPUT,
                    "%s: error: the runs of a study that share a scene must share triangles and "
                    "bands, or their solutions cannot be compared",
                    t->path);
  if (run->value && with->value)
    row->error = rad_grid_difference(
        t->grid, (int)run->n_area, (int)(run->n_value / rad_grid_points(t->grid, (int)run->n_area)),
        run->area, run->value, with->value);
  compare_rows(t, i, t->n_reference ? INFINITY : with->n);
  return RAD_OK;
}

enum rad_code rad_study_compare(struct rad_study_table *t, struct rad_error *e) {
  int some = 0, *reference = find_references(t, &t->n_problem);
  enum rad_code code = reference ? RAD_OK : rad_fail_memory(e, "the table", 4.0 * t->n_row);
  for (int i = 0; i < t->n_row && !code; i++)
    some |= t->row[reference[i]].run.value != NULL;
  if (!code && !some)
    code = rad_fail(e, RAD_ENUMERIC, "%s: error: the reference run of the study did not converge",
                    t->path);
  for (int i = 0; i < t->n_row && !code; i++)
    code = compare_row(t, i, reference[i], e);
  free(reference);
  return code;
}

/* True if norms of the inverse are known of any run. */
static int has_norms(const struct rad_study_table *t) {
  int some = 0;
  for (int i = 0; i < t->n_row; i++)
    some |= !isnan(t->row[i].run.inverse_norm);
  return some;
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
  fprintf(out, " %9s %12s %12s %8s %6s", "unknowns", "error", "mean square", "ratio", "EOC");
  if (has_norms(t))
    fprintf(out, " %10s %10s %10s", "|inverse|", "|matrix^-1|", "radius");
  fprintf(out, " %10s %10s %10s\n", "assemble s", "solve s", "total s");
  for (int i = 0; i < t->n_row; i++) {
    const struct rad_study_row *r = &t->row[i];
    for (int k = 0; k < t->n_key; k++)
      fprintf(out, " %16s", r->set[k]);
    fprintf(out, " %9.0f", r->run.unknowns);
    print_number(out, " %12.5e", r->error.largest, 12);
    print_number(out, " %12.5e", r->error.mean_square, 12);
    print_number(out, " %8.4f", r->ratio, 8);
    print_number(out, " %6.3f", r->eoc, 6);
    if (has_norms(t)) {
      print_number(out, " %10.4g", r->run.inverse_norm, 10);
      print_number(out, " %10.4g", r->run.inverse_matrix, 11);
      print_number(out, " %10.6f", r->run.spectral_radius, 10);
    }
    fprintf(out, " %10.3f %10.3f %10.3f\n", r->run.seconds_assemble,
            r->run.seconds_factor + r->run.seconds_solve, r->run.seconds_total);
  }
  fprintf(out,
          "error: max |%s - reference| [W/m2] over %s of every sub-triangle; reference: %s%s\n",
          t->is_solution ? "u_h" : "reported u",
          t->grid == RAD_GRID_CLOSED ? "the closed 100 x 100 grid" : "24 x 24 points from 1e-6 on",
          t->n_reference ? "the named run" : "the last run",
          t->n_problem > 1 ? " of the same scene" : "");
}

/* The table's own numbers stand after the first two of the runs: unknowns and elements. */
enum { N_BEFORE = 2, N_OWN = 4, N_NUMBER = RAD_N_TASK_NUMBER + N_OWN };
static const struct rad_task_number own[N_OWN] = {
    {"error", "W/m2", "max |u_h - reference| over the comparison grid",
     offsetof(struct rad_study_row, error.largest)},
    {"error_mean_square", "W/m2", "root of the mean of |u_h - reference|^2 over the surface",
     offsetof(struct rad_study_row, error.mean_square)},
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
  size_t n_number = N_NUMBER - (has_norms(t) ? 0 : RAD_N_NORM);
  for (size_t k = 0; k < n_number && !code; k++) {
    size_t offset;
    const struct rad_task_number *c = column_of((int)k, &offset);
    for (size_t i = 0; i < n_row; i++)
      memcpy(&number[k * n_row + i], (const char *)&t->row[i] + offset, sizeof *number);
    column[n_key + k] =
        (struct rad_column){c->name, c->unit, c->description, number + k * n_row, NULL};
  }
  struct rad_table table = {t->n_row, t->n_key + (int)n_number, column};
  if (!code)
    code = rad_table_write(path, &table, t->deck, command, t->threads, e);
  free(column);
  free(text);
  free(number);
  return code;
}
