#include "system/h2_basis.h"

#include <cblas.h>
#include <lapacke.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "system/h2_leaf.h"

enum {
  TASK = 2048, /* unknowns of a subtree that is worth a task */
  BAND = 32,   /* columns of a factorization at a time */
  AT_ONCE = 8  /* blocks of a factorization */
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

/* Rows of weights under one another, each for the nodes of the cluster. */
struct stack {
  size_t n, ld;       /* rows, room */
  double *z;          /* owned [ld, n_node] */
  double *kernel, *t; /* owned [n_node, n_node], [BAND, n_node] */
};

/* The kernel between a cluster and one partner times the partner's share in a row sum: |s'| of the
 * source, and the roots of the partner's mean weights (theory 14.5). A row for each of its nodes.
 */
static void push_block(const struct work *w, int cluster, int partner, struct stack *s) {
  const struct rad_interpolation *p = w->goal->interpolation;
  const struct rad_cluster *own = &w->tree->cluster[cluster], *other = &w->tree->cluster[partner];
  int is_row = w->goal->kind == RAD_BASIS_ROW;
  double area = is_row ? other->area : own->area, *out = s->z + s->n;
  rad_interpolation_kernel(p, w->tree, is_row ? own : other, is_row ? other : own, s->kernel);
  for (size_t a = 0; a < w->n; a++) /* of the cluster; b: of the partner */
    for (size_t b = 0; b < w->n; b++)
      out[b + s->ld * a] = s->kernel[is_row ? a + w->n * b : b + w->n * a] * area * p->root[b];
  s->n += w->n;
}

/* As few rows R with R^T R = z^T z. dgeqrf would not use matrix products for matrices this small;
 * dgeqrt does. */
static int reduce_stack(size_t n, struct stack *s) {
  int band = (int)n < BAND ? (int)n : BAND;
  if (s->n <= n)
    return 1;
  if (LAPACKE_dgeqrt(LAPACK_COL_MAJOR, (int)s->n, (int)n, band, s->z, (int)s->ld, s->t, band))
    return 0;
  for (size_t a = 0; a < n; a++)
    for (size_t b = a + 1; b < n; b++)
      s->z[b + s->ld * a] = 0;
  s->n = n;
  return 1;
}

/* The stack's rows as weights z [n_node, kept], without what is below `least` in the mean square
 * over the cluster: by QR with pivots, which costs a third of an SVD here and keeps little more.
 * Returns their number, or -1. */
static int principal(const struct work *w, const struct stack *s, double least, double *z) {
  size_t n = w->n, kept = 0, most = s->n < n ? s->n : n;
  const double *root = w->goal->interpolation->root;
  lapack_int *pivot = rad_calloc(n, sizeof *pivot);
  for (size_t a = 0; a < n; a++)
    for (size_t b = 0; b < s->n; b++)
      s->z[b + s->ld * a] *= root[a];
  int done =
      pivot && !LAPACKE_dgeqp3(LAPACK_COL_MAJOR, (int)s->n, (int)n, s->z, (int)s->ld, pivot, s->t);
  while (done && kept < most && fabs(s->z[kept + s->ld * kept]) > least)
    kept++;
  for (size_t c = 0; c < kept; c++)
    for (size_t a = 0; a < n; a++) {
      size_t node = (size_t)pivot[a] - 1;
      z[n * c + node] = a < c ? 0 : s->z[c + s->ld * a] / root[node];
    }
  free(pivot);
  return done ? (int)kept : -1;
}

/* Add the far blocks of a cluster to the weights that came from its parent. */
static int add_blocks(const struct work *w, int cluster, struct weights *own) {
  const struct rad_block_list *far = w->goal->far;
  size_t n = w->n;
  struct stack s = {.n = (size_t)own->n, .ld = (1 + AT_ONCE) * n};
  s.z = rad_alloc(s.ld * n, sizeof(double));
  s.kernel = rad_alloc(n * n, sizeof(double));
  s.t = rad_alloc(BAND * n, sizeof(double));
  double *z = rad_alloc(n * n, sizeof(double));
  int done = s.z && s.kernel && s.t && z, kept = -1;
  for (size_t i = 0; done && i < n * s.n; i++)
    s.z[i / n + s.ld * (i % n)] = own->z[i];
  for (size_t b = far->first[cluster]; b < far->first[cluster + 1] && done; b++) {
    push_block(w, cluster, far->source[b], &s);
    if (s.n > AT_ONCE * n || b + 1 == far->first[cluster + 1])
      done = reduce_stack(n, &s);
  }
  if (done)
    kept = principal(w, &s, REST * w->goal->cut, z);
  free(s.z);
  free(s.kernel);
  free(s.t);
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
    if (scratch)
      rad_leaf_moments(p, w->tree, c, w->goal->tolerance, v, scratch);
    else
      w->basis->failed = 1;
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
  int rows = rad_basis_rows(w->basis, cluster), n = (int)w->n, kept = 0;
  int most = rows < own->n ? rows : own->n;
  double least = w->goal->cut * sqrt(w->goal->kind == RAD_BASIS_ROW ? c->n : c->area);
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

/* Down with the weights, up with the bases. */
static void shrink(const struct work *w, int cluster, const struct weights *above) {
  const struct rad_cluster *c = &w->tree->cluster[cluster];
  struct weights own;
  int done = inherit(w, cluster, above, &own);
  for (int i = c->child; c->child >= 0 && i < c->child + 2; i++) {
#pragma omp task default(none) firstprivate(w, i) shared(own) if (c->n > TASK)
    shrink(w, i, &own);
  }
#pragma omp taskwait
  if (done) {
    double *v = polynomials(w, cluster, rad_basis_rows(w->basis, cluster));
    done = v && truncate_basis(w, cluster, v, &own);
    free(v);
  }
  for (int i = c->child; c->child >= 0 && i < c->child + 2; i++)
    if (!has_blocks(w, i)) {
      free(w->basis->change[i]);
      w->basis->change[i] = NULL;
    }
  free(own.z);
  if (!done) {
#pragma omp atomic write
    w->basis->failed = 1;
  }
}

int rad_basis_rows(const struct rad_basis *basis, int cluster) {
  const struct rad_cluster *c = &basis->tree->cluster[cluster];
  return c->child < 0 ? c->n : basis->rank[c->child] + basis->rank[c->child + 1];
}

enum rad_code rad_basis_build(const struct rad_tree *tree, const struct rad_basis_goal *goal,
                              struct rad_basis *basis, struct rad_error *e) {
  size_t n = (size_t)tree->n_cluster, node = (size_t)goal->interpolation->n, most = 0;
  int n_triangle = tree->mesh->scene->n_triangle;
  *basis = (struct rad_basis){.tree = tree,
                              .rank = rad_calloc(n, sizeof(int)),
                              .matrix = rad_calloc(n, sizeof(double *)),
                              .change = rad_calloc(n, sizeof(double *))};
  if (!basis->rank || !basis->matrix || !basis->change)
    return rad_fail_memory(e, "the bases of the clusters", 20.0 * (double)n);
  for (int i = 0; i < tree->mesh->n_element; i++) {
    const struct rad_element *one = &tree->mesh->element[i];
    size_t need = (size_t)(one->k_phi * one->k_r + one->k_r);
    most = need > most ? need : most;
  }
  struct work work = {tree, goal, basis, node, most * node}, *w = &work;
#pragma omp parallel default(none) shared(n_triangle, w)
#pragma omp single
  for (int t = 0; t < n_triangle; t++) {
#pragma omp task default(none) firstprivate(t, w)
    shrink(w, t, NULL);
  }
  return basis->failed ? rad_fail_memory(e, "the bases of the clusters", 0) : RAD_OK;
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
  *basis = (struct rad_basis){0};
}
