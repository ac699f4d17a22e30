#include "system/h2_once.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "system/h2.h"
#include "system/h2_leaf.h"

/* Functions of high degree, and clusters that are long in the wrong direction, err by up to twice
 * of what (14.3) allows; one point more makes it half (tests/cases/test_once.c). */
#define PART 0.3

static void mark_sources(struct rad_once *o) {
  const struct rad_tree *tree = &o->tree;
  size_t total = o->blocks.far.first[tree->n_cluster];
  for (size_t b = 0; b < total; b++)
    o->is_source[o->blocks.far.source[b]] = 1;
  for (int c = 0; c < tree->n_cluster; c++)
    if (tree->cluster[c].parent >= 0)
      o->is_source[c] |= o->is_source[tree->cluster[c].parent];
}

enum rad_code rad_once_begin(const struct rad_mesh *mesh, const struct rad_rules *rules, int leaf,
                             double tolerance, struct rad_once *o, struct rad_error *e) {
  *o = (struct rad_once){.mesh = mesh, .rules = rules, .tolerance = fmax(tolerance, 1e-13)};
  rad_interpolation_init(&o->p, PART * o->tolerance);
  enum rad_code code = rad_h2_divide(mesh, leaf, o->tolerance, 0, &o->tree, &o->blocks, e);
  if (code)
    return code;
  size_t n = (size_t)o->tree.n_cluster, total = o->blocks.far.first[n];
  o->is_source = rad_calloc(n, 1);
  o->has_light = rad_calloc((size_t)mesh->n_element, 1);
  o->is_lit = rad_calloc(n, 1);
  o->n_target = rad_calloc(n, sizeof(int));
  o->mean = rad_calloc(total, sizeof(double));
  if (!o->is_source || !o->has_light || !o->is_lit || !o->n_target || !o->mean)
    return rad_fail_memory(e, "products by interpolation", 8.0 * (double)total);
  mark_sources(o);
  return RAD_OK;
}

static void find_light(struct rad_once *o) {
  for (int i = 0; i < o->mesh->n_element; i++) {
    const struct rad_element *el = &o->mesh->element[i];
    o->has_light[i] = 0;
    for (int v = 0; v < o->n_vector; v++)
      for (int f = el->first; f < el->first + el->n_function; f++)
        o->has_light[i] |= o->u[v][f] != 0;
  }
  for (int c = o->tree.n_cluster - 1; c >= 0; c--) {
    const struct rad_cluster *t = &o->tree.cluster[c];
    o->is_lit[c] = t->child >= 0 && (o->is_lit[t->child] || o->is_lit[t->child + 1]);
    for (int i = t->element; t->child < 0 && i < t->element + t->n_element; i++)
      o->is_lit[c] |= o->has_light[o->tree.element[i]];
  }
}

/* Memory of one thread on the way up. */
struct up {
  double *value, *scratch, *share; /* owned */
};

static void leaf_up(const struct rad_once *o, int c, const struct up *w) {
  const struct rad_cluster *leaf = &o->tree.cluster[c];
  size_t n = (size_t)o->p.n;
  double *m = rad_once_moments(o, c);
  rad_leaf_moments(&o->p, &o->tree, leaf, o->tolerance, w->value, w->scratch);
  rad_leaf_shares(&o->tree, leaf, w->share);
  for (int v = 0; v < o->n_vector; v++, m += n) {
    memset(m, 0, sizeof(double) * n);
    for (int l = 0; l < leaf->n; l++) {
      double u = sqrt(w->share[l]) * o->u[v][o->tree.unknown[leaf->first + l]];
      for (size_t a = 0; a < n && u != 0; a++)
        m[a] += u * w->value[(size_t)l * n + a];
    }
  }
}

static void parent_up(const struct rad_once *o, int c, double *half) {
  const struct rad_cluster *parent = &o->tree.cluster[c];
  size_t all = (size_t)o->n_vector * (size_t)o->p.n;
  double e[2][RAD_MAX_INTERPOLATION * RAD_MAX_INTERPOLATION], *m = rad_once_moments(o, c);
  for (int i = 0; i < 2; i++) {
    rad_interpolation_child(&o->p, parent, &o->tree.cluster[parent->child + i], e);
    rad_interpolation_transfer(&o->p, e[0], e[1], 1, o->n_vector,
                               rad_once_moments(o, parent->child + i), i ? half : m);
  }
  for (size_t a = 0; a < all; a++)
    m[a] += half[a];
}

static void go_up(struct rad_once *o, const struct up *w) {
  const struct rad_tree *tree = &o->tree;
#pragma omp parallel default(none) shared(o, w, tree)
  {
    const struct up *own = &w[omp_get_thread_num()];
#pragma omp for schedule(dynamic)
    for (int c = 0; c < tree->n_cluster; c++)
      if (o->is_source[c] && o->is_lit[c] && tree->cluster[c].child < 0)
        leaf_up(o, c, own);
    for (int level = tree->n_level - 2; level >= 0; level--)
#pragma omp for schedule(dynamic)
      for (int c = tree->level_first[level]; c < tree->level_first[level + 1]; c++)
        if (o->is_source[c] && o->is_lit[c] && tree->cluster[c].child >= 0)
          parent_up(o, c, own->value);
  }
}

enum rad_code rad_once_gather(struct rad_once *o, int n_vector, const double *const *u,
                              struct rad_error *e) {
  rad_pages_free(o->moment, o->moment ? rad_once_bytes(o) : 0);
  o->n_vector = n_vector;
  memcpy(o->u, u, sizeof *u * (size_t)n_vector); /* the list may be gone when rows are asked for */
  find_light(o);
  o->moment = rad_pages_alloc(rad_once_bytes(o)); /* zeroed: those of dark clusters stay so */
  int n_thread = omp_get_max_threads(), failed = !o->moment;
  struct up *up = rad_calloc((size_t)n_thread, sizeof *up);
  size_t n = (size_t)o->p.n, element, leaf = rad_tree_most(&o->tree, &element);
  size_t value = leaf > (size_t)n_vector ? leaf : (size_t)n_vector;
  for (int t = 0; up && t < n_thread; t++) {
    up[t].value = rad_alloc(value * n, sizeof(double));
    up[t].scratch = rad_alloc(element * n, sizeof(double));
    up[t].share = rad_alloc(leaf, sizeof(double));
    failed |= !up[t].value || !up[t].scratch || !up[t].share;
  }
  if (up && !failed)
    go_up(o, up);
  for (int t = 0; up && t < n_thread; t++) {
    free(up[t].value);
    free(up[t].scratch);
    free(up[t].share);
  }
  failed |= !up;
  free(up);
  return failed ? rad_fail_memory(e, "products by interpolation", (double)rad_once_bytes(o))
                : RAD_OK;
}

void rad_once_free(struct rad_once *o) {
  rad_pages_free(o->moment, o->moment ? rad_once_bytes(o) : 0);
  free(o->is_source);
  free(o->has_light);
  free(o->is_lit);
  free(o->n_target);
  free(o->mean);
  rad_blocks_free(&o->blocks);
  rad_tree_free(&o->tree);
  *o = (struct rad_once){0};
}
