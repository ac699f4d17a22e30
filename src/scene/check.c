#include "scene/check.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/vec.h"

#define CONTACT 1e-9      /* of the scene's size: closer is touching */
#define DEGENERATE 1e-14  /* area over longest edge squared; the rounding of the coordinates */
#define SMALL_HEIGHT 1e-3 /* of the smaller triangle's height: an upper bound of the tolerance */

static const char *name_of(const struct rad_checked *c, int t) {
  return c->scene->surface_name[c->scene->triangle[t].surface];
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
  return rad_fail(e, RAD_EINPUT, "%s%s: error: triangle %d (%s): %s", c->path, line, c->number[t],
                  name_of(c, t), what);
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

static double longest_edge(const struct rad_triangle *t) {
  double longest = 0;
  for (int m = 0; m < 3; m++) {
    double edge[3];
    rad_sub(t->v[(m + 1) % 3], t->v[m], edge);
    longest = fmax(longest, rad_norm(edge));
  }
  return longest;
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
    double longest = longest_edge(tri);
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

static double distance(const double p[3], const double q[3]) {
  double d[3];
  rad_sub(p, q, d);
  return rad_norm(d);
}

/* Parameter, in [0, 1], of the point of segment p q that is closest to x. */
static double closest_parameter(const double x[3], const double p[3], const double q[3]) {
  double d[3], r[3];
  rad_sub(q, p, d);
  rad_sub(x, p, r);
  return fmin(fmax(rad_dot(r, d) / rad_dot(d, d), 0), 1);
}

static void along(const double p[3], const double q[3], double s, double x[3]) {
  for (int m = 0; m < 3; m++)
    x[m] = s < 0.5 ? p[m] + s * (q[m] - p[m]) : q[m] - (1 - s) * (q[m] - p[m]);
}

static double point_segment(const double x[3], const double p[3], const double q[3]) {
  double y[3];
  along(p, q, closest_parameter(x, p, q), y);
  return distance(x, y);
}

/* Segments p q and a b: the lines' closest point first, then each clamped to its segment in turn.
 * Cross products keep the digits that the usual a c - b^2 loses for nearly parallel segments. */
static double segment_segment(const double p[3], const double q[3], const double a[3],
                              const double b[3]) {
  double u[3], v[3], w[3], n[3], wv[3], x[3], y[3];
  rad_sub(q, p, u);
  rad_sub(b, a, v);
  rad_sub(a, p, w);
  rad_cross(u, v, n);
  rad_cross(w, v, wv);
  double nn = rad_dot(n, n);
  along(p, q, nn > 0 ? fmin(fmax(rad_dot(wv, n) / nn, 0), 1) : 0, x);
  along(a, b, closest_parameter(x, a, b), y);
  along(p, q, closest_parameter(y, p, q), x);
  return distance(x, y);
}

static double height_above(const double x[3], const struct rad_triangle *t) {
  double r[3];
  rad_sub(x, t->v[0], r);
  return rad_dot(r, t->normal);
}

static double point_triangle(const double x[3], const struct rad_triangle *t) {
  int n_left = 0, n_right = 0;
  double least = INFINITY;
  for (int m = 0; m < 3; m++) {
    const double *p = t->v[m], *q = t->v[(m + 1) % 3];
    double edge[3], r[3], normal[3];
    rad_sub(q, p, edge);
    rad_sub(x, p, r);
    rad_cross(edge, r, normal);
    double side = rad_dot(normal, t->normal);
    n_left += side > 0;
    n_right += side < 0;
    least = fmin(least, point_segment(x, p, q));
  }
  return n_left && n_right ? least : fmin(least, fabs(height_above(x, t)));
}

/* Whether segment p q comes within `tolerance` of triangle t. */
static int segment_near(const double p[3], const double q[3], const struct rad_triangle *t,
                        double tolerance) {
  double hp = height_above(p, t), hq = height_above(q, t), x[3];
  if (fmin(hp, hq) > tolerance || fmax(hp, hq) < -tolerance)
    return 0;
  if (point_triangle(p, t) <= tolerance || point_triangle(q, t) <= tolerance)
    return 1;
  for (int m = 0; m < 3; m++)
    if (segment_segment(p, q, t->v[m], t->v[(m + 1) % 3]) <= tolerance)
      return 1;
  if (!((hp < 0 && hq > 0) || (hp > 0 && hq < 0)))
    return 0;
  along(p, q, hp / (hp - hq), x);
  return point_triangle(x, t) <= tolerance;
}

/* Whether x, with a's edge p q shared, lies on a's side of p q in a's plane. */
static int folded(const double x[3], const double p[3], const double q[3], const double apex[3],
                  const struct rad_triangle *a, double tolerance) {
  double edge[3], inward[3], r[3], to_apex[3];
  rad_sub(q, p, edge);
  rad_sub(x, p, r);
  rad_sub(apex, p, to_apex);
  rad_cross(a->normal, edge, inward);
  double across = rad_dot(r, inward) / rad_norm(inward);
  across = rad_dot(to_apex, inward) < 0 ? -across : across;
  return fabs(rad_dot(r, a->normal)) <= tolerance && across > tolerance;
}

int rad_triangles_touch(const struct rad_triangle *a, const struct rad_triangle *b,
                        double tolerance) {
  double height = fmin(a->area / longest_edge(a), b->area / longest_edge(b)) * 2;
  tolerance = fmin(tolerance, SMALL_HEIGHT * height);
  int n_shared = 0, shared_a[3] = {0}, shared_b[3] = {0};
  for (int m = 0; m < 3; m++)
    for (int o = 0; o < 3; o++)
      if (a->vertex[m] == b->vertex[o]) {
        n_shared++;
        shared_a[m] = shared_b[o] = 1;
      }
  int apex_a = shared_a[0] ? (shared_a[1] ? 2 : 1) : 0; /* first vertex that is not shared */
  int apex_b = shared_b[0] ? (shared_b[1] ? 2 : 1) : 0;
  if (n_shared == 3)
    return 0;
  if (n_shared == 2) {
    const double *p = a->v[(apex_a + 1) % 3], *q = a->v[(apex_a + 2) % 3];
    return folded(b->v[apex_b], p, q, a->v[apex_a], a, tolerance) ||
           folded(a->v[apex_a], p, q, b->v[apex_b], b, tolerance);
  }
  for (int m = 0; m < 3; m++) {
    int next = (m + 1) % 3;
    if (!shared_a[m] && !shared_a[next] && segment_near(a->v[m], a->v[next], b, tolerance))
      return 1;
    if (!shared_b[m] && !shared_b[next] && segment_near(b->v[m], b->v[next], a, tolerance))
      return 1;
  }
  return 0;
}

struct box {
  double low[3], high[3];
  double start; /* low end along the sweep */
  int t;
};

static int compare_boxes(const void *a, const void *b) {
  const struct box *p = a, *q = b;
  if (p->start != q->start)
    return p->start < q->start ? -1 : 1;
  return (p->t > q->t) - (p->t < q->t);
}

/* Boxes of all triangles but second twins, sorted along the axis of largest spread: its number. */
static int sort_boxes(const struct rad_checked *c, struct box *box, int *n_box) {
  const struct rad_scene *s = c->scene;
  double sum[3] = {0}, square[3] = {0};
  int n = 0;
  for (int t = 0; t < s->n_triangle; t++) {
    if (t > 0 && c->number[t] == c->number[t - 1])
      continue;
    const struct rad_triangle *tri = &s->triangle[t];
    struct box *b = &box[n++];
    b->t = t;
    for (int m = 0; m < 3; m++) {
      b->low[m] = fmin(fmin(tri->v[0][m], tri->v[1][m]), tri->v[2][m]);
      b->high[m] = fmax(fmax(tri->v[0][m], tri->v[1][m]), tri->v[2][m]);
      double x = (b->low[m] + b->high[m]) / 2 - s->triangle[0].v[0][m];
      sum[m] += x;
      square[m] += x * x;
    }
  }
  int axis = 0;
  for (int m = 1; m < 3; m++)
    if (square[m] - sum[m] * sum[m] / n > square[axis] - sum[axis] * sum[axis] / n)
      axis = m;
  for (int k = 0; k < n; k++)
    box[k].start = box[k].low[axis];
  qsort(box, (size_t)n, sizeof *box, compare_boxes);
  *n_box = n;
  return axis;
}

/* The first pairs in deck order, of all those that were found. */
struct pairs {
  long n;
  int first[RAD_MAX_CONTACT_NOTES][2];
};

static void add_pair(struct pairs *p, int a, int b) {
  int low = a < b ? a : b, high = a < b ? b : a;
  int at = p->n < RAD_MAX_CONTACT_NOTES ? (int)p->n : RAD_MAX_CONTACT_NOTES;
  p->n++;
  while (at > 0 && (p->first[at - 1][0] > low ||
                    (p->first[at - 1][0] == low && p->first[at - 1][1] > high))) {
    at--;
    if (at + 1 < RAD_MAX_CONTACT_NOTES) {
      p->first[at + 1][0] = p->first[at][0];
      p->first[at + 1][1] = p->first[at][1];
    }
  }
  if (at < RAD_MAX_CONTACT_NOTES) {
    p->first[at][0] = low;
    p->first[at][1] = high;
  }
}

static void find_contacts(const struct rad_checked *c, const struct box *box, int n, int axis,
                          struct pairs *pairs) {
  double tolerance = CONTACT * c->scene->size;
  for (int k = 0; k < n; k++)
    for (int o = k + 1; o < n && box[o].start <= box[k].high[axis] + tolerance; o++) {
      int apart = 0;
      for (int m = 0; m < 3; m++)
        apart |= box[o].low[m] > box[k].high[m] + tolerance ||
                 box[k].low[m] > box[o].high[m] + tolerance;
      if (!apart && rad_triangles_touch(&c->scene->triangle[box[k].t],
                                        &c->scene->triangle[box[o].t], tolerance))
        add_pair(pairs, box[k].t, box[o].t);
    }
}

static void note_contacts(const struct rad_checked *c, const struct pairs *pairs,
                          struct rad_notes *notes) {
  for (int k = 0; k < pairs->n && k < RAD_MAX_CONTACT_NOTES; k++) {
    int a = pairs->first[k][0], b = pairs->first[k][1];
    char line[16] = "";
    if (c->scene->triangle[b].line > 0)
      snprintf(line, sizeof line, ":%d", c->scene->triangle[b].line);
    rad_notes_add(notes,
                  "%s%s: warning: triangle %d (%s) touches triangle %d (%s) other than in a vertex "
                  "or a whole edge; divide them so that they share vertices and edges",
                  c->path, line, c->number[b], name_of(c, b), c->number[a], name_of(c, a));
  }
  long more = pairs->n - RAD_MAX_CONTACT_NOTES;
  if (more > 0)
    rad_notes_add(notes,
                  "%s: warning: and %ld more pair%s of triangles touch%s other than in a vertex or "
                  "a whole edge",
                  c->path, more, more > 1 ? "s" : "", more > 1 ? "" : "es");
}

enum rad_code rad_check_contacts(const struct rad_checked *c, struct rad_notes *notes,
                                 struct rad_error *e) {
  struct box *box = calloc((size_t)c->scene->n_triangle + 1, sizeof *box);
  if (!box)
    return rad_fail_memory(e, "the search for touching triangles",
                           (double)c->scene->n_triangle * sizeof *box);
  int n = 0;
  int axis = sort_boxes(c, box, &n);
  struct pairs pairs = {0};
  find_contacts(c, box, n, axis, &pairs);
  free(box);
  note_contacts(c, &pairs, notes);
  return RAD_OK;
}
