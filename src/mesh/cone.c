#include "mesh/cone.h"

#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec.h"

enum {
  GRADE = 3,     /* of panels at edges */
  MAX_BREAK = 6, /* per face: planes of others that cross it */
  /* Tips of round bodies: with more faces than MANY each is one panel of FEW points, even if its
   * edges or kinks would deserve better: 5 digits, but memory and time stay in bounds. */
  MANY = 16,
  FEW = 3
};
#define IN_PLANE 1e-10 /* height over distance that counts as zero */

static const double pi = 3.14159265358979323846;

static struct rad_cone_sector sector_of(const struct rad_cone_face *face) {
  struct rad_cone_sector s = {.rho = face->rho};
  double c = rad_dot(face->edge[0], face->edge[1]);
  memcpy(s.end, face->edge, sizeof s.end);
  memcpy(s.normal, face->normal, sizeof s.normal);
  for (int m = 0; m < 3; m++)
    s.across[m] = face->edge[1][m] - c * face->edge[0][m];
  double length = rad_norm(s.across);
  for (int m = 0; m < 3; m++)
    s.across[m] /= length;
  s.angle = atan2(length, c);
  return s;
}

static void direction(const struct rad_cone_sector *s, double phi, double x[3]) {
  double c = cos(phi), d = sin(phi);
  for (int m = 0; m < 3; m++)
    x[m] = c * s->end[0][m] + d * s->across[m];
}

/* The part of j in front of the plane of i; 0 if there is none. */
static int front_part(const struct rad_cone_sector *i, const struct rad_cone_sector *j,
                      double part[2]) {
  double h[2];
  for (int m = 0; m < 2; m++) {
    h[m] = rad_dot(i->normal, j->end[m]);
    h[m] = fabs(h[m]) < IN_PLANE ? 0 : h[m];
  }
  part[0] = 0;
  part[1] = j->angle;
  if (h[0] * h[1] < 0)
    part[h[0] > 0] = atan2(fabs(h[0]) * sin(j->angle), fabs(h[0]) * cos(j->angle) + fabs(h[1]));
  return h[0] > 0 || h[1] > 0;
}

static int see_each_other(const struct rad_cone_sector *i, const struct rad_cone_sector *j) {
  double part[2];
  return front_part(i, j, part) && front_part(j, i, part);
}

static int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Panels of face i: b of (2.19) and thus v have kinks where other faces' planes cross it. */
static void add_panels(struct rad_cone *cone, int i) {
  const struct rad_cone_sector *s = &cone->face[i];
  double at[MAX_BREAK + 2] = {0}, part[2];
  int n = 1;
  if (cone->n_face > MANY) {
    cone->panel[cone->n_panel++] = (struct rad_cone_panel){i, 0, s->angle, 1};
    return;
  }
  for (int j = 0; j < cone->n_face && n <= MAX_BREAK; j++)
    if (see_each_other(s, &cone->face[j]) && front_part(&cone->face[j], s, part)) {
      double kink = part[0] > 0 ? part[0] : part[1], gap = fmin(kink, s->angle - kink);
      for (int b = 1; b < n; b++)
        gap = fmin(gap, fabs(kink - at[b]));
      if (gap > 1e-6 * s->angle)
        at[n++] = kink;
    }
  if (n == 1)
    at[n++] = 0.5 * s->angle;
  at[n++] = s->angle;
  qsort(at, (size_t)n, sizeof *at, ascending);
  for (int b = 0; b + 1 < n; b++) {
    int last = b + 2 == n;
    double span = at[b + 1] - at[b];
    cone->panel[cone->n_panel++] = (struct rad_cone_panel){
        i, last ? at[b + 1] : at[b], last ? -span : span, last || b == 0 ? GRADE : 1};
  }
}

static double angle_at(const struct rad_cone_panel *p, double sigma) {
  double power = sigma;
  for (int m = 1; m < p->p; m++)
    power *= sigma;
  return p->anchor + p->span * power;
}

/* |d phi / d sigma| */
static double stretch(const struct rad_cone_panel *p, double sigma) {
  double power = p->p * fabs(p->span);
  for (int m = 1; m < p->p; m++)
    power *= sigma;
  return power;
}

/* The complex sigma at which the kernel of point x is singular: 1 - cos omega =
 * 1 - c cos(phi - phi_x) vanishes at phi = phi_x +- i atanh|z|, z the height of x over the face. */
static double complex singularity(const struct rad_cone_panel *p, const struct rad_cone_sector *s,
                                  const double x[3]) {
  double z = fmin(fabs(rad_dot(s->normal, x)), 0.999);
  double phi = atan2(rad_dot(x, s->across), rad_dot(x, s->end[0])) - p->anchor;
  phi = remainder(phi, 2 * pi) * (p->span > 0 ? 1 : -1);
  return cpow((phi + I * atanh(z)) / fabs(p->span), 1. / p->p);
}

/* Room for a block of `more` samples; 0 without memory. */
static int reserve(struct rad_cone *cone, int more) {
  if (cone->n_sample + more > cone->max_sample) {
    int room = 2 * cone->max_sample + 4096;
    void *grown = realloc(cone->sample, (size_t)room * sizeof *cone->sample);
    if (!grown)
      return 0;
    cone->sample = grown;
    cone->max_sample = room;
  }
  if (cone->n_block == cone->max_block) {
    int room = 2 * cone->max_block + 256;
    void *grown = realloc(cone->block, (size_t)room * sizeof *cone->block);
    if (!grown)
      return 0;
    cone->block = grown;
    cone->max_block = room;
  }
  return 1;
}

/* q = 2 acos(|x-y|/2), not below 1e-3, where I_alpha is flat but cancels. */
static void fill_sample(int points, const double *to_lagrange, const double x[3], const double y[3],
                        double sigma, double weight, struct rad_cone_sample *out) {
  double d[3], legendre[RAD_CONE_POINTS];
  rad_sub(x, y, d);
  double half = fmin(0.5 * rad_norm(d), 1 - 1.25e-7), sine = 2 * half * sqrt(1 - half * half);
  out->q = 2 * acos(half);
  out->sin2q = sin(2 * out->q);
  out->cos2q = cos(2 * out->q);
  out->weight = 0.25 * weight / (sine * sine * sine);
  rad_legendre(points, 2 * sigma - 1, legendre);
  for (int a = 0; a < points; a++) {
    out->basis[a] = 0;
    for (int m = 0; m < points; m++)
      out->basis[a] += to_lagrange[a * points + m] * legendre[m];
  }
}

/* Samples of the part of a panel that the point x of face `target` sees. Gauss points in zeta,
 * sigma = Re + Im sinh(zeta), resolve the singularity at any distance: at most 7 + 2 * 28. */
static int add_block(struct rad_cone *cone, const struct rad_gauss *g, const double *to_lagrange,
                     const struct rad_cone_sector *target, int row, const double x[3], int panel,
                     const double part[2]) {
  const struct rad_cone_panel *p = &cone->panel[panel];
  const struct rad_cone_sector *s = &cone->face[p->face];
  double end[2], height = rad_dot(s->normal, x);
  for (int m = 0; m < 2; m++)
    end[m] = pow(fmin(fmax((part[m] - p->anchor) / p->span, 0), 1), 1. / p->p);
  double low = fmin(end[0], end[1]), high = fmax(end[0], end[1]);
  if (!(height > 0 && high > low))
    return 1;
  double complex centre = singularity(p, s, x);
  double re = creal(centre), im = fmin(fabs(cimag(centre)), 2);
  double zeta0 = asinh((low - re) / im), range = asinh((high - re) / im) - zeta0;
  int n = (int)fmin(7 + 2 * range, RAD_GAUSS_MAX);
  if (!reserve(cone, n))
    return 0;
  const double *node = rad_gauss_node(g, n), *w = rad_gauss_weight(g, n);
  cone->block[cone->n_block++] = (struct rad_cone_block){row, panel, cone->n_sample, n};
  for (int i = 0; i < n; i++) {
    double grow = exp(zeta0 + 0.5 * (1 + node[i]) * range), y[3];
    double sigma = fmin(fmax(re + 0.5 * im * (grow - 1 / grow), low), high);
    direction(s, angle_at(p, sigma), y);
    double a = fmax(rad_dot(target->normal, y), 0);
    double jacobian = 0.25 * w[i] * range * im * (grow + 1 / grow) * stretch(p, sigma);
    fill_sample(cone->points, to_lagrange, x, y, sigma, jacobian * a * height,
                &cone->sample[cone->n_sample++]);
  }
  return 1;
}

/* All blocks; 0 without memory. */
static int add_blocks(struct rad_cone *cone, const struct rad_gauss *g) {
  const int points = cone->points;
  const double *node = rad_gauss_node(g, points);
  double to_lagrange[RAD_CONE_POINTS * RAD_CONE_POINTS], part[2], x[3];
  rad_lagrange_from_legendre(g, points, to_lagrange);
  for (int row = 0; row < cone->n; row++) {
    const struct rad_cone_panel *p = &cone->panel[row / points];
    const struct rad_cone_sector *target = &cone->face[p->face];
    direction(target, angle_at(p, 0.5 * (1 + node[row % points])), x);
    for (int j = 0; j < cone->n_panel; j++) {
      const struct rad_cone_sector *source = &cone->face[cone->panel[j].face];
      if (source != target && front_part(source, target, part) &&
          front_part(target, source, part) &&
          !add_block(cone, g, to_lagrange, target, row, x, j, part))
        return 0;
    }
  }
  return 1;
}

/* The faces that matter, in place: not black, and seen by another one that is not. */
static void select_faces(struct rad_cone *cone, int n_face, const struct rad_cone_face *face) {
  struct rad_cone_sector *s = cone->face;
  int n = 0;
  for (int i = 0; i < n_face; i++)
    if (face[i].rho > 0)
      s[n++] = sector_of(&face[i]);
  for (int i = 0; i < n; i++) {
    int seen = 0; /* by one of those kept before it or one that comes after it */
    for (int j = 0; j < n && !seen; j++)
      seen = (j < cone->n_face || j > i) && see_each_other(&s[i], &s[j]);
    if (seen)
      s[cone->n_face++] = s[i];
  }
}

enum rad_code rad_cone_build(const struct rad_gauss *g, int n_face,
                             const struct rad_cone_face *face, struct rad_cone *cone,
                             struct rad_error *e) {
  *cone = (struct rad_cone){0};
  size_t panels = (size_t)n_face * (MAX_BREAK + 1);
  cone->face = rad_alloc((size_t)n_face, sizeof *cone->face);
  cone->panel = rad_alloc(panels, sizeof *cone->panel);
  if (!cone->face || !cone->panel)
    return rad_fail_memory(e, "the faces at a vertex", (double)(panels * sizeof *cone->panel));
  select_faces(cone, n_face, face);
  for (int i = 0; i < cone->n_face; i++)
    add_panels(cone, i);
  cone->points = cone->n_face > MANY ? FEW : RAD_CONE_POINTS;
  cone->n = cone->points * cone->n_panel;
  if (!add_blocks(cone, g))
    return rad_fail_memory(e, "the faces at a vertex",
                           2. * cone->max_sample * (double)sizeof *cone->sample);
  return RAD_OK;
}

void rad_cone_free(struct rad_cone *cone) {
  free(cone->face);
  free(cone->panel);
  free(cone->block);
  free(cone->sample);
  *cone = (struct rad_cone){0};
}

/* Numerator of I_alpha over alpha, without cancellation at 0:
 * (2+alpha) sin(alpha q)/alpha - sin((2+alpha) q), times alpha / sin(alpha pi); pi cancels. */
void rad_cone_assemble(const struct rad_cone *cone, double alpha, double *k) {
  const int points = cone->points;
  double factor = alpha > 0 ? alpha / sin(pi * fmin(alpha, 1 - alpha)) : 1 / pi;
  memset(k, 0, (size_t)cone->n * (size_t)cone->n * sizeof *k);
  for (int b = 0; b < cone->n_block; b++) {
    const struct rad_cone_block *block = &cone->block[b];
    double *row = k + (size_t)block->row * (size_t)cone->n + block->panel * points;
    double scale = factor * cone->face[cone->panel[block->row / points].face].rho;
    for (int i = block->first; i < block->first + block->n; i++) {
      const struct rad_cone_sample *s = &cone->sample[i];
      double c = cos(alpha * s->q), d = sin(alpha * s->q);
      double first = (2 + alpha) * (alpha > 0 ? d / alpha : s->q);
      double value = scale * s->weight * (first - d * s->cos2q - c * s->sin2q);
      for (int a = 0; a < points; a++)
        row[a] += value * s->basis[a];
    }
  }
}
