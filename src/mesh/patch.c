#include "mesh/patch.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"

double rad_angle_t(enum rad_angle angle, double phi) {
  return angle == RAD_ANGLE_POLAR ? sqrt(3) * tan(M_PI / 6 * phi) : phi;
}

double rad_angle_dt(enum rad_angle angle, double t) {
  return angle == RAD_ANGLE_POLAR ? sqrt(3) * M_PI / 6 * (1 + t * t / 3) : 1;
}

double rad_angle_phi(enum rad_angle angle, double t) {
  return angle == RAD_ANGLE_POLAR ? 6 / M_PI * atan(t / sqrt(3)) : t;
}

void rad_triangle_point(const struct rad_triangle *t, int base, const double mu[2], double x[3]) {
  const double *v = t->v[base], *w1 = t->v[(base + 1) % 3], *w2 = t->v[(base + 2) % 3];
  for (int d = 0; d < 3; d++)
    x[d] = v[d] + (mu[0] * (w1[d] - v[d]) + mu[1] * (w2[d] - v[d]));
}

void rad_triangle_weights(const struct rad_triangle *t, const double x[3], double weight[3]) {
  for (int c = 0; c < 3; c++) { /* area of the triangle that the point makes with the other edge */
    double side[3], d[3], cross[3];
    rad_sub(t->v[(c + 2) % 3], t->v[(c + 1) % 3], side);
    rad_sub(x, t->v[(c + 1) % 3], d);
    rad_cross(side, d, cross);
    weight[c] = rad_dot(cross, t->normal) / (2 * t->area);
  }
  double total = weight[0] + weight[1] + weight[2]; /* 1, or -1 if the normal is the other one */
  for (int c = 0; c < 3; c++)
    weight[c] /= total;
}

/* Vectors and frame from mu0, mu_a, mu_b. */
static void set_frame(const struct rad_triangle *tri, struct rad_patch *p) {
  const double *v = tri->v[p->base];
  double f1[3], f2[3];
  rad_sub(tri->v[(p->base + 1) % 3], v, f1);
  rad_sub(tri->v[(p->base + 2) % 3], v, f2);
  for (int d = 0; d < 3; d++) {
    p->v[d] = v[d] + (p->mu0[0] * f1[d] + p->mu0[1] * f2[d]);
    p->a[d] = p->mu_a[0] * f1[d] + p->mu_a[1] * f2[d];
    p->b[d] = p->mu_b[0] * f1[d] + p->mu_b[1] * f2[d];
  }
  p->a1 = rad_norm(p->a);
  for (int d = 0; d < 3; d++)
    p->e1[d] = p->a[d] / p->a1;
  rad_cross(tri->normal, p->e1, p->e2);
  p->b1 = rad_dot(p->b, p->e1);
  p->b2 = rad_dot(p->b, p->e2);
  if (p->b2 < 0) {
    p->b2 = -p->b2;
    for (int d = 0; d < 3; d++)
      p->e2[d] = -p->e2[d];
  }
}

void rad_patch_sub_triangle(const struct rad_scene *scene, int triangle, int sub,
                            enum rad_angle angle, struct rad_patch *p) {
  const struct rad_triangle *tri = &scene->triangle[triangle];
  int edge = sub / 2, back = sub % 2;
  int from = back ? (edge + 1) % 3 : edge, to = back ? edge : (edge + 1) % 3;
  *p = (struct rad_patch){.triangle = triangle,
                          .corner = tri->vertex[from],
                          .toward = tri->vertex[to],
                          .base = from,
                          .angle = angle};
  /* a = (w - v)/2, b = centroid - (v + w)/2; w is F1's end going forward, F2's going back */
  p->mu_a[back] = 0.5;
  p->mu_b[back] = -1.0 / 6;
  p->mu_b[!back] = 1.0 / 3;
  set_frame(tri, p);
}

void rad_patch_plain(const struct rad_scene *scene, int triangle, const double corner[3][2],
                     struct rad_patch *p) {
  const struct rad_triangle *tri = &scene->triangle[triangle];
  *p = (struct rad_patch){
      .triangle = triangle, .corner = -1, .toward = -1, .base = 0, .angle = RAD_ANGLE_DUFFY};
  for (int d = 0; d < 2; d++) {
    p->mu0[d] = corner[0][d];
    p->mu_a[d] = corner[1][d] - corner[0][d];
    p->mu_b[d] = corner[2][d] - corner[1][d];
  }
  set_frame(tri, p);
}

void rad_patch_from(const struct rad_scene *scene, int triangle, int vertex, int toward,
                    struct rad_patch *p) {
  const struct rad_triangle *tri = &scene->triangle[triangle];
  int back = toward != (vertex + 1) % 3;
  *p = (struct rad_patch){.triangle = triangle,
                          .corner = tri->vertex[vertex],
                          .toward = tri->vertex[toward],
                          .base = vertex,
                          .angle = RAD_ANGLE_DUFFY};
  p->mu_a[back] = 1;
  p->mu_b[back] = -1;
  p->mu_b[!back] = 1;
  set_frame(tri, p);
}

void rad_patch_whole(const struct rad_scene *scene, int triangle, struct rad_patch *p) {
  rad_patch_from(scene, triangle, 0, 1, p);
}

void rad_patch_mu(const struct rad_patch *p, double phi, double r, double mu[2]) {
  double t = rad_angle_t(p->angle, phi);
  for (int d = 0; d < 2; d++)
    mu[d] = p->mu0[d] + r * (p->mu_a[d] + t * p->mu_b[d]);
}

/* mu counted from another vertex of the same triangle. */
static void rebase(int from, const double mu[2], int to, double out[2]) {
  double bary[3];
  bary[from] = 1 - mu[0] - mu[1];
  bary[(from + 1) % 3] = mu[0];
  bary[(from + 2) % 3] = mu[1];
  out[0] = bary[(to + 1) % 3];
  out[1] = bary[(to + 2) % 3];
}

int rad_patch_locate(const struct rad_patch *patch, int n, int base, const double mu[2],
                     double *phi, double *r) {
  int best = 0;
  double best_outside = INFINITY;
  for (int i = 0; i < n; i++) {
    const struct rad_patch *p = &patch[i];
    double m[2];
    rebase(base, mu, p->base, m);
    double c0 = m[0] - p->mu0[0], c1 = m[1] - p->mu0[1];
    double det = p->mu_a[0] * p->mu_b[1] - p->mu_a[1] * p->mu_b[0];
    double ra = (c0 * p->mu_b[1] - c1 * p->mu_b[0]) / det; /* r */
    double rb = (p->mu_a[0] * c1 - p->mu_a[1] * c0) / det; /* r t */
    double outside = fmax(fmax(ra - 1, -rb), fmax(rb - ra, -ra));
    if (outside < best_outside) {
      best_outside = outside;
      best = i;
      double t = ra > 0 ? fmin(fmax(rb / ra, 0), 1) : 0;
      *r = fmin(fmax(ra, 0), 1);
      *phi = rad_angle_phi(p->angle, t);
    }
  }
  return best;
}
