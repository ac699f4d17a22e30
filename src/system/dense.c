#include "system/dense.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/simd_math.h"

/* A batch of targets on one triangle against one source patch. */
struct task {
  int triangle, first, n, patch;
};

unsigned char *rad_sees(const struct rad_scene *scene) {
  size_t n = (size_t)scene->n_triangle;
  unsigned char *sees = rad_calloc(n * n, 1);
  for (size_t i = 0; sees && i < n; i++)
    for (size_t j = 0; j < i; j++)
      sees[i * n + j] = sees[j * n + i] = !rad_block_is_zero(scene, (int)i, (int)j);
  return sees;
}

/* All tasks, or only their number when task is NULL. */
static int64_t list_tasks(const struct rad_dense *dense, struct task *task) {
  const struct rad_mesh *mesh = dense->mesh;
  int n_triangle = mesh->scene->n_triangle;
  int64_t n = 0;
  for (int i = 0; i < n_triangle; i++)
    for (int first = mesh->point_first[i]; first < mesh->point_first[i + 1]; first += RAD_BATCH)
      for (int j = 0; j < n_triangle; j++) {
        if (!dense->sees[(size_t)i * n_triangle + j])
          continue;
        int rest = mesh->point_first[i + 1] - first;
        for (int p = mesh->patch_first[j]; p < mesh->patch_first[j + 1]; p++, n++)
          if (task)
            task[n] = (struct task){i, first, rest < RAD_BATCH ? rest : RAD_BATCH, p};
      }
  return n;
}

static void run_task(struct rad_dense *dense, const struct rad_rules *rules, const struct task *t,
                     struct rad_scratch *scratch) {
  const struct rad_mesh *mesh = dense->mesh;
  struct rad_targets targets = {t->triangle, t->n, mesh->point_base + t->first,
                                (const double(*)[2])mesh->point_mu + t->first};
  rad_patch_block(mesh, rules, &targets, t->patch, dense->k + t->first, dense->n, scratch);
}

static void add_counters(struct rad_dense *dense, const struct rad_scratch *scratch) {
  dense->counters.kernel_values += scratch->counters.kernel_values;
  dense->counters.near += scratch->counters.near;
  dense->counters.far += scratch->counters.far;
}

static enum rad_code run_all(struct rad_dense *dense, const struct rad_rules *rules,
                             const struct task *task, int64_t n_task, struct rad_error *e) {
  int n_thread = omp_get_max_threads();
  struct rad_scratch *scratch = rad_calloc((size_t)n_thread, sizeof *scratch);
  if (!scratch)
    return rad_fail_memory(e, "the integrator", 0);
  enum rad_code code = RAD_OK;
  for (int t = 0; t < n_thread && !code; t++)
    code = rad_scratch_init(dense->mesh, &scratch[t], e);
  if (!code) {
#pragma omp parallel for schedule(dynamic) default(none) shared(dense, rules, task, n_task, scratch)
    for (int64_t i = 0; i < n_task; i++)
      run_task(dense, rules, &task[i], &scratch[omp_get_thread_num()]);
  }
  for (int t = 0; t < n_thread; t++) {
    add_counters(dense, &scratch[t]);
    rad_scratch_free(&scratch[t]);
  }
  free(scratch);
  return code;
}

static int64_t count_pairs(const struct rad_mesh *mesh) {
  return (int64_t)mesh->n_point * mesh->n_element;
}

enum rad_code rad_dense_assemble(const struct rad_mesh *mesh, const struct rad_rules *rules,
                                 struct rad_dense *dense, struct rad_error *e) {
  size_t n = (size_t)mesh->n_point;
  *dense = (struct rad_dense){.mesh = mesh, .n = mesh->n_point, .sees = rad_sees(mesh->scene)};
  dense->k = rad_pages_alloc(n * n * sizeof(double));
  if (!dense->k || !dense->sees)
    return rad_fail_memory(e, "the matrix", 8.0 * (double)n * (double)n);
  int64_t n_task = list_tasks(dense, NULL);
  struct task *task = rad_alloc((size_t)n_task, sizeof *task);
  if (!task)
    return rad_fail_memory(e, "the list of blocks", (double)n_task * sizeof *task);
  list_tasks(dense, task);
  enum rad_code code = run_all(dense, rules, task, n_task, e);
  free(task);
  dense->pairs_skipped = count_pairs(mesh) - dense->counters.near - dense->counters.far;
  return code;
}

void rad_dense_free(struct rad_dense *dense) {
  rad_pages_free(dense->k, (size_t)dense->n * (size_t)dense->n * sizeof(double));
  free(dense->sees);
  *dense = (struct rad_dense){0};
}

/* y += four columns times their coefficients. */
static inline void add_columns(const double *restrict k, size_t ld, int m, const double *u,
                               double *restrict y) {
  const double *k0 = k, *k1 = k + ld, *k2 = k + 2 * ld, *k3 = k + 3 * ld;
  double u0 = u[0], u1 = u[1], u2 = u[2], u3 = u[3];
#pragma omp simd
  for (int r = 0; r < m; r++)
    y[r] += (k0[r] * u0 + k1[r] * u1) + (k2[r] * u2 + k3[r] * u3);
}

/* Rows first..first+m of triangle i: y = K u over the triangles that i sees. */
static RAD_CLONES void apply_rows(const struct rad_dense *dense, int i, int first, int m,
                                  int n_vector, const double *const *u, double *const *y) {
  const struct rad_mesh *mesh = dense->mesh;
  int n_triangle = mesh->scene->n_triangle;
  size_t ld = (size_t)dense->n;
  for (int v = 0; v < n_vector; v++)
    memset(y[v] + first, 0, sizeof(double) * (size_t)m);
  for (int j = 0; j < n_triangle; j++) {
    if (!dense->sees[(size_t)i * n_triangle + j])
      continue;
    int c = mesh->point_first[j], end = mesh->point_first[j + 1];
    for (; c + 4 <= end; c += 4)
      for (int v = 0; v < n_vector; v++)
        add_columns(dense->k + ld * c + first, ld, m, u[v] + c, y[v] + first);
    for (; c < end; c++)
      for (int v = 0; v < n_vector; v++)
        for (int r = 0; r < m; r++)
          y[v][first + r] += dense->k[ld * c + first + r] * u[v][c];
  }
}

void rad_dense_apply(const struct rad_dense *dense, int n_vector, const double *const *u,
                     double *const *y) {
  enum { ROWS = 512 };
  const struct rad_mesh *mesh = dense->mesh;
  int n_triangle = mesh->scene->n_triangle;
#pragma omp parallel default(none) shared(dense, mesh, n_vector, u, y, n_triangle)
  for (int i = 0; i < n_triangle; i++) {
    int end = mesh->point_first[i + 1];
#pragma omp for schedule(dynamic) nowait
    for (int first = mesh->point_first[i]; first < end; first += ROWS)
      apply_rows(dense, i, first, end - first < ROWS ? end - first : ROWS, n_vector, u, y);
  }
}
