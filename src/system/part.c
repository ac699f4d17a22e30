#include "system/part.h"

#include "system/facets.h"

/* Subtrees that bases are shared out by have at most 1/SHARES of a part's unknowns. */
enum { SHARES = 8 };

/* The part that a unit belongs to, when units of this weight come before it. */
static int owner(double before, double total, int n) {
  int part = total > 0 ? (int)(before / total * n) : 0;
  return 1 + (part < n ? part : n - 1);
}

/* A unit first .. end - 1 that follows others of some weight. */
static void add(struct rad_part_number p, double before, double total, int first, int end,
                struct rad_part_range *r) {
  if (owner(before, total, p.n) != p.number)
    return;
  if (r->first == r->end)
    r->first = first;
  r->end = end;
}

/* Points that see a triangle. */
static double points_before(const struct rad_dense *dense, int source) {
  const struct rad_mesh *mesh = dense->mesh;
  int n = mesh->scene->n_triangle;
  double sum = 0;
  for (int i = 0; i < n; i++)
    if (dense->sees[(size_t)i * (size_t)n + (size_t)source])
      sum += mesh->point_first[i + 1] - mesh->point_first[i];
  return sum;
}

/* Units of columns with their weights: patches, or groups of facets. With r NULL only their sum. */
static double walk_columns(const struct rad_dense *dense, struct rad_part_number p, double total,
                           struct rad_part_range *r) {
  const struct rad_mesh *mesh = dense->mesh;
  double before = 0, seen = 0;
  int n_unit = mesh->n_patch, by_facets = rad_dense_is_by_facets(dense);
  if (by_facets)
    n_unit = (int)rad_facets_tasks(mesh);
  for (int u = 0, triangle = -1; u < n_unit; u++) {
    int first = by_facets ? u * RAD_FACET_COLUMNS : mesh->element[mesh->element_first[u]].first;
    int end = u + 1 == n_unit ? mesh->n_point
              : by_facets     ? first + RAD_FACET_COLUMNS
                              : mesh->element[mesh->element_first[u + 1]].first;
    int own = by_facets ? first : mesh->patch[u].triangle;
    if (own != triangle)
      seen = points_before(dense, own);
    triangle = own;
    if (r)
      add(p, before, total, first, end, r);
    before += seen * (end - first);
  }
  return before;
}

struct rad_part_range rad_part_columns(const struct rad_dense *dense, struct rad_part_number p) {
  struct rad_part_range r = {0};
  walk_columns(dense, p, walk_columns(dense, p, 0, NULL), &r);
  return r;
}

struct rad_part_range rad_part_clusters(const struct rad_h2 *h, struct rad_part_number p) {
  const size_t *near = h->blocks.near.first, *sector = h->blocks.sector.first;
  struct rad_part_range r = {0};
  double total = (double)(h->near.n + h->sector.n);
  for (int t = 0; t < h->tree.n_cluster; t++) /* `at` has one more entry than there are blocks */
    add(p, (double)(h->near.at[near[t]] + h->sector.at[sector[t]]), total, t, t + 1, &r);
  return r;
}

enum rad_code rad_part_mark_dense(struct rad_dense *dense, struct rad_part_number p,
                                  struct rad_error *e) {
  struct rad_part_range own = rad_part_columns(dense, p);
  return rad_dense_set_done(dense, own.first, own.end, 1, e);
}

void rad_part_mark_h2(struct rad_h2 *h, struct rad_part_number p) {
  const struct rad_cluster *cluster = h->tree.cluster;
  struct rad_part_range own = rad_part_clusters(h, p);
  for (int t = 0; t < h->tree.n_cluster; t++)
    h->near_done[t] = t < own.first || t >= own.end;
  int n = h->mesh->n_point, most = n / (SHARES * p.n);
  double before = 0;
  for (int s = 0; s < 2; s++) {
    unsigned char *state = h->basis[s].state;
    for (int c = 0; c < h->tree.n_cluster; c++) {
      int below = cluster[c].child < 0 || cluster[c].n <= most, parent = cluster[c].parent;
      if (!below || (parent >= 0 && cluster[parent].n <= most))
        continue; /* not the root of a subtree */
      if (owner(before, 2.0 * n, p.n) != p.number)
        state[c] = RAD_BASIS_ELSEWHERE;
      before += cluster[c].n;
    }
    for (int c = h->tree.n_cluster - 1; c >= 0; c--) /* children come after parents */
      if (cluster[c].child >= 0 && state[cluster[c].child] == RAD_BASIS_ELSEWHERE &&
          state[cluster[c].child + 1] == RAD_BASIS_ELSEWHERE)
        state[c] = RAD_BASIS_ELSEWHERE;
  }
}
