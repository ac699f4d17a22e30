#include "scene/contact.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "base/vec.h"
#include "scene/box_pairs.h"
#include "scene/intersect.h"

#define CONTACT 1e-9      /* of the scene's size: closer is touching */
#define SMALL_HEIGHT 1e-3 /* of the smaller triangle's height: an upper bound of the tolerance */
#define ROUNDING 16 /* of coordinates that were turned and shifted, in units of the last place */
#define FLUSH 1e-12 /* of the larger triangle: heights that count as none when faces see */

/* --- two triangles --- */

double rad_longest_edge(const struct rad_triangle *t) {
  double longest = 0;
  for (int m = 0; m < 3; m++) {
    double edge[3];
    rad_sub(t->v[(m + 1) % 3], t->v[m], edge);
    longest = fmax(longest, rad_norm(edge));
  }
  return longest;
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

static double lowered(double tolerance, const struct rad_triangle *a,
                      const struct rad_triangle *b) {
  double height = fmin(a->area / rad_longest_edge(a), b->area / rad_longest_edge(b)) * 2;
  return fmin(tolerance, SMALL_HEIGHT * height);
}

int rad_triangles_touch(const struct rad_triangle *a, const struct rad_triangle *b,
                        double tolerance) {
  tolerance = lowered(tolerance, a, b);
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

/* Of a triangle's coordinates. */
static double rounding_of(const struct rad_triangle *t) {
  double largest = 0;
  for (int m = 0; m < 9; m++)
    largest = fmax(largest, fabs(t->v[m / 3][m % 3]));
  return ROUNDING * DBL_EPSILON * largest;
}

static int share_all(const struct rad_triangle *a, const struct rad_triangle *b) {
  int n = 0;
  for (int m = 0; m < 9; m++)
    n += a->vertex[m / 3] == b->vertex[m % 3];
  return n == 3;
}

enum rad_contact rad_contact_of(const struct rad_triangle *a, const struct rad_triangle *b,
                                int two_sided, double tolerance) {
  double least = fmax(rounding_of(a), rounding_of(b)), above = 0;
  double lower = fmax(lowered(tolerance, a, b), least);
  if (share_all(a, b) || rad_triangles_overlap(a, b, lower, &above)) {
    if (two_sided || rad_dot(a->normal, b->normal) > 0)
      return RAD_OVERLAPPING;
    double flush = fmax(FLUSH * fmax(rad_longest_edge(a), rad_longest_edge(b)), least);
    return above <= flush ? RAD_BACK_TO_BACK : RAD_TOUCHING;
  }
  if (rad_triangles_cross(a, b, lower))
    return RAD_CROSSING;
  return rad_triangles_touch(a, b, fmax(tolerance, least)) ? RAD_TOUCHING : RAD_APART;
}

/* --- all of them --- */

struct search {
  const struct rad_scene *scene;
  const int *number;
  double tolerance;
  void (*found)(void *context, int low, int high, enum rad_contact kind);
  void *context;
};

static int is_two_sided(const struct search *s, int t) {
  return t + 1 < s->scene->n_triangle && s->number[t] == s->number[t + 1];
}

static void try_pair(void *context, int a, int b) {
  const struct search *s = context;
  const struct rad_triangle *t = s->scene->triangle;
  int low = a < b ? a : b, high = a < b ? b : a;
  enum rad_contact kind = rad_contact_of(
      &t[low], &t[high], is_two_sided(s, low) || is_two_sided(s, high), s->tolerance);
  if (kind != RAD_APART)
    s->found(s->context, low, high, kind);
}

/* Boxes of all triangles but second twins, wider by the tolerance: their number. */
static int make_boxes(const struct rad_scene *s, const int *number, double tolerance,
                      struct rad_box *box) {
  int n = 0;
  for (int t = 0; t < s->n_triangle; t++) {
    if (t > 0 && number[t] == number[t - 1])
      continue;
    const double(*v)[3] = s->triangle[t].v;
    struct rad_box *b = &box[n++];
    b->item = t;
    for (int m = 0; m < 3; m++) {
      b->low[m] = fmin(fmin(v[0][m], v[1][m]), v[2][m]) - tolerance;
      b->high[m] = fmax(fmax(v[0][m], v[1][m]), v[2][m]) + tolerance;
    }
  }
  return n;
}

enum rad_code rad_find_contacts(const struct rad_scene *s, const int *number,
                                void (*found)(void *context, int low, int high,
                                              enum rad_contact kind),
                                void *context, struct rad_error *e) {
  struct rad_box *box = calloc((size_t)s->n_triangle + 1, sizeof *box);
  if (!box)
    return rad_fail_memory(e, "the search for touching triangles",
                           (double)s->n_triangle * sizeof *box);
  double farthest = 0;
  for (int t = 0; t < s->n_triangle; t++)
    farthest = fmax(farthest, rounding_of(&s->triangle[t]));
  struct search search = {s, number, CONTACT * s->size, found, context};
  int n = make_boxes(s, number, fmax(search.tolerance, farthest), box);
  enum rad_code code = rad_box_pairs(n, box, try_pair, &search, e);
  free(box);
  return code;
}
