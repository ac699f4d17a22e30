/* Means of a hierarchical matrix over aggregates: C = R K P (theory 5.7). */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "system/coarse.h"
#include "system/sector.h"

/* s[c] = P^T W_c: what value 1 on an aggregate is in the coefficients of the columns. */
struct sums {
  const struct rad_h2 *h;
  const struct rad_aggregates *a;
  size_t *at; /* owned [n_cluster + 1] of s[c], [rank, aggregates that touch c] */
  double *s;  /* owned */
};

/* Aggregates that touch a cluster: *first, and how many. */
static int touching(const struct rad_h2 *h, const struct rad_aggregates *a, int cluster,
                    int *first) {
  const struct rad_cluster *c = &h->tree.cluster[cluster];
  *first = a->of[c->first];
  return a->of[c->first + c->n - 1] - *first + 1;
}

/* y [n] += the rows x_r of A [m, n], column-major. */
static void add_rows(size_t m, size_t n, const double *a, const double *x, double *y) {
  for (size_t j = 0; j < n; j++)
    for (size_t i = 0; i < m; i++)
      y[j] += a[i + m * j] * x[i];
}

/* s of one cluster, from its unknowns or from its children. */
static void set_sums(const struct sums *s, int cluster) {
  const struct rad_h2_side *side = &s->h->column;
  const struct rad_cluster *c = &s->h->tree.cluster[cluster];
  const double *w = side->data + side->at[cluster];
  size_t k = (size_t)side->rank[cluster], rows = (size_t)c->n;
  int first, own, n = touching(s->h, s->a, cluster, &first);
  double *out = s->s + s->at[cluster];
  if (c->child < 0) {
    for (size_t j = 0; j < k; j++)
      for (size_t i = 0; i < rows; i++)
        out[j + k * (size_t)(s->a->of[(size_t)c->first + i] - first)] += w[i + rows * j];
    return;
  }
  rows = (size_t)(side->rank[c->child] + side->rank[c->child + 1]);
  for (int child = c->child; child < c->child + 2; child++) {
    size_t k_child = (size_t)side->rank[child];
    const double *part = w + (child == c->child ? 0 : side->rank[c->child]);
    n = touching(s->h, s->a, child, &own);
    for (int g = 0; g < n; g++)
      for (size_t j = 0; j < k; j++)
        for (size_t i = 0; i < k_child; i++)
          out[j + k * (size_t)(own + g - first)] +=
              part[i + rows * j] * s->s[s->at[child] + i + k_child * (size_t)g];
  }
}

static int make_sums(struct sums *s) {
  int n = s->h->tree.n_cluster, first;
  s->at = rad_alloc((size_t)n + 1, sizeof(size_t));
  if (!s->at)
    return 0;
  s->at[0] = 0;
  for (int c = 0; c < n; c++)
    s->at[c + 1] =
        s->at[c] + (size_t)s->h->column.rank[c] * (size_t)touching(s->h, s->a, c, &first);
  s->s = rad_calloc(s->at[n], sizeof(double));
  if (!s->s)
    return 0;
  for (int c = n - 1; c >= 0; c--) /* children come after their parents */
    set_sums(s, c);
  return 1;
}

/* Row `target` of C gets its part of the far blocks of a cluster; v [rank]: R U of the cluster. */
static void add_far(const struct sums *s, int cluster, const double *v, double *work, double *row) {
  const struct rad_h2 *h = s->h;
  size_t k = (size_t)h->row.rank[cluster];
  for (size_t b = h->blocks.far.first[cluster]; b < h->blocks.far.first[cluster + 1]; b++) {
    int source = h->blocks.far.source[b], first, n = touching(h, s->a, source, &first);
    size_t k_s = (size_t)h->column.rank[source];
    memset(work, 0, sizeof(double) * k_s);
    add_rows(k, k_s, h->far + h->far_at[b], v, work);
    add_rows(k_s, (size_t)n, s->s + s->at[source], work, row + first);
  }
}

/* Row `row` of C gets x^T B of the near or sector blocks B [m, sources] of a cluster. */
static void add_dense(const struct sums *s, const struct rad_h2_dense *dense,
                      const struct rad_block_list *list, int cluster, size_t m, const double *x,
                      double *row) {
  for (size_t b = list->first[cluster]; b < list->first[cluster + 1]; b++) {
    const struct rad_cluster *source = &s->h->tree.cluster[list->source[b]];
    for (int j = 0; j < source->n; j++) {
      size_t at = dense->at[b] + m * (size_t)j;
      double sum = 0;
      if (dense->narrow)
        for (size_t i = 0; i < m; i++)
          sum += x[i] * (double)dense->narrow[at + i];
      else
        for (size_t i = 0; i < m; i++)
          sum += x[i] * dense->wide[at + i];
      row[s->a->of[source->first + j]] += sum;
    }
  }
}

/* The part of a cluster in an aggregate, for its near and sector blocks; share [points of the
 * cluster] and place [its places] are scratch. */
static void add_points(const struct sums *s, int target, int cluster, double *share, double *row) {
  const struct rad_h2 *h = s->h;
  const struct rad_cluster *c = &h->tree.cluster[cluster];
  size_t n = (size_t)c->n, places = (size_t)h->place_count[cluster];
  int is_near = h->blocks.near.first[cluster + 1] > h->blocks.near.first[cluster];
  if (!is_near && !places)
    return;
  for (size_t i = 0; i < n; i++)
    share[i] = s->a->of[(size_t)c->first + i] == target ? s->a->weight[(size_t)c->first + i] : 0;
  add_dense(s, &h->near, &h->blocks.near, cluster, n, share, row);
  if (places) {
    double place[RAD_MAX_PLACES] = {0};
    add_rows(n, places, h->spread + h->spread_at[cluster], share, place);
    add_dense(s, &h->sector, &h->blocks.sector, cluster, places, place, row);
  }
}

/* Scratch of one thread. */
struct space {
  size_t most;   /* largest rank */
  double *v;     /* [levels + 2, most] */
  double *share; /* [n_point] */
};

/* v [rank] = U^T weights over the part of a cluster in an aggregate; adds the blocks on the way. */
static void descend(const struct sums *s, int target, int cluster, const struct space *space,
                    double *v, double *row) {
  const struct rad_h2_side *side = &s->h->row;
  const struct rad_cluster *c = &s->h->tree.cluster[cluster];
  const double *u = side->data + side->at[cluster];
  size_t k = (size_t)side->rank[cluster], rows = (size_t)c->n;
  double *below = v + space->most;
  memset(v, 0, sizeof(double) * k);
  if (c->child < 0) {
    int from = s->a->first[target] - c->first, to = s->a->first[target + 1] - c->first;
    from = from > 0 ? from : 0;
    to = to < c->n ? to : c->n;
    for (size_t j = 0; j < k; j++)
      for (int i = from; i < to; i++)
        v[j] += u[(size_t)i + rows * j] * s->a->weight[c->first + i];
  } else {
    rows = (size_t)(side->rank[c->child] + side->rank[c->child + 1]);
    for (int child = c->child; child < c->child + 2; child++) {
      const double *part = u + (child == c->child ? 0 : side->rank[c->child]);
      descend(s, target, child, space, below, row);
      for (size_t j = 0; j < k; j++)
        for (int i = 0; i < side->rank[child]; i++)
          v[j] += part[(size_t)i + rows * j] * below[i];
    }
  }
  add_points(s, target, cluster, space->share, row);
  add_far(s, cluster, v, below, row);
}

/* One row of C: down to the unknowns of the aggregate, then up to the root of its triangle. */
static void set_row(const struct sums *s, int target, const struct space *space, double *row) {
  const struct rad_h2_side *side = &s->h->row;
  const struct rad_cluster *cluster = s->h->tree.cluster;
  double *v = space->v, *next = v + space->most;
  int at = s->a->cluster[target];
  descend(s, target, at, space, v, row);
  for (int up = cluster[at].parent; up >= 0; at = up, up = cluster[at].parent) {
    int child = cluster[up].child;
    size_t rows = (size_t)(side->rank[child] + side->rank[child + 1]);
    const double *u = side->data + side->at[up] + (at == child ? 0 : side->rank[child]);
    for (int j = 0; j < side->rank[up]; j++) {
      next[j] = 0;
      for (int i = 0; i < side->rank[at]; i++)
        next[j] += u[(size_t)i + rows * (size_t)j] * v[i];
    }
    memcpy(v, next, sizeof(double) * (size_t)side->rank[up]);
    add_points(s, target, up, space->share, row);
    add_far(s, up, v, next, row);
  }
}

/* Rows of C in parallel, each with one owner; 0 without memory. */
static int set_rows(const struct sums *s, double *k) {
  const struct rad_h2 *h = s->h;
  size_t most = 1, n = (size_t)s->a->n, level = (size_t)h->tree.n_level,
         n_point = (size_t)h->mesh->n_point;
  int failed = 0;
  for (int c = 0; c < h->tree.n_cluster; c++) {
    most = (size_t)h->row.rank[c] > most ? (size_t)h->row.rank[c] : most;
    most = (size_t)h->column.rank[c] > most ? (size_t)h->column.rank[c] : most;
  }
#pragma omp parallel default(none) shared(s, k, most, n, level, n_point) reduction(| : failed)
  {
    struct space space = {.most = most,
                          .v = rad_alloc((level + 2) * most, sizeof(double)),
                          .share = rad_alloc(n_point, sizeof(double))};
    double *row = rad_alloc(n, sizeof(double));
    int done = space.v && space.share && row;
    failed |= !done;
#pragma omp for schedule(dynamic)
    for (size_t g = 0; g < n; g++) {
      if (!done)
        continue;
      memset(row, 0, sizeof(double) * n);
      set_row(s, (int)g, &space, row);
      for (size_t j = 0; j < n; j++)
        k[g + n * j] = row[j];
    }
    free(space.v);
    free(space.share);
    free(row);
  }
  return !failed;
}

enum rad_code rad_coarse_h2(const struct rad_h2 *h, const struct rad_aggregates *a, double *k,
                            struct rad_error *e) {
  struct sums s = {.h = h, .a = a};
  int done = make_sums(&s) && set_rows(&s, k);
  free(s.at);
  free(s.s);
  return done ? RAD_OK : rad_fail_memory(e, "the preconditioner", 8.0 * h->mesh->n_point);
}
