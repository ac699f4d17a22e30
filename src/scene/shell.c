#include "scene/shell.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/union_find.h"
#include "base/vec.h"

#define CLOSED 1e-11    /* sum of the line integrals over the length of all edges: rounding */
#define ROUNDING 16     /* of coordinates, in units of the last place */
#define LEAST_FILL 1e-9 /* volume over area times size: less is none */

enum { N_FIELD = 3 };

/* Fields G(x) = a sin(k.x + phase), x in units of the shell's size: any that are not special. */
static const struct {
  double a[3], k[3], phase;
} FIELD[N_FIELD] = {{{0.62, -0.31, 0.72}, {2.3, 1.7, -1.1}, 0.4},
                    {{-0.45, 0.81, 0.37}, {-1.3, 2.1, 1.9}, 1.9},
                    {{0.28, 0.55, -0.79}, {1.2, -2.6, 1.5}, 3.1}};

/* What is known of a shell on the way. */
struct sums {
  double low[3], high[3], size;
  double rim[N_FIELD], length, area, farthest;
};

/* Shells by common vertices; their number. */
static int join(const struct rad_scene *scene, int *parent, int *number, int *shell) {
  int n = 0;
  for (int v = 0; v < scene->n_vertex; v++) {
    parent[v] = v;
    number[v] = -1;
  }
  for (int t = 0; t < scene->n_triangle; t++)
    for (int m = 1; m < 3; m++)
      rad_unite(parent, scene->triangle[t].vertex[0], scene->triangle[t].vertex[m]);
  for (int t = 0; t < scene->n_triangle; t++) {
    int *known = &number[rad_find_root(parent, scene->triangle[t].vertex[0])];
    if (*known < 0)
      *known = n++;
    shell[t] = *known;
  }
  return n;
}

static void extend(struct sums *s, const struct rad_triangle *t) {
  for (int m = 0; m < 9; m++) {
    double x = t->v[m / 3][m % 3];
    s->low[m % 3] = fmin(s->low[m % 3], x);
    s->high[m % 3] = fmax(s->high[m % 3], x);
    s->farthest = fmax(s->farthest, fabs(x));
  }
  s->size = hypot(s->high[0] - s->low[0], hypot(s->high[1] - s->low[1], s->high[2] - s->low[2]));
}

/* The integral of field f from p to q, straight: a.(q-p) times the mean of a sine whose argument
 * is linear, sin(middle) sin(z)/z with z half its change. */
static double integral(int f, const double p[3], const double q[3]) {
  double d[3];
  rad_sub(q, p, d);
  double z = rad_dot(FIELD[f].k, d) / 2;
  double mean = fabs(z) > 1e-8 ? sin(z) / z : 1;
  return rad_dot(FIELD[f].a, d) * mean * sin(FIELD[f].phase + rad_dot(FIELD[f].k, p) + z);
}

/* Add the triangle's rim, counterclockwise as seen from its radiating side; its part of the volume
 * is that of the cone over it from the shell's lowest corner. */
static void add_triangle(struct sums *s, const struct rad_triangle *t, double *volume) {
  double x[3][3], u[3], v[3], normal[3];
  for (int m = 0; m < 9; m++)
    x[m / 3][m % 3] = (t->v[m / 3][m % 3] - s->low[m % 3]) / s->size;
  rad_sub(x[1], x[0], u);
  rad_sub(x[2], x[0], v);
  rad_cross(u, v, normal);
  int turned = rad_dot(normal, t->normal) < 0;
  for (int m = 0; m < 3; m++) {
    const double *p = x[m], *q = x[(m + 1) % 3];
    double d[3];
    rad_sub(q, p, d);
    s->length += rad_norm(d);
    for (int f = 0; f < N_FIELD; f++)
      s->rim[f] += turned ? -integral(f, p, q) : integral(f, p, q);
  }
  s->area += t->area;
  double r[3];
  rad_sub(t->v[0], s->low, r);
  *volume += t->area * rad_dot(r, t->normal) / 3;
}

static int is_closed(const struct sums *s, double volume) {
  double most = (CLOSED + ROUNDING * DBL_EPSILON * s->farthest / s->size) * s->length;
  for (int f = 0; f < N_FIELD; f++)
    if (!(fabs(s->rim[f]) <= most))
      return 0;
  return fabs(volume) > LEAST_FILL * s->area * s->size;
}

static void measure(const struct rad_scene *scene, struct rad_shells *s, struct sums *sums) {
  for (int k = 0; k < s->n; k++)
    sums[k] = (struct sums){.low = {INFINITY, INFINITY, INFINITY},
                            .high = {-INFINITY, -INFINITY, -INFINITY}};
  for (int t = 0; t < scene->n_triangle; t++)
    extend(&sums[s->shell[t]], &scene->triangle[t]);
  for (int t = 0; t < scene->n_triangle; t++)
    add_triangle(&sums[s->shell[t]], &scene->triangle[t], &s->volume[s->shell[t]]);
  for (int k = 0; k < s->n; k++)
    s->closed[k] = (unsigned char)is_closed(&sums[k], s->volume[k]);
}

static enum rad_code fail_memory(const struct rad_scene *scene, struct rad_error *e) {
  return rad_fail_memory(e, "the search for closed shells", 200.0 * scene->n_triangle);
}

enum rad_code rad_shells_measure(const struct rad_scene *scene, struct rad_shells *s,
                                 struct rad_error *e) {
  struct sums *sums = rad_alloc((size_t)s->n, sizeof *sums);
  s->closed = rad_calloc((size_t)s->n, sizeof *s->closed);
  s->volume = rad_calloc((size_t)s->n, sizeof *s->volume);
  int made = s->closed && s->volume && sums;
  if (made)
    measure(scene, s, sums);
  free(sums);
  return made ? RAD_OK : fail_memory(scene, e);
}

enum rad_code rad_shells_find(const struct rad_scene *scene, struct rad_shells *s,
                              struct rad_error *e) {
  *s = (struct rad_shells){.shell = rad_alloc((size_t)scene->n_triangle, sizeof *s->shell)};
  int *parent = rad_alloc((size_t)scene->n_vertex, sizeof *parent);
  int *number = rad_alloc((size_t)scene->n_vertex, sizeof *number);
  int made = s->shell && parent && number;
  if (made)
    s->n = join(scene, parent, number, s->shell);
  free(parent);
  free(number);
  return made ? rad_shells_measure(scene, s, e) : fail_memory(scene, e);
}

void rad_shells_free(struct rad_shells *s) {
  free(s->shell);
  free(s->closed);
  free(s->volume);
  *s = (struct rad_shells){0};
}
