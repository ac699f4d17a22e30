#include "system/local.h"

#include <lapacke.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "system/stream.h"

double rad_local_bytes(double n, int n_band) {
  return sizeof(float) * n * fmin(n, RAD_GROUP) * n_band;
}

/* The first of the ascending places that is not before `least`. */
static int lower_bound(int n, const int *place, int least) {
  int low = 0;
  while (n > 0) {
    int half = n / 2;
    if (place[low + half] < least) {
      low += half + 1;
      n -= half + 1;
    } else {
      n = half;
    }
  }
  return low;
}

static inline double entry(const struct rad_h2_dense *dense, size_t at) {
  return dense->narrow ? (double)dense->narrow[at] : dense->wide[at];
}

/* Rows from .. to of a group's block a [n, n], the group's points in one leaf, from the near blocks
 * of the leaf. */
static void fill_near(const struct rad_h2 *h, int leaf, int n, const int *place, int from, int to,
                      double *a) {
  const struct rad_cluster *t = &h->tree.cluster[leaf];
  for (size_t b = h->blocks.near.first[leaf]; b < h->blocks.near.first[leaf + 1]; b++) {
    const struct rad_cluster *s = &h->tree.cluster[h->blocks.near.source[b]];
    for (int j = lower_bound(n, place, s->first); j < n && place[j] < s->first + s->n; j++) {
      size_t at = h->near.at[b] + (size_t)t->n * (size_t)(place[j] - s->first);
      for (int i = from; i < to; i++)
        a[i + (size_t)n * (size_t)j] = entry(&h->near, at + (size_t)(place[i] - t->first));
    }
  }
}

/* The same from the sector blocks of a cluster that holds these points. */
static void fill_sector(const struct rad_h2 *h, int cluster, int n, const int *place, int from,
                        int to, double *a) {
  const struct rad_cluster *t = &h->tree.cluster[cluster];
  size_t m = (size_t)h->place_count[cluster], rows = (size_t)t->n;
  const double *spread = h->spread + h->spread_at[cluster];
  for (size_t b = h->blocks.sector.first[cluster]; m && b < h->blocks.sector.first[cluster + 1];
       b++) {
    const struct rad_cluster *s = &h->tree.cluster[h->blocks.sector.source[b]];
    for (int j = lower_bound(n, place, s->first); j < n && place[j] < s->first + s->n; j++) {
      size_t at = h->sector.at[b] + m * (size_t)(place[j] - s->first);
      for (int i = from; i < to; i++) {
        double sum = 0;
        for (size_t p = 0; p < m; p++)
          sum += spread[(size_t)(place[i] - t->first) + rows * p] * entry(&h->sector, at + p);
        a[i + (size_t)n * (size_t)j] = sum;
      }
    }
  }
}

/* The block of K of one group. leaf_of [n_point]: leaf of a place. */
static void fill(const struct rad_operator *k, const int *leaf_of, int n, const int *place,
                 const int *unknown, double *a) {
  memset(a, 0, sizeof(double) * (size_t)n * (size_t)n);
  if (k->dense) {
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++)
        a[i + (size_t)n * (size_t)j] =
            k->dense->k[(size_t)unknown[i] + (size_t)k->n * (size_t)unknown[j]];
    return;
  }
  for (int from = 0, to; from < n; from = to) {
    int leaf = leaf_of[place[from]];
    for (to = from; to < n && leaf_of[place[to]] == leaf;)
      to++;
    fill_near(k->h2, leaf, n, place, from, to, a);
    for (int up = leaf; up >= 0; up = k->h2->tree.cluster[up].parent)
      fill_sector(k->h2, up, n, place, from, to, a);
  }
}

/* I - D K inverted; the identity in place of what is singular. a [n, n]: scratch. */
static void invert(size_t n, const double *k, const double *rho, const int *unknown, double *a,
                   int *pivot, float *inverse) {
  int m = (int)n;
  for (size_t j = 0; j < n; j++)
    for (size_t i = 0; i < n; i++)
      a[i + n * j] = (i == j) - rho[unknown[i]] * k[i + n * j];
  int failed = LAPACKE_dgetrf(LAPACK_COL_MAJOR, m, m, a, m, pivot) ||
               LAPACKE_dgetri(LAPACK_COL_MAJOR, m, a, m, pivot);
  for (size_t i = 0; i < n * n; i++)
    inverse[i] = failed ? (float)(i % (n + 1) == 0) : (float)a[i];
}

static enum rad_code invert_all(const struct rad_operator *k, const int *leaf_of,
                                struct rad_local *l, struct rad_error *e) {
  const struct rad_groups *g = &l->groups;
  size_t most = (size_t)g->most;
  int failed = 0;
#pragma omp parallel default(none) shared(k, leaf_of, l, g, most) reduction(| : failed)
  {
    double *block = rad_alloc(2 * most * most, sizeof(double));
    int *pivot = rad_alloc(most, sizeof(int)), done = block && pivot;
    failed |= !done;
#pragma omp for schedule(dynamic)
    for (int i = 0; i < g->n; i++) {
      int first = g->first[i], n = g->first[i + 1] - first;
      if (!done)
        continue;
      fill(k, leaf_of, n, g->place + first, g->unknown + first, block);
      for (int f = 0; f < l->n_inverse; f++)
        invert((size_t)n, block, l->inverse[f].rho, g->unknown + first, block + most * most, pivot,
               l->inverse[f].inverse + l->at[i]);
    }
    free(block);
    free(pivot);
  }
  return failed ? rad_fail_memory(e, "the preconditioner", 16.0 * (double)(most * most)) : RAD_OK;
}

/* Memory for the inverses of all systems. */
static enum rad_code begin(int n_system, const double *const *rho, struct rad_local *l,
                           struct rad_error *e) {
  const struct rad_groups *g = &l->groups;
  l->at = rad_alloc((size_t)g->n + 1, sizeof(size_t));
  l->inverse = rad_calloc((size_t)n_system, sizeof *l->inverse);
  if (!l->at || !l->inverse)
    return rad_fail_memory(e, "the preconditioner", 8.0 * g->n);
  l->at[0] = 0;
  for (int i = 0; i < g->n; i++) {
    size_t n = (size_t)(g->first[i + 1] - g->first[i]);
    l->at[i + 1] = l->at[i] + n * n;
  }
  for (int s = 0; s < n_system; s++) {
    int known = 0;
    for (int f = 0; f < l->n_inverse; f++)
      known |= l->inverse[f].rho == rho[s];
    if (known)
      continue;
    struct rad_local_inverse *own = &l->inverse[l->n_inverse++];
    own->rho = rho[s];
    own->inverse = rad_pages_alloc(sizeof(float) * l->at[g->n]);
    if (!own->inverse)
      return rad_fail_memory(e, "the preconditioner", 4.0 * (double)l->at[g->n]);
  }
  return RAD_OK;
}

enum rad_code rad_local_build(const struct rad_operator *k, const struct rad_tree *tree,
                              int n_system, const double *const *rho, struct rad_local *l,
                              struct rad_error *e) {
  *l = (struct rad_local){0};
  int *leaf_of = rad_alloc((size_t)k->n, sizeof(int));
  enum rad_code code = leaf_of ? RAD_OK : rad_fail_memory(e, "the preconditioner", 4.0 * k->n);
  for (int c = 0; c < tree->n_cluster && !code; c++)
    for (int i = 0; tree->cluster[c].child < 0 && i < tree->cluster[c].n; i++)
      leaf_of[tree->cluster[c].first + i] = c;
  if (!code)
    code = rad_groups_build(k, tree, &l->groups, e);
  if (!code)
    code = begin(n_system, rho, l, e);
  if (!code)
    code = invert_all(k, leaf_of, l, e);
  free(leaf_of);
  return code;
}

void rad_local_free(struct rad_local *l) {
  for (int f = 0; f < l->n_inverse; f++)
    rad_pages_free(l->inverse[f].inverse, sizeof(float) * l->at[l->groups.n]);
  free(l->inverse);
  free(l->at);
  rad_groups_free(&l->groups);
  *l = (struct rad_local){0};
}

void rad_local_apply(const struct rad_local *l, const double *rho, int group, const double *v,
                     double *z) {
  const struct rad_local_inverse *f = l->inverse;
  int first = l->groups.first[group];
  size_t n = (size_t)(l->groups.first[group + 1] - first);
  const int *unknown = l->groups.unknown + first;
  double x[RAD_MOST_COLUMNS] = {0}, y[RAD_MOST_COLUMNS] = {0};
  while (f->rho != rho)
    f++;
  for (size_t i = 0; i < n; i++)
    x[i] = v[unknown[i]];
  rad_add_product_narrow(n, n, f->inverse + l->at[group], x, y);
  for (size_t i = 0; i < n; i++)
    z[unknown[i]] = y[i];
}
