#include <string.h>

#include "base/memory.h"
#include "system/h2.h"
#include "system/sector.h"
#include "system/stream.h"

/* One vector's part of the workspace. */
struct slot {
  double *u, *y, *column, *row;
};

static inline struct slot slot_of(const struct rad_h2 *h, int v) {
  double *u = h->work + h->n_work * (size_t)v;
  double *y = u + h->mesh->n_point, *column = y + h->mesh->n_point;
  return (struct slot){u, y, column, column + h->column.place[h->tree.n_cluster]};
}

enum rad_code rad_h2_workspace(struct rad_h2 *h, struct rad_error *e) {
  int n = h->tree.n_cluster;
  h->n_work = 2 * (size_t)h->mesh->n_point + h->column.place[n] + h->row.place[n];
  h->work = rad_pages_alloc(sizeof(double) * RAD_MOST_VECTORS * h->n_work);
  if (!h->work)
    return rad_fail_memory(e, "products", 64.0 * (double)h->n_work);
  return RAD_OK;
}

double rad_h2_traffic(const struct rad_h2 *h) {
  size_t n_dense = h->near.n + h->sector.n;
  double near = (double)n_dense * (h->near.narrow ? sizeof(float) : sizeof(double));
  double vectors = 5.0 * h->mesh->n_point; /* u read, moved; y summed, read, written */
  double lists = 12.0 * (double)(h->blocks.far.first[h->tree.n_cluster] +
                                 h->blocks.near.first[h->tree.n_cluster] +
                                 h->blocks.sector.first[h->tree.n_cluster]);
  return near +
         8 * ((double)(h->row.n_data + h->column.n_data + h->n_far + h->n_spread) + vectors +
              2.0 * (double)(h->n_work - 2 * (size_t)h->mesh->n_point)) +
         4.0 * h->mesh->n_point + lists;
}

/* Up: x_s = W_s^T u_s, from a leaf's unknowns or from its children's coefficients. What will be
 * summed on the way down begins at 0. */
static void go_up(const struct rad_h2 *h, int c, int n_vector, const double *const *u) {
  const struct rad_cluster *cluster = &h->tree.cluster[c];
  const struct rad_h2_side *side = &h->column;
  size_t k = (size_t)side->rank[c];
  for (int v = 0; v < n_vector; v++) {
    struct slot slot = slot_of(h, v);
    const double *from = slot.column + (cluster->child < 0 ? 0 : side->place[cluster->child]);
    size_t m = (size_t)cluster->n;
    if (cluster->child < 0) {
      double *own = slot.u + cluster->first;
      const int *unknown = h->tree.unknown + cluster->first;
      for (size_t i = 0; i < m; i++)
        own[i] = u[v][unknown[i]];
      from = own;
    } else {
      m = side->place[cluster->child + 2] - side->place[cluster->child];
    }
    rad_set_transposed(m, k, side->data + side->at[c], from, slot.column + side->place[c]);
    memset(slot.row + h->row.place[c], 0, sizeof(double) * (size_t)h->row.rank[c]);
    if (cluster->child < 0)
      memset(slot.y + cluster->first, 0, sizeof(double) * m);
  }
}

enum kind { FAR, NEAR, SECTOR };

/* Where a source's numbers are: coefficients of a far one, unknowns of any other. */
struct segment {
  size_t at, n;
};

static inline struct segment segment_of(const struct rad_h2 *h, enum kind kind, int source) {
  const struct rad_cluster *s = &h->tree.cluster[source];
  if (kind == FAR)
    return (struct segment){h->column.place[source], (size_t)h->column.rank[source]};
  return (struct segment){(size_t)s->first, (size_t)s->n};
}

/* The numbers of sources from..end of a list, one after another; returns how many. */
static inline size_t gather(const struct rad_h2 *h, enum kind kind, const int *source, size_t n,
                            const double *from, double *x) {
  size_t at = 0;
  for (size_t b = 0; b < n; b++) {
    struct segment s = segment_of(h, kind, source[b]);
    memcpy(x + at, from + s.at, sizeof *x * s.n);
    at += s.n;
  }
  return at;
}

/* How many of the next n sources have RAD_MOST_COLUMNS columns in all. */
static inline size_t take(const struct rad_h2 *h, enum kind kind, const int *source, size_t n) {
  size_t taken = 0, columns = segment_of(h, kind, source[0]).n;
  while (columns <= RAD_MOST_COLUMNS && ++taken < n)
    columns += segment_of(h, kind, source[taken]).n;
  return taken;
}

/* y_v [m] += A x_v for the blocks of a target, which follow one another in memory: as one matrix of
 * up to RAD_MOST_COLUMNS columns at a time, for all vectors while it is in the cache. */
static inline void add_blocks(const struct rad_h2 *h, enum kind kind, int target, size_t m,
                              int n_vector, double *const *y) {
  const struct rad_block_list *list = kind == FAR    ? &h->blocks.far
                                      : kind == NEAR ? &h->blocks.near
                                                     : &h->blocks.sector;
  const struct rad_h2_dense *dense = kind == NEAR ? &h->near : &h->sector;
  size_t last = list->first[target + 1];
  for (size_t b = list->first[target], n; b < last; b += n) {
    n = take(h, kind, list->source + b, last - b);
    for (int v = 0; v < n_vector; v++) {
      double x[RAD_MOST_COLUMNS];
      struct slot slot = slot_of(h, v);
      size_t columns = gather(h, kind, list->source + b, n, kind == FAR ? slot.column : slot.u, x);
      if (kind == FAR)
        rad_add_product(m, columns, h->far + h->far_at[b], x, y[v]);
      else if (dense->narrow)
        rad_add_product_narrow(m, columns, dense->narrow + dense->at[b], x, y[v]);
      else
        rad_add_product(m, columns, dense->wide + dense->at[b], x, y[v]);
    }
  }
}

static void add_far(const struct rad_h2 *h, int target, int n_vector) {
  double *y[RAD_MOST_VECTORS];
  for (int v = 0; v < n_vector; v++)
    y[v] = slot_of(h, v).row + h->row.place[target];
  add_blocks(h, FAR, target, (size_t)h->row.rank[target], n_vector, y);
}

static void add_near(const struct rad_h2 *h, int target, int n_vector) {
  const struct rad_cluster *t = &h->tree.cluster[target];
  double *y[RAD_MOST_VECTORS];
  for (int v = 0; v < n_vector; v++)
    y[v] = slot_of(h, v).y + t->first;
  add_blocks(h, NEAR, target, (size_t)t->n, n_vector, y);
}

/* What the places of a sector receive, spread to its points. */
static void add_sector(const struct rad_h2 *h, int target, int n_vector) {
  const struct rad_cluster *t = &h->tree.cluster[target];
  size_t m = (size_t)h->place_count[target];
  double place[RAD_MOST_VECTORS][RAD_MAX_PLACES], *y[RAD_MOST_VECTORS] = {NULL};
  for (int v = 0; v < n_vector; v++) {
    y[v] = place[v];
    memset(y[v], 0, sizeof(double) * m);
  }
  add_blocks(h, SECTOR, target, m, n_vector, y);
  for (int v = 0; v < n_vector; v++)
    rad_add_product((size_t)t->n, m, h->spread + h->spread_at[target], place[v],
                    slot_of(h, v).y + t->first);
}

/* A cluster's coefficients to its children, or to the points of a leaf; a sector's places to its
 * points. */
static void go_down(const struct rad_h2 *h, int c, int n_vector) {
  const struct rad_cluster *cluster = &h->tree.cluster[c];
  const struct rad_h2_side *side = &h->row;
  int is_leaf = cluster->child < 0;
  size_t m = (size_t)cluster->n;
  if (!is_leaf)
    m = side->place[cluster->child + 2] - side->place[cluster->child];
  for (int v = 0; v < n_vector; v++) {
    struct slot slot = slot_of(h, v);
    double *to = is_leaf ? slot.y + cluster->first : slot.row + side->place[cluster->child];
    rad_add_product(m, (size_t)side->rank[c], side->data + side->at[c], slot.row + side->place[c],
                    to);
  }
  if (h->place_count[c])
    add_sector(h, c, n_vector);
}

/* The rows of a leaf, which has everything from above: add its near blocks, and done. */
static void finish_leaf(const struct rad_h2 *h, int c, int n_vector, double *const *y) {
  const struct rad_cluster *leaf = &h->tree.cluster[c];
  add_near(h, c, n_vector);
  for (int v = 0; v < n_vector; v++) {
    const double *from = slot_of(h, v).y + leaf->first;
    for (int i = 0; i < leaf->n; i++)
      y[v][h->tree.unknown[leaf->first + i]] = from[i];
  }
}

/* Level by level, and in the order in which bases and blocks lie in memory: each is read as one
 * stream. */
void rad_h2_apply(const struct rad_h2 *h, int n_vector, const double *const *u, double *const *y) {
  const int *level = h->tree.level_first;
  int n_level = h->tree.n_level, n = h->tree.n_cluster;
#pragma omp parallel default(none) shared(h, n_vector, u, y, level, n_level, n)
  {
    for (int l = n_level - 1; l >= 0; l--)
#pragma omp for schedule(guided)
      for (int c = level[l]; c < level[l + 1]; c++)
        go_up(h, c, n_vector, u);
#pragma omp for schedule(guided)
    for (int c = 0; c < n; c++)
      add_far(h, c, n_vector);
    for (int l = 0; l < n_level; l++)
#pragma omp for schedule(guided)
      for (int c = level[l]; c < level[l + 1]; c++)
        go_down(h, c, n_vector);
#pragma omp for schedule(guided)
    for (int c = 0; c < n; c++)
      if (h->tree.cluster[c].child < 0)
        finish_leaf(h, c, n_vector, y);
  }
}
