#include "scene/weld.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"

#define WELD 1e-10          /* of the scene's size: closer vertices are one */
#define SMALLEST_SIZE 1e-60 /* fourth powers of lengths must stay finite and normal */
#define LARGEST_SIZE 1e60

/* The scene's size, and the lowest corner of its bounding box. */
static enum rad_code measure(struct rad_scene *scene, const char *path, double low[3],
                             struct rad_error *e) {
  double extent[3];
  for (int m = 0; m < 3; m++) {
    double high = low[m] = scene->triangle[0].v[0][m];
    for (int k = 0; k < 3 * scene->n_triangle; k++) {
      low[m] = fmin(low[m], scene->triangle[k / 3].v[k % 3][m]);
      high = fmax(high, scene->triangle[k / 3].v[k % 3][m]);
    }
    extent[m] = high - low[m];
  }
  scene->size = hypot(extent[0], hypot(extent[1], extent[2]));
  if (scene->size >= SMALLEST_SIZE && scene->size <= LARGEST_SIZE)
    return RAD_OK;
  return rad_fail(e, RAD_EINPUT,
                  "%s: error: the bounding box of the scene has diameter %g; give lengths "
                  "in a unit that makes it %g to %g",
                  path, scene->size, SMALLEST_SIZE, LARGEST_SIZE);
}

/* Vertices by the cell of a regular grid they lie in. */
struct grid {
  double low[3], cell, radius;
  size_t mask; /* number of buckets, a power of two, minus 1 */
  int *head;   /* owned [mask + 1] first vertex of a bucket, or -1 */
  int *next;   /* owned: next vertex in the same bucket, or -1 */
};

static size_t bucket(const struct grid *g, const int64_t cell[3]) {
  uint64_t hash = (uint64_t)cell[0] * 0x9E3779B97F4A7C15u;
  hash = (hash ^ (hash >> 29) ^ (uint64_t)cell[1]) * 0xBF58476D1CE4E5B9u;
  hash = (hash ^ (hash >> 32) ^ (uint64_t)cell[2]) * 0x94D049BB133111EBu;
  return (size_t)(hash ^ (hash >> 31)) & g->mask;
}

static int64_t cell_of(const struct grid *g, int axis, double x) {
  return (int64_t)floor((x - g->low[axis]) / g->cell);
}

/* The nearest vertex within the radius of x, or -1. Cells are much wider than the radius, so that
 * mostly one cell is looked at. */
static int nearest_vertex(const struct grid *g, const struct rad_scene *scene, const double x[3]) {
  int64_t first[3], last[3], c[3];
  for (int m = 0; m < 3; m++) {
    first[m] = cell_of(g, m, x[m] - g->radius);
    last[m] = cell_of(g, m, x[m] + g->radius);
  }
  int nearest = -1;
  double least = g->radius;
  for (c[0] = first[0]; c[0] <= last[0]; c[0]++)
    for (c[1] = first[1]; c[1] <= last[1]; c[1]++)
      for (c[2] = first[2]; c[2] <= last[2]; c[2]++)
        for (int v = g->head[bucket(g, c)]; v >= 0; v = g->next[v]) {
          double d[3];
          rad_sub(x, scene->vertex[v], d);
          double distance = rad_norm(d);
          if (distance < least || (distance == least && nearest < 0)) {
            least = distance;
            nearest = v;
          }
        }
  return nearest;
}

/* Number the vertices; corners that weld take the coordinates of the one met first. */
static void weld_corners(struct rad_scene *scene, struct grid *g) {
  for (int k = 0; k < 3 * scene->n_triangle; k++) {
    struct rad_triangle *t = &scene->triangle[k / 3];
    double *x = t->v[k % 3];
    int v = nearest_vertex(g, scene, x);
    if (v < 0) {
      v = scene->n_vertex++;
      memcpy(scene->vertex[v], x, sizeof scene->vertex[v]);
      int64_t cell[3] = {cell_of(g, 0, x[0]), cell_of(g, 1, x[1]), cell_of(g, 2, x[2])};
      size_t at = bucket(g, cell);
      g->next[v] = g->head[at];
      g->head[at] = v;
    }
    memcpy(x, scene->vertex[v], sizeof scene->vertex[v]);
    t->vertex[k % 3] = v;
  }
}

enum rad_code rad_weld(struct rad_scene *scene, const char *path, struct rad_error *e) {
  struct grid g = {0};
  enum rad_code code = measure(scene, path, g.low, e);
  if (code)
    return code;
  g.radius = WELD * scene->size;
  g.cell = 16 * g.radius;
  size_t n = 3 * (size_t)scene->n_triangle, n_bucket = 16;
  while (n_bucket < n)
    n_bucket *= 2;
  g.mask = n_bucket - 1;
  g.head = malloc(n_bucket * sizeof *g.head);
  g.next = malloc(n * sizeof *g.next);
  scene->vertex = malloc(n * sizeof *scene->vertex);
  if (!g.head || !g.next || !scene->vertex) {
    code = rad_fail_memory(e, "the scene", 40.0 * (double)n);
  } else {
    memset(g.head, -1, n_bucket * sizeof *g.head);
    weld_corners(scene, &g);
  }
  free(g.head);
  free(g.next);
  return code;
}
