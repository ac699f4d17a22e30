#include "estimate/view_cubature.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "visibility/visibility.h"

enum { MAX_RULE = 12, CHUNK = 1 << 15 };
const int rad_view_rule[RAD_VIEW_LEVELS] = {2, 3, 5, 8, MAX_RULE};

/* One constant per triangle, from its first vertex: the rows are point-to-triangle factors. */
static enum rad_code make_mesh(const struct rad_scene *scene, struct rad_mesh *mesh,
                               struct rad_error *e) {
  enum rad_code code = rad_mesh_begin(scene, NULL, mesh, e);
  for (int t = 0; t < scene->n_triangle && !code; t++) {
    struct rad_patch patch;
    rad_patch_whole(scene, t, &patch);
    rad_mesh_add_patch(mesh, &patch);
    rad_mesh_add_element(
        mesh, (struct rad_element){
                  .sigma = {0, 1}, .tau = {0, 1}, .p_phi = 1, .p_r = 1, .k_phi = 1, .k_r = 1});
  }
  return code ? code : rad_mesh_finish(mesh, e);
}

/* Room for n cells, each with two numbers per column. */
static enum rad_code reserve(struct rad_view_cubature *c, int n, struct rad_error *e) {
  if (n <= c->room)
    return RAD_OK;
  int room = n > 2 * c->room ? n : 2 * c->room;
  size_t row = sizeof(double) * (size_t)c->n_column;
  struct rad_view_leaf *leaf = realloc(c->leaf, sizeof *leaf * (size_t)room);
  c->leaf = leaf ? leaf : c->leaf;
  double *value = realloc(c->value, row * (size_t)room);
  c->value = value ? value : c->value;
  double *change = realloc(c->change, row * (size_t)room);
  c->change = change ? change : c->change;
  if (!leaf || !value || !change)
    return rad_fail_memory(e, "the view factors", (2.0 * (double)row + sizeof *leaf) * room);
  c->room = room;
  return RAD_OK;
}

static enum rad_code add_cells(struct rad_view_cubature *c, struct rad_error *e) {
  const struct rad_scene *s = c->scene;
  enum rad_code code = reserve(c, 4 * s->n_triangle, e);
  for (int t = 0; t < s->n_triangle && !code; t++) {
    struct rad_view_cell whole = rad_view_cell_whole(t), child[RAD_CELL_CHILDREN];
    int n = rad_view_cell_split(&whole, child);
    for (int k = 0; k < n; k++)
      c->leaf[c->n++] = (struct rad_view_leaf){
          .cell = child[k], .surface = s->triangle[t].surface, .change = INFINITY};
    c->area[s->triangle[t].surface] += s->triangle[t].area;
  }
  return code;
}

enum rad_code rad_view_cubature_begin(const struct rad_scene *scene, double quadrature,
                                      struct rad_view_cubature *c, struct rad_error *e) {
  *c = (struct rad_view_cubature){.scene = scene, .n_column = scene->n_surface + 1};
  c->max_cell = 0.25 * rad_memory_available() / (16.0 * c->n_column + sizeof *c->leaf);
  enum rad_code code = make_mesh(scene, &c->mesh, e);
  if (!code)
    code = rad_rules_build(&c->mesh, quadrature, &c->rules, e);
  c->sees = scene->visibility->sight;
  c->area = rad_calloc((size_t)scene->n_surface, sizeof(double));
  if (!code && !c->area)
    code = rad_fail_memory(e, "the view factors", 8.0 * scene->n_surface);
  return code ? code : add_cells(c, e);
}

void rad_view_cubature_free(struct rad_view_cubature *c) {
  rad_rules_free(&c->rules);
  rad_mesh_free(&c->mesh);
  free(c->area);
  free(c->leaf);
  free(c->value);
  free(c->change);
  *c = (struct rad_view_cubature){0};
}

/* ---- points of many cells at once, and the factors there ---- */

struct chunk {
  const struct rad_view_cubature *c;
  int n;
  int *triangle, *base; /* owned [CHUNK] */
  double (*mu)[2];      /* owned [CHUNK] */
  double *weight;       /* owned [CHUNK] */
  double *h;            /* owned [most points, n_column] */
};

/* Few enough that h stays near 32 MB, and enough for any one cell. */
static int chunk_size(const struct rad_view_cubature *c) {
  double fit = 4e6 / c->n_column;
  return fit > CHUNK ? CHUNK : fit < MAX_RULE * MAX_RULE ? MAX_RULE * MAX_RULE : (int)fit;
}

static void chunk_free(struct chunk *k) {
  free(k->triangle);
  free(k->base);
  free(k->mu);
  free(k->weight);
  free(k->h);
}

static enum rad_code chunk_init(const struct rad_view_cubature *c, struct chunk *k,
                                struct rad_error *e) {
  size_t n = (size_t)chunk_size(c);
  *k = (struct chunk){.c = c,
                      .triangle = rad_alloc(n, sizeof(int)),
                      .base = rad_alloc(n, sizeof(int)),
                      .mu = rad_alloc(n, sizeof *k->mu),
                      .weight = rad_alloc(n, sizeof(double)),
                      .h = rad_alloc(n * (size_t)c->n_column, sizeof(double))};
  if (!k->triangle || !k->base || !k->mu || !k->weight || !k->h)
    return rad_fail_memory(e, "the view factors", 8.0 * (double)n * (c->n_column + 4));
  return RAD_OK;
}

static void add_rule(struct chunk *k, const struct rad_view_cell *cell, int rule) {
  int n = rule * rule;
  int base = rad_view_cell_points(&k->c->mesh.gauss, cell, rule, k->mu + k->n, k->weight + k->n);
  for (int i = k->n; i < k->n + n; i++) {
    k->triangle[i] = cell->triangle;
    k->base[i] = base;
  }
  k->n += n;
}

/* Rows of K, summed over the triangles of each surface, and over all. */
static void gather(void *context, int thread, int first, int m, const double *row) {
  const struct chunk *k = context;
  const struct rad_scene *scene = k->c->scene;
  int n_column = k->c->n_column, n_triangle = scene->n_triangle;
  const unsigned char *sees = k->c->sees + (size_t)k->triangle[first] * n_triangle;
  double *h = k->h + (size_t)first * n_column;
  (void)thread;
  memset(h, 0, sizeof(double) * (size_t)m * (size_t)n_column);
  for (int j = 0; j < n_triangle; j++)
    if (sees[j])
      for (int i = 0; i < m; i++) {
        double value = row[(size_t)j * m + i];
        h[(size_t)i * n_column + scene->triangle[j].surface] += value;
        h[(size_t)i * n_column + n_column - 1] += value;
      }
}

/* sum = share sum_q weight_q h(x_q) over one rule; returns the point after it. */
static int apply_rule(const struct chunk *k, int first, int rule, double share, double *sum) {
  int n_column = k->c->n_column;
  memset(sum, 0, sizeof(double) * (size_t)n_column);
  for (int q = first; q < first + rule * rule; q++)
    for (int t = 0; t < n_column; t++)
      sum[t] += share * k->weight[q] * k->h[(size_t)q * n_column + t];
  return first + rule * rule;
}

/* New value of a cell, and how far it is from that of the rule before. */
static int update(struct rad_view_cubature *c, const struct chunk *k, int i, int at) {
  struct rad_view_leaf *l = &c->leaf[i];
  double *value = c->value + (size_t)i * c->n_column, *change = c->change + (size_t)i * c->n_column;
  const struct rad_triangle *t = &c->scene->triangle[l->cell.triangle];
  double share = rad_view_cell_share(&l->cell) * t->area / c->area[l->surface];
  if (l->level == 0)
    at = apply_rule(k, at, rad_view_rule[0], share, value);
  l->before = l->change;
  memcpy(change, value, sizeof(double) * (size_t)c->n_column);
  at = apply_rule(k, at, rad_view_rule[++l->level], share, value);
  l->change = 0;
  for (int j = 0; j < c->n_column; j++) {
    change[j] = fabs(change[j] - value[j]);
    l->change = fmax(l->change, change[j]);
  }
  return at;
}

int rad_view_step_points(const struct rad_view_leaf *l) {
  int n = rad_view_rule[l->level + 1], low = rad_view_rule[0];
  return l->level == 0 ? low * low + n * n : n * n;
}

static int compare_int(const void *a, const void *b) {
  int x = *(const int *)a, y = *(const int *)b;
  return (x > y) - (x < y);
}

/* By triangle, so that rows come in long batches; counting keeps the order within one. */
static enum rad_code sort_by_triangle(const struct rad_view_cubature *c, int n, int *list,
                                      struct rad_error *e) {
  int n_triangle = c->scene->n_triangle;
  int *first = rad_calloc((size_t)n_triangle + 1, sizeof(int)), *copy = rad_alloc((size_t)n, 4);
  enum rad_code code = RAD_OK;
  if (!first || !copy)
    code = rad_fail_memory(e, "the view factors", 4.0 * n);
  else {
    qsort(list, (size_t)n, sizeof(int), compare_int);
    memcpy(copy, list, sizeof(int) * (size_t)n);
    for (int i = 0; i < n; i++)
      first[c->leaf[list[i]].cell.triangle + 1]++;
    for (int t = 0; t < n_triangle; t++)
      first[t + 1] += first[t];
    for (int i = 0; i < n; i++)
      list[first[c->leaf[copy[i]].cell.triangle]++] = copy[i];
  }
  free(first);
  free(copy);
  return code;
}

enum rad_code rad_view_cubature_step(struct rad_view_cubature *c, int n, int *list,
                                     struct rad_error *e) {
  struct chunk k;
  int size = chunk_size(c);
  enum rad_code code = chunk_init(c, &k, e);
  if (!code)
    code = sort_by_triangle(c, n, list, e);
  for (int done = 0, next = 0; done < n && !code; done = next) {
    k.n = 0;
    for (; next < n && k.n + rad_view_step_points(&c->leaf[list[next]]) <= size; next++) {
      const struct rad_view_leaf *l = &c->leaf[list[next]];
      if (l->level == 0)
        add_rule(&k, &l->cell, rad_view_rule[0]);
      add_rule(&k, &l->cell, rad_view_rule[l->level + 1]);
    }
    struct rad_point_list points = {k.n, k.triangle, k.base, (const double(*)[2])k.mu};
    code = rad_visit_rows(&c->mesh, &c->rules, c->sees, &points, gather, &k, e);
    for (int i = done, at = 0; i < next && !code; i++)
      at = update(c, &k, list[i], at);
    c->points += k.n;
  }
  chunk_free(&k);
  return code;
}

enum rad_code rad_view_cubature_split(struct rad_view_cubature *c, int i, int *list, int *n,
                                      struct rad_error *e) {
  struct rad_view_cell child[RAD_CELL_CHILDREN];
  struct rad_view_leaf parent = c->leaf[i];
  *n = rad_view_cell_split(&parent.cell, child);
  enum rad_code code = reserve(c, c->n + *n - 1, e);
  for (int k = 0; k < *n && !code; k++) {
    list[k] = k ? c->n++ : i;
    c->leaf[list[k]] =
        (struct rad_view_leaf){.cell = child[k], .surface = parent.surface, .change = INFINITY};
  }
  return code;
}

void rad_view_cubature_sum(const struct rad_view_cubature *c, const double *of, double *sum) {
  size_t row = (size_t)c->n_column;
  memset(sum, 0, sizeof(double) * (size_t)c->scene->n_surface * row);
  for (int i = 0; i < c->n; i++) {
    const double *from = of + (size_t)i * row;
    double *to = sum + (size_t)c->leaf[i].surface * row;
    for (size_t t = 0; t < row; t++)
      to[t] += from[t];
  }
}
