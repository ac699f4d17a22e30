#include "output/task.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "output/stamp.h"

const struct rad_task_number rad_task_number[RAD_N_TASK_NUMBER] = {
    {"unknowns", "1", "number of unknowns", offsetof(struct rad_task_run, unknowns)},
    {"elements", "1", "number of elements", offsetof(struct rad_task_run, elements)},
    {"residual", "W/m2", "max norm of the residual", offsetof(struct rad_task_run, residual)},
    {"matrix_bytes", "byte", "size of the matrix", offsetof(struct rad_task_run, matrix_bytes)},
    {"seconds_assemble", "s", "time to assemble", offsetof(struct rad_task_run, seconds_assemble)},
    {"seconds_factor", "s", "time of dgetrf", offsetof(struct rad_task_run, seconds_factor)},
    {"seconds_solve", "s", "time to solve without dgetrf",
     offsetof(struct rad_task_run, seconds_solve)},
    {"seconds_total", "s", "time from deck to solution",
     offsetof(struct rad_task_run, seconds_total)},
    {"error_bound", "W/m2", "bound of the error, of adaptive runs",
     offsetof(struct rad_task_run, error_bound)},
    {"kappa", "1", "max rho K1 at the collocation points", offsetof(struct rad_task_run, kappa)},
    {"inverse_w", "1", "max |w| of (5.2): about the norm of the inverse operator",
     offsetof(struct rad_task_run, inverse_w)},
    {"inverse_norm", "1", "norm of E at the points -> u_h, in the max norm",
     offsetof(struct rad_task_run, inverse_norm)},
    {"inverse_matrix", "1", "max norm of the inverse of I - D K",
     offsetof(struct rad_task_run, inverse_matrix)},
    {"condition", "1", "condition of I - D K in the max norm",
     offsetof(struct rad_task_run, condition)},
    {"spectral_radius", "1", "of D K", offsetof(struct rad_task_run, spectral_radius)}};

static double *number_of(struct rad_task_run *run, int k) {
  return (double *)((char *)run + rad_task_number[k].offset);
}

void rad_task_run_free(struct rad_task_run *run) {
  free(run->area);
  free(run->value);
  run->area = run->value = NULL;
  run->n_area = run->n_value = 0;
}

void rad_task_free(struct rad_task *t) {
  rad_hdf_texts_free(t->key, t->n_key);
  rad_hdf_texts_free(t->set, t->n_key);
  free(t->grid);
  free(t->overrides);
  free(t->table);
  rad_task_run_free(&t->run);
  *t = (struct rad_task){0};
}

void rad_task_put(struct rad_hdf *h, hid_t root, const struct rad_task *t) {
  struct rad_task_run run = t->run;
  const hid_t group = rad_hdf_group(h, root, "task");
  rad_hdf_set_integer(h, group, "number", t->number);
  rad_hdf_set_integer(h, group, "tasks", t->n_task);
  rad_hdf_set_integer(h, group, "rows", t->n_row);
  rad_hdf_set_integer(h, group, "inner", t->n_inner);
  rad_hdf_set_text(h, group, "grid", t->grid);
  rad_hdf_set_text(h, group, "overrides", t->overrides);
  rad_hdf_set_text(h, group, "table", t->table);
  rad_hdf_set_real(h, group, "n", run.n);
  for (int k = 0; k < RAD_N_TASK_NUMBER; k++)
    rad_hdf_set_real(h, group, rad_task_number[k].name, *number_of(&run, k));
  rad_hdf_texts(h, group, "key", (size_t)t->n_key, (const char *const *)t->key, "varied key");
  rad_hdf_texts(h, group, "set", (size_t)t->n_key, (const char *const *)t->set,
                "value of this run");
  if (run.value)
    rad_hdf_array(h, group,
                  &(struct rad_hdf_array){
                      "area", "m2", "of the triangles", RAD_HDF_REAL, 1, {run.n_area}, run.area});
  if (run.value)
    rad_hdf_array(h, group,
                  &(struct rad_hdf_array){"value",
                                          "W/m2",
                                          "solution at the points where runs are compared",
                                          RAD_HDF_REAL,
                                          1,
                                          {run.n_value},
                                          run.value});
  rad_hdf_group_close(h, group);
}

enum rad_code rad_task_write(const char *path, const struct rad_task *task,
                             const struct rad_deck *deck, const char *command, int threads,
                             struct rad_error *e) {
  struct rad_hdf h;
  rad_hdf_begin(&h);
  const hid_t root = rad_stamp(&h, deck, command, threads, rad_stamp_now());
  rad_task_put(&h, root, task);
  rad_hdf_group_close(&h, root);
  return rad_hdf_end(&h, path, e);
}

/* A whole number from 1 to 10000, or 0. */
static int read_count(hid_t at, const char *name) {
  const double value = rad_hdf_get_number(at, name);
  return value >= 1 && value <= 10000 ? (int)value : 0;
}

static void read_run(hid_t at, struct rad_task_run *run) {
  hsize_t shape[RAD_HDF_MAX_RANK];
  run->n = rad_hdf_get_number(at, "n");
  for (int k = 0; k < RAD_N_TASK_NUMBER; k++)
    *number_of(run, k) = rad_hdf_get_number(at, rad_task_number[k].name);
  run->value = rad_hdf_read_numbers(at, "value", shape);
  run->n_value = run->value ? (size_t)(shape[0] * shape[1] * shape[2]) : 0;
  run->area = rad_hdf_read_numbers(at, "area", shape);
  run->n_area = run->area ? (size_t)shape[0] : 0;
}

/* Whether all was there, and fits. */
static bool read_task(hid_t at, struct rad_task *t) {
  int n_set = 0;
  t->number = read_count(at, "number");
  t->n_task = read_count(at, "tasks");
  t->n_row = read_count(at, "rows");
  t->n_inner = read_count(at, "inner");
  t->grid = rad_hdf_get_text(at, "grid");
  t->overrides = rad_hdf_get_text(at, "overrides");
  t->table = rad_hdf_get_text(at, "table");
  t->key = rad_hdf_read_texts(at, "key", &t->n_key);
  t->set = rad_hdf_read_texts(at, "set", &n_set);
  read_run(at, &t->run);
  if (n_set != t->n_key) {
    rad_hdf_texts_free(t->set, n_set);
    t->set = NULL;
  }
  return t->key && t->set && t->grid && t->overrides && t->table && t->n_inner > 0 &&
         t->number > 0 && t->number <= t->n_task && t->n_row > 0 &&
         t->n_task - t->n_row <= t->n_row && (!t->run.value || t->run.area) &&
         t->n_row <= t->n_task && t->n_row % t->n_inner == 0;
}

static bool read_deck(hid_t root, struct rad_deck *deck) {
  int n = 0;
  char **band = rad_hdf_get_texts(root, "bands", &n);
  deck->title = rad_hdf_get_text(root, "title");
  deck->text = rad_hdf_get_text(root, "deck");
  const bool fits = band && n >= 1 && n <= RAD_MAX_BAND;
  if (fits) {
    deck->n_band = n;
    memcpy(deck->band, band, (size_t)n * sizeof *band); /* the texts are the deck's from here on */
    free(band);
  } else {
    rad_hdf_texts_free(band, n);
  }
  return fits && deck->title && deck->text;
}

static enum rad_code read_root(const char *path, hid_t root, struct rad_task *task,
                               struct rad_deck *deck, int *threads, struct rad_error *e) {
  const hid_t at = rad_hdf_has(root, "task") ? H5Gopen2(root, "task", H5P_DEFAULT) : -1;
  if (at < 0)
    return rad_fail(e, RAD_ESYSTEM,
                    "%s holds no task of a study; name files that polyrad study --task wrote",
                    path);
  *threads = read_count(root, "threads");
  const bool is_whole = read_task(at, task) && read_deck(root, deck);
  H5Gclose(at);
  return is_whole
             ? RAD_OK
             : rad_fail(e, RAD_ESYSTEM,
                        "%s is damaged: its task of a study cannot be read; run it again", path);
}

enum rad_code rad_task_read(const char *path, struct rad_task *task, struct rad_deck *deck,
                            int *threads, struct rad_error *e) {
  struct rad_hdf_silence silence;
  hid_t file, root;
  *task = (struct rad_task){0};
  *deck = (struct rad_deck){0};
  rad_hdf_silence_begin(&silence);
  enum rad_code code = rad_hdf_open(path, &file, &root, e);
  if (!code) {
    code = read_root(path, root, task, deck, threads, e);
    rad_hdf_close(file, root);
  }
  rad_hdf_silence_end(&silence);
  return code;
}
