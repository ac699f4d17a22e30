/* What the mesh can be asked once it is built: positions, trial functions, u_h at a point. */
#include <math.h>
#include <stddef.h>

#include "mesh/mesh.h"

int rad_element_triangle(const struct rad_mesh *mesh, int element) {
  return mesh->patch[mesh->element[element].patch].triangle;
}

int rad_point_triangle(const struct rad_mesh *mesh, int point) {
  int lo = 0, hi = mesh->scene->n_triangle;
  while (hi - lo > 1) {
    int mid = (lo + hi) / 2;
    if (mesh->point_first[mid] <= point)
      lo = mid;
    else
      hi = mid;
  }
  return lo;
}

void rad_point_position(const struct rad_mesh *mesh, int point, double x[3]) {
  rad_triangle_point(&mesh->scene->triangle[rad_point_triangle(mesh, point)],
                     mesh->point_base[point], mesh->point_mu[point], x);
}

double rad_emission(const struct rad_scene *scene, int triangle, int band, int base,
                    const double mu[2]) {
  if (scene->emission_at)
    return scene->emission_at(scene->emission_context, triangle, band, base, mu);
  const double *e = scene->emission + (size_t)triangle * 3 * (size_t)scene->n_band + band;
  int nb = scene->n_band;
  double e0 = e[base * nb], e1 = e[(base + 1) % 3 * nb], e2 = e[(base + 2) % 3 * nb];
  return e0 + mu[0] * (e1 - e0) + mu[1] * (e2 - e0);
}

void rad_mesh_data(const struct rad_mesh *m, double *rho, double *emission) {
  const struct rad_scene *s = m->scene;
  size_t n = (size_t)m->n_point;
  for (int t = 0; t < s->n_triangle; t++)
    for (int p = m->point_first[t]; p < m->point_first[t + 1]; p++)
      for (int b = 0; b < s->n_band; b++) {
        rho[(size_t)b * n + (size_t)p] = s->rho[t * s->n_band + b];
        emission[(size_t)b * n + (size_t)p] =
            rad_emission(s, t, b, m->point_base[p], m->point_mu[p]);
      }
}

void rad_element_basis(const struct rad_mesh *mesh, int element, double phi, double r,
                       double *value) {
  const struct rad_element *e = &mesh->element[element];
  double s =
      (2 * rad_ungraded(phi, e->p_phi) - e->sigma[0] - e->sigma[1]) / (e->sigma[1] - e->sigma[0]);
  double t = (2 * rad_ungraded(r, e->p_r) - e->tau[0] - e->tau[1]) / (e->tau[1] - e->tau[0]);
  double ls[RAD_GAUSS_MAX], lt[RAD_GAUSS_MAX];
  rad_lagrange(&mesh->nodes, e->k_phi, s, ls);
  rad_lagrange(&mesh->nodes, e->k_r, t, lt);
  if (!e->fold) {
    for (int c = 0; c < e->k_r; c++)
      for (int a = 0; a < e->k_phi; a++)
        value[a + e->k_phi * c] = ls[a] * lt[c];
    return;
  }
  for (int f = 0; f < e->n_function; f++) {
    value[f] = 0;
    for (int b = 0; b < e->k_phi * e->k_r; b++)
      value[f] += e->fold[f * e->k_phi * e->k_r + b] * ls[b % e->k_phi] * lt[b / e->k_phi];
  }
}

int rad_mesh_locate(const struct rad_mesh *mesh, int patch, double phi, double r) {
  for (int i = mesh->element_first[patch]; i < mesh->element_first[patch + 1]; i++) {
    const struct rad_element *e = &mesh->element[i];
    double s = rad_ungraded(phi, e->p_phi), t = rad_ungraded(r, e->p_r);
    if (s >= e->sigma[0] && t >= e->tau[0] && (s < e->sigma[1] || e->sigma[1] == 1) &&
        (t < e->tau[1] || e->tau[1] == 1))
      return i;
  }
  return mesh->element_first[patch]; /* the elements cover the square: not reached */
}

double rad_mesh_evaluate(const struct rad_mesh *mesh, const double *u, int patch, double phi,
                         double r) {
  int i = rad_mesh_locate(mesh, patch, phi, r);
  const struct rad_element *e = &mesh->element[i];
  double value[RAD_GAUSS_MAX * RAD_GAUSS_MAX], sum = 0;
  rad_element_basis(mesh, i, phi, r, value);
  for (int b = 0; b < e->n_function; b++)
    sum += value[b] * u[e->first + b];
  return sum;
}
