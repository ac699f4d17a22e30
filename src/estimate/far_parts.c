#include "estimate/far_parts.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "system/h2_leaf.h"

/* The far block through which a source weighs most. */
struct partner {
  int target; /* -1: none */
  double weight;
};

static double most_weight(const double *weight, int triangle, int n_band) {
  double most = 0;
  for (int b = 0; b < n_band; b++)
    most = fmax(most, weight[triangle * n_band + b]);
  return most;
}

/* Of every source cluster, its ancestors' included. */
static void set_partners(const struct rad_once *o, int n_band, const double *weight,
                         struct partner *partner) {
  const struct rad_tree *tree = &o->tree;
  for (int c = 0; c < tree->n_cluster; c++)
    partner[c] = (struct partner){-1, 0};
  for (int t = 0; t < tree->n_cluster; t++) {
    double rho = most_weight(weight, tree->cluster[t].triangle, n_band);
    for (size_t b = o->blocks.far.first[t]; b < o->blocks.far.first[t + 1]; b++) {
      struct partner *p = &partner[o->blocks.far.source[b]];
      if (o->n_target[t] > 0 && rho * o->mean[b] > p->weight)
        *p = (struct partner){t, rho * o->mean[b]};
    }
  }
  for (int c = 0; c < tree->n_cluster; c++) {
    int parent = tree->cluster[c].parent;
    if (parent >= 0 && partner[parent].weight > partner[c].weight)
      partner[c] = partner[parent];
  }
}

/* largest: from the sources' largest integrals, block by block, down to the elements of leaves;
 * most, light: [n_cluster]. */
static void set_largest(const struct rad_once *o, const double *integral, double *most,
                        double *light, double *largest) {
  const struct rad_tree *tree = &o->tree;
  for (int c = tree->n_cluster - 1; c >= 0; c--) {
    const struct rad_cluster *s = &tree->cluster[c];
    most[c] = s->child >= 0 ? fmax(most[s->child], most[s->child + 1]) : 0;
    for (int i = s->element; s->child < 0 && i < s->element + s->n_element; i++)
      most[c] = fmax(most[c], fabs(integral[tree->element[i]]));
  }
  for (int c = 0; c < tree->n_cluster; c++) {
    const struct rad_cluster *t = &tree->cluster[c];
    light[c] = t->parent >= 0 ? light[t->parent] : 0;
    for (size_t b = o->blocks.far.first[c]; b < o->blocks.far.first[c + 1]; b++)
      light[c] = fmax(light[c], o->mean[b] * most[o->blocks.far.source[b]]);
    for (int i = t->element; t->child < 0 && i < t->element + t->n_element; i++)
      largest[tree->element[i]] = light[c];
  }
}

/* Memory of one thread. */
struct work {
  double *kernel, *value, *scratch, *share, *moment; /* owned */
};

/* Largest over the nodes of |S m|, S [n, n], m [n]. */
static double largest_at_nodes(int n, const double *s, const double *m) {
  double sum[RAD_MAX_INTERPOLATION * RAD_MAX_INTERPOLATION] = {0}, most = 0;
  for (int l = 0; l < n; l++)
#pragma omp simd
    for (int a = 0; a < n; a++)
      sum[a] += s[l * n + a] * m[l];
  for (int a = 0; a < n; a++)
    most = fmax(most, fabs(sum[a]));
  return most;
}

/* Parts of the elements of a source leaf at the nodes of its partner. */
static void leaf_parts(const struct rad_once *o, int c, int target, int n_band,
                       const double *weight, double *part, const struct work *w) {
  const struct rad_cluster *leaf = &o->tree.cluster[c], *t = &o->tree.cluster[target];
  int n = o->p.n, l = 0;
  rad_interpolation_kernel(&o->p, &o->tree, t, leaf, w->kernel);
  rad_leaf_moments(&o->p, &o->tree, leaf, o->tolerance, w->value, w->scratch);
  rad_leaf_shares(&o->tree, leaf, w->share);
  for (int i = leaf->element; i < leaf->element + leaf->n_element; i++) {
    int element = o->tree.element[i];
    const struct rad_element *el = &o->mesh->element[element];
    for (int b = 0; b < n_band && o->has_light[element]; b++) {
      memset(w->moment, 0, sizeof(double) * (size_t)n);
      for (int f = 0; f < el->n_function; f++) {
        double u = sqrt(w->share[l + f]) * o->u[b][el->first + f];
        for (int a = 0; a < n; a++)
          w->moment[a] += u * w->value[(size_t)(l + f) * (size_t)n + (size_t)a];
      }
      double rho = weight[t->triangle * n_band + b];
      part[element] = fmax(part[element], rho * largest_at_nodes(n, w->kernel, w->moment));
    }
    l += el->n_function;
  }
}

static void free_work(struct work *w, int n_thread) {
  for (int t = 0; w && t < n_thread; t++) {
    free(w[t].kernel);
    free(w[t].value);
    free(w[t].scratch);
    free(w[t].share);
    free(w[t].moment);
  }
  free(w);
}

static struct work *make_work(const struct rad_once *o, int n_thread) {
  struct work *w = rad_calloc((size_t)n_thread, sizeof *w);
  size_t n = (size_t)o->p.n, element, leaf = rad_tree_most(&o->tree, &element);
  int failed = !w;
  for (int t = 0; w && t < n_thread; t++) {
    w[t] = (struct work){rad_alloc(n * n, sizeof(double)), rad_alloc(leaf * n, sizeof(double)),
                         rad_alloc(element * n, sizeof(double)), rad_alloc(leaf, sizeof(double)),
                         rad_alloc(n, sizeof(double))};
    failed |= !w[t].kernel || !w[t].value || !w[t].scratch || !w[t].share || !w[t].moment;
  }
  if (failed) {
    free_work(w, n_thread);
    w = NULL;
  }
  return w;
}

enum rad_code rad_far_parts(const struct rad_once *o, int n_band, const double *integral,
                            const double *weight, double *largest, double *part,
                            struct rad_error *e) {
  size_t n = (size_t)o->tree.n_cluster, n_element = (size_t)o->mesh->n_element;
  int n_thread = omp_get_max_threads(), n_cluster = o->tree.n_cluster;
  struct partner *partner = rad_alloc(n, sizeof *partner);
  double *most = rad_alloc(2 * n, sizeof(double));
  struct work *w = make_work(o, n_thread);
  int done = partner && most && w;
  if (done) {
    for (size_t b = 0; b < (size_t)n_band; b++)
      set_largest(o, integral + b * n_element, most, most + n, largest + b * n_element);
    set_partners(o, n_band, weight, partner);
#pragma omp parallel for schedule(dynamic) default(none)                                           \
    shared(o, n_cluster, partner, n_band, weight, part, w)
    for (int c = 0; c < n_cluster; c++)
      if (o->tree.cluster[c].child < 0 && partner[c].target >= 0)
        leaf_parts(o, c, partner[c].target, n_band, weight, part, &w[omp_get_thread_num()]);
  }
  free_work(w, n_thread);
  free(partner);
  free(most);
  return done ? RAD_OK : rad_fail_memory(e, "the error estimate", 40.0 * (double)n);
}
