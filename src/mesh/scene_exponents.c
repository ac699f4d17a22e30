#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/vec.h"
#include "mesh/exponents.h"

#define IN_PLANE 1e-10  /* height over distance that counts as zero */
#define SAME_ANGLE 1e-9 /* [rad] faces of a slit */

/* One side of a triangle: its edge from v[slot] to v[slot + 1]. */
struct side {
  int low, high; /* the edge's vertices, in order of number */
  int triangle, slot;
  double inward[3]; /* unit vector in the triangle, perpendicular to the edge */
};

static int by_edge(const void *a, const void *b) {
  const struct side *s = a, *t = b;
  if (s->low != t->low)
    return s->low < t->low ? -1 : 1;
  if (s->high != t->high)
    return s->high < t->high ? -1 : 1;
  return 3 * (s->triangle - t->triangle) + s->slot - t->slot;
}

static void unit(const double from[3], const double to[3], double d[3]) {
  rad_sub(to, from, d);
  double length = rad_norm(d);
  for (int m = 0; m < 3; m++)
    d[m] /= length;
}

static struct side side_of(const struct rad_triangle *t, int triangle, int slot) {
  int next = (slot + 1) % 3, a = t->vertex[slot], b = t->vertex[next];
  struct side s = {a < b ? a : b, a < b ? b : a, triangle, slot, {0}};
  double along[3], to_third[3], zero[3] = {0};
  unit(t->v[slot], t->v[next], along);
  rad_sub(t->v[(slot + 2) % 3], t->v[slot], to_third);
  double c = rad_dot(along, to_third);
  for (int m = 0; m < 3; m++)
    to_third[m] -= c * along[m];
  unit(zero, to_third, s.inward);
  return s;
}

/* Angle from side s, on its radiating side, to side t; INFINITY if t is not in front. */
static double angle_to(const struct rad_scene *scene, const struct side *s, const struct side *t) {
  double turn[3];
  if (!(rad_dot(scene->triangle[s->triangle].normal, t->inward) > IN_PLANE))
    return INFINITY;
  rad_cross(s->inward, t->inward, turn);
  return atan2(rad_norm(turn), rad_dot(s->inward, t->inward));
}

/* beta of one side among the n sides of its edge: with what it meets first in front of it. */
static double beta_of(const struct rad_scene *scene, const struct side *s, int n,
                      const struct side *around) {
  double least = INFINITY, beta = INFINITY;
  for (int j = 0; j < n; j++)
    least = fmin(least, angle_to(scene, s, &around[j]));
  for (int j = 0; j < n; j++) {
    double gamma = angle_to(scene, s, &around[j]);
    if (!(gamma <= least + SAME_ANGLE) || isinf(gamma) || isinf(angle_to(scene, &around[j], s)))
      continue;
    for (int b = 0; b < scene->n_band; b++) {
      const double *rho = scene->rho + b;
      beta = fmin(beta, rad_edge_exponent(rho[s->triangle * scene->n_band],
                                          rho[around[j].triangle * scene->n_band], gamma));
    }
  }
  return beta;
}

static enum rad_code edges(const struct rad_scene *scene, double (*beta)[3], struct rad_error *e) {
  size_t n = 3 * (size_t)scene->n_triangle;
  struct side *side = rad_alloc(n, sizeof *side);
  if (!side)
    return rad_fail_memory(e, "the edges of the scene", (double)(n * sizeof *side));
  for (size_t i = 0; i < n; i++)
    side[i] = side_of(&scene->triangle[i / 3], (int)(i / 3), (int)(i % 3));
  qsort(side, n, sizeof *side, by_edge);
  for (size_t first = 0, last; first < n; first = last) {
    for (last = first + 1;
         last < n && side[last].low == side[first].low && side[last].high == side[first].high;)
      last++;
    for (size_t i = first; i < last; i++)
      beta[side[i].triangle][side[i].slot] =
          beta_of(scene, &side[i], (int)(last - first), side + first);
  }
  free(side);
  return RAD_OK;
}

/* The corners of the triangles at a vertex, as 3 triangle + slot. */
struct fan {
  int n;
  const int *corner;
};

static int is_flat(int n, const struct rad_cone_face *face) {
  for (int i = 1; i < n; i++)
    for (int m = 0; m < 2; m++)
      if (fabs(rad_dot(face[0].normal, face[i].edge[m])) > IN_PLANE)
        return 0;
  return 1;
}

/* True if some other band reflects at least as much everywhere: its alpha is not larger. */
static int is_outshone(const struct rad_scene *scene, struct fan fan, int band) {
  for (int other = 0; other < scene->n_band; other++) {
    int less = 0, more = 0;
    for (int i = 0; i < fan.n; i++) {
      const double *rho = scene->rho + (fan.corner[i] / 3) * scene->n_band;
      less |= rho[other] < rho[band];
      more |= rho[other] > rho[band];
    }
    if (!less && (more || other < band))
      return 1;
  }
  return 0;
}

static enum rad_code alpha_of(const struct rad_scene *scene, const struct rad_gauss *g,
                              struct fan fan, double *alpha, struct rad_error *e) {
  *alpha = INFINITY;
  struct rad_cone_face *face = rad_alloc((size_t)fan.n, sizeof *face);
  if (!face)
    return rad_fail_memory(e, "the faces at a vertex", (double)((size_t)fan.n * sizeof *face));
  for (int i = 0; i < fan.n; i++) {
    const struct rad_triangle *t = &scene->triangle[fan.corner[i] / 3];
    int slot = fan.corner[i] % 3;
    for (int m = 0; m < 2; m++)
      unit(t->v[slot], t->v[(slot + 1 + m) % 3], face[i].edge[m]);
    for (int m = 0; m < 3; m++)
      face[i].normal[m] = t->normal[m];
  }
  enum rad_code code = RAD_OK;
  for (int b = 0; b < scene->n_band && code == RAD_OK && !is_flat(fan.n, face); b++) {
    double value;
    if (is_outshone(scene, fan, b))
      continue;
    for (int i = 0; i < fan.n; i++)
      face[i].rho = scene->rho[(fan.corner[i] / 3) * scene->n_band + b];
    code = rad_vertex_exponent(g, fan.n, face, &value, e);
    *alpha = fmin(*alpha, value);
  }
  free(face);
  return code;
}

/* Corners sorted by vertex: those of vertex v are corner[first[v]] .. corner[first[v + 1] - 1]. */
static void sort_corners(const struct rad_scene *scene, int *first, int *corner) {
  for (int c = 0; c < 3 * scene->n_triangle; c++)
    first[scene->triangle[c / 3].vertex[c % 3] + 1]++;
  for (int v = 0; v < scene->n_vertex; v++)
    first[v + 1] += first[v];
  for (int c = 0; c < 3 * scene->n_triangle; c++)
    corner[first[scene->triangle[c / 3].vertex[c % 3]]++] = c;
  for (int v = scene->n_vertex; v > 0; v--)
    first[v] = first[v - 1];
  first[0] = 0;
}

static int is_black(const struct rad_scene *scene, int triangle) {
  for (int b = 0; b < scene->n_band; b++)
    if (scene->rho[triangle * scene->n_band + b] > 0)
      return 0;
  return 1;
}

static enum rad_code vertices(const struct rad_scene *scene, const struct rad_gauss *g,
                              double (*alpha)[3], struct rad_error *e) {
  int n = scene->n_vertex, failed = 0;
  size_t n_corner = 3 * (size_t)scene->n_triangle;
  int *first = rad_calloc((size_t)n + 1, sizeof *first);
  int *corner = rad_alloc(n_corner, sizeof *corner);
  if (first && corner) {
    sort_corners(scene, first, corner);
    rad_progress_begin(scene->progress, "vertices", n);
#pragma omp parallel for schedule(dynamic) default(none)                                           \
    shared(scene, g, alpha, first, corner, n, failed)
    for (int v = 0; v < n; v++) {
      struct fan fan = {first[v + 1] - first[v], corner + first[v]};
      struct rad_error mine;
      double value;
      if (alpha_of(scene, g, fan, &value, &mine) != RAD_OK) {
#pragma omp atomic write
        failed = 1;
      }
      for (int i = 0; i < fan.n; i++) {
        int triangle = fan.corner[i] / 3;
        alpha[triangle][fan.corner[i] % 3] = is_black(scene, triangle) ? INFINITY : value;
      }
      rad_progress_add(scene->progress, 1);
    }
  } else {
    failed = 1;
  }
  free(first);
  free(corner);
  return failed ? rad_fail_memory(e, "the exponents of the vertices", 12. * (double)n_corner)
                : RAD_OK;
}

enum rad_code rad_scene_exponents(const struct rad_scene *scene, struct rad_exponents *x,
                                  struct rad_error *e) {
  struct rad_gauss g = {0};
  size_t n = (size_t)scene->n_triangle;
  *x = (struct rad_exponents){.n_triangle = scene->n_triangle};
  x->beta = rad_alloc(n, sizeof *x->beta);
  x->alpha = rad_alloc(n, sizeof *x->alpha);
  if (!x->beta || !x->alpha)
    return rad_fail_memory(e, "the exponents of the scene", 48. * (double)n);
  enum rad_code code = rad_gauss_init(&g, e);
  if (code == RAD_OK)
    code = edges(scene, x->beta, e);
  if (code == RAD_OK)
    code = vertices(scene, &g, x->alpha, e);
  rad_gauss_free(&g);
  return code;
}

void rad_exponents_free(struct rad_exponents *x) {
  free(x->beta);
  free(x->alpha);
  *x = (struct rad_exponents){0};
}
