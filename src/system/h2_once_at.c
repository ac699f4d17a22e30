/* Products made once, second part: from moments to values at points. */
#include <cblas.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/simd_math.h"
#include "base/stop.h"
#include "system/h2_leaf.h"
#include "system/h2_near.h"
#include "system/h2_once.h"

/* Elements that are integrated at a time, and how large their block should be at least. */
enum { PIECES = 64, BLOCK = 1 << 17 };

/* Costs in kernel values: a pair of nodes with its products; what an element takes beside its own
 * kernel values. */
enum { NODES = 2, ELEMENT = 200 };

/* One product. */
struct product {
  struct rad_once *o;
  const struct rad_element_points *points;
  int n_near;
  double *const *y;
  rad_once_visitor *visit;
  void *context;
  double *local; /* owned [n_cluster, n_vector, p.n], pages: what far blocks make at nodes */
  unsigned char *is_far; /* owned [n_cluster] it, or one above it, is the target of a far block */
  unsigned char *is_direct;    /* owned [far blocks] integrated as near ones, which takes less */
  size_t block;                /* numbers of a block of near integrals */
  struct down *down;           /* owned [threads] */
  struct rad_scratch *scratch; /* owned [threads] */
};

/* Memory of one thread on the way down. */
struct down {
  double *work; /* owned: kernel values; or a block and one element's part [n_near, RAD_BATCH] */
  struct rad_near_list near;
  int *source; /* owned [room_source] clusters that are integrated directly */
  size_t room, room_value, room_source;
  int *point, *base;       /* owned [room] a leaf's points */
  double (*mu)[2], *value; /* owned [room], [room_value] */
};

static double *local_of(const struct product *p, int cluster) {
  return p->local + (size_t)cluster * (size_t)p->o->n_vector * (size_t)p->o->p.n;
}

static void count_targets(struct product *p) {
  struct rad_once *o = p->o;
  for (int c = o->tree.n_cluster - 1; c >= 0; c--) {
    const struct rad_cluster *t = &o->tree.cluster[c];
    o->n_target[c] = 0;
    for (int i = t->element; t->child < 0 && i < t->element + t->n_element; i++)
      o->n_target[c] += p->points->count[o->tree.element[i]];
    if (t->child >= 0)
      o->n_target[c] = o->n_target[t->child] + o->n_target[t->child + 1];
  }
  for (int c = 0; c < o->tree.n_cluster; c++) {
    int parent = o->tree.cluster[c].parent;
    p->is_far[c] = o->n_target[c] > 0 && ((parent >= 0 && p->is_far[parent]) ||
                                          o->blocks.far.first[c + 1] > o->blocks.far.first[c]);
  }
}

/* True if the kernel values between points and elements are fewer than those between nodes. */
static int takes_less(const struct product *p, int target, int source) {
  const struct rad_once *o = p->o;
  const struct rad_cluster *s = &o->tree.cluster[source];
  double values = 0;
  if (o->tree.cluster[target].child >= 0 || s->child >= 0)
    return 0;
  for (int i = s->element; i < s->element + s->n_element; i++) {
    const struct rad_element *e = &o->mesh->element[o->tree.element[i]];
    values += ELEMENT + (double)o->n_target[target] * (e->k_phi + 2) * (e->k_r + 2);
  }
  return values < (double)NODES * o->p.n * o->p.n;
}

static void choose_direct(struct product *p) {
  const struct rad_once *o = p->o;
  const struct rad_block_list *far = &o->blocks.far;
  for (int c = 0; c < o->tree.n_cluster; c++)
    for (size_t b = far->first[c]; b < far->first[c + 1] && p->is_far[c]; b++)
      p->is_direct[b] = (unsigned char)takes_less(p, c, far->source[b]);
}

/* What all far blocks of a cluster send to its nodes, in the order of the list. */
static RAD_CLONES void far_blocks(const struct product *p, int c, double *kernel) {
  struct rad_once *o = p->o;
  const struct rad_cluster *cluster = o->tree.cluster;
  int n = o->p.n;
  double *local = local_of(p, c);
  for (size_t b = o->blocks.far.first[c]; b < o->blocks.far.first[c + 1]; b++) {
    int s = o->blocks.far.source[b];
    o->mean[b] = 0;
    if (!o->is_lit[s] || p->is_direct[b])
      continue;
    rad_interpolation_kernel(&o->p, &o->tree, &cluster[c], &cluster[s], kernel);
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int i = 0; i < n * n; i++)
      sum += kernel[i];
    o->mean[b] = sum / ((double)n * n);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, n, o->n_vector, n, 1, kernel, n,
                rad_once_moments(o, s), n, 1, local, n);
  }
}

static void from_parent(const struct product *p, int c, double *half) {
  const struct rad_once *o = p->o;
  const struct rad_cluster *child = &o->tree.cluster[c];
  size_t all = (size_t)o->n_vector * (size_t)o->p.n;
  double e[2][RAD_MAX_INTERPOLATION * RAD_MAX_INTERPOLATION], *local = local_of(p, c);
  rad_interpolation_child(&o->p, &o->tree.cluster[child->parent], child, e);
  rad_interpolation_transfer(&o->p, e[0], e[1], 0, o->n_vector, local_of(p, child->parent), half);
  for (size_t a = 0; a < all; a++)
    local[a] += half[a];
}

/* The points of a leaf; returns their number, or -1 without memory. */
static int list_points(const struct product *p, int c, struct down *d) {
  const struct rad_once *o = p->o;
  const struct rad_cluster *leaf = &o->tree.cluster[c];
  size_t n = (size_t)o->n_target[c], room = d->room, again = room;
  if (!rad_reserve((void **)&d->point, n, &room, sizeof(int)) ||
      !rad_reserve((void **)&d->base, n, &again, sizeof(int)) ||
      !rad_reserve((void **)&d->mu, n, &d->room, sizeof *d->mu) ||
      !rad_reserve((void **)&d->value, n * (size_t)o->n_vector, &d->room_value, sizeof(double)))
    return -1;
  int at = 0;
  for (int i = leaf->element; i < leaf->element + leaf->n_element; i++) {
    int first = p->points->first[o->tree.element[i]];
    for (int q = first; q < first + p->points->count[o->tree.element[i]]; q++, at++) {
      d->point[at] = q;
      d->base[at] = p->points->base[q];
      memcpy(d->mu[at], p->points->mu[q], sizeof d->mu[at]);
    }
  }
  return at;
}

/* value [n_vector, n] of the far blocks at the points of a leaf. */
static RAD_CLONES void far_values(const struct product *p, int c, int n, struct down *d) {
  const struct rad_once *o = p->o;
  const struct rad_cluster *leaf = &o->tree.cluster[c];
  const struct rad_triangle *triangle = &o->mesh->scene->triangle[leaf->triangle];
  double polynomial[RAD_MAX_INTERPOLATION * RAD_MAX_INTERPOLATION], x[3];
  for (int i = 0; i < n; i++) {
    rad_triangle_point(triangle, d->base[i], d->mu[i], x);
    rad_leaf_polynomials(&o->p, &o->tree, leaf, x, polynomial);
    const double *local = local_of(p, c);
    for (int v = 0; v < o->n_vector; v++, local += o->p.n) {
      double sum = 0;
#pragma omp simd reduction(+ : sum)
      for (int a = 0; a < o->p.n; a++)
        sum += polynomial[a] * local[a];
      d->value[v * n + i] = sum;
    }
  }
}

/* out [n_near, m]: one element's columns k [m, functions] times its coefficients. */
static RAD_CLONES void multiply(const struct product *p, int element, int m,
                                const double *restrict k, double *restrict out) {
  const struct rad_element *el = &p->o->mesh->element[element];
  memset(out, 0, sizeof(double) * (size_t)m * (size_t)p->n_near);
  for (int v = 0; v < p->n_near; v++, out += m)
    for (int f = 0; f < el->n_function; f++) {
      double u = p->o->u[v][el->first + f];
      const double *restrict column = k + (size_t)m * (size_t)f;
#pragma omp simd
      for (int i = 0; i < m; i++)
        out[i] += column[i] * u;
    }
}

/* Elements of one patch, from list[*at] on, as many as fit: their numbers and columns. */
static int take_pieces(const struct product *p, const struct rad_near_list *list, int m, int *at,
                       int *element, int64_t *column) {
  int n = 0, patch = -1;
  int64_t total = 0;
  for (; *at < list->n && n < PIECES; ++*at) {
    int one = list->element[*at];
    const struct rad_element *el = &p->o->mesh->element[one];
    if (!p->o->has_light[one])
      continue;
    if (n > 0 && (el->patch != patch || (total + el->n_function) * m > (int64_t)p->block))
      break;
    patch = el->patch;
    element[n] = one;
    column[n++] = total;
    total += el->n_function;
  }
  return n;
}

/* Add the near blocks of points first .. first + m of a leaf. */
static void near_values(const struct product *p, int triangle, int first, int m, int n,
                        struct down *d) {
  const struct rad_once *o = p->o;
  int thread = omp_get_thread_num(), element[PIECES], n_piece;
  int64_t column[PIECES];
  double *out = d->work + p->block;
  struct rad_targets targets = {triangle, m, d->base + first, (const double(*)[2])(d->mu + first),
                                NULL};
  for (int at = 0;
       !rad_stop_asked() && (n_piece = take_pieces(p, &d->near, m, &at, element, column)) > 0;) {
    rad_element_list_block(o->mesh, o->rules, &targets, n_piece, element, column, d->work, m,
                           &p->scratch[thread]);
    for (int i = 0; i < n_piece; i++) {
      multiply(p, element[i], m, d->work + column[i] * m, out);
      for (int v = 0; v < p->n_near; v++)
        for (int q = 0; q < m; q++)
          d->value[v * n + first + q] += out[v * m + q];
      if (p->visit)
        p->visit(p->context, thread, element[i], triangle, m, d->point + first, out);
    }
  }
}

/* The elements of a leaf's near blocks, and of far ones that take less that way; 0 without memory.
 */
static int list_elements(const struct product *p, int c, struct down *d) {
  const struct rad_block_list *near = &p->o->blocks.near, *far = &p->o->blocks.far;
  size_t most = near->first[c + 1] - near->first[c] + far->first[c + 1] - far->first[c], n = 0;
  if (!rad_reserve((void **)&d->source, most, &d->room_source, sizeof(int)))
    return 0;
  for (size_t b = near->first[c]; b < near->first[c + 1]; b++)
    d->source[n++] = near->source[b];
  for (size_t b = far->first[c]; b < far->first[c + 1]; b++)
    if (p->is_direct[b])
      d->source[n++] = far->source[b];
  return rad_near_list(&p->o->tree, n, d->source, &d->near);
}

/* Values at the points of a leaf; 0 without memory. */
static int leaf_values(const struct product *p, int c) {
  const struct rad_once *o = p->o;
  struct down *d = &p->down[omp_get_thread_num()];
  int n = list_points(p, c, d);
  if (n < 0 || !list_elements(p, c, d))
    return 0;
  if (p->is_far[c])
    far_values(p, c, n, d);
  else
    memset(d->value, 0, sizeof(double) * (size_t)n * (size_t)o->n_vector);
  for (int first = 0; first < n; first += RAD_BATCH)
    near_values(p, o->tree.cluster[c].triangle, first,
                n - first < RAD_BATCH ? n - first : RAD_BATCH, n, d);
  for (int v = 0; v < o->n_vector; v++)
    for (int i = 0; i < n; i++)
      p->y[v][d->point[i]] = d->value[v * n + i];
  return 1;
}

static int go_down(const struct product *p) {
  const struct rad_tree *tree = &p->o->tree;
  struct rad_progress *progress = p->o->mesh->scene->progress;
  int failed = 0, n_root = p->o->mesh->scene->n_triangle;
  int64_t all = 0;
  for (int t = 0; t < n_root; t++)
    all += p->o->n_target[t];
  rad_progress_begin(progress, "points", all);
#pragma omp parallel default(none) shared(p, tree, progress) reduction(| : failed)
  {
    double *work = p->down[omp_get_thread_num()].work;
#pragma omp for schedule(dynamic)
    for (int c = 0; c < tree->n_cluster; c++)
      if (p->is_far[c] && !rad_stop_asked())
        far_blocks(p, c, work);
    for (int level = 1; level < tree->n_level; level++)
#pragma omp for schedule(dynamic)
      for (int c = tree->level_first[level]; c < tree->level_first[level + 1]; c++)
        if (p->is_far[c] && p->is_far[tree->cluster[c].parent])
          from_parent(p, c, work);
#pragma omp for schedule(dynamic)
    for (int c = 0; c < tree->n_cluster; c++)
      if (p->o->n_target[c] > 0 && tree->cluster[c].child < 0) {
        failed |= !leaf_values(p, c);
        rad_progress_add(progress, p->o->n_target[c]);
      }
  }
  return !failed;
}

static void free_product(struct product *p, int n_thread) {
  for (int t = 0; p->down && t < n_thread; t++) {
    rad_near_list_free(&p->down[t].near);
    free(p->down[t].work);
    free(p->down[t].source);
    free(p->down[t].point);
    free(p->down[t].base);
    free(p->down[t].mu);
    free(p->down[t].value);
  }
  free(p->down);
  free(p->is_far);
  free(p->is_direct);
  rad_pages_free(p->local, p->local ? rad_once_bytes(p->o) : 0);
}

/* 0 without memory. */
static int make_product(struct product *p, int n_thread) {
  const struct rad_once *o = p->o;
  size_t node = (size_t)o->p.n, functions;
  rad_tree_most(&o->tree, &functions);
  p->block = functions * RAD_BATCH > BLOCK ? functions * RAD_BATCH : BLOCK;
  size_t out = (size_t)o->n_vector * (node > RAD_BATCH ? node : RAD_BATCH);
  size_t work = p->block + out > node * node ? p->block + out : node * node;
  p->local = rad_pages_alloc(rad_once_bytes(o));
  p->is_far = rad_calloc((size_t)o->tree.n_cluster, 1);
  p->is_direct = rad_calloc(o->blocks.far.first[o->tree.n_cluster], 1);
  p->down = rad_calloc((size_t)n_thread, sizeof *p->down);
  int done = p->local && p->is_far && p->is_direct && p->down;
  for (int t = 0; done && t < n_thread; t++)
    done = (p->down[t].work = rad_alloc(work, sizeof(double))) != NULL;
  return done;
}

enum rad_code rad_once_at(struct rad_once *o, const struct rad_element_points *points, int n_near,
                          double *const *y, rad_once_visitor *visit, void *context,
                          struct rad_error *e) {
  struct product p = {
      .o = o, .points = points, .n_near = n_near, .y = y, .visit = visit, .context = context};
  int n_thread = omp_get_max_threads(), failed = 1;
  p.scratch = rad_scratch_make(o->mesh, n_thread, e);
  enum rad_code code = p.scratch ? RAD_OK : RAD_ESYSTEM;
  if (!code && make_product(&p, n_thread)) {
    count_targets(&p);
    choose_direct(&p);
    failed = !go_down(&p);
  }
  free_product(&p, n_thread);
  if (!code)
    code = rad_scratch_end(p.scratch, n_thread, NULL, e);
  if (!code && !failed && rad_stop_asked())
    code = rad_fail_stopped(e);
  return failed && !code
             ? rad_fail_memory(e, "products by interpolation", (double)rad_once_bytes(o))
             : code;
}
