#include "system/h2_near.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "integrate/task.h"
#include "system/sector.h"

/* Memory of one thread. */
struct strip {
  struct rad_near_list list;
  size_t room_value, room_target;
  int n;                   /* rows */
  int *base;               /* owned [room_target] */
  double (*mu)[2], *value; /* owned [room_target]; owned [room_value] */
};

struct rad_scratch *rad_scratch_make(const struct rad_mesh *mesh, int n_thread,
                                     struct rad_error *e) {
  struct rad_scratch *scratch = rad_calloc((size_t)n_thread, sizeof *scratch);
  enum rad_code code = scratch ? RAD_OK : rad_fail_memory(e, "the integrator", 0);
  for (int t = 0; t < n_thread && !code; t++)
    code = rad_scratch_init(mesh, &scratch[t], e);
  if (code && scratch) {
    rad_scratch_end(scratch, n_thread, NULL, e);
    scratch = NULL;
  }
  return scratch;
}

enum rad_code rad_scratch_end(struct rad_scratch *scratch, int n_thread,
                              struct rad_counters *counters, struct rad_error *e) {
  int failed = 0;
  for (int t = 0; t < n_thread; t++) {
    failed |= scratch[t].shade.failed;
    if (counters) {
      counters->kernel_values += scratch[t].counters.kernel_values;
      counters->near += scratch[t].counters.near;
      counters->far += scratch[t].counters.far;
    }
    rad_scratch_free(&scratch[t]);
  }
  free(scratch);
  return failed ? rad_fail_memory(e, "the shadows", 0) : RAD_OK;
}

static int by_element(const void *a, const void *b) {
  int x = ((const struct rad_near_piece *)a)->element;
  int y = ((const struct rad_near_piece *)b)->element;
  return (x > y) - (x < y);
}

int rad_near_list(const struct rad_tree *tree, size_t n_source, const int *source,
                  struct rad_near_list *list) {
  size_t n = 0;
  int64_t column = 0;
  for (size_t b = 0; b < n_source; b++)
    n += (size_t)tree->cluster[source[b]].n_element;
  size_t room = list->room, again = list->room;
  if (!rad_reserve((void **)&list->piece, n, &room, sizeof *list->piece) ||
      !rad_reserve((void **)&list->element, n, &again, sizeof(int)) ||
      !rad_reserve((void **)&list->column, n, &list->room, sizeof(int64_t)))
    return 0;
  n = 0;
  for (size_t b = 0; b < n_source; b++) {
    const struct rad_cluster *c = &tree->cluster[source[b]];
    for (int i = c->element; i < c->element + c->n_element; i++) {
      list->piece[n++] = (struct rad_near_piece){tree->element[i], column};
      column += tree->mesh->element[tree->element[i]].n_function;
    }
  }
  if (n)
    qsort(list->piece, n, sizeof *list->piece, by_element);
  for (size_t i = 0; i < n; i++) {
    list->element[i] = list->piece[i].element;
    list->column[i] = list->piece[i].column;
  }
  list->n = (int)n;
  return 1;
}

void rad_near_list_free(struct rad_near_list *list) {
  free(list->piece);
  free(list->element);
  free(list->column);
  *list = (struct rad_near_list){0};
}

/* The rows of a strip: the points of a leaf, or with p the places of a sector; 0 without memory. */
static int list_rows(const struct rad_h2 *h, const struct rad_interpolation *p, int target,
                     struct strip *s) {
  const struct rad_cluster *c = &h->tree.cluster[target];
  s->n = p ? rad_sector_places(&h->tree, p->q, c) : c->n;
  size_t room = s->room_target;
  if (!rad_reserve((void **)&s->base, (size_t)s->n, &room, sizeof(int)) ||
      !rad_reserve((void **)&s->mu, (size_t)s->n, &s->room_target, sizeof *s->mu))
    return 0;
  struct rad_sector sector;
  if (p)
    rad_sector_set(&h->tree, c, &sector);
  for (int i = 0; i < s->n; i++) {
    int point = h->tree.unknown[c->first + (p ? 0 : i)];
    s->base[i] = h->mesh->point_base[point];
    if (p)
      rad_sector_place(p, &sector, i, s->mu[i]);
    else
      memcpy(s->mu[i], h->mesh->point_mu[point], sizeof s->mu[i]);
  }
  return 1;
}

/* All pieces for rows first .. first + n. */
static void integrate(const struct rad_h2 *h, const struct rad_rules *rules, int triangle,
                      int first, int n, const struct strip *s, struct rad_scratch *scratch) {
  const struct rad_mesh *mesh = h->mesh;
  const struct rad_near_list *list = &s->list;
  struct rad_targets targets = {triangle, n, s->base + first, (const double(*)[2])s->mu + first,
                                NULL};
  for (int i = 0, end; i < list->n; i = end) {
    int patch = mesh->element[list->element[i]].patch;
    for (end = i + 1; end < list->n && mesh->element[list->element[end]].patch == patch;)
      end++;
    rad_element_list_block(mesh, rules, &targets, end - i, list->element + i, list->column + i,
                           s->value + first, s->n, scratch);
  }
}

/* The near blocks of one leaf, which are one matrix of its rows, or with p the sector blocks of a
 * cluster; 0 without memory. */
static int fill_strip(const struct rad_h2 *h, const struct rad_rules *rules,
                      const struct rad_interpolation *p, int target, struct strip *s,
                      struct rad_scratch *scratch) {
  const struct rad_block_list *list = p ? &h->blocks.sector : &h->blocks.near;
  const struct rad_h2_dense *dense = p ? &h->sector : &h->near;
  size_t from = list->first[target], to = list->first[target + 1];
  if (from == to)
    return 1;
  size_t at = dense->at[from], size = dense->at[to] - at;
  int triangle = h->tree.cluster[target].triangle;
  if (!rad_near_list(&h->tree, to - from, list->source + from, &s->list) ||
      !rad_reserve((void **)&s->value, size, &s->room_value, sizeof(double)) ||
      !list_rows(h, p, target, s))
    return 0;
  for (int first = 0; first < s->n; first += RAD_BATCH) {
    int rest = s->n - first;
    integrate(h, rules, triangle, first, rest < RAD_BATCH ? rest : RAD_BATCH, s, scratch);
  }
  for (size_t i = 0; i < size && dense->narrow; i++)
    dense->narrow[at + i] = (float)s->value[i];
  if (dense->wide)
    memcpy(dense->wide + at, s->value, sizeof(double) * size);
  return 1;
}

/* Room for the blocks of a list; with p of sectors. */
static enum rad_code reserve_blocks(const struct rad_h2 *h, const struct rad_interpolation *p,
                                    int narrow, struct rad_h2_dense *dense, struct rad_error *e) {
  const struct rad_block_list *list = p ? &h->blocks.sector : &h->blocks.near;
  size_t total = list->first[h->tree.n_cluster];
  dense->at = rad_alloc(total + 1, sizeof(size_t));
  if (!dense->at)
    return rad_fail_memory(e, "the near blocks", 8.0 * (double)total);
  for (int t = 0; t < h->tree.n_cluster; t++) {
    const struct rad_cluster *c = &h->tree.cluster[t];
    size_t rows = (size_t)(p ? rad_sector_places(&h->tree, p->q, c) : c->n);
    for (size_t b = list->first[t]; b < list->first[t + 1]; b++) {
      dense->at[b] = dense->n;
      dense->n += rows * (size_t)h->tree.cluster[list->source[b]].n;
    }
  }
  dense->at[total] = dense->n;
  if (narrow)
    dense->narrow = rad_pages_alloc(sizeof(float) * dense->n);
  else
    dense->wide = rad_pages_alloc(sizeof(double) * dense->n);
  return dense->narrow || dense->wide
             ? RAD_OK
             : rad_fail_memory(e, "the near blocks", (narrow ? 4.0 : 8.0) * (double)dense->n);
}

/* How the places of sectors spread to their points. */
static enum rad_code set_spread(struct rad_h2 *h, const struct rad_interpolation *p,
                                struct rad_error *e) {
  size_t n = (size_t)h->tree.n_cluster;
  const size_t *first = h->blocks.sector.first;
  h->place_count = rad_calloc(n, sizeof(int));
  h->spread_at = rad_alloc(n, sizeof(size_t));
  if (!h->place_count || !h->spread_at)
    return rad_fail_memory(e, "the sectors", 12.0 * (double)n);
  for (size_t t = 0; t < n; t++) {
    const struct rad_cluster *c = &h->tree.cluster[t];
    if (first[t + 1] > first[t])
      h->place_count[t] = rad_sector_places(&h->tree, p->q, c);
    h->spread_at[t] = h->n_spread;
    h->n_spread += (size_t)c->n * (size_t)h->place_count[t];
  }
  h->spread = rad_pages_alloc(sizeof(double) * h->n_spread);
  if (!h->spread)
    return rad_fail_memory(e, "the sectors", 8.0 * (double)h->n_spread);
  for (size_t t = 0; t < n; t++)
    if (h->place_count[t]) {
      struct rad_sector sector;
      rad_sector_set(&h->tree, &h->tree.cluster[t], &sector);
      rad_sector_spread(p, &h->tree, &h->tree.cluster[t], &sector, h->spread + h->spread_at[t]);
    }
  return RAD_OK;
}

enum rad_code rad_h2_near_begin(struct rad_h2 *h, int narrow, struct rad_error *e) {
  struct rad_interpolation p;
  rad_interpolation_init(&p, h->tolerance);
  enum rad_code code = reserve_blocks(h, NULL, narrow, &h->near, e);
  if (!code)
    code = reserve_blocks(h, &p, narrow, &h->sector, e);
  if (!code)
    code = set_spread(h, &p, e);
  if (!code && !(h->near_done = rad_calloc((size_t)h->tree.n_cluster, 1)))
    code = rad_fail_memory(e, "the near blocks", (double)h->tree.n_cluster);
  return code;
}

enum rad_code rad_h2_near(struct rad_h2 *h, const struct rad_rules *rules, struct rad_error *e) {
  struct rad_interpolation p;
  rad_interpolation_init(&p, h->tolerance);
  int n_thread = omp_get_max_threads(), failed = 0;
  struct rad_scratch *scratch = rad_scratch_make(h->mesh, n_thread, e);
  struct strip *strip = rad_calloc((size_t)n_thread, sizeof *strip);
  struct rad_progress *progress = h->mesh->scene->progress;
  rad_progress_begin(progress, "near clusters", h->tree.n_cluster);
  if (scratch && strip) {
#pragma omp parallel for schedule(dynamic) default(none)                                           \
    shared(h, rules, p, strip, scratch, progress) reduction(| : failed)
    for (int t = 0; t < h->tree.n_cluster; t++) {
      int me = omp_get_thread_num();
      const struct rad_counters before = scratch[me].counters;
      if (rad_task_begin(h->near_done, (size_t)t)) {
        failed |= !fill_strip(h, rules, NULL, t, &strip[me], &scratch[me]) ||
                  !fill_strip(h, rules, &p, t, &strip[me], &scratch[me]);
        rad_task_end(h->near_done, (size_t)t, &before, &scratch[me]);
      }
      rad_progress_add(progress, 1);
    }
  } else if (scratch) {
    failed = 1;
  }
  for (int t = 0; t < n_thread && strip; t++) {
    rad_near_list_free(&strip[t].list);
    free(strip[t].base);
    free(strip[t].mu);
    free(strip[t].value);
  }
  free(strip);
  enum rad_code code = scratch ? rad_scratch_end(scratch, n_thread, &h->counters, e) : RAD_ESYSTEM;
  if (!code && !failed && memchr(h->near_done, 0, (size_t)h->tree.n_cluster))
    code = rad_fail_stopped(e);
  return failed ? rad_fail_memory(e, "the near blocks", 0) : code;
}
