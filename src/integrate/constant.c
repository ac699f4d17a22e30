#include "integrate/constant.h"

#include <math.h>

#include "base/simd_math.h"
#include "base/vec.h"

#define INLINE static inline __attribute__((always_inline))

#define ROUNDING 4e-16 /* see rad_facet_values */
#define BEHIND 1e-13   /* depth over distance that may be rounding; rad_side_of cuts from 1e-12 */
#define NARROW 0.17157 /* tan(pi/8)^2, up to which rad_atan_ratio may be used */

struct vec {
  double x, y, z;
};

INLINE struct vec load(const double a[3]) {
  return (struct vec){a[0], a[1], a[2]};
}

INLINE double dot(struct vec a, struct vec b) {
  return a.x * b.x + (a.y * b.y + a.z * b.z);
}

INLINE struct vec cross(struct vec a, struct vec b) {
  return (struct vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* y - v - d: exact where y = v. */
INLINE struct vec from(struct vec y, const struct rad_facet_targets *t, int i) {
  return (struct vec){(y.x - t->v[0][i]) - t->d[0][i], (y.y - t->v[1][i]) - t->d[1][i],
                      (y.z - t->v[2][i]) - t->d[2][i]};
}

/* What the sides add up to. */
struct sums {
  double value, rounding; /* sum theta n.Gamma; sum of the terms' errors in units of ROUNDING */
  double widest;          /* largest tan(theta)^2, INFINITY from a right angle on */
};

/* theta / |c| of c = a x side, b = a + side; wide: at any angle, else up to pi/8. */
INLINE double angle_over_length(const int wide, double c2, double along) {
  if (wide) {
    double length = sqrt(c2);
    return rad_atan2(length, along) / (length > 0 ? length : 1);
  }
  double inverse = 1 / along;
  return rad_atan_ratio(c2 * inverse * inverse) * inverse;
}

INLINE struct sums add_side(const int wide, struct sums s, struct vec a, struct vec b,
                            struct vec side, double length, struct vec n) {
  struct vec c = cross(a, side);
  double c2 = dot(c, c), along = dot(a, b), w = angle_over_length(wide, c2, along);
  s.value += w * dot(c, n);
  s.rounding += w * length * (fabs(a.x) + fabs(a.y) + fabs(a.z));
  s.widest = along > 0 && c2 <= NARROW * (along * along) ? s.widest : INFINITY;
  return s;
}

/* RAD_FACET_LANES targets. Returns 1 if there are NANs, 2 if an angle is too wide. */
INLINE int lanes(const int wide, const struct rad_facet_source *s,
                 const struct rad_facet_targets *t, int first, struct rad_facet_error allowed,
                 double *restrict value) {
  const struct vec v0 = load(s->v[0]), v1 = load(s->v[1]), v2 = load(s->v[2]);
  const struct vec s0 = load(s->side[0]), s1 = load(s->side[1]), s2 = load(s->side[2]);
  const struct vec normal = load(s->normal);
  const double l0 = s->length[0], l1 = s->length[1], l2 = s->length[2], scale = s->scale;
  int flags = 0;
#pragma omp simd reduction(| : flags)
  for (int i = 0; i < RAD_FACET_LANES; i++) {
    int at = first + i;
    struct vec a = from(v0, t, at), b = from(v1, t, at), c = from(v2, t, at);
    struct vec n = {t->normal[0][at], t->normal[1][at], t->normal[2][at]};
    struct sums sums = {0, 0, 0};
    sums = add_side(wide, sums, a, b, s0, l0, n);
    sums = add_side(wide, sums, b, c, s1, l1, n);
    sums = add_side(wide, sums, c, a, s2, l2, n);
    double result = scale * sums.value, ha = dot(a, n), hb = dot(b, n), hc = dot(c, n);
    double lowest = ha < hb ? ha : hb, depth = BEHIND * (fabs(a.x) + fabs(a.y) + fabs(a.z));
    lowest = lowest < hc ? lowest : hc;
    int visible = dot(a, normal) < 0;
    double error = fabs(scale) * ROUNDING * sums.rounding;
    int sure =
        lowest >= -depth && (error <= allowed.relative * result || error <= allowed.absolute);
    value[i] = visible ? (sure ? result : NAN) : 0;
    flags |= (visible && !sure ? 1 : 0) | (sums.widest > 0 ? 2 : 0);
  }
  return flags;
}

RAD_CLONES int rad_facet_values(const struct rad_facet_source *s,
                                const struct rad_facet_targets *targets, int first,
                                struct rad_facet_error allowed, double *restrict value) {
  int flags = lanes(0, s, targets, first, allowed, value);
  if (flags & 2)
    flags = lanes(1, s, targets, first, allowed, value);
  return flags & 1;
}

void rad_facet_source_set(const struct rad_triangle *source, struct rad_facet_source *s) {
  double turn[3];
  for (int m = 0; m < 3; m++) {
    for (int d = 0; d < 3; d++) {
      s->v[m][d] = source->v[m][d];
      s->side[m][d] = source->v[(m + 1) % 3][d] - source->v[m][d];
    }
    s->length[m] = rad_norm(s->side[m]);
    s->normal[m] = source->normal[m];
  }
  rad_cross(s->side[0], s->side[1], turn);
  s->scale = (rad_dot(turn, s->normal) > 0 ? -1 : 1) / (2 * M_PI);
}

void rad_facet_front(const struct rad_facet_source *s, const struct rad_facet_targets *targets,
                     int target, int cut, struct rad_polygon *part) {
  struct vec n = {targets->normal[0][target], targets->normal[1][target],
                  targets->normal[2][target]};
  double h[3];
  *part = (struct rad_polygon){.n = 3, .corner = {{0, 0}, {1, 0}, {0, 1}}};
  for (int m = 0; m < 3; m++)
    h[m] = dot(from(load(s->v[m]), targets, target), n);
  if (cut)
    rad_clip(part, h[0], h[1] - h[0], h[2] - h[0]);
}

/* Corner of a part seen from x: a mean of the vertices seen from x, exact at a vertex. */
static struct vec corner(const double b[2], const struct vec r[3]) {
  double b0 = 1 - b[0] - b[1];
  return (struct vec){b0 * r[0].x + (b[0] * r[1].x + b[1] * r[2].x),
                      b0 * r[0].y + (b[0] * r[1].y + b[1] * r[2].y),
                      b0 * r[0].z + (b[0] * r[1].z + b[1] * r[2].z)};
}

double rad_facet_part(const struct rad_facet_source *s, const struct rad_facet_targets *targets,
                      int target, const struct rad_polygon *part, struct rad_facet_error allowed) {
  struct vec r[3],
      n = {targets->normal[0][target], targets->normal[1][target], targets->normal[2][target]};
  struct sums sums = {0, 0, 0};
  for (int m = 0; m < 3; m++)
    r[m] = from(load(s->v[m]), targets, target);
  if (dot(r[0], load(s->normal)) >= 0)
    return 0;
  for (int m = 0; m < part->n; m++) {
    const double *p = part->corner[m], *q = part->corner[(m + 1) % part->n];
    double side[3];
    for (int d = 0; d < 3; d++)
      side[d] = (q[0] - p[0]) * s->side[0][d] - (q[1] - p[1]) * s->side[2][d];
    sums = add_side(1, sums, corner(p, r), corner(q, r), load(side), rad_norm(side), n);
  }
  double result = s->scale * sums.value;
  double error = fabs(s->scale) * ROUNDING * sums.rounding;
  int sure = error <= allowed.relative * result || error <= allowed.absolute;
  return part->n == 0 ? 0 : sure ? result : NAN;
}
