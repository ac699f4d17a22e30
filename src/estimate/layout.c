#include "estimate/layout.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec.h"

/* A graded leaf [0, b] is split at this part of b, a plain one in the middle. */
#define SPLIT_GRADED 0.2

static int black(const struct rad_scene *s, int t) {
  for (int b = 0; b < s->n_band; b++)
    if (s->rho[t * s->n_band + b] > 0)
      return 0;
  return 1;
}

static int dark(const struct rad_scene *s, int t) {
  if (s->emission_at)
    return 0;
  for (int i = 0; i < 3 * s->n_band; i++)
    if (s->emission[(size_t)t * 3 * (size_t)s->n_band + (size_t)i] != 0)
      return 0;
  return 1;
}

static int constant(const struct rad_scene *s, int t) {
  const double *e = s->emission + (size_t)t * 3 * (size_t)s->n_band;
  for (int i = 0; i < 2 * s->n_band; i++)
    if (e[i] != e[i + s->n_band])
      return 0;
  return 1;
}

/* Mark the triangles that light reaches, directly or after reflections. */
static void spread_light(const struct rad_scene *s, const unsigned char *sees, unsigned char *lit,
                         int *queue) {
  int n = s->n_triangle, head = 0, tail = 0;
  for (int t = 0; t < n; t++) {
    lit[t] = !dark(s, t);
    if (lit[t])
      queue[tail++] = t;
  }
  while (head < tail) {
    int i = queue[head++];
    for (int j = 0; j < n; j++)
      if (!lit[j] && sees[(size_t)i * n + j]) {
        lit[j] = 1;
        if (!black(s, j))
          queue[tail++] = j;
      }
  }
}

static int sees_any(const unsigned char *sees, int n, int i) {
  for (int j = 0; j < n; j++)
    if (sees[(size_t)i * n + j])
      return 1;
  return 0;
}

/* Grading exponent: p beta near 1.5 for 1e-3, 2.4 for 1e-6, 3 for 1e-8 (docs/performance.md). */
int rad_layout_grading(double exponent, double tolerance) {
  if (!(exponent < 1))
    return 1;
  double p = (0.6 - 0.3 * log10(tolerance)) / exponent;
  return (int)fmin(fmax(floor(p + 0.5), 2), 6);
}

static enum rad_code add_leaf(struct rad_layout *l, struct rad_leaf leaf, struct rad_error *e) {
  if (l->n_leaf == l->room) {
    int room = l->room ? 2 * l->room : 64;
    struct rad_leaf *grown = realloc(l->leaf, sizeof leaf * (size_t)room);
    if (!grown)
      return rad_fail_memory(e, "the adaptive mesh", (double)room * sizeof leaf);
    l->leaf = grown;
    l->room = room;
  }
  l->leaf[l->n_leaf++] = leaf;
  return RAD_OK;
}

/* One whole triangle as a plain patch with k x k points. */
static enum rad_code add_plain(struct rad_layout *l, int t, int k, struct rad_error *e) {
  int p = l->n_patch++;
  rad_patch_whole(l->scene, t, &l->patch[p]);
  l->p_phi[p] = l->p_r[p] = 1;
  return add_leaf(l, (struct rad_leaf){p, {0, 1}, {0, 1}, k, k, -1}, e);
}

/* Beyond this ratio of two lengths of a sub-triangle one element would hide what happens within the
 * shorter one from the samples of the estimate; its parts grow by GROWTH. */
#define WIDE 8
#define GROWTH 5
enum { MOST_BREAKS = 60 };

/* Borders of [0, 1] when all that happens within `near` of 0 is to be seen; returns the parts. */
static int grow_parts(double near, double border[MOST_BREAKS + 2]) {
  int n = 0;
  border[0] = 0;
  if (near * WIDE < 1)
    for (double x = 2 * near; x * GROWTH < 2 && n < MOST_BREAKS; x *= GROWTH)
      border[++n] = x;
  border[++n] = 1;
  return n;
}

/* The leaves of a sub-triangle: one, or in a needle several, from the short edge on. */
static enum rad_code add_parts(struct rad_layout *l, int p, double short_edge,
                               struct rad_error *e) {
  const struct rad_patch *patch = &l->patch[p];
  double phi[MOST_BREAKS + 2], r[MOST_BREAKS + 2], far[3];
  for (int d = 0; d < 3; d++)
    far[d] = patch->a[d] + patch->b[d];
  int n_phi = grow_parts(2 * patch->a1 / rad_norm(patch->b), phi);
  int n_r = grow_parts(short_edge / fmax(patch->a1, rad_norm(far)), r);
  int k_phi = l->p_phi[p] > 1 ? 4 : 3, k_r = l->p_r[p] > 1 ? 4 : 3;
  enum rad_code code = RAD_OK;
  for (int j = 0; j < n_r; j++)
    for (int i = 0; i < n_phi && !code; i++)
      code = add_leaf(
          l, (struct rad_leaf){p, {phi[i], phi[i + 1]}, {r[j], r[j + 1]}, k_phi, k_r, -1}, e);
  return code;
}

static double edge_length(const struct rad_triangle *t, int edge) {
  double f[3];
  rad_sub(t->v[(edge + 1) % 3], t->v[edge], f);
  return rad_norm(f);
}

/* Six sub-triangles with the gradings of their edges and vertices. */
static enum rad_code add_six(struct rad_layout *l, int t, const struct rad_exponents *x,
                             double tolerance, struct rad_error *e) {
  enum rad_code code = RAD_OK;
  for (int s = 0; s < RAD_N_SUB && !code; s++) {
    int p = l->n_patch++, edge = s / 2, vertex = s % 2 ? (edge + 1) % 3 : edge;
    rad_patch_sub_triangle(l->scene, t, s, RAD_ANGLE_POLAR, &l->patch[p]);
    l->p_phi[p] = rad_layout_grading(x->beta[t][edge], tolerance);
    l->p_r[p] = rad_layout_grading(x->alpha[t][vertex], tolerance);
    double at_vertex = fmin(edge_length(&l->scene->triangle[t], vertex),
                            edge_length(&l->scene->triangle[t], (vertex + 2) % 3));
    code = add_parts(l, p, at_vertex, e);
  }
  return code;
}

/* True if a triangle sees one that it touches: what that sends depends on the direction from their
 * common vertices. */
static int touched(const struct rad_scene *s, const unsigned char *sees, int t) {
  const int *v = s->triangle[t].vertex;
  for (int j = 0; j < s->n_triangle; j++)
    for (int c = 0; c < 3 && sees[(size_t)t * (size_t)s->n_triangle + (size_t)j]; c++) {
      int vertex = s->triangle[j].vertex[c];
      if (vertex == v[0] || vertex == v[1] || vertex == v[2])
        return 1;
    }
  return 0;
}

static int singular(const struct rad_exponents *x, int t) {
  for (int c = 0; c < 3; c++)
    if (x->beta[t][c] < 1 || x->alpha[t][c] < 1)
      return 1;
  return 0;
}

static enum rad_code add_triangle(struct rad_layout *l, int t, const unsigned char *sees, int lit,
                                  const struct rad_exponents *x, double tolerance,
                                  struct rad_error *e) {
  const struct rad_scene *s = l->scene;
  if (s->emission_at) /* E is any function: rows to estimate by, and polar at every vertex */
    return add_six(l, t, x, tolerance, e);
  l->passive[t] = !sees_any(sees, s->n_triangle, t) ? RAD_ALONE
                  : black(s, t)                     ? RAD_BLACK
                  : !lit                            ? RAD_UNLIT
                                                    : RAD_ACTIVE;
  if (l->passive[t])
    return add_plain(l, t, constant(s, t) ? 1 : 2, e);
  return singular(x, t) || touched(s, sees, t) ? add_six(l, t, x, tolerance, e)
                                               : add_plain(l, t, 3, e);
}

static enum rad_code allocate(struct rad_layout *l, struct rad_error *e) {
  size_t n = (size_t)l->scene->n_triangle;
  l->patch = rad_alloc(n * RAD_N_SUB, sizeof *l->patch);
  l->p_phi = rad_alloc(n * RAD_N_SUB, sizeof(int));
  l->p_r = rad_alloc(n * RAD_N_SUB, sizeof(int));
  l->passive = rad_calloc(n, 1);
  if (!l->patch || !l->p_phi || !l->p_r || !l->passive)
    return rad_fail_memory(e, "the adaptive mesh", (double)n * RAD_N_SUB * sizeof *l->patch);
  return RAD_OK;
}

enum rad_code rad_layout_begin(const struct rad_scene *scene, const unsigned char *sees,
                               double tolerance, struct rad_layout *l, struct rad_error *e) {
  *l = (struct rad_layout){.scene = scene};
  unsigned char *lit = rad_calloc((size_t)scene->n_triangle, 1);
  int *queue = rad_alloc((size_t)scene->n_triangle, sizeof(int));
  enum rad_code code = allocate(l, e);
  if (!code && (!lit || !queue))
    code = rad_fail_memory(e, "the adaptive mesh", 5.0 * scene->n_triangle);
  if (!code)
    code = rad_scene_exponents(scene, &l->exponents, e);
  if (!code)
    spread_light(scene, sees, lit, queue);
  for (int t = 0; t < scene->n_triangle && !code; t++)
    code = add_triangle(l, t, sees, lit[t], &l->exponents, tolerance, e);
  free(lit);
  free(queue);
  return code;
}

void rad_layout_free(struct rad_layout *l) {
  free(l->patch);
  free(l->p_phi);
  free(l->p_r);
  free(l->leaf);
  free(l->passive);
  rad_exponents_free(&l->exponents);
  *l = (struct rad_layout){0};
}

double rad_layout_unknowns(const struct rad_layout *l) {
  double n = 0;
  for (int i = 0; i < l->n_leaf; i++)
    if (!l->passive[l->patch[l->leaf[i].patch].triangle])
      n += (double)l->leaf[i].k_phi * l->leaf[i].k_r;
  return n;
}

enum rad_code rad_layout_mesh(const struct rad_layout *l, struct rad_mesh *mesh,
                              struct rad_error *e) {
  enum rad_code code = rad_mesh_begin(l->scene, NULL, mesh, e);
  for (int p = 0, i = 0; p < l->n_patch && !code; p++) {
    rad_mesh_add_patch(mesh, &l->patch[p]);
    for (; i < l->n_leaf && l->leaf[i].patch == p; i++) {
      const struct rad_leaf *f = &l->leaf[i];
      int pp = f->phi[0] == 0 ? l->p_phi[p] : 1, pr = f->r[0] == 0 ? l->p_r[p] : 1;
      rad_mesh_add_element(
          mesh,
          (struct rad_element){.sigma = {rad_ungraded(f->phi[0], pp), rad_ungraded(f->phi[1], pp)},
                               .tau = {rad_ungraded(f->r[0], pr), rad_ungraded(f->r[1], pr)},
                               .p_phi = pp,
                               .p_r = pr,
                               .k_phi = f->k_phi,
                               .k_r = f->k_r});
    }
  }
  return code ? code : rad_mesh_finish(mesh, e);
}

/* The parts of [lo, hi] after a split, or itself; returns their number. */
static int parts_of(const double range[2], int split, int graded, double part[3]) {
  part[0] = range[0];
  part[1] = part[2] = range[1];
  if (split)
    part[1] = graded ? SPLIT_GRADED * range[1] : 0.5 * (range[0] + range[1]);
  return split ? 2 : 1;
}

enum rad_code rad_layout_refine(struct rad_layout *l, const struct rad_refinement *what,
                                struct rad_error *e) {
  struct rad_leaf *old = l->leaf;
  int n = l->n_leaf;
  enum rad_code code = RAD_OK;
  l->leaf = NULL;
  l->n_leaf = l->room = 0;
  for (int i = 0; i < n && !code; i++) {
    const struct rad_leaf *f = &old[i];
    const struct rad_refinement *w = &what[i];
    int same = w->k_phi == f->k_phi && w->k_r == f->k_r && !w->split_phi && !w->split_r;
    double a[3], b[3];
    int na = parts_of(f->phi, w->split_phi, f->phi[0] == 0 && l->p_phi[f->patch] > 1, a);
    int nb = parts_of(f->r, w->split_r, f->r[0] == 0 && l->p_r[f->patch] > 1, b);
    for (int q = 0; q < nb && !code; q++)
      for (int p = 0; p < na && !code; p++)
        code = add_leaf(
            l,
            (struct rad_leaf){
                f->patch, {a[p], a[p + 1]}, {b[q], b[q + 1]}, w->k_phi, w->k_r, same ? i : -1},
            e);
  }
  free(old);
  return code;
}
