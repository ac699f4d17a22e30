#include "system/h2.h"

#include <cblas.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "base/stop.h"
#include "system/h2_leaf.h"
#include "system/h2_near.h"
#include "visibility/visibility.h"

/* Below this distance over the tolerance, rounding of coordinates shows in the kernel
 * (theory 14.1). */
#define ROUNDING 4e-15
#define SHARE 0.1 /* of the tolerance: the cut of one block's basis */

enum rad_code rad_h2_divide(const struct rad_mesh *mesh, int leaf, double tolerance, int sectors,
                            struct rad_tree *tree, struct rad_blocks *blocks, struct rad_error *e) {
  struct rad_interpolation p;
  rad_interpolation_init(&p, tolerance);
  enum rad_code code = rad_tree_build(mesh, leaf, tree, e);
  if (!code)
    code = rad_blocks_build(tree, sectors ? p.q : 0, ROUNDING * mesh->scene->size / tolerance,
                            blocks, e);
  return code;
}

/* Where a side's matrices and coefficients begin, from the ranks. */
static enum rad_code set_places(const struct rad_tree *tree, struct rad_h2_side *side,
                                struct rad_error *e) {
  size_t n = (size_t)tree->n_cluster, at = 0, place = 0;
  side->at = rad_alloc(n, sizeof(size_t));
  side->place = rad_alloc(n + 1, sizeof(size_t));
  if (!side->at || !side->place)
    return rad_fail_memory(e, "the bases of the clusters", 16.0 * (double)n);
  for (size_t c = 0; c < n; c++) {
    side->at[c] = at;
    side->place[c] = place;
    at += (size_t)rad_basis_rows(tree, side->rank, (int)c) * (size_t)side->rank[c];
    place += (size_t)side->rank[c];
  }
  side->place[n] = place;
  side->n_data = at;
  side->data = rad_pages_alloc(sizeof(double) * at);
  return side->data ? RAD_OK : rad_fail_memory(e, "the bases of the clusters", 8.0 * (double)at);
}

enum rad_code rad_h2_far_begin(struct rad_h2 *h, struct rad_error *e) {
  size_t total = h->blocks.far.first[h->tree.n_cluster];
  double ranks = 0;
  enum rad_code code = set_places(&h->tree, &h->row, e);
  if (!code)
    code = set_places(&h->tree, &h->column, e);
  h->far_at = rad_alloc(total, sizeof(size_t));
  if (!code && !h->far_at)
    code = rad_fail_memory(e, "the far blocks", 8.0 * (double)total);
  for (int t = 0; t < h->tree.n_cluster && !code; t++)
    for (size_t b = h->blocks.far.first[t]; b < h->blocks.far.first[t + 1]; b++) {
      int k_t = h->row.rank[t], k_s = h->column.rank[h->blocks.far.source[b]];
      h->far_at[b] = h->n_far;
      h->n_far += (size_t)k_t * (size_t)k_s;
      ranks += 0.5 * (k_t + k_s);
    }
  h->mean_rank = total ? ranks / (double)total : 0;
  if (!code && !(h->far = rad_pages_alloc(sizeof(double) * h->n_far)))
    code = rad_fail_memory(e, "the far blocks", 8.0 * (double)h->n_far);
  return code;
}

/* A basis moves into one piece of memory, cluster by cluster. */
static void pack(struct rad_basis *basis, struct rad_h2_side *side) {
  for (int c = 0; c < basis->tree->n_cluster; c++) {
    size_t size = (size_t)rad_basis_rows(basis->tree, basis->rank, c) * (size_t)basis->rank[c];
    memcpy(side->data + side->at[c], basis->matrix[c], sizeof(double) * size);
    free(basis->matrix[c]);
    basis->matrix[c] = NULL;
  }
}

/* The moments were divided by the roots of the shares: leaves of columns get them back. */
static void weigh_columns(const struct rad_tree *tree, struct rad_basis *basis, double *share) {
  for (int c = 0; c < tree->n_cluster; c++) {
    const struct rad_cluster *leaf = &tree->cluster[c];
    if (leaf->child >= 0)
      continue;
    rad_leaf_shares(tree, leaf, share);
    for (int k = 0; k < basis->rank[c]; k++)
      for (int i = 0; i < leaf->n; i++)
        basis->matrix[c][(size_t)k * (size_t)leaf->n + (size_t)i] *= sqrt(share[i]);
  }
}

/* The far blocks by source: who is a source's partner. */
static enum rad_code turn_list(const struct rad_tree *tree, const struct rad_block_list *list,
                               struct rad_block_list *turned, struct rad_error *e) {
  size_t n = (size_t)tree->n_cluster, total = list->first[n];
  turned->first = rad_calloc(n + 2, sizeof(size_t));
  turned->source = rad_alloc(total, sizeof(int));
  if (!turned->first || !turned->source)
    return rad_fail_memory(e, "the list of blocks", 4.0 * (double)total);
  for (size_t b = 0; b < total; b++)
    turned->first[list->source[b] + 2]++;
  for (size_t s = 0; s < n; s++)
    turned->first[s + 2] += turned->first[s + 1];
  for (size_t t = 0; t < n; t++)
    for (size_t b = list->first[t]; b < list->first[t + 1]; b++)
      turned->source[turned->first[list->source[b] + 1]++] = (int)t;
  return RAD_OK;
}

/* S = R_t G R_s^T for the far blocks of one target; work: [2, n_node^2]. */
static void couple(struct rad_h2 *h, const struct rad_interpolation *p, int target, double *work) {
  const struct rad_cluster *cluster = h->tree.cluster;
  const struct rad_basis *row = &h->basis[0], *column = &h->basis[1];
  int n = p->n, k_t = row->rank[target];
  double *kernel = work, *half = work + (size_t)n * (size_t)n;
  for (size_t b = h->blocks.far.first[target]; b < h->blocks.far.first[target + 1]; b++) {
    int source = h->blocks.far.source[b], k_s = column->rank[source];
    if (!k_t || !k_s)
      continue;
    rad_interpolation_kernel(p, &h->tree, &cluster[target], &cluster[source], kernel);
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, k_t, n, n, 1, row->change[target], n,
                kernel, n, 0, half, k_t);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, k_t, k_s, n, 1, half, k_t,
                column->change[source], n, 0, h->far + h->far_at[b], k_t);
  }
}

static enum rad_code couple_all(struct rad_h2 *h, const struct rad_interpolation *p,
                                struct rad_error *e) {
  size_t node = (size_t)p->n, n_thread = (size_t)omp_get_max_threads();
  double *work = rad_alloc(2 * node * node * n_thread, sizeof(double));
  if (!work)
    return rad_fail_memory(e, "the far blocks", 16.0 * (double)(node * node * n_thread));
  struct rad_progress *progress = h->mesh->scene->progress;
  rad_progress_begin(progress, "far clusters", h->tree.n_cluster);
#pragma omp parallel for schedule(dynamic) default(none) shared(h, p, work, node, progress)
  for (int t = 0; t < h->tree.n_cluster; t++) {
    if (!rad_stop_asked())
      couple(h, p, t, work + 2 * node * node * (size_t)omp_get_thread_num());
    rad_progress_add(progress, 1);
  }
  free(work);
  return rad_stop_asked() ? rad_fail_stopped(e) : RAD_OK;
}

/* Both bases, as far as they are missing. */
static enum rad_code build_bases(struct rad_h2 *h, const struct rad_interpolation *p,
                                 struct rad_error *e) {
  struct rad_block_list by_source = {0};
  struct rad_basis_goal goal = {p, &h->blocks.far, RAD_BASIS_ROW, h->tolerance,
                                SHARE * h->tolerance};
  enum rad_code code = rad_basis_build(&h->tree, &goal, &h->basis[0], e);
  if (!code)
    code = turn_list(&h->tree, &h->blocks.far, &by_source, e);
  goal.far = &by_source;
  goal.kind = RAD_BASIS_COLUMN;
  if (!code)
    code = rad_basis_build(&h->tree, &goal, &h->basis[1], e);
  free(by_source.first);
  free(by_source.source);
  return code;
}

/* The far blocks from finished bases, which end here. */
static enum rad_code build_far(struct rad_h2 *h, const struct rad_interpolation *p,
                               struct rad_error *e) {
  struct rad_h2_side *side[2] = {&h->row, &h->column};
  double *share = rad_alloc((size_t)h->mesh->n_point, sizeof(double));
  enum rad_code code = share ? RAD_OK : rad_fail_memory(e, "the bases of the clusters", 0);
  for (int s = 0; s < 2 && !code; s++) {
    size_t bytes = sizeof(int) * (size_t)h->tree.n_cluster;
    if ((side[s]->rank = rad_alloc(bytes, 1)))
      memcpy(side[s]->rank, h->basis[s].rank, bytes);
    else
      code = rad_fail_memory(e, "the bases of the clusters", (double)bytes);
  }
  if (!code)
    code = rad_h2_far_begin(h, e);
  if (!code)
    code = couple_all(h, p, e);
  if (!code) {
    weigh_columns(&h->tree, &h->basis[1], share);
    for (int s = 0; s < 2; s++) {
      pack(&h->basis[s], side[s]);
      rad_basis_free(&h->basis[s]);
    }
    h->far_done = 1;
  }
  free(share);
  return code;
}

static double bytes_of(const struct rad_h2 *h) {
  double clusters = h->tree.n_cluster, far = (double)h->blocks.far.first[h->tree.n_cluster];
  double near =
      (double)(h->blocks.near.first[h->tree.n_cluster] + h->blocks.sector.first[h->tree.n_cluster]);
  return 8.0 * (double)(h->row.n_data + h->column.n_data + h->n_far) +
         (double)(h->near.n + h->sector.n) * (double)rad_h2_near_size(h->tolerance) +
         8.0 * (double)h->n_spread + 12 * (far + near) +
         clusters * (double)(sizeof(struct rad_cluster) + 48) + 4.0 * h->mesh->n_point;
}

enum rad_code rad_h2_begin(const struct rad_mesh *mesh, double tolerance, struct rad_h2 *h,
                           struct rad_error *e) {
  *h = (struct rad_h2){
      .mesh = mesh, .sees = mesh->scene->visibility->sight, .tolerance = fmax(tolerance, 1e-13)};
  double start = rad_seconds();
  enum rad_code code = rad_h2_divide(mesh, RAD_LEAF, h->tolerance, 1, &h->tree, &h->blocks, e);
  h->seconds_blocks = rad_seconds() - start;
  for (int s = 0; s < 2 && !code; s++)
    code = rad_basis_begin(&h->tree, &h->basis[s], e);
  if (!code)
    code = rad_h2_near_begin(h, rad_h2_near_size(h->tolerance) == sizeof(float), e);
  return code;
}

enum rad_code rad_h2_part(struct rad_h2 *h, const struct rad_rules *rules, struct rad_error *e) {
  struct rad_interpolation p;
  rad_interpolation_init(&p, h->tolerance);
  enum rad_code code = build_bases(h, &p, e);
  return code ? code : rad_h2_near(h, rules, e);
}

enum rad_code rad_h2_finish(struct rad_h2 *h, const struct rad_rules *rules, struct rad_error *e) {
  struct rad_interpolation p;
  enum rad_code code = RAD_OK;
  double start = rad_seconds();
  rad_interpolation_init(&p, h->tolerance);
  if (!h->far_done)
    code = build_bases(h, &p, e);
  h->seconds_bases = rad_seconds() - start;
  start = rad_seconds();
  if (!code && !h->far_done)
    code = build_far(h, &p, e);
  h->seconds_far = rad_seconds() - start;
  start = rad_seconds();
  if (!code)
    code = rad_h2_near(h, rules, e);
  h->seconds_near = rad_seconds() - start;
  if (!code)
    code = rad_h2_workspace(h, e);
  if (!code)
    h->bytes = bytes_of(h);
  return code;
}

enum rad_code rad_h2_build(const struct rad_mesh *mesh, const struct rad_rules *rules,
                           double tolerance, struct rad_h2 *h, struct rad_error *e) {
  enum rad_code code = rad_h2_begin(mesh, tolerance, h, e);
  return code ? code : rad_h2_finish(h, rules, e);
}

static void free_side(struct rad_h2_side *side) {
  free(side->rank);
  free(side->at);
  free(side->place);
  rad_pages_free(side->data, sizeof(double) * side->n_data);
}

static void free_dense(struct rad_h2_dense *dense) {
  free(dense->at);
  rad_pages_free(dense->wide, sizeof(double) * dense->n);
  rad_pages_free(dense->narrow, sizeof(float) * dense->n);
}

void rad_h2_free(struct rad_h2 *h) {
  rad_pages_free(h->work, sizeof(double) * RAD_MOST_VECTORS * h->n_work);
  free_side(&h->row);
  free_side(&h->column);
  rad_pages_free(h->far, sizeof(double) * h->n_far);
  free_dense(&h->near);
  free_dense(&h->sector);
  free(h->place_count);
  free(h->spread_at);
  rad_pages_free(h->spread, sizeof(double) * h->n_spread);
  free(h->far_at);
  free(h->near_done);
  for (int s = 0; s < 2; s++)
    rad_basis_free(&h->basis[s]);
  rad_blocks_free(&h->blocks);
  rad_tree_free(&h->tree);
  *h = (struct rad_h2){0};
}
