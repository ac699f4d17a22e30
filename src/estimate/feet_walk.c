#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec.h"
#include "estimate/feet.h"
#include "estimate/indicator.h"

/* The estimate's points may be this part of a width apart: then one of them lies where what is that
 * wide has half of its height. */
#define RESOLVED 0.7

/* A foot at the rim of its face is moved inwards by this part of the face. */
#define INSIDE 1e-7

/* A part of a segment is one foot if the distances of its ends do not differ more than this. */
#define ALIKE 4

/* Of a width: two feet that near are one. */
#define CLOSE 0.1

enum { DEEPEST = 14 }; /* halvings of a segment */

/* Gauss points of k in an interval are at most this much farther apart than equal parts. */
#define UNEVEN (M_PI / 2)

/* Length of dx/ds, where graded variables have x = s^p: not below the one in the middle of the
 * first interval between points. */
static double stretch(double x, double p, const double s[2], int k) {
  double at = fmax(rad_ungraded(x, p), s[0] + 0.5 * (s[1] - s[0]) / k);
  return p == 1 ? 1 : p * pow(at, p - 1);
}

static double along(const double v[3], const double across[3]) {
  return across[0] == 0 && across[1] == 0 && across[2] == 0 ? rad_norm(v)
                                                            : fabs(rad_dot(v, across));
}

void rad_unresolved(const struct rad_mesh *mesh, int element, double phi, double r, double width,
                    const double across[3], int *in_phi, int *in_r) {
  const struct rad_element *el = &mesh->element[element];
  const struct rad_patch *p = &mesh->patch[el->patch];
  double t = rad_angle_t(p->angle, phi), by_phi[3], by_r[3];
  int k_phi = el->k_phi + RAD_MORE, k_r = el->k_r + RAD_MORE;
  double step_phi =
      UNEVEN * stretch(phi, el->p_phi, el->sigma, k_phi) * (el->sigma[1] - el->sigma[0]) / k_phi;
  double step_r = UNEVEN * stretch(r, el->p_r, el->tau, k_r) * (el->tau[1] - el->tau[0]) / k_r;
  for (int d = 0; d < 3; d++) {
    by_phi[d] = step_phi * r * rad_angle_dt(p->angle, t) * p->b[d];
    by_r[d] = step_r * (p->a[d] + t * p->b[d]);
  }
  *in_phi = along(by_phi, across) > RESOLVED * width;
  *in_r = along(by_r, across) > RESOLVED * width;
}

/* The place of a face at barycentric weights, and its element. */
static void set_place(const struct rad_mesh *mesh, int triangle, double w[3],
                      struct rad_foot *foot) {
  const struct rad_triangle *face = &mesh->scene->triangle[triangle];
  double sum = 0;
  foot->base = 0;
  for (int c = 0; c < 3; c++)
    sum += w[c] = fmax(w[c], INSIDE);
  for (int c = 0; c < 3; c++)
    foot->base = w[c] > w[foot->base] ? c : foot->base;
  foot->mu[0] = w[(foot->base + 1) % 3] / sum;
  foot->mu[1] = w[(foot->base + 2) % 3] / sum;
  rad_triangle_point(face, foot->base, foot->mu, foot->x);
  int first = mesh->patch_first[triangle], n = mesh->patch_first[triangle + 1] - first;
  int patch =
      first + rad_patch_locate(&mesh->patch[first], n, foot->base, foot->mu, &foot->phi, &foot->r);
  foot->element = rad_mesh_locate(mesh, patch, foot->phi, foot->r);
}

/* The foot of a place of a segment; its width is 0 where it touches or is behind the face. */
static struct rad_foot foot_of(const struct rad_mesh *mesh, const struct rad_feature *f,
                               double at) {
  const struct rad_triangle *face = &mesh->scene->triangle[f->face];
  double x[3], w[3], off[3];
  struct rad_foot foot = {.width = 0};
  for (int d = 0; d < 3; d++)
    x[d] = f->p[0][d] + at * (f->p[1][d] - f->p[0][d]);
  double distance = rad_nearest_point(face, x, w);
  if (f->own) {
    double other[3];
    distance = rad_nearest_point(&mesh->scene->triangle[f->near], x, other);
  }
  rad_sub(x, face->v[0], off);
  if (f->own || rad_dot(off, face->normal) > 0)
    foot.width = fmax(distance, f->width);
  set_place(mesh, f->face, w, &foot);
  return foot;
}

/* One of the same element is as near as makes no difference, and for the same directions. */
static int there_already(const struct rad_feet *feet, const struct rad_foot *foot,
                         const double across[3]) {
  for (int i = feet->n_foot - 1; i >= 0; i--) {
    const struct rad_foot *f = &feet->foot[i];
    const struct rad_feature *g = &feet->feature[f->feature];
    double apart[3], turn[3];
    if (g->face != feet->feature[foot->feature].face)
      break;
    rad_sub(f->x, foot->x, apart);
    rad_cross(g->across, across, turn);
    if (f->element == foot->element && rad_norm(apart) < CLOSE * fmin(f->width, foot->width) &&
        rad_norm(turn) < CLOSE && fabs(rad_norm(g->across) - rad_norm(across)) < CLOSE)
      return 1;
  }
  return 0;
}

/* Append a foot if it is not resolved, nor there already. */
static int add_place(const struct rad_mesh *mesh, const struct rad_foot *foot,
                     struct rad_feet *feet) {
  const double *across = feet->feature[foot->feature].across;
  int in_phi, in_r;
  rad_unresolved(mesh, foot->element, foot->phi, foot->r, foot->width, across, &in_phi, &in_r);
  if ((!in_phi && !in_r) || there_already(feet, foot, across))
    return 1;
  if (!rad_reserve((void **)&feet->foot, (size_t)feet->n_foot + 1, &feet->room_foot, sizeof *foot))
    return 0;
  feet->foot[feet->n_foot++] = *foot;
  return 1;
}

/* The foot in the middle of a part of a feature, and places around it that are in other elements:
 * what happens there reaches as far as it is wide. */
static int add_foot(const struct rad_mesh *mesh, int feature, double from, double to,
                    struct rad_feet *feet) {
  static const double ring[] = {0.4, 1}; /* of the width */
  const struct rad_feature *f = &feet->feature[feature];
  const struct rad_triangle *face = &mesh->scene->triangle[f->face];
  struct rad_foot foot = foot_of(mesh, f, 0.5 * (from + to));
  double side[2][3], x[3], w[3];
  foot.feature = feature;
  foot.from = from;
  foot.to = to;
  if (foot.width == 0)
    return 1;
  int done = add_place(mesh, &foot, feet);
  rad_sub(face->v[(foot.base + 1) % 3], face->v[foot.base], side[0]);
  double length = rad_norm(side[0]);
  for (int d = 0; d < 3; d++)
    side[0][d] /= length;
  rad_cross(face->normal, side[0], side[1]);
  for (int i = 0; i < 16 && done; i++) {
    struct rad_foot near = foot;
    double turn = M_PI / 4 * (i % 8), far = ring[i / 8] * foot.width;
    for (int d = 0; d < 3; d++)
      x[d] = foot.x[d] + far * (cos(turn) * side[0][d] + sin(turn) * side[1][d]);
    rad_nearest_point(face, x, w);
    set_place(mesh, f->face, w, &near);
    if (near.element != foot.element)
      done = add_place(mesh, &near, feet);
  }
  return done;
}

/* A part of a feature, halved until it stays within one element, or is short. */
static int walk(const struct rad_mesh *mesh, int feature, double from, double to, int depth,
                struct rad_feet *feet) {
  const struct rad_feature *f = &feet->feature[feature];
  struct rad_foot a = foot_of(mesh, f, from), b = foot_of(mesh, f, to);
  double d[3], low = fmin(a.width, b.width), high = fmax(a.width, b.width);
  rad_sub(f->p[1], f->p[0], d);
  double length = (to - from) * rad_norm(d);
  int alike = a.element == b.element && high <= ALIKE * low;
  if (alike || depth == DEEPEST || length < 0.5 * low)
    return add_foot(mesh, feature, from, to, feet);
  double mid = 0.5 * (from + to);
  return walk(mesh, feature, from, mid, depth + 1, feet) &&
         walk(mesh, feature, mid, to, depth + 1, feet);
}

int rad_feet_walk(const struct rad_mesh *mesh, int feature, double from, double to,
                  struct rad_feet *feet) {
  return walk(mesh, feature, from, to, 0, feet);
}
