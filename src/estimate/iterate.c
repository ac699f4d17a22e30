#include "estimate/iterate.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

/* Memory of one thread: the rows of a batch, at most about 16 MB. */
struct worker {
  struct rad_scratch scratch;
  double *row;
};

static int batch_size(const struct rad_mesh *mesh) {
  double fit = 16e6 / (8.0 * mesh->n_point);
  return fit < 1 ? 1 : fit > RAD_BATCH ? RAD_BATCH : (int)fit;
}

/* h of one batch of points on one triangle. */
static void batch(const struct rad_mesh *mesh, const struct rad_rules *rules,
                  const unsigned char *sees, const struct rad_targets *t, int n_band,
                  const double *u, double *h, struct worker *w) {
  int n_triangle = mesh->scene->n_triangle, m = t->n;
  memset(h, 0, sizeof(double) * (size_t)m * (size_t)n_band);
  for (int j = 0; j < n_triangle; j++) {
    if (!sees[(size_t)t->triangle * n_triangle + j])
      continue;
    for (int p = mesh->patch_first[j]; p < mesh->patch_first[j + 1]; p++)
      rad_patch_block(mesh, rules, t, p, w->row, m, &w->scratch);
    for (int c = mesh->point_first[j]; c < mesh->point_first[j + 1]; c++)
      for (int b = 0; b < n_band; b++) {
        double uc = u[(size_t)b * mesh->n_point + c];
        for (int i = 0; i < m; i++)
          h[i * n_band + b] += w->row[(size_t)c * m + i] * uc;
      }
  }
}

/* First points of the batches: runs of one triangle, cut to size. Returns their number. */
static int list_batches(const struct rad_point_list *p, int size, int *first) {
  int n = 0;
  for (int i = 0; i < p->n; i++)
    if (i == 0 || p->triangle[i] != p->triangle[i - 1] || i - first[n - 1] == size)
      first[n++] = i;
  first[n] = p->n;
  return n;
}

static enum rad_code init_workers(const struct rad_mesh *mesh, int n, int size, struct worker *w,
                                  struct rad_error *e) {
  size_t bytes = sizeof(double) * (size_t)size * (size_t)mesh->n_point;
  for (int t = 0; t < n; t++) {
    enum rad_code code = rad_scratch_init(mesh, &w[t].scratch, e);
    if (code)
      return code;
    if (!(w[t].row = rad_alloc(bytes, 1)))
      return rad_fail_memory(e, "the evaluation at points", (double)bytes);
  }
  return RAD_OK;
}

enum rad_code rad_irradiance_at(const struct rad_mesh *mesh, const struct rad_rules *rules,
                                const unsigned char *sees, const struct rad_point_list *p,
                                int n_band, const double *u, double *h, struct rad_error *e) {
  int n_thread = omp_get_max_threads(), size = batch_size(mesh);
  struct worker *worker = rad_calloc((size_t)n_thread, sizeof *worker);
  int *first = rad_alloc((size_t)p->n + 1, sizeof(int));
  enum rad_code code = RAD_OK;
  if (!worker || !first)
    code = rad_fail_memory(e, "the evaluation at points", 4.0 * p->n);
  else
    code = init_workers(mesh, n_thread, size, worker, e);
  if (!code) {
    int n = list_batches(p, size, first);
#pragma omp parallel for schedule(dynamic) default(none)                                           \
    shared(mesh, rules, sees, p, n_band, u, h, worker, first, n)
    for (int i = 0; i < n; i++) {
      int at = first[i];
      struct rad_targets t = {p->triangle[at], first[i + 1] - at, p->base + at, p->mu + at};
      batch(mesh, rules, sees, &t, n_band, u, h + (size_t)at * n_band,
            &worker[omp_get_thread_num()]);
    }
  }
  for (int t = 0; worker && t < n_thread; t++) {
    rad_scratch_free(&worker[t].scratch);
    free(worker[t].row);
  }
  free(worker);
  free(first);
  return code;
}
