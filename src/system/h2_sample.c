/* What a build takes, from samples of its work on this machine. */
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "system/h2.h"
#include "system/h2_basis.h"
#include "system/h2_near.h"

enum { SAMPLES = 12 };

/* Near and sector entries of a target. */
static double entries_of(const struct rad_h2 *h, int target) {
  const size_t *near = h->blocks.near.first, *sector = h->blocks.sector.first;
  return (double)(h->near.at[near[target + 1]] - h->near.at[near[target]]) +
         (double)(h->sector.at[sector[target + 1]] - h->sector.at[sector[target]]);
}

/* Near integrals of targets spread evenly over the entries; the others count as done. All threads
 * work, as they will. */
static enum rad_code sample_near(struct rad_h2 *h, const struct rad_rules *rules, double *seconds,
                                 struct rad_error *e) {
  double total = 0, so_far = 0, taken = 0;
  for (int t = 0; t < h->tree.n_cluster; t++)
    total += entries_of(h, t);
  for (int t = 0, picked = 0; t < h->tree.n_cluster; t++) {
    so_far += entries_of(h, t);
    h->near_done[t] = so_far * SAMPLES <= total * (picked + 0.5);
    if (!h->near_done[t]) {
      taken += entries_of(h, t);
      picked++;
    }
  }
  double start = rad_seconds();
  enum rad_code code = rad_h2_near(h, rules, e);
  *seconds = taken > 0 ? (rad_seconds() - start) * total / taken : 0;
  return code;
}

/* What a cluster costs, in what a leaf of `mean` far blocks does alone: a part for each block, and
 * what is inherited and cut, which also clusters without blocks have (measured). */
static double cost(double blocks, double mean) {
  return blocks > 0 ? 1.1 + 0.6 * blocks / mean : 0.5;
}

/* Bases of both sides and couplings, from leaves with far blocks. */
static enum rad_code sample_bases(const struct rad_h2 *h, double *seconds, struct rad_error *e) {
  struct rad_interpolation p;
  rad_interpolation_init(&p, h->tolerance);
  struct rad_basis_goal goal = {&p, &h->blocks.far, RAD_BASIS_ROW, h->tolerance, h->tolerance};
  const size_t *first = h->blocks.far.first;
  double leaves = 0, blocks = 0, seen = 0, sum = 0, one, all = 0;
  int taken = 0;
  for (int c = 0; c < h->tree.n_cluster; c++)
    if (h->tree.cluster[c].child < 0 && first[c + 1] > first[c]) {
      leaves++;
      blocks += (double)(first[c + 1] - first[c]);
    }
  enum rad_code code = RAD_OK;
  for (int c = 0; c < h->tree.n_cluster && !code; c++) {
    all += cost((double)(first[c + 1] - first[c]), blocks / leaves);
    if (h->tree.cluster[c].child < 0 && first[c + 1] > first[c] &&
        (seen += SAMPLES) > leaves * (taken + 0.5)) {
      code = rad_basis_sample(&h->tree, &goal, c, &one, e);
      sum += one;
      taken++;
    }
  }
  *seconds = taken ? 2 * all * sum / taken / omp_get_max_threads() : 0;
  return code;
}

enum rad_code rad_h2_sample(const struct rad_mesh *mesh, const struct rad_rules *rules,
                            double tolerance, double *seconds, struct rad_error *e) {
  struct rad_h2 h;
  double near = 0, bases = 0, start = rad_seconds();
  enum rad_code code = rad_h2_begin(mesh, tolerance, &h, e);
  double begin = rad_seconds() - start;
  if (!code)
    code = sample_near(&h, rules, &near, e);
  if (!code)
    code = sample_bases(&h, &bases, e);
  *seconds = begin + near + bases;
  rad_h2_free(&h);
  return code;
}
