#include <stdlib.h>

#include "base/memory.h"
#include "system/h2.h"
#include "system/interpolate.h"

/* Ranks as measured (docs/performance.md): of clusters with far blocks, and how they fall from a
 * cluster to its children that have none. */
#define RANK_PER_DIGIT 3.5
#define RANK_AT_NONE 2.0
#define FALL 0.82

/* Predicted ranks of one side. */
static void set_ranks(const struct rad_tree *tree, const unsigned char *has_blocks, double most,
                      double *rank) {
  for (int c = 0; c < tree->n_cluster; c++) {
    const struct rad_cluster *cluster = &tree->cluster[c];
    double own = has_blocks[c] ? most : cluster->parent < 0 ? 0 : FALL * rank[cluster->parent];
    if (cluster->parent >= 0)
      own = fmax(own, FALL * rank[cluster->parent]);
    rank[c] = own;
  }
  for (int c = 0; c < tree->n_cluster; c++)
    rank[c] = fmin(rank[c], 0.8 * tree->cluster[c].n);
}

/* Numbers in the bases of one side. */
static double count_bases(const struct rad_tree *tree, const double *rank) {
  double sum = 0;
  for (int c = 0; c < tree->n_cluster; c++) {
    const struct rad_cluster *cluster = &tree->cluster[c];
    double rows = cluster->n;
    if (cluster->child >= 0)
      rows = rank[cluster->child] + rank[cluster->child + 1];
    sum += rows * fmin(rank[c], rows);
  }
  return sum;
}

/* Numbers in both bases and in the far blocks; has: [2, n_cluster], rank: likewise. */
static void count(const struct rad_tree *tree, const struct rad_blocks *blocks, double digits,
                  unsigned char *has, double *rank, double *bases, double *far) {
  size_t n = (size_t)tree->n_cluster;
  const struct rad_block_list *list = &blocks->far;
  for (size_t t = 0; t < n; t++)
    for (size_t b = list->first[t]; b < list->first[t + 1]; b++)
      has[t] = has[n + (size_t)list->source[b]] = 1;
  *bases = *far = 0;
  for (size_t side = 0; side < 2; side++) {
    set_ranks(tree, has + n * side, RANK_AT_NONE + RANK_PER_DIGIT * digits, rank + n * side);
    *bases += count_bases(tree, rank + n * side);
  }
  for (size_t t = 0; t < n; t++)
    for (size_t b = list->first[t]; b < list->first[t + 1]; b++)
      *far += rank[t] * rank[n + (size_t)list->source[b]];
}

enum rad_code rad_h2_predict(const struct rad_mesh *mesh, double tolerance,
                             struct rad_h2_plan *plan, struct rad_error *e) {
  struct rad_tree tree = {0};
  struct rad_blocks blocks = {0};
  enum rad_code code = rad_h2_divide(mesh, RAD_LEAF, tolerance, 1, &tree, &blocks, e);
  size_t n = (size_t)tree.n_cluster;
  unsigned char *has = rad_calloc(2 * n, 1);
  double *rank = rad_alloc(2 * n, sizeof(double)), bases, far;
  if (!code && (!has || !rank))
    code = rad_fail_memory(e, "the prediction", 18.0 * (double)n);
  if (!code) {
    count(&tree, &blocks, -log10(tolerance), has, rank, &bases, &far);
    double lists =
        12.0 * (double)(blocks.far.first[n] + blocks.near.first[n] + blocks.sector.first[n]);
    plan->near_entries = blocks.near_entries + blocks.sector_entries;
    plan->bytes = plan->near_entries * (double)rad_h2_near_size(tolerance) + 8 * (bases + far) +
                  lists + 4.0 * mesh->n_point +
                  (double)n * (double)(sizeof(struct rad_cluster) + 48);
    struct rad_interpolation p;
    rad_interpolation_init(&p, tolerance);
    double change = 0; /* from polynomials to bases, while these are made */
    for (size_t c = 0; c < 2 * n; c++)
      change += 8.0 * p.n * rank[c];
    plan->bytes_build = plan->bytes + 16 * bases + change + 100.0 * mesh->n_point;
  }
  free(has);
  free(rank);
  rad_blocks_free(&blocks);
  rad_tree_free(&tree);
  return code;
}
