#include <string.h>

#include "base/memory.h"
#include "base/simd_math.h"
#include "system/h2.h"
#include "system/sector.h"

#define INLINE static inline __attribute__((always_inline))

enum {
  SUBTREES = 64,  /* more than threads, so that they are shared out evenly */
  COLUMNS = 1024, /* of a target's blocks at a time: no block has more */
  AHEAD = 1024    /* bytes */
};

/* Ask for n bytes that are about to be used. */
INLINE void fetch(const void *at, size_t n) {
  for (size_t i = 0; i < n; i += 64)
    __builtin_prefetch((const char *)at + i);
}

/* y [m] += A x, A [m, n] column-major, in single or double precision. Four streams, from the four
 * quarters of A, asked for AHEAD of their use: one stream alone reads memory at two thirds of the
 * speed, and the hardware sees none in matrices this short. */
#define ADD_PRODUCT(name, type)                                                                    \
  INLINE void name(size_t m, size_t n, const type *restrict a, const double *restrict x,           \
                   double *restrict y) {                                                           \
    size_t q = n / 4, column = m * sizeof *a, part = q * column, ahead = AHEAD / sizeof *a;        \
    for (size_t k = 0; k < 4; k++)                                                                 \
      fetch(a + k * m * q, part < AHEAD ? part : AHEAD);                                           \
    for (size_t c = 0; c < q; c++) {                                                               \
      const type *a0 = a + m * c, *a1 = a0 + m * q, *a2 = a1 + m * q, *a3 = a2 + m * q;            \
      double x0 = x[c], x1 = x[c + q], x2 = x[c + 2 * q], x3 = x[c + 3 * q];                       \
      fetch(a0 + ahead, column);                                                                   \
      fetch(a1 + ahead, column);                                                                   \
      fetch(a2 + ahead, column);                                                                   \
      fetch(a3 + ahead, column);                                                                   \
      _Pragma("omp simd") for (size_t r = 0; r < m; r++) y[r] +=                                   \
          (a0[r] * x0 + a1[r] * x1) + (a2[r] * x2 + a3[r] * x3);                                   \
    }                                                                                              \
    for (size_t c = 4 * q; c < n; c++)                                                             \
      _Pragma("omp simd") for (size_t r = 0; r < m; r++) y[r] += a[m * c + r] * x[c];              \
  }
ADD_PRODUCT(add_product, double)
ADD_PRODUCT(add_product_narrow, float)

/* y [n] = A^T x, A [m, n] column-major. */
INLINE void set_transposed(size_t m, size_t n, const double *restrict a, const double *restrict x,
                           double *restrict y) {
  size_t c = 0;
  for (; c + 4 <= n; c += 4) {
    const double *a0 = a + m * c, *a1 = a0 + m, *a2 = a1 + m, *a3 = a2 + m;
    double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
    fetch(a0 + AHEAD / sizeof *a, 4 * m * sizeof *a);
#pragma omp simd reduction(+ : s0, s1, s2, s3)
    for (size_t r = 0; r < m; r++) {
      s0 += a0[r] * x[r];
      s1 += a1[r] * x[r];
      s2 += a2[r] * x[r];
      s3 += a3[r] * x[r];
    }
    y[c] = s0;
    y[c + 1] = s1;
    y[c + 2] = s2;
    y[c + 3] = s3;
  }
  for (; c < n; c++) {
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t r = 0; r < m; r++)
      sum += a[m * c + r] * x[r];
    y[c] = sum;
  }
}

/* One vector's part of the workspace. */
struct slot {
  double *u, *y, *column, *row;
};

static inline struct slot slot_of(const struct rad_h2 *h, int v) {
  double *u = h->work + h->n_work * (size_t)v;
  double *y = u + h->mesh->n_point, *column = y + h->mesh->n_point;
  return (struct slot){u, y, column, column + h->column.place[h->tree.n_cluster]};
}

/* A subtree holds at most 1/SUBTREES of the unknowns. */
static enum rad_code set_subtrees(struct rad_h2 *h, struct rad_error *e) {
  const struct rad_tree *tree = &h->tree;
  int least = h->mesh->n_point / SUBTREES;
  h->subtree = rad_alloc((size_t)tree->n_cluster, sizeof(int));
  if (!h->subtree)
    return rad_fail_memory(e, "products", 4.0 * tree->n_cluster);
  for (int top = 0; top < 2; top++)
    for (int c = 0; c < tree->n_cluster; c++) {
      const struct rad_cluster *cluster = &tree->cluster[c];
      int below = cluster->child < 0 || cluster->n <= least, parent = cluster->parent;
      if (top && !below)
        h->subtree[h->n_subtree + h->n_top++] = c;
      if (!top && below && (parent < 0 || tree->cluster[parent].n > least))
        h->subtree[h->n_subtree++] = c;
    }
  return RAD_OK;
}

enum rad_code rad_h2_workspace(struct rad_h2 *h, struct rad_error *e) {
  int n = h->tree.n_cluster;
  h->n_work = 2 * (size_t)h->mesh->n_point + h->column.place[n] + h->row.place[n];
  h->work = rad_pages_alloc(sizeof(double) * RAD_MOST_VECTORS * h->n_work);
  if (!h->work)
    return rad_fail_memory(e, "products", 64.0 * (double)h->n_work);
  return set_subtrees(h, e);
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
static RAD_CLONES void go_up(const struct rad_h2 *h, int c, int n_vector, const double *const *u) {
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
    set_transposed(m, k, side->data + side->at[c], from, slot.column + side->place[c]);
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

INLINE struct segment segment_of(const struct rad_h2 *h, enum kind kind, int source) {
  const struct rad_cluster *s = &h->tree.cluster[source];
  if (kind == FAR)
    return (struct segment){h->column.place[source], (size_t)h->column.rank[source]};
  return (struct segment){(size_t)s->first, (size_t)s->n};
}

/* The numbers of sources from..end of a list, one after another; returns how many. */
INLINE size_t gather(const struct rad_h2 *h, enum kind kind, const int *source, size_t n,
                     const double *from, double *x) {
  size_t at = 0;
  for (size_t b = 0; b < n; b++) {
    struct segment s = segment_of(h, kind, source[b]);
    memcpy(x + at, from + s.at, sizeof *x * s.n);
    at += s.n;
  }
  return at;
}

/* How many of the next n sources have COLUMNS columns in all. */
INLINE size_t take(const struct rad_h2 *h, enum kind kind, const int *source, size_t n) {
  size_t taken = 0, columns = segment_of(h, kind, source[0]).n;
  while (columns <= COLUMNS && ++taken < n)
    columns += segment_of(h, kind, source[taken]).n;
  return taken;
}

/* y_v [m] += A x_v for the blocks of a target, which follow one another in memory: as one matrix of
 * up to COLUMNS columns at a time, for all vectors while it is in the cache. */
INLINE void add_blocks(const struct rad_h2 *h, enum kind kind, int target, size_t m, int n_vector,
                       double *const *y) {
  const struct rad_block_list *list = kind == FAR    ? &h->blocks.far
                                      : kind == NEAR ? &h->blocks.near
                                                     : &h->blocks.sector;
  const struct rad_h2_dense *dense = kind == NEAR ? &h->near : &h->sector;
  size_t last = list->first[target + 1];
  for (size_t b = list->first[target], n; b < last; b += n) {
    n = take(h, kind, list->source + b, last - b);
    for (int v = 0; v < n_vector; v++) {
      double x[COLUMNS];
      struct slot slot = slot_of(h, v);
      size_t columns = gather(h, kind, list->source + b, n, kind == FAR ? slot.column : slot.u, x);
      if (kind == FAR)
        add_product(m, columns, h->far + h->far_at[b], x, y[v]);
      else if (dense->narrow)
        add_product_narrow(m, columns, dense->narrow + dense->at[b], x, y[v]);
      else
        add_product(m, columns, dense->wide + dense->at[b], x, y[v]);
    }
  }
}

static RAD_CLONES void add_far(const struct rad_h2 *h, int target, int n_vector) {
  double *y[RAD_MOST_VECTORS];
  for (int v = 0; v < n_vector; v++)
    y[v] = slot_of(h, v).row + h->row.place[target];
  add_blocks(h, FAR, target, (size_t)h->row.rank[target], n_vector, y);
}

static RAD_CLONES void add_near(const struct rad_h2 *h, int target, int n_vector) {
  const struct rad_cluster *t = &h->tree.cluster[target];
  double *y[RAD_MOST_VECTORS];
  for (int v = 0; v < n_vector; v++)
    y[v] = slot_of(h, v).y + t->first;
  add_blocks(h, NEAR, target, (size_t)t->n, n_vector, y);
}

/* What the places of a sector receive, spread to its points. */
static RAD_CLONES void add_sector(const struct rad_h2 *h, int target, int n_vector) {
  const struct rad_cluster *t = &h->tree.cluster[target];
  size_t m = (size_t)h->place_count[target];
  double place[RAD_MOST_VECTORS][RAD_MAX_PLACES], *y[RAD_MOST_VECTORS];
  for (int v = 0; v < n_vector; v++) {
    y[v] = place[v];
    memset(y[v], 0, sizeof(double) * m);
  }
  add_blocks(h, SECTOR, target, m, n_vector, y);
  for (int v = 0; v < n_vector; v++)
    add_product((size_t)t->n, m, h->spread + h->spread_at[target], place[v],
                slot_of(h, v).y + t->first);
}

/* A cluster's coefficients to its children, or to the points of a leaf; a sector's places to its
 * points. */
static RAD_CLONES void go_down(const struct rad_h2 *h, int c, int n_vector) {
  const struct rad_cluster *cluster = &h->tree.cluster[c];
  const struct rad_h2_side *side = &h->row;
  int is_leaf = cluster->child < 0;
  size_t m = (size_t)cluster->n;
  if (!is_leaf)
    m = side->place[cluster->child + 2] - side->place[cluster->child];
  for (int v = 0; v < n_vector; v++) {
    struct slot slot = slot_of(h, v);
    double *to = is_leaf ? slot.y + cluster->first : slot.row + side->place[cluster->child];
    add_product(m, (size_t)side->rank[c], side->data + side->at[c], slot.row + side->place[c], to);
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

/* A whole subtree, children before parents. */
static void subtree_up(const struct rad_h2 *h, int c, int n_vector, const double *const *u) {
  int child = h->tree.cluster[c].child;
  if (child >= 0) {
    subtree_up(h, child, n_vector, u);
    subtree_up(h, child + 1, n_vector, u);
  }
  go_up(h, c, n_vector, u);
}

/* A whole subtree, parents before children. */
static void subtree_down(const struct rad_h2 *h, int c, int n_vector, double *const *y) {
  int child = h->tree.cluster[c].child;
  add_far(h, c, n_vector);
  go_down(h, c, n_vector);
  if (child >= 0) {
    subtree_down(h, child, n_vector, y);
    subtree_down(h, child + 1, n_vector, y);
  } else {
    finish_leaf(h, c, n_vector, y);
  }
}

void rad_h2_apply(const struct rad_h2 *h, int n_vector, const double *const *u, double *const *y) {
  const int *top = h->subtree + h->n_subtree; /* parents first */
#pragma omp parallel default(none) shared(h, n_vector, u, y, top)
  {
#pragma omp for schedule(dynamic)
    for (int i = 0; i < h->n_subtree; i++)
      subtree_up(h, h->subtree[i], n_vector, u);
#pragma omp single
    for (int i = h->n_top - 1; i >= 0; i--)
      go_up(h, top[i], n_vector, u);
#pragma omp for schedule(dynamic)
    for (int i = 0; i < h->n_top; i++)
      add_far(h, top[i], n_vector);
#pragma omp single
    for (int i = 0; i < h->n_top; i++)
      go_down(h, top[i], n_vector);
#pragma omp for schedule(dynamic)
    for (int i = 0; i < h->n_subtree; i++)
      subtree_down(h, h->subtree[i], n_vector, y);
  }
}
