#include "system/dense.h"

#include <assert.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/simd_math.h"
#include "integrate/task.h"
#include "system/facets.h"
#include "visibility/visibility.h"

enum { GROUP = 512 }; /* rows of a product at once; 4 kB of a column */

/* A batch of targets on one triangle against one source patch. */
struct task {
  int triangle, first, n, patch;
};

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

/* The blocks of any mesh, with what an old matrix has of them. */
static enum rad_code run_blocks(struct rad_dense *dense, const struct rad_rules *rules,
                                const struct rad_reuse *reuse, struct rad_scratch *scratch,
                                struct rad_error *e) {
  const unsigned char *passive = reuse ? reuse->passive : NULL;
  struct origins o;
  enum rad_code code = set_origins(dense->mesh, reuse, &o, e);
  int64_t n_task = dense->n_task;
  struct task *task = rad_alloc((size_t)n_task, sizeof *task);
  if (!code && !task)
    code = rad_fail_memory(e, "the list of blocks", (double)n_task * sizeof *task);
  if (!code) {
    list_tasks(dense, passive, task);
    struct rad_progress *progress = dense->mesh->scene->progress;
    rad_progress_begin(progress, "blocks", n_task);
#pragma omp parallel for schedule(dynamic) default(none)                                           \
    shared(dense, rules, o, task, n_task, scratch, progress)
    for (int64_t i = 0; i < n_task; i++) {
      struct rad_scratch *own = &scratch[omp_get_thread_num()];
      const struct rad_counters before = own->counters;
      if (rad_task_begin(dense->done, (size_t)i)) {
        run_task(dense, rules, &task[i], &o, own);
        rad_task_end(dense->done, (size_t)i, &before, own);
      }
      rad_progress_add(progress, 1);
    }
  }
  free(task);
  free_origins(&o);
  return code;
}

static int is_facets(const struct rad_mesh *mesh, const struct rad_reuse *reuse) {
  return !reuse && rad_mesh_is_facets(mesh);
}

enum rad_code rad_dense_finish(const struct rad_rules *rules, const struct rad_reuse *reuse,
                               struct rad_dense *dense, struct rad_error *e) {
  int n_thread = omp_get_max_threads();
  struct rad_scratch *scratch = rad_calloc((size_t)n_thread, sizeof *scratch);
  if (!scratch)
    return rad_fail_memory(e, "the integrator", 0);
  enum rad_code code = RAD_OK;
  for (int t = 0; t < n_thread && !code; t++)
    code = rad_scratch_init(dense->mesh, &scratch[t], e);
  if (!code && is_facets(dense->mesh, reuse))
    code = rad_facets_assemble(dense->mesh, rules, dense->sees, dense->k, dense->done, scratch, e);
  else if (!code)
    code = run_blocks(dense, rules, reuse, scratch, e);
  for (int t = 0; t < n_thread; t++) {
    if (!code && scratch[t].shade.failed)
      code = rad_fail_memory(e, "the shadows", 0);
    add_counters(dense, &scratch[t]);
    rad_scratch_free(&scratch[t]);
  }
  free(scratch);
  if (!code && memchr(dense->done, 0, (size_t)dense->n_task))
    code = rad_fail_stopped(e);
  return code;
}

/* Pairs of points and elements whose rows or blocks are not needed. */
int64_t rad_pairs_skipped(const struct rad_mesh *m, const unsigned char *passive) {
  int n = m->scene->n_triangle;
  int64_t skipped = 0;
  for (int i = 0; i < n; i++) {
    const unsigned char *sees = m->scene->visibility->sight + (size_t)i * n;
    int64_t elements = 0;
    for (int j = 0; j < n; j++)
      if (!sees[j] || (passive && passive[i]))
        elements += m->element_first[m->patch_first[j + 1]] - m->element_first[m->patch_first[j]];
    skipped += elements * (m->point_first[i + 1] - m->point_first[i]);
  }
  return skipped;
}

/* Whole small triangles, or parts of large ones, of at most GROUP rows that products take at once.
 * With lists NULL only their number. */
static int list_groups(const struct rad_mesh *mesh, struct rad_row_group *group) {
  const int *first = mesh->point_first;
  int n = 0;
  for (int t = 0, end; t < mesh->scene->n_triangle; t = end) {
    end = t + 1;
    while (end < mesh->scene->n_triangle && first[end + 1] - first[t] <= GROUP)
      end++;
    for (int row = first[t]; row < first[end]; row += GROUP, n++)
      if (group)
        group[n] = (struct rad_row_group){
            t, end, row, first[end] - row < GROUP ? first[end] - row : GROUP, NULL};
  }
  return n;
}

/* Which triangles the rows of each group see. */
static enum rad_code set_groups(struct rad_dense *dense, struct rad_error *e) {
  size_t n_triangle = (size_t)dense->mesh->scene->n_triangle;
  dense->n_group = list_groups(dense->mesh, NULL);
  dense->group = rad_alloc((size_t)dense->n_group, sizeof *dense->group);
  dense->group_sees = rad_calloc((size_t)dense->n_group * n_triangle, 1);
  if (!dense->group || !dense->group_sees)
    return rad_fail_memory(e, "the groups of rows", (double)dense->n_group * (double)n_triangle);
  list_groups(dense->mesh, dense->group);
  for (int g = 0; g < dense->n_group; g++) {
    struct rad_row_group *group = &dense->group[g];
    unsigned char *sees = dense->group_sees + n_triangle * (size_t)g;
    for (int t = group->triangle; t < group->triangle_end; t++)
      for (size_t j = 0; j < n_triangle; j++)
        sees[j] |= dense->sees[n_triangle * (size_t)t + j] != 0;
    group->sees = sees;
  }
  return RAD_OK;
}

enum rad_code rad_dense_begin(const struct rad_mesh *mesh, const struct rad_reuse *reuse,
                              struct rad_dense *dense, struct rad_error *e) {
  size_t n = (size_t)mesh->n_point;
  assert(mesh->scene->visibility);
  *dense =
      (struct rad_dense){.mesh = mesh, .n = mesh->n_point, .sees = mesh->scene->visibility->sight};
  dense->k = rad_pages_alloc(n * n * sizeof(double));
  if (!dense->k)
    return rad_fail_memory(e, "the matrix", 8.0 * (double)n * (double)n);
  const unsigned char *passive = reuse ? reuse->passive : NULL;
  dense->pairs_skipped = rad_pairs_skipped(mesh, passive);
  dense->n_task =
      is_facets(mesh, reuse) ? rad_facets_tasks(mesh) : list_tasks(dense, passive, NULL);
  dense->done = rad_calloc((size_t)dense->n_task, 1);
  if (!dense->done)
    return rad_fail_memory(e, "the list of blocks", (double)dense->n_task);
  return set_groups(dense, e);
}

enum rad_code rad_dense_assemble(const struct rad_mesh *mesh, const struct rad_rules *rules,
                                 const struct rad_reuse *reuse, struct rad_dense *dense,
                                 struct rad_error *e) {
  enum rad_code code = rad_dense_begin(mesh, reuse, dense, e);
  return code ? code : rad_dense_finish(rules, reuse, dense, e);
}

int rad_dense_is_by_facets(const struct rad_dense *dense) {
  return is_facets(dense->mesh, NULL);
}

enum rad_code rad_dense_set_done(struct rad_dense *dense, int first, int end, int outside,
                                 struct rad_error *e) {
  const struct rad_mesh *mesh = dense->mesh;
  int by_facets = rad_dense_is_by_facets(dense);
  struct task *task = rad_alloc(by_facets ? 0 : (size_t)dense->n_task, sizeof *task);
  if (!task)
    return rad_fail_memory(e, "the list of blocks", (double)dense->n_task * sizeof *task);
  if (!by_facets)
    list_tasks(dense, NULL, task);
  for (int64_t i = 0; i < dense->n_task; i++) {
    int column = by_facets ? (int)i * RAD_FACET_COLUMNS
                           : mesh->element[mesh->element_first[task[i].patch]].first;
    if ((column >= first && column < end) != outside)
      dense->done[i] = 1;
  }
  free(task);
  return RAD_OK;
}

void rad_dense_free(struct rad_dense *dense) {
  rad_pages_free(dense->k, (size_t)dense->n * (size_t)dense->n * sizeof(double));
  free(dense->done);
  free(dense->group);
  free(dense->group_sees);
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

/* y = K u for the rows of a group, over the triangles that it sees. */
static RAD_CLONES void apply_group(const struct rad_dense *dense, const struct rad_row_group *group,
                                   int n_vector, const double *const *u, double *const *y) {
  const int *point_first = dense->mesh->point_first;
  int n_triangle = dense->mesh->scene->n_triangle, first = group->first, m = group->n;
  size_t ld = (size_t)dense->n;
  for (int v = 0; v < n_vector; v++)
    memset(y[v] + first, 0, sizeof(double) * (size_t)m);
  for (int j = 0, next; j < n_triangle; j = next) {
    for (next = j + 1; next < n_triangle && group->sees[next] == group->sees[j];)
      next++;
    if (!group->sees[j])
      continue;
    int c = point_first[j], end = point_first[next];
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
#pragma omp parallel for schedule(dynamic) default(none) shared(dense, n_vector, u, y)
  for (int g = 0; g < dense->n_group; g++)
    apply_group(dense, &dense->group[g], n_vector, u, y);
}
