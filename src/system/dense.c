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

/* Elements and points by what a reuse says of them. */
struct origins {
  const struct rad_dense *old; /* NULL: everything is new */
  unsigned char *fresh, *kept; /* owned [n_element] */
  int *from;                   /* owned [n_point] the same point in the old mesh, or -1 */
};

static enum rad_code set_origins(const struct rad_mesh *mesh, const struct rad_reuse *reuse,
                                 struct origins *o, struct rad_error *e) {
  *o = (struct origins){0};
  if (!reuse || !reuse->old)
    return RAD_OK;
  o->old = reuse->old;
  o->fresh = rad_alloc((size_t)mesh->n_element, 1);
  o->kept = rad_alloc((size_t)mesh->n_element, 1);
  o->from = rad_alloc((size_t)mesh->n_point, sizeof(int));
  if (!o->fresh || !o->kept || !o->from)
    return rad_fail_memory(e, "the list of kept blocks", 4.0 * mesh->n_point);
  for (int i = 0; i < mesh->n_element; i++) {
    const struct rad_element *el = &mesh->element[i];
    int origin = reuse->origin[i];
    o->fresh[i] = origin < 0;
    o->kept[i] = origin >= 0;
    for (int b = 0; b < el->n_function; b++)
      o->from[el->first + b] = origin < 0 ? -1 : o->old->mesh->element[origin].first + b;
  }
  return RAD_OK;
}

static void free_origins(struct origins *o) {
  free(o->fresh);
  free(o->kept);
  free(o->from);
}

/* All tasks, or only their number when task is NULL. */
static int64_t list_tasks(const struct rad_dense *dense, const unsigned char *passive,
                          struct task *task) {
  const struct rad_mesh *mesh = dense->mesh;
  int n_triangle = mesh->scene->n_triangle;
  int64_t n = 0;
  for (int i = 0; i < n_triangle; i++)
    for (int first = mesh->point_first[i]; first < mesh->point_first[i + 1]; first += RAD_BATCH)
      for (int j = 0; j < n_triangle; j++) {
        if (!dense->sees[(size_t)i * n_triangle + j] || (passive && passive[i]))
          continue;
        int rest = mesh->point_first[i + 1] - first;
        for (int p = mesh->patch_first[j]; p < mesh->patch_first[j + 1]; p++, n++)
          if (task)
            task[n] = (struct task){i, first, rest < RAD_BATCH ? rest : RAD_BATCH, p};
      }
  return n;
}

/* Entries of kept points and kept elements, from the old matrix. */
static void copy_kept(struct rad_dense *dense, const struct task *t, const struct origins *o) {
  const struct rad_mesh *mesh = dense->mesh;
  size_t n = (size_t)dense->n, n_old = (size_t)o->old->n;
  for (int e = mesh->element_first[t->patch]; e < mesh->element_first[t->patch + 1]; e++) {
    const struct rad_element *el = &mesh->element[e];
    for (int c = el->first; o->kept[e] && c < el->first + el->n_function; c++)
      for (int r = t->first; r < t->first + t->n; r++)
        if (o->from[r] >= 0)
          dense->k[(size_t)r + n * (size_t)c] =
              o->old->k[(size_t)o->from[r] + n_old * (size_t)o->from[c]];
  }
}

static void run_task(struct rad_dense *dense, const struct rad_rules *rules, const struct task *t,
                     const struct origins *o, struct rad_scratch *scratch) {
  const struct rad_mesh *mesh = dense->mesh;
  struct rad_targets all = {t->triangle, t->n, mesh->point_base + t->first,
                            (const double(*)[2])mesh->point_mu + t->first, NULL};
  double *k = dense->k + t->first;
  rad_patch_block(mesh, rules, &all, t->patch, o->fresh, k, dense->n, scratch);
  if (!o->old)
    return;
  int base[RAD_BATCH], row[RAD_BATCH], n = 0;
  double mu[RAD_BATCH][2];
  for (int i = 0; i < t->n; i++)
    if (o->from[t->first + i] < 0) {
      base[n] = all.base[i];
      memcpy(mu[n], all.mu[i], sizeof mu[n]);
      row[n++] = i;
    }
  struct rad_targets rest = {t->triangle, n, base, (const double(*)[2])mu, row};
  if (n)
    rad_patch_block(mesh, rules, &rest, t->patch, o->kept, k, dense->n, scratch);
  copy_kept(dense, t, o);
}

static void add_counters(struct rad_dense *dense, const struct rad_scratch *scratch) {
  dense->counters.kernel_values += scratch->counters.kernel_values;
  dense->counters.near += scratch->counters.near;
  dense->counters.far += scratch->counters.far;
}

static enum rad_code run_all(struct rad_dense *dense, const struct rad_rules *rules,
                             const struct origins *o, const struct task *task, int64_t n_task,
                             struct rad_error *e) {
  int n_thread = omp_get_max_threads();
  struct rad_scratch *scratch = rad_calloc((size_t)n_thread, sizeof *scratch);
  if (!scratch)
    return rad_fail_memory(e, "the integrator", 0);
  enum rad_code code = RAD_OK;
  for (int t = 0; t < n_thread && !code; t++)
    code = rad_scratch_init(dense->mesh, &scratch[t], e);
  if (!code) {
#pragma omp parallel for schedule(dynamic) default(none)                                           \
    shared(dense, rules, o, task, n_task, scratch)
    for (int64_t i = 0; i < n_task; i++)
      run_task(dense, rules, &task[i], o, &scratch[omp_get_thread_num()]);
  }
  for (int t = 0; t < n_thread; t++) {
    add_counters(dense, &scratch[t]);
    rad_scratch_free(&scratch[t]);
  }
  free(scratch);
  return code;
}

/* Pairs of points and elements whose rows or blocks are not needed. */
static int64_t count_skipped(const struct rad_dense *dense, const unsigned char *passive) {
  const struct rad_mesh *m = dense->mesh;
  int n = m->scene->n_triangle;
  int64_t skipped = 0;
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++)
      if (!dense->sees[(size_t)i * n + j] || (passive && passive[i]))
        skipped += (int64_t)(m->point_first[i + 1] - m->point_first[i]) *
                   (m->element_first[m->patch_first[j + 1]] - m->element_first[m->patch_first[j]]);
  return skipped;
}

enum rad_code rad_dense_assemble(const struct rad_mesh *mesh, const struct rad_rules *rules,
                                 const struct rad_reuse *reuse, struct rad_dense *dense,
                                 struct rad_error *e) {
  size_t n = (size_t)mesh->n_point;
  const unsigned char *passive = reuse ? reuse->passive : NULL;
  *dense = (struct rad_dense){.mesh = mesh, .n = mesh->n_point, .sees = rad_sees(mesh->scene)};
  dense->k = rad_pages_alloc(n * n * sizeof(double));
  if (!dense->k || !dense->sees)
    return rad_fail_memory(e, "the matrix", 8.0 * (double)n * (double)n);
  struct origins origins;
  enum rad_code code = set_origins(mesh, reuse, &origins, e);
  int64_t n_task = list_tasks(dense, passive, NULL);
  struct task *task = rad_alloc((size_t)n_task, sizeof *task);
  if (!code && !task)
    code = rad_fail_memory(e, "the list of blocks", (double)n_task * sizeof *task);
  if (!code) {
    list_tasks(dense, passive, task);
    code = run_all(dense, rules, &origins, task, n_task, e);
  }
  free(task);
  free_origins(&origins);
  dense->pairs_skipped = count_skipped(dense, passive);
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
