#include "estimate/received.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/stop.h"
#include "estimate/transfer.h"
#include "visibility/visibility.h"

/* Rounding of factors that only tell shares. */
#define COARSE 1e-3

/* Of elements, each chunk with its own sums: the same bits for any number of threads. */
enum { CHUNKS = 128 };

/* Everything that the chunks share. */
struct receive {
  struct rad_transfer t;
  int n_receiver;
  double *portion; /* owned [n_element] of the tolerance that an element may use up */
  double *value, *error, *variance; /* owned [CHUNKS, n_receiver, n_weight] */
};

static int sends(const struct receive *r, int element) {
  const struct rad_element *e = &r->t.w->mesh->element[element];
  for (int k = 0; k < r->t.w->n; k++)
    for (int f = 0; f < e->n_function; f++)
      if (r->t.w->w[k][e->first + f] != 0)
        return 1;
  return 0;
}

/* What all elements send; returns how many do. Half of the tolerance by area, half by number, so
 * that neither one large element nor many small ones use it up. */
static int share_out(struct receive *r, struct rad_light *light, double *sent) {
  const struct rad_mesh *mesh = r->t.w->mesh;
  double area = 0;
  int n = 0;
  for (int i = 0; i < mesh->n_element; i++) {
    r->portion[i] = 0;
    if (!sends(r, i))
      continue;
    struct rad_light_cell cell = rad_light_cell_whole(mesh, i);
    rad_light_set(r->t.w, &cell, rad_transfer_rule(&mesh->element[i]), light);
    r->portion[i] = light->area;
    area += light->area;
    n++;
    for (int k = 0; k < r->t.w->n; k++)
      for (int q = 0; q < light->senders.n; q++)
        sent[k] += light->flux[k][q];
  }
  for (int i = 0; i < mesh->n_element; i++)
    if (r->portion[i] > 0)
      r->portion[i] = 0.5 * (r->portion[i] / area + 1.0 / n);
  return n;
}

static void send(const struct receive *r, int chunk, int element, struct rad_transfer_scratch *w) {
  const struct rad_transfer *t = &r->t;
  size_t n = (size_t)t->to->n_triangle, nw = (size_t)t->w->n;
  const unsigned char *sees =
      t->to->visibility->sight + (size_t)rad_element_triangle(t->w->mesh, element) * n;
  rad_transfer_element(t, element, w);
  for (int i = t->first; i < (int)n && !rad_stop_asked(); i++) {
    size_t at = ((size_t)chunk * (size_t)r->n_receiver + (size_t)(i - t->first)) * nw;
    const struct rad_transfer_sums sums = {r->value + at, r->error + at, r->variance + at};
    if (sees[i] != RAD_HIDDEN)
      rad_transfer_to(t, i, r->portion[element], &sums, w);
  }
}

/* What a receiver would get without shadows from elements that it does not see evenly. */
static void set_open(const struct receive *r, int triangle, struct rad_transfer_scratch *w) {
  const struct rad_transfer *t = &r->t;
  struct rad_open *open = &t->open[triangle - t->first];
  double most[RAD_MAX_WEIGHT];
  for (int i = 0; i < t->w->mesh->n_element && !rad_stop_asked(); i++) {
    int from = rad_element_triangle(t->w->mesh, i);
    if (!(r->portion[i] > 0) || !rad_transfer_is_broken(t, from, triangle))
      continue;
    rad_transfer_element(t, i, w);
    rad_transfer_open(t, triangle, COARSE, most, w);
    open->n++;
    for (int k = 0; k < t->w->n; k++)
      open->sum[k] += most[k];
  }
}

static void gather(struct receive *r, struct rad_received *out) {
  size_t n = (size_t)out->n_triangle * (size_t)out->n_weight;
  for (size_t c = 0; c < CHUNKS; c++)
    for (size_t i = 0; i < n; i++) {
      out->value[i] += r->value[c * n + i];
      out->error[i] += r->error[c * n + i] + r->t.accuracy * fabs(r->value[c * n + i]);
      r->variance[i] += c ? r->variance[c * n + i] : 0;
    }
  for (size_t i = 0; i < n; i++)
    out->error[i] += RAD_SIGMAS * sqrt(r->variance[i]);
}

static void run(struct receive *r, struct rad_transfer_scratch *worker) {
  int n_element = r->t.w->mesh->n_element;
  struct rad_progress *progress = r->t.w->mesh->scene->progress;
  int n_open = r->t.as_it_comes ? 0 : r->n_receiver;
#pragma omp parallel for schedule(dynamic) default(none) shared(r, worker, n_open)
  for (int i = 0; i < n_open; i++)
    set_open(r, r->t.first + i, &worker[omp_get_thread_num()]);
  rad_progress_begin(progress, "elements", n_element);
#pragma omp parallel for schedule(dynamic) default(none) shared(r, worker, n_element, progress)
  for (int c = 0; c < CHUNKS; c++)
    for (int i = c; i < n_element; i += CHUNKS) {
      if (r->portion[i] > 0 && !rad_stop_asked())
        send(r, c, i, &worker[omp_get_thread_num()]);
      rad_progress_add(progress, 1);
    }
}

static enum rad_code begin(struct receive *r, struct rad_error *e) {
  size_t n = (size_t)r->n_receiver * (size_t)r->t.w->n;
  r->portion = rad_alloc((size_t)r->t.w->mesh->n_element, sizeof(double));
  r->value = rad_calloc(CHUNKS * n, sizeof(double));
  r->error = rad_calloc(CHUNKS * n, sizeof(double));
  r->variance = rad_calloc(CHUNKS * n, sizeof(double));
  return r->portion && r->value && r->error && r->variance
             ? RAD_OK
             : rad_fail_memory(e, "the means", 24.0 * CHUNKS * (double)n);
}

static enum rad_code finish(struct receive *r, int n_thread, struct rad_transfer_scratch *worker,
                            struct rad_received *out, struct rad_error *e) {
  enum rad_code code = rad_stop_asked() ? rad_fail_stopped(e) : RAD_OK;
  for (int t = 0; t < n_thread && !code; t++) {
    out->factors += worker[t].factors;
    if (worker[t].patch.shade.failed)
      code = rad_fail_memory(e, "the shadows", 0);
    else if (worker[t].code) {
      *e = worker[t].error;
      code = worker[t].code;
    }
  }
  if (!code)
    gather(r, out);
  return code;
}

enum rad_code rad_receive(const struct rad_weights *w, const struct rad_scene *to, int first,
                          const double *tolerance, struct rad_received *out, struct rad_error *e) {
  int n_thread = omp_get_max_threads(), n_receiver = to->n_triangle - first;
  size_t n = (size_t)n_receiver * (size_t)w->n;
  struct receive r = {.n_receiver = n_receiver};
  *out = (struct rad_received){.n_triangle = n_receiver,
                               .n_weight = w->n,
                               .value = rad_calloc(n, sizeof(double)),
                               .error = rad_calloc(n, sizeof(double))};
  struct rad_transfer_scratch *worker = rad_calloc((size_t)n_thread, sizeof *worker);
  enum rad_code code = rad_transfer_begin(w, to, first, tolerance, &r.t, e);
  if (!code)
    code = begin(&r, e);
  if (!code && (!worker || !out->value || !out->error))
    code = rad_fail_memory(e, "the means", 16.0 * (double)n);
  for (int t = 0; t < n_thread && !code; t++)
    code = rad_transfer_scratch_init(&r.t, &worker[t], e);
  if (!code) {
    out->n_sender = share_out(&r, &worker[0].whole.rule[0], out->sent);
    run(&r, worker);
    code = finish(&r, n_thread, worker, out, e);
  }
  for (int t = 0; worker && t < n_thread; t++)
    rad_transfer_scratch_free(&worker[t]);
  free(worker);
  rad_transfer_free(&r.t);
  free(r.portion);
  free(r.value);
  free(r.error);
  free(r.variance);
  return code;
}

void rad_received_free(struct rad_received *r) {
  free(r->value);
  free(r->error);
  *r = (struct rad_received){0};
}
