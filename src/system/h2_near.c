#include "system/h2_near.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

/* Memory of one thread. */
struct strip {
  struct rad_near_list list;
  size_t room_value, room_target;
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

int rad_near_list(const struct rad_tree *tree, const struct rad_block_list *near, int target,
                  struct rad_near_list *list) {
  size_t n = 0;
  int64_t column = 0;
  for (size_t b = near->first[target]; b < near->first[target + 1]; b++)
    n += (size_t)tree->cluster[near->source[b]].n_element;
  size_t room = list->room, again = list->room;
  if (!rad_reserve((void **)&list->piece, n, &room, sizeof *list->piece) ||
      !rad_reserve((void **)&list->element, n, &again, sizeof(int)) ||
      !rad_reserve((void **)&list->column, n, &list->room, sizeof(int64_t)))
    return 0;
  n = 0;
  for (size_t b = near->first[target]; b < near->first[target + 1]; b++) {
    const struct rad_cluster *c = &tree->cluster[near->source[b]];
    for (int i = c->element; i < c->element + c->n_element; i++) {
      list->piece[n++] = (struct rad_near_piece){tree->element[i], column};
      column += tree->mesh->element[tree->element[i]].n_function;
    }
  }
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

/* All pieces for rows first .. first + n of a leaf. */
static void integrate(const struct rad_h2 *h, const struct rad_rules *rules,
                      const struct rad_cluster *leaf, int first, int n, const struct strip *s,
                      struct rad_scratch *scratch) {
  const struct rad_mesh *mesh = h->mesh;
  const struct rad_near_list *list = &s->list;
  for (int i = 0; i < n; i++) {
    int point = h->tree.unknown[leaf->first + first + i];
    s->base[i] = mesh->point_base[point];
    memcpy(s->mu[i], mesh->point_mu[point], sizeof s->mu[i]);
  }
  struct rad_targets targets = {leaf->triangle, n, s->base, (const double(*)[2])s->mu, NULL};
  for (int i = 0, end; i < list->n; i = end) {
    int patch = mesh->element[list->element[i]].patch;
    for (end = i + 1; end < list->n && mesh->element[list->element[end]].patch == patch;)
      end++;
    rad_element_list_block(mesh, rules, &targets, end - i, list->element + i, list->column + i,
                           s->value + first, leaf->n, scratch);
  }
}

/* The near blocks of one leaf, which are one matrix of its rows; 0 without memory. */
static int fill_strip(struct rad_h2 *h, const struct rad_rules *rules, int target, struct strip *s,
                      struct rad_scratch *scratch) {
  const struct rad_cluster *leaf = &h->tree.cluster[target];
  const struct rad_block_list *near = &h->blocks.near;
  size_t from = near->first[target], to = near->first[target + 1];
  if (from == to)
    return 1;
  size_t at = h->near_at[from], size = h->near_at[to] - at, room = s->room_target;
  if (!rad_near_list(&h->tree, near, target, &s->list) ||
      !rad_reserve((void **)&s->value, size, &s->room_value, sizeof(double)) ||
      !rad_reserve((void **)&s->base, RAD_BATCH, &room, sizeof(int)) ||
      !rad_reserve((void **)&s->mu, RAD_BATCH, &s->room_target, sizeof *s->mu))
    return 0;
  for (int first = 0; first < leaf->n; first += RAD_BATCH) {
    int rest = leaf->n - first;
    integrate(h, rules, leaf, first, rest < RAD_BATCH ? rest : RAD_BATCH, s, scratch);
  }
  for (size_t i = 0; i < size && h->near_narrow; i++)
    h->near_narrow[at + i] = (float)s->value[i];
  if (h->near_wide)
    memcpy(h->near_wide + at, s->value, sizeof(double) * size);
  return 1;
}

static enum rad_code reserve_blocks(struct rad_h2 *h, int narrow, struct rad_error *e) {
  const struct rad_block_list *near = &h->blocks.near;
  size_t total = near->first[h->tree.n_cluster];
  h->near_at = rad_alloc(total + 1, sizeof(size_t));
  if (!h->near_at)
    return rad_fail_memory(e, "the near blocks", 8.0 * (double)total);
  for (int t = 0; t < h->tree.n_cluster; t++)
    for (size_t b = near->first[t]; b < near->first[t + 1]; b++) {
      h->near_at[b] = h->n_near;
      h->n_near += (size_t)h->tree.cluster[t].n * (size_t)h->tree.cluster[near->source[b]].n;
    }
  h->near_at[total] = h->n_near;
  if (narrow)
    h->near_narrow = rad_pages_alloc(sizeof(float) * h->n_near);
  else
    h->near_wide = rad_pages_alloc(sizeof(double) * h->n_near);
  return h->near_narrow || h->near_wide
             ? RAD_OK
             : rad_fail_memory(e, "the near blocks", (narrow ? 4.0 : 8.0) * (double)h->n_near);
}

enum rad_code rad_h2_near(struct rad_h2 *h, const struct rad_rules *rules, int narrow,
                          struct rad_error *e) {
  enum rad_code code = reserve_blocks(h, narrow, e);
  if (code)
    return code;
  int n_thread = omp_get_max_threads(), failed = 0;
  struct rad_scratch *scratch = rad_scratch_make(h->mesh, n_thread, e);
  struct strip *strip = rad_calloc((size_t)n_thread, sizeof *strip);
  struct rad_progress *progress = h->mesh->scene->progress;
  rad_progress_begin(progress, "near clusters", h->tree.n_cluster);
  if (scratch && strip) {
#pragma omp parallel for schedule(dynamic) default(none)                                           \
    shared(h, rules, strip, scratch, progress) reduction(| : failed)
    for (int t = 0; t < h->tree.n_cluster; t++) {
      int me = omp_get_thread_num();
      failed |= !fill_strip(h, rules, t, &strip[me], &scratch[me]);
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
  code = scratch ? rad_scratch_end(scratch, n_thread, &h->counters, e) : RAD_ESYSTEM;
  return failed ? rad_fail_memory(e, "the near blocks", 0) : code;
}
