#include "estimate/iterate.h"

#include <math.h>

#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/stop.h"
#include "visibility/visibility.h"

/* Memory of one thread: the rows of a batch, at most about 16 MB. */
struct worker {
  struct rad_scratch scratch;
  double *row;
};

static int batch_size(const struct rad_mesh *mesh) {
  double fit = 16e6 / (8.0 * mesh->n_point);
  return fit < 1 ? 1 : fit > RAD_BATCH ? RAD_BATCH : (int)fit;
}

/* Rows of one batch of points on one triangle. */
static void fill(const struct rad_mesh *mesh, const struct rad_rules *rules,
                 const unsigned char *sees, const struct rad_targets *t, struct worker *w) {
  int n_triangle = mesh->scene->n_triangle;
  for (int j = 0; j < n_triangle; j++)
    if (sees[(size_t)t->triangle * n_triangle + j])
      for (int p = mesh->patch_first[j]; p < mesh->patch_first[j + 1]; p++)
        rad_patch_block(mesh, rules, t, p, NULL, w->row, t->n, &w->scratch);
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

enum rad_code rad_visit_rows(const struct rad_mesh *mesh, const struct rad_rules *rules,
                             const unsigned char *sees, const struct rad_point_list *p,
                             rad_row_visitor *visit, void *context, struct rad_error *e) {
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
    struct rad_progress *progress = mesh->scene->progress;
    rad_progress_begin(progress, "points", p->n);
#pragma omp parallel for schedule(dynamic) default(none)                                           \
    shared(mesh, rules, sees, p, visit, context, worker, first, n, progress)
    for (int i = 0; i < n; i++) {
      int at = first[i], thread = omp_get_thread_num();
      struct rad_targets t = {p->triangle[at], first[i + 1] - at, p->base + at, p->mu + at, NULL};
      fill(mesh, rules, sees, &t, &worker[thread]);
      if (!rad_stop_asked()) /* else the row is not whole */
        visit(context, thread, at, t.n, worker[thread].row);
      rad_progress_add(progress, t.n);
    }
    if (rad_stop_asked())
      code = rad_fail_stopped(e);
  }
  for (int t = 0; worker && t < n_thread; t++) {
    if (!code && worker[t].scratch.shade.failed)
      code = rad_fail_memory(e, "the shadows", 0);
    rad_scratch_free(&worker[t].scratch);
    free(worker[t].row);
  }
  free(worker);
  free(first);
  return code;
}

struct irradiance {
  const struct rad_mesh *mesh;
  const unsigned char *sees;
  const int *triangle;
  int n_band;
  const double *u;
  double *h;
};

static void add_irradiance(void *context, int thread, int first, int m, const double *row) {
  const struct irradiance *c = context;
  const struct rad_mesh *mesh = c->mesh;
  int n_triangle = mesh->scene->n_triangle, nb = c->n_band;
  double *h = c->h + (size_t)first * nb;
  (void)thread;
  memset(h, 0, sizeof(double) * (size_t)m * (size_t)nb);
  for (int j = 0; j < n_triangle; j++)
    if (c->sees[(size_t)c->triangle[first] * n_triangle + j])
      for (int q = mesh->point_first[j]; q < mesh->point_first[j + 1]; q++)
        for (int b = 0; b < nb; b++) {
          double uq = c->u[(size_t)b * mesh->n_point + q];
          for (int i = 0; i < m; i++)
            h[i * nb + b] += row[(size_t)q * m + i] * uq;
        }
}

enum rad_code rad_irradiance_at(const struct rad_mesh *mesh, const struct rad_rules *rules,
                                const struct rad_point_list *p, int n_band, const double *u,
                                double *h, struct rad_error *e) {
  const unsigned char *sees = mesh->scene->visibility->sight;
  struct irradiance c = {mesh, sees, p->triangle, n_band, u, h};
  enum rad_code code = rad_visit_rows(mesh, rules, sees, p, add_irradiance, &c, e);
  for (int i = 0; i < p->n * n_band && !code; i++)
    if (!isfinite(h[i]))
      code = rad_fail_integral(mesh->scene, p->triangle[i / n_band], e);
  return code;
}

enum rad_code rad_irradiance_on(const struct rad_mesh *mesh, const struct rad_rules *rules,
                                const struct rad_element_points *points, int n, int n_band,
                                const double *u, double *h, struct rad_error *e) {
  const double *in[RAD_MAX_BAND];
  double *out[RAD_MAX_BAND];
  struct rad_once once = {0};
  for (int b = 0; b < n_band; b++) {
    in[b] = u + (size_t)b * (size_t)mesh->n_point;
    out[b] = h + (size_t)b * (size_t)n;
  }
  enum rad_code code = rad_once_begin(mesh, rules, RAD_ONCE_LEAF, rules->tolerance, &once, e);
  if (!code)
    code = rad_once_gather(&once, n_band, in, e);
  if (!code)
    code = rad_once_at(&once, points, n_band, out, NULL, NULL, e);
  for (int i = 0; i < mesh->n_element && !code; i++)
    for (int p = points->first[i]; p < points->first[i] + points->count[i] && !code; p++)
      for (int b = 0; b < n_band && !code; b++)
        if (!isfinite(out[b][p]))
          code = rad_fail_integral(mesh->scene, rad_element_triangle(mesh, i), e);
  rad_once_free(&once);
  return code;
}

enum rad_code rad_fail_integral(const struct rad_scene *s, int triangle, struct rad_error *e) {
  return rad_fail(e, RAD_ENUMERIC,
                  "an integral for a point of triangle %d (%s) is not finite: an error of polyrad; "
                  "please report the deck",
                  triangle + 1, s->surface_name[s->triangle[triangle].surface]);
}

void rad_iterated(const struct rad_scene *scene, const struct rad_point_list *p, const double *h,
                  double *u) {
  int nb = scene->n_band;
  for (int i = 0; i < p->n; i++)
    for (int b = 0; b < nb; b++)
      u[(size_t)i * nb + b] = rad_emission(scene, p->triangle[i], b, p->base[i], p->mu[i]) +
                              scene->rho[p->triangle[i] * nb + b] * h[(size_t)i * nb + b];
}
