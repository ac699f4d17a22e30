#include <string.h>

#include "base/memory.h"
#include "base/simd_math.h"
#include "system/h2.h"

#define INLINE static inline __attribute__((always_inline))

enum { SUBTREES = 128 }; /* more than threads, so that they are shared out evenly */

/* y [m] += A x, A [m, n] column-major, in single or double precision. */
#define ADD_PRODUCT(name, type)                                                                    \
  INLINE void name(size_t m, size_t n, const type *restrict a, const double *restrict x,           \
                   double *restrict y) {                                                           \
    size_t c = 0;                                                                                  \
    for (; c + 4 <= n; c += 4) {                                                                   \
      const type *a0 = a + m * c, *a1 = a0 + m, *a2 = a1 + m, *a3 = a2 + m;                        \
      double x0 = x[c], x1 = x[c + 1], x2 = x[c + 2], x3 = x[c + 3];                               \
      _Pragma("omp simd") for (size_t r = 0; r < m; r++) y[r] +=                                   \
          (a0[r] * x0 + a1[r] * x1) + (a2[r] * x2 + a3[r] * x3);                                   \
    }                                                                                              \
    for (; c < n; c++)                                                                             \
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
  double near = (double)h->n_near * (h->near_narrow ? sizeof(float) : sizeof(double));
  double vectors = 5.0 * h->mesh->n_point; /* u read, moved; y summed, read, written */
  double lists = 12.0 * (double)(h->blocks.far.first[h->tree.n_cluster] +
                                 h->blocks.near.first[h->tree.n_cluster]);
  return near +
         8 * ((double)(h->row.n_data + h->column.n_data + h->n_far) + vectors +
              2.0 * (double)(h->n_work - 2 * (size_t)h->mesh->n_point)) +
         4.0 * h->mesh->n_point + lists;
}

/* Up: x_s = W_s^T u_s, from a leaf's unknowns or from its children's coefficients. */
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
  }
}

static RAD_CLONES void add_far(const struct rad_h2 *h, int c, int n_vector) {
  size_t k = (size_t)h->row.rank[c];
  for (size_t b = h->blocks.far.first[c]; b < h->blocks.far.first[c + 1]; b++) {
    int s = h->blocks.far.source[b];
    for (int v = 0; v < n_vector; v++) {
      struct slot slot = slot_of(h, v);
      add_product(k, (size_t)h->column.rank[s], h->far + h->far_at[b],
                  slot.column + h->column.place[s], slot.row + h->row.place[c]);
    }
  }
}

static RAD_CLONES void add_near(const struct rad_h2 *h, int c, int n_vector) {
  const struct rad_cluster *t = &h->tree.cluster[c];
  size_t m = (size_t)t->n;
  for (size_t b = h->blocks.near.first[c]; b < h->blocks.near.first[c + 1]; b++) {
    const struct rad_cluster *s = &h->tree.cluster[h->blocks.near.source[b]];
    for (int v = 0; v < n_vector; v++) {
      struct slot slot = slot_of(h, v);
      double *y = slot.y + t->first;
      if (h->near_narrow)
        add_product_narrow(m, (size_t)s->n, h->near_narrow + h->near_at[b], slot.u + s->first, y);
      else
        add_product(m, (size_t)s->n, h->near_wide + h->near_at[b], slot.u + s->first, y);
    }
  }
}

/* A cluster's coefficients to its children, or to the points of a leaf, which are then done. */
static RAD_CLONES void go_down(const struct rad_h2 *h, int c, int n_vector, double *const *y) {
  const struct rad_cluster *cluster = &h->tree.cluster[c];
  const struct rad_h2_side *side = &h->row;
  int is_leaf = cluster->child < 0;
  size_t m = (size_t)cluster->n;
  if (!is_leaf)
    m = side->place[cluster->child + 2] - side->place[cluster->child];
  add_far(h, c, n_vector);
  for (int v = 0; v < n_vector; v++) {
    struct slot slot = slot_of(h, v);
    double *to = is_leaf ? slot.y + cluster->first : slot.row + side->place[cluster->child];
    memset(to, 0, sizeof(double) * m);
    add_product(m, (size_t)side->rank[c], side->data + side->at[c], slot.row + side->place[c], to);
  }
  if (!is_leaf)
    return;
  add_near(h, c, n_vector);
  for (int v = 0; v < n_vector; v++) {
    const double *from = slot_of(h, v).y + cluster->first;
    for (size_t i = 0; i < m; i++)
      y[v][h->tree.unknown[(size_t)cluster->first + i]] = from[i];
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
  go_down(h, c, n_vector, y);
  if (child >= 0) {
    subtree_down(h, child, n_vector, y);
    subtree_down(h, child + 1, n_vector, y);
  }
}

/* Above the subtrees: up to the roots, to which nothing comes down, and down again. */
static void turn(const struct rad_h2 *h, int n_vector, const double *const *u, double *const *y) {
  const int *top = h->subtree + h->n_subtree;
  for (int i = h->n_top - 1; i >= 0; i--)
    go_up(h, top[i], n_vector, u);
  for (int t = 0; t < h->mesh->scene->n_triangle; t++)
    for (int v = 0; v < n_vector; v++)
      memset(slot_of(h, v).row + h->row.place[t], 0, sizeof(double) * (size_t)h->row.rank[t]);
  for (int i = 0; i < h->n_top; i++)
    go_down(h, top[i], n_vector, y);
}

void rad_h2_apply(const struct rad_h2 *h, int n_vector, const double *const *u, double *const *y) {
#pragma omp parallel default(none) shared(h, n_vector, u, y)
  {
#pragma omp for schedule(dynamic)
    for (int i = 0; i < h->n_subtree; i++)
      subtree_up(h, h->subtree[i], n_vector, u);
#pragma omp single
    turn(h, n_vector, u, y);
#pragma omp for schedule(dynamic)
    for (int i = 0; i < h->n_subtree; i++)
      subtree_down(h, h->subtree[i], n_vector, y);
  }
}
