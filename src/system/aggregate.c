#include "system/aggregate.h"

#include <stdlib.h>

#include "base/memory.h"

enum { HALVINGS = 80 };
#define APART 1e-6 /* sizes that are equal by symmetry are told apart by their place */

/* A cut through the tree: what is no wider than `most` stays whole. first NULL: only counted. */
struct cut {
  const struct rad_tree *tree;
  double most;
  int n, *first, *cluster;
};

static int is_small(const struct cut *c, double size, int place) {
  return size * (1 + APART * place / c->tree->mesh->n_point) <= c->most;
}

static void put(struct cut *c, int cluster, int place) {
  if (c->first) {
    c->first[c->n] = place;
    c->cluster[c->n] = cluster;
  }
  c->n++;
}

/* The elements of a leaf that is too wide, whole or unknown by unknown. */
static void divide_leaf(struct cut *c, int leaf) {
  const struct rad_cluster *l = &c->tree->cluster[leaf];
  for (int i = l->element, place = l->first; i < l->element + l->n_element; i++) {
    int element = c->tree->element[i], n = c->tree->mesh->element[element].n_function;
    double low[2], high[2];
    rad_element_box(c->tree, element, low, high);
    int whole = n == 1 || is_small(c, hypot(high[0] - low[0], high[1] - low[1]), place);
    for (int f = 0; f < (whole ? 1 : n); f++)
      put(c, leaf, place + f);
    place += n;
  }
}

static void divide(struct cut *c, int cluster) {
  const struct rad_cluster *l = &c->tree->cluster[cluster];
  if (is_small(c, rad_cluster_diameter(l), l->first)) {
    put(c, cluster, l->first);
  } else if (l->child < 0) {
    divide_leaf(c, cluster);
  } else {
    divide(c, l->child);
    divide(c, l->child + 1);
  }
}

static int divide_all(struct cut *c) {
  c->n = 0;
  for (int t = 0; t < c->tree->mesh->scene->n_triangle; t++)
    divide(c, t);
  return c->n;
}

/* The least width with no more aggregates than `most`. */
static void find_width(struct cut *c, int most) {
  double low = 0, high = 2 * c->tree->mesh->scene->size;
  c->most = low;
  if (divide_all(c) <= most)
    return;
  for (int i = 0; i < HALVINGS; i++) {
    c->most = i < HALVINGS / 4 ? 0.1 * high : 0.5 * (low + high);
    if (divide_all(c) <= most)
      high = c->most;
    else
      low = c->most;
  }
  c->most = high;
}

/* Parts of the unknowns in the areas of their aggregates. */
static void set_weights(const struct rad_tree *tree, struct rad_aggregates *a) {
  const struct rad_mesh *mesh = tree->mesh;
  for (int i = 0, place = 0; i < mesh->n_element; i++) {
    int element = tree->element[i], n = mesh->element[element].n_function;
    double share = rad_element_area(mesh, element) / n;
    for (int f = 0; f < n; f++)
      a->weight[place++] = share;
  }
  for (int g = 0; g < a->n; g++) {
    double sum = 0;
    for (int i = a->first[g]; i < a->first[g + 1]; i++)
      sum += a->weight[i];
    for (int i = a->first[g]; i < a->first[g + 1]; i++) {
      a->weight[i] /= sum;
      a->of[i] = g;
    }
  }
}

enum rad_code rad_aggregates_build(const struct rad_tree *tree, int most, struct rad_aggregates *a,
                                   struct rad_error *e) {
  struct cut c = {.tree = tree};
  size_t n_point = (size_t)tree->mesh->n_point;
  find_width(&c, most);
  size_t n = (size_t)divide_all(&c);
  *a = (struct rad_aggregates){.n = (int)n,
                               .first = rad_alloc(n + 1, sizeof(int)),
                               .cluster = rad_alloc(n, sizeof(int)),
                               .of = rad_alloc(n_point, sizeof(int)),
                               .weight = rad_alloc(n_point, sizeof(double))};
  if (!a->first || !a->cluster || !a->of || !a->weight)
    return rad_fail_memory(e, "the aggregates", 12.0 * (double)n_point);
  c.first = a->first;
  c.cluster = a->cluster;
  divide_all(&c);
  a->first[n] = (int)n_point;
  set_weights(tree, a);
  return RAD_OK;
}

void rad_aggregates_free(struct rad_aggregates *a) {
  free(a->first);
  free(a->cluster);
  free(a->of);
  free(a->weight);
  *a = (struct rad_aggregates){0};
}
