#include "scene/check.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/vec.h"
#include "scene/contact.h"

#define DEGENERATE 1e-14 /* area over longest edge squared; the rounding of the coordinates */

static const char *name_of(const struct rad_checked *c, int t) {
  return c->scene->surface_name[c->scene->triangle[t].surface];
}

const char *rad_checked_path(const struct rad_checked *c, int t) {
  return c->number[t] > c->n_deck ? c->mesh_path : c->path;
}

enum rad_code rad_check_fail(const struct rad_checked *c, int t, struct rad_error *e,
                             const char *fmt, ...) {
  char what[768], line[16] = "";
  va_list args;
  va_start(args, fmt);
  vsnprintf(what, sizeof what, fmt, args);
  va_end(args);
  if (c->scene->triangle[t].line > 0)
    snprintf(line, sizeof line, ":%d", c->scene->triangle[t].line);
  return rad_fail(e, RAD_EINPUT, "%s%s: error: triangle %d (%s): %s", rad_checked_path(c, t), line,
                  c->number[t], name_of(c, t), what);
}

enum rad_code rad_check_numbers(const struct rad_checked *c, struct rad_error *e) {
  const struct rad_scene *s = c->scene;
  for (int t = 0; t < s->n_triangle; t++) {
    for (int m = 0; m < 9; m++)
      if (!isfinite(s->triangle[t].v[m / 3][m % 3]))
        return rad_check_fail(c, t, e, "vertex %d has a coordinate that is not finite; correct it",
                              m / 3 + 1);
    for (int b = 0; b < s->n_band; b++) {
      double rho = s->rho[t * s->n_band + b];
      if (!(rho >= 0 && rho <= 1)) /* also not a number */
        return rad_check_fail(c, t, e, "rho is %g in band %s; give a number from 0 to 1", rho,
                              s->band[b]);
      for (int m = 0; m < 3; m++)
        if (!isfinite(s->emission[(3 * t + m) * s->n_band + b]))
          return rad_check_fail(c, t, e, "emission is not finite in band %s; correct it",
                                s->band[b]);
    }
  }
  return RAD_OK;
}

enum rad_code rad_check_shapes(const struct rad_checked *c, struct rad_error *e) {
  for (int t = 0; t < c->scene->n_triangle; t++) {
    const struct rad_triangle *tri = &c->scene->triangle[t];
    for (int m = 0; m < 3; m++)
      if (tri->vertex[m] == tri->vertex[(m + 1) % 3])
        return rad_check_fail(c, t, e,
                              "degenerate: vertices %d and %d are equal to 1e-10 of the scene's "
                              "size; move one or delete the triangle",
                              m + 1, (m + 1) % 3 + 1);
    double longest = rad_longest_edge(tri);
    if (tri->area < DEGENERATE * longest * longest)
      return rad_check_fail(c, t, e,
                            "degenerate: its vertices lie on a line (area %.3g, longest edge "
                            "%.3g); move one or delete the triangle",
                            tri->area, longest);
  }
  return RAD_OK;
}

/* A triangle by its vertices, in ascending order. */
struct key {
  int vertex[3], t;
};

static int compare_keys(const void *a, const void *b) {
  const struct key *p = a, *q = b;
  for (int m = 0; m < 3; m++)
    if (p->vertex[m] != q->vertex[m])
      return p->vertex[m] < q->vertex[m] ? -1 : 1;
  return (p->t > q->t) - (p->t < q->t);
}

static struct key key_of(const struct rad_triangle *tri, int t) {
  int a = tri->vertex[0], b = tri->vertex[1], c = tri->vertex[2];
  int least = a < b ? (a < c ? a : c) : (b < c ? b : c);
  int most = a > b ? (a > c ? a : c) : (b > c ? b : c);
  return (struct key){{least, a ^ b ^ c ^ least ^ most, most}, t};
}

enum rad_code rad_check_duplicates(const struct rad_checked *c, struct rad_error *e) {
  const struct rad_scene *s = c->scene;
  int n = s->n_triangle;
  struct key *key = calloc((size_t)n + 1, sizeof *key);
  if (!key)
    return rad_fail_memory(e, "the search for duplicate triangles", (double)n * sizeof *key);
  for (int t = 0; t < n; t++)
    key[t] = key_of(&s->triangle[t], t);
  qsort(key, (size_t)n, sizeof *key, compare_keys);
  int first = -1, second = -1;
  for (int m = 0; m < n && first < 0; m++)
    for (int o = m + 1; o < n && o <= m + 2; o++) { /* of three alike, two have the same normal */
      const struct rad_triangle *p = &s->triangle[key[m].t], *q = &s->triangle[key[o].t];
      if (key[m].vertex[0] != key[o].vertex[0] || key[m].vertex[1] != key[o].vertex[1] ||
          key[m].vertex[2] != key[o].vertex[2])
        break;
      if (rad_dot(p->normal, q->normal) > 0) {
        first = key[m].t;
        second = key[o].t;
        break;
      }
    }
  free(key);
  if (first < 0)
    return RAD_OK;
  return rad_check_fail(c, second, e,
                        "same vertices and same normal as triangle %d (%s); delete one of them, "
                        "or give them opposite normals to make a slit",
                        c->number[first], name_of(c, first));
}
