#include "system/h2_basis.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "base/scramble.h"
#include "base/stop.h"
#include "system/h2_leaf.h"

enum {
  TASK = 2048, /* unknowns of a subtree that is worth a task */
  SPREAD = 4   /* sketched columns that take a part of one column */
};
#define REST 0.05 /* of the cut: what weights may lose */

/* What is the same for all clusters. */
struct work {
  const struct rad_tree *tree;
  const struct rad_basis_goal *goal;
  struct rad_basis *basis;
  size_t n;       /* nodes of a cluster */
  size_t scratch; /* for moments */
};

/* Weights of a cluster: column c of z is what one direction of its far field makes of the
 * polynomials, so that V z holds all that the basis must reproduce. */
struct weights {
  int n;
  double *z; /* owned [n_node, n] */
};

static int has_blocks(const struct work *w, int cluster) {
  return w->goal->far->first[cluster + 1] > w->goal->far->first[cluster];
}

/* Weights under way: columns for the nodes of the cluster. */
struct stack {
  size_t n;       /* columns */
  double *z;      /* owned [n_node, n] */
  double *kernel; /* owned [n_node, n_node] */
};

/* The kernel between a cluster and one partner times the partner's share in a row sum: |s'| of the
 * source, and the roots of the partner's mean weights (theory 14.5), a column for each node of the
 * partner. There are many more columns than directions in them: each is added with random signs to
 * SPREAD of the `n` sketched columns from `first` on (theory 14.8). */
static void sketch_block(const struct work *w, int cluster, int partner, int number, size_t first,
                         struct stack *s) {
  const struct rad_interpolation *p = w->goal->interpolation;
  const struct rad_cluster *own = &w->tree->cluster[cluster], *other = &w->tree->cluster[partner];
  double area = w->goal->kind == RAD_BASIS_ROW ? other->area : own->area;
  size_t n = w->n;
  rad_interpolation_kernel(p, w->tree, own, other, s->kernel); /* G is symmetric */
  for (size_t b = 0; b < n; b++) {
    const double *column = s->kernel + n * b;
    for (size_t k = 0; k < SPREAD; k++) {
      uint64_t draw = rad_scramble(((uint64_t)number * n + b) * SPREAD + k);
      double *to = s->z + n * (first + (size_t)(draw >> 1) % n);
      double factor = area * p->root[b] * (draw & 1 ? 1 : -1) / sqrt(SPREAD);
#pragma omp simd
      for (size_t a = 0; a < n; a++)
        to[a] += factor * column[a];
    }
  }
}

/* The stack's columns as weights z [n_node, kept], without what is below `least` in the mean square
 * over the cluster: by QR with pivots, which costs a third of an SVD here and keeps little more.
 * Returns their number, or -1. */
static int principal(const struct work *w, const struct stack *s, double least, double *z) {
  size_t n = w->n, m = s->n, kept = 0, most = m < n ? m : n;
  const double *root = w->goal->interpolation->root;
  lapack_int *pivot = rad_calloc(n, sizeof *pivot);
  double *rows = rad_alloc(m * n, sizeof(double)), *t = rad_alloc(n, sizeof(double));
  for (size_t a = 0; a < n && rows; a++)
    for (size_t b = 0; b < m; b++)
      rows[b + m * a] = root[a] * s->z[a + n * b];
  int done = pivot && rows && t &&
             !LAPACKE_dgeqp3(LAPACK_COL_MAJOR, (int)m, (int)n, rows, (int)m, pivot, t);
  while (done && kept < most && fabs(rows[kept + m * kept]) > least)
    kept++;
  for (size_t c = 0; c < kept; c++)
    for (size_t a = 0; a < n; a++) {
      size_t node = (size_t)pivot[a] - 1;
      z[n * c + node] = a < c ? 0 : rows[c + m * a] / root[node];
    }
  free(pivot);
  free(rows);
  free(t);
  return done ? (int)kept : -1;
}

/* Add the far blocks of a cluster to the weights that came from its parent. */
static int add_blocks(const struct work *w, int cluster, struct weights *own) {
  const struct rad_block_list *far = w->goal->far;
  size_t n = w->n, above = (size_t)own->n, from = far->first[cluster];
  struct stack s = {.n = above + n};
  s.z = rad_calloc(n * s.n, sizeof(double));
  s.kernel = rad_alloc(n * n, sizeof(double));
  double *z = rad_alloc(n * n, sizeof(double));
  int kept = -1;
  if (s.z && s.kernel && z) {
    memcpy(s.z, own->z, sizeof(double) * n * above);
    for (size_t b = from; b < far->first[cluster + 1]; b++)
      sketch_block(w, cluster, far->source[b], (int)(b - from), above, &s);
    kept = principal(w, &s, REST * w->goal->cut, z);
  }
  free(s.z);
  free(s.kernel);
  free(own->z);
  *own = (struct weights){kept, z};
  return kept >= 0;
}

/* What the parent handed down, at the nodes of this cluster, and the cluster's own blocks. */
static int inherit(const struct work *w, int cluster, const struct weights *above,
                   struct weights *own) {
  const struct rad_interpolation *p = w->goal->interpolation;
  const struct rad_cluster *c = &w->tree->cluster[cluster];
  *own = (struct weights){.n = above ? above->n : 0};
  own->z = rad_alloc(w->n * (size_t)own->n, sizeof(double));
  if (!own->z)
    return 0;
  if (own->n) {
    const struct rad_cluster *up = &w->tree->cluster[c->parent];
    double e[2][RAD_MAX_INTERPOLATION * RAD_MAX_INTERPOLATION];
    for (int d = 0; d < 2; d++)
      rad_interpolation_between(p, up->low[d], up->high[d], c->low[d], c->high[d], e[d]);
    rad_interpolation_transfer(p, e[0], e[1], 0, own->n, above->z, own->z);
  }
  return has_blocks(w, cluster) ? add_blocks(w, cluster, own) : 1;
}

/* V^T [n_node, rows]: the polynomials in the rows of a cluster's matrix; NULL without memory. */
static double *polynomials(const struct work *w, int cluster, int rows) {
  const struct rad_interpolation *p = w->goal->interpolation;
  const struct rad_cluster *c = &w->tree->cluster[cluster];
  double *v = rad_alloc(w->n * (size_t)rows, sizeof(double)), *at = v;
  if (!v || (c->child < 0 && w->goal->kind == RAD_BASIS_ROW)) {
    if (v)
      rad_leaf_values(p, w->tree, c, v);
  } else if (c->child < 0) {
    double *scratch = rad_alloc(w->scratch, sizeof(double));
    if (scratch) {
      rad_leaf_moments(p, w->tree, c, w->goal->tolerance, v, scratch);
    } else {
      free(v);
      v = NULL;
    }
    free(scratch);
  } else {
    for (int i = c->child; i < c->child + 2; i++) {
      const struct rad_cluster *child = &w->tree->cluster[i];
      double e[2][RAD_MAX_INTERPOLATION * RAD_MAX_INTERPOLATION];
      for (int d = 0; d < 2; d++)
        rad_interpolation_between(p, c->low[d], c->high[d], child->low[d], child->high[d], e[d]);
      rad_interpolation_transfer(p, e[0], e[1], 1, w->basis->rank[i], w->basis->change[i], at);
      at += w->n * (size_t)w->basis->rank[i];
    }
  }
  return v;
}

/* The basis of a cluster: left singular vectors of V z; R^T = V^T basis (theory 14.6). */
static int truncate_basis(const struct work *w, int cluster, const double *v,
                          const struct weights *own) {
  const struct rad_cluster *c = &w->tree->cluster[cluster];
  int rows = rad_basis_rows(w->tree, w->basis->rank, cluster), n = (int)w->n, kept = 0;
  int most = rows < own->n ? rows : own->n;
  double least =
      w->goal->cut * sqrt(w->goal->kind == RAD_BASIS_ROW ? fmin(c->n, w->tree->leaf) : c->area);
  double *m = rad_alloc((size_t)rows * (size_t)own->n, sizeof(double));
  double *u = rad_alloc((size_t)rows * (size_t)most, sizeof(double));
  double *right = rad_alloc((size_t)most * (size_t)own->n, sizeof(double));
  double *sigma = rad_alloc((size_t)most, sizeof(double)), *change = NULL;
  int done = m && u && right && sigma;
  if (done && most) {
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, rows, own->n, n, 1, v, n, own->z, n, 0, m,
                rows);
    done =
        !LAPACKE_dgesdd(LAPACK_COL_MAJOR, 'S', rows, own->n, m, rows, sigma, u, rows, right, most);
    while (done && kept < most && sigma[kept] > least)
      kept++;
    change = rad_alloc(w->n * (size_t)kept, sizeof(double));
    done = done && change;
    if (done && kept)
      cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, n, kept, rows, 1, v, n, u, rows, 0,
                  change, n);
  }
  free(m);
  free(right);
  free(sigma);
  w->basis->rank[cluster] = kept;
  w->basis->matrix[cluster] = u;
  w->basis->change[cluster] = change;
  return done;
}

/* True if nothing below a cluster is missing. */
static int is_ready(const struct work *w, const struct rad_cluster *c) {
  const unsigned char *state = w->basis->state + c->child;
  return c->child < 0 || (state[0] == RAD_BASIS_DONE && state[1] == RAD_BASIS_DONE);
}

/* Down with the weights, up with the bases. */
static void shrink(const struct work *w, int cluster, const struct weights *above) {
  const struct rad_cluster *c = &w->tree->cluster[cluster];
  struct weights own;
  if (w->basis->state[cluster] != RAD_BASIS_MISSING || rad_stop_asked())
    return;
  int done = inherit(w, cluster, above, &own), ready = 0;
  for (int i = c->child; c->child >= 0 && i < c->child + 2; i++) {
#pragma omp task default(none) firstprivate(w, i) shared(own) if (c->n > TASK)
    shrink(w, i, &own);
  }
#pragma omp taskwait
  ready = done && is_ready(w, c);
  if (ready) {
    double *v = polynomials(w, cluster, rad_basis_rows(w->tree, w->basis->rank, cluster));
    done = v && truncate_basis(w, cluster, v, &own);
    free(v);
  }
  for (int i = c->child; ready && done && c->child >= 0 && i < c->child + 2; i++)
    if (!has_blocks(w, i)) {
      free(w->basis->change[i]);
      w->basis->change[i] = NULL;
      w->basis->state[i] = RAD_BASIS_SPENT;
    }
  if (ready && done)
    w->basis->state[cluster] = RAD_BASIS_DONE;
  free(own.z);
  if (!done) {
#pragma omp atomic write
    w->basis->failed = 1;
  }
}

int rad_basis_rows(const struct rad_tree *tree, const int *rank, int cluster) {
  const struct rad_cluster *c = &tree->cluster[cluster];
  return c->child < 0 ? c->n : rank[c->child] + rank[c->child + 1];
}

enum rad_code rad_basis_begin(const struct rad_tree *tree, struct rad_basis *basis,
                              struct rad_error *e) {
  size_t n = (size_t)tree->n_cluster;
  *basis = (struct rad_basis){.tree = tree,
                              .rank = rad_calloc(n, sizeof(int)),
                              .matrix = rad_calloc(n, sizeof(double *)),
                              .change = rad_calloc(n, sizeof(double *)),
                              .state = rad_calloc(n, 1)};
  if (!basis->rank || !basis->matrix || !basis->change || !basis->state)
    return rad_fail_memory(e, "the bases of the clusters", 21.0 * (double)n);
  return RAD_OK;
}

enum rad_code rad_basis_build(const struct rad_tree *tree, const struct rad_basis_goal *goal,
                              struct rad_basis *basis, struct rad_error *e) {
  size_t node = (size_t)goal->interpolation->n, most = 0;
  int n_triangle = tree->mesh->scene->n_triangle;
  rad_tree_most(tree, &most);
  struct work work = {tree, goal, basis, node, most * node}, *w = &work;
  struct rad_progress *progress = tree->mesh->scene->progress;
  rad_progress_begin(progress, "bases", n_triangle);
#pragma omp parallel for schedule(dynamic, 1) default(none) shared(n_triangle, w, progress)
  for (int t = 0; t < n_triangle; t++) {
    shrink(w, t, NULL);
    rad_progress_add(progress, 1);
  }
  if (basis->failed)
    return rad_fail_memory(e, "the bases of the clusters", 0);
  return rad_stop_asked() && memchr(basis->state, RAD_BASIS_MISSING, (size_t)n_triangle)
             ? rad_fail_stopped(e)
             : RAD_OK;
}

enum rad_code rad_basis_sample(const struct rad_tree *tree, const struct rad_basis_goal *goal,
                               int leaf, double *seconds, struct rad_error *e) {
  size_t most = 0;
  struct rad_basis basis;
  rad_tree_most(tree, &most);
  struct work work = {tree, goal, &basis, (size_t)goal->interpolation->n, 0};
  work.scratch = most * work.n;
  enum rad_code code = rad_basis_begin(tree, &basis, e);
  double start = rad_seconds();
  if (!code)
    shrink(&work, leaf, NULL);
  *seconds = rad_seconds() - start;
  if (!code && basis.failed)
    code = rad_fail_memory(e, "the bases of the clusters", 0);
  rad_basis_free(&basis);
  return code;
}

void rad_basis_free(struct rad_basis *basis) {
  for (int c = 0; basis->tree && c < basis->tree->n_cluster; c++) {
    if (basis->matrix)
      free(basis->matrix[c]);
    if (basis->change)
      free(basis->change[c]);
  }
  free(basis->rank);
  free(basis->matrix);
  free(basis->change);
  free(basis->state);
  *basis = (struct rad_basis){0};
}
