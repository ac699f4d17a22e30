#include "system/coupling.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "system/sector.h"

/* What all need. Elements are numbered in the tree's order. */
struct search {
  const struct rad_operator *k;
  const struct rad_tree *tree;
  const double *area;
  int *of;    /* owned [n_point] element of a place */
  int *first; /* owned [n_element + 1] first place of an element */
  int *count;
  struct rad_partner *partner;
};

/* `other` becomes a partner of `one`, perhaps in place of the weakest. */
static void offer(const struct search *s, int one, int other, double light) {
  struct rad_partner *list = s->partner + (size_t)one * RAD_PARTNERS;
  double least = light / fmin(s->area[one], s->area[other]);
  int at = -1;
  if (one == other || !(light > 0))
    return;
  if (s->count[one] < RAD_PARTNERS) {
    at = s->count[one]++;
  } else {
    for (int i = 0; i < RAD_PARTNERS; i++) {
      double strength = list[i].light / fmin(s->area[one], s->area[list[i].other]);
      if (strength < least) {
        least = strength;
        at = i;
      }
    }
  }
  if (at >= 0)
    list[at] = (struct rad_partner){other, light};
}

/* The elements of a source leaf are offered to those of a target, where x [m, elements of the
 * target] says what a row of the block B [m, sources] is worth to each. */
static void offer_block(const struct search *s, const struct rad_h2_dense *dense, size_t at,
                        size_t m, int target, int n, int source, const double *x) {
  const struct rad_cluster *c = &s->tree->cluster[source];
  for (int other = c->element; other < c->element + c->n_element; other++)
    for (int g = 0; g < n; g++) {
      double sum = 0;
      for (int j = s->first[other] - c->first; j < s->first[other + 1] - c->first; j++)
        for (size_t i = 0; i < m; i++) {
          size_t entry = at + m * (size_t)j + i;
          sum += x[i + m * (size_t)g] * (dense->narrow ? dense->narrow[entry] : dense->wide[entry]);
        }
      offer(s, target + g, other, sum * s->area[target + g]);
    }
}

/* Near blocks of a leaf, sector blocks of it and of what it is a part of, for the leaf's elements.
 * x: [max(points, places), elements]. */
static void search_leaf(const struct search *s, int leaf, double *x) {
  const struct rad_h2 *h = s->k->h2;
  const struct rad_cluster *l = &s->tree->cluster[leaf];
  int n = l->n_element;
  size_t m = (size_t)l->n;
  memset(x, 0, sizeof(double) * m * (size_t)n);
  for (int i = 0; i < l->n; i++) {
    int g = s->of[l->first + i];
    x[(size_t)i + m * (size_t)(g - l->element)] = 1.0 / (s->first[g + 1] - s->first[g]);
  }
  for (size_t b = h->blocks.near.first[leaf]; b < h->blocks.near.first[leaf + 1]; b++)
    offer_block(s, &h->near, h->near.at[b], m, l->element, n, h->blocks.near.source[b], x);
  for (int up = leaf; up >= 0; up = s->tree->cluster[up].parent) {
    const struct rad_cluster *c = &s->tree->cluster[up];
    const double *spread = h->spread + h->spread_at[up];
    if (!(m = (size_t)h->place_count[up]))
      continue;
    memset(x, 0, sizeof(double) * m * (size_t)n);
    for (int i = l->first; i < l->first + l->n; i++) {
      int g = s->of[i];
      for (size_t p = 0; p < m; p++)
        x[p + m * (size_t)(g - l->element)] +=
            spread[(size_t)(i - c->first) + (size_t)c->n * p] / (s->first[g + 1] - s->first[g]);
    }
    for (size_t b = h->blocks.sector.first[up]; b < h->blocks.sector.first[up + 1]; b++)
      offer_block(s, &h->sector, h->sector.at[b], m, l->element, n, h->blocks.sector.source[b], x);
  }
}

static int search_h2(const struct search *s) {
  size_t most = RAD_MAX_PLACES, element = 1;
  int failed = 0;
  for (int c = 0; c < s->tree->n_cluster; c++) {
    const struct rad_cluster *l = &s->tree->cluster[c];
    if (l->child < 0 && (size_t)l->n > most)
      most = (size_t)l->n;
    if (l->child < 0 && (size_t)l->n_element > element)
      element = (size_t)l->n_element;
  }
#pragma omp parallel default(none) shared(s, most, element) reduction(| : failed)
  {
    double *x = rad_alloc(most * element, sizeof(double));
    failed |= !x;
#pragma omp for schedule(dynamic)
    for (int c = 0; c < s->tree->n_cluster; c++)
      if (x && s->tree->cluster[c].child < 0)
        search_leaf(s, c, x);
    free(x);
  }
  return !failed;
}

/* What all elements receive from one, which is what it receives from them: columns of the dense
 * matrix, which follow one another in memory, and not rows. */
static void search_columns(const struct search *s, int one, double *sum) {
  size_t n = (size_t)s->k->n;
  const int *unknown = s->tree->unknown;
  memset(sum, 0, sizeof(double) * n);
  for (int j = s->first[one]; j < s->first[one + 1]; j++) {
    const double *column = s->k->dense->k + n * (size_t)unknown[j];
    for (size_t i = 0; i < n; i++)
      sum[i] += column[i];
  }
  for (int g = 0; g < s->tree->mesh->n_element; g++) {
    double mean = 0;
    for (int i = s->first[g]; i < s->first[g + 1]; i++)
      mean += sum[unknown[i]] / (s->first[g + 1] - s->first[g]);
    offer(s, one, g, mean * s->area[g]);
  }
}

static int search_dense(const struct search *s) {
  int failed = 0;
#pragma omp parallel default(none) shared(s) reduction(| : failed)
  {
    double *sum = rad_alloc((size_t)s->k->n, sizeof(double));
    failed |= !sum;
#pragma omp for schedule(dynamic)
    for (int one = 0; one < s->tree->mesh->n_element; one++)
      if (sum)
        search_columns(s, one, sum);
    free(sum);
  }
  return !failed;
}

enum rad_code rad_coupling(const struct rad_operator *k, const struct rad_tree *tree,
                           const double *area, int *count, struct rad_partner *partner,
                           struct rad_error *e) {
  int n = tree->mesh->n_element, place = 0;
  struct search s = {k, tree, area, .count = count, .partner = partner};
  s.of = rad_alloc((size_t)k->n, sizeof(int));
  s.first = rad_alloc((size_t)n + 1, sizeof(int));
  int done = s.of && s.first;
  for (int i = 0; i < n && done; i++) {
    s.first[i] = place;
    count[i] = 0;
    for (int f = tree->mesh->element[tree->element[i]].n_function; f > 0; f--)
      s.of[place++] = i;
  }
  if (done) {
    s.first[n] = place;
    done = k->h2 ? search_h2(&s) : search_dense(&s);
  }
  free(s.of);
  free(s.first);
  return done ? RAD_OK : rad_fail_memory(e, "the preconditioner", 8.0 * k->n);
}
