#include "app/grid.h"

#include <math.h>
#include <omp.h>

size_t rad_grid_size(const struct rad_scene *scene) {
  return (size_t)scene->n_triangle * RAD_N_SUB * RAD_GRID * RAD_GRID * (size_t)scene->n_band;
}

int rad_grid_threads(void) {
  return omp_get_max_threads();
}

/* u_h at (phi, r) of a sub-triangle, whatever patches the mesh has. */
static void grid_point(const struct rad_case *c, const struct rad_patch *sub, double phi, double r,
                       double *value) {
  const struct rad_mesh *m = c->mesh;
  int first = m->patch_first[sub->triangle], n = m->patch_first[sub->triangle + 1] - first;
  double mu[2], p = phi, q = r;
  int patch = 0;
  rad_patch_mu(sub, phi, r, mu);
  if (n == RAD_N_SUB &&
      m->patch[first].corner >= 0) { /* sub-triangles: the same patch, perhaps another angle map */
    while (patch < n - 1 && (m->patch[first + patch].corner != sub->corner ||
                             m->patch[first + patch].toward != sub->toward))
      patch++;
    p = rad_angle_phi(m->patch[first].angle, rad_angle_t(sub->angle, phi));
  } else {
    patch = rad_patch_locate(m->patch + first, n, sub->base, mu, &p, &q);
  }
  for (int b = 0; b < c->scene.n_band; b++)
    value[b] = rad_mesh_evaluate(m, c->u + (size_t)b * m->n_point, first + patch, p, q);
}

void rad_grid_evaluate(const struct rad_case *c, double *value) {
  int n_sub = c->scene.n_triangle * RAD_N_SUB, nb = c->scene.n_band;
#pragma omp parallel for schedule(dynamic) default(none) shared(c, value, n_sub, nb)
  for (int s = 0; s < n_sub; s++) {
    struct rad_patch sub;
    rad_patch_sub_triangle(&c->scene, s / RAD_N_SUB, s % RAD_N_SUB, RAD_ANGLE_POLAR, &sub);
    for (int j = 0; j < RAD_GRID; j++)
      for (int i = 0; i < RAD_GRID; i++)
        grid_point(c, &sub, i / (RAD_GRID - 1.0), j / (RAD_GRID - 1.0),
                   value +
                       (((size_t)s * RAD_GRID + (size_t)j) * RAD_GRID + (size_t)i) * (size_t)nb);
  }
}

/* (n0^-a - nr^-a) / (n1^-a - nr^-a), increasing in a. */
static double model(double n0, double n1, double nr, double a) {
  double tail = isinf(nr) ? 0 : pow(nr, -a);
  return (pow(n0, -a) - tail) / (pow(n1, -a) - tail);
}

double rad_eoc(double n0, double n1, double n_reference, double ratio) {
  double lo = 1e-6, hi = 40;
  if (!(n0 < n1 && n1 < n_reference && ratio > 0) || model(n0, n1, n_reference, lo) > ratio ||
      model(n0, n1, n_reference, hi) < ratio)
    return NAN;
  while (hi - lo > 1e-9) {
    double mid = 0.5 * (lo + hi);
    if (model(n0, n1, n_reference, mid) < ratio)
      lo = mid;
    else
      hi = mid;
  }
  return lo;
}
