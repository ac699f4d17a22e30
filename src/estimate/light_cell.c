#include "estimate/light_cell.h"

#include <math.h>

#include "base/vec.h"

struct rad_light_cell rad_light_cell_whole(const struct rad_mesh *mesh, int element) {
  const struct rad_element *e = &mesh->element[element];
  return (struct rad_light_cell){element, {e->sigma[0], e->sigma[1]}, {e->tau[0], e->tau[1]}};
}

void rad_light_cell_split(const struct rad_light_cell *cell, struct rad_light_cell child[4]) {
  for (int c = 0; c < 4; c++) {
    child[c] = *cell;
    child[c].sigma[1 - c % 2] = 0.5 * (cell->sigma[0] + cell->sigma[1]);
    child[c].tau[1 - c / 2] = 0.5 * (cell->tau[0] + cell->tau[1]);
  }
}

void rad_light_cell_shape(const struct rad_mesh *mesh, const struct rad_light_cell *cell,
                          struct rad_cell_shape *shape) {
  const struct rad_element *e = &mesh->element[cell->element];
  const struct rad_patch *p = &mesh->patch[e->patch];
  for (int d = 0; d < 3; d++)
    shape->centre[d] = 0;
  for (int c = 0; c < 4; c++) {
    double phi = rad_graded(cell->sigma[c % 2], e->p_phi), r = rad_graded(cell->tau[c / 2], e->p_r);
    double t = rad_angle_t(p->angle, phi);
    for (int d = 0; d < 3; d++) {
      shape->corner[c][d] = p->v[d] + r * (p->a[d] + t * p->b[d]);
      shape->centre[d] += 0.25 * shape->corner[c][d];
    }
  }
  shape->radius = 0;
  for (int c = 0; c < 4; c++) {
    double way[3];
    rad_sub(shape->corner[c], shape->centre, way);
    shape->radius = fmax(shape->radius, rad_norm(way));
  }
  shape->vertex = cell->tau[0] == 0 ? p->corner : -1;
}

/* Values of one direction's Lagrange polynomials at the n Gauss points of [lo, hi], which is a part
 * of the element's [from, to]; x: the points. */
static void direction(const struct rad_mesh *mesh, int k, const double part[2],
                      const double whole[2], int n, double x[], double l[][RAD_GAUSS_MAX]) {
  const double *node = rad_gauss_node(&mesh->gauss, n);
  for (int q = 0; q < n; q++) {
    x[q] = part[0] + 0.5 * (1 + node[q]) * (part[1] - part[0]);
    rad_lagrange(&mesh->nodes, k, 2 * (x[q] - whole[0]) / (whole[1] - whole[0]) - 1, l[q]);
  }
}

/* Coefficients of the tensor Lagrange polynomials: folded functions are sums of them. */
static void coefficients(const struct rad_element *e, const double *u, double *c) {
  int k = e->k_phi * e->k_r;
  for (int b = 0; b < k; b++) {
    c[b] = e->fold ? 0 : u[e->first + b];
    for (int f = 0; e->fold && f < e->n_function; f++)
      c[b] += e->fold[f * k + b] * u[e->first + f];
  }
}

/* w_k at the points, times the weights that stand in flux[k]. */
static void set_flux(const struct rad_weights *w, const struct rad_element *e, int n,
                     double lp[][RAD_GAUSS_MAX], double lr[][RAD_GAUSS_MAX],
                     struct rad_light *light) {
  double c[RAD_GAUSS_MAX * RAD_GAUSS_MAX], half[RAD_GAUSS_MAX];
  for (int k = 0; k < w->n; k++) {
    coefficients(e, w->w[k], c);
    light->most[k] = 0;
    for (int j = 0; j < n; j++) {
      for (int a = 0; a < e->k_phi; a++) {
        half[a] = 0;
        for (int b = 0; b < e->k_r; b++)
          half[a] += c[a + e->k_phi * b] * lr[j][b];
      }
      for (int i = 0; i < n; i++) {
        double value = 0;
        for (int a = 0; a < e->k_phi; a++)
          value += half[a] * lp[i][a];
        light->most[k] = fmax(light->most[k], fabs(value));
        light->flux[k][i + n * j] = value * light->dS[i + n * j];
      }
    }
  }
}

void rad_light_set(const struct rad_weights *w, const struct rad_light_cell *cell, int n,
                   struct rad_light *light) {
  const struct rad_mesh *mesh = w->mesh;
  const struct rad_element *e = &mesh->element[cell->element];
  const struct rad_patch *p = &mesh->patch[e->patch];
  const double *weight = rad_gauss_weight(&mesh->gauss, n);
  double sigma[RAD_GAUSS_MAX], tau[RAD_GAUSS_MAX];
  double lp[RAD_GAUSS_MAX][RAD_GAUSS_MAX], lr[RAD_GAUSS_MAX][RAD_GAUSS_MAX];
  double scale =
      0.25 * (cell->sigma[1] - cell->sigma[0]) * (cell->tau[1] - cell->tau[0]) * p->a1 * p->b2;
  struct rad_senders *s = &light->senders;
  direction(mesh, e->k_phi, cell->sigma, e->sigma, n, sigma, lp);
  direction(mesh, e->k_r, cell->tau, e->tau, n, tau, lr);
  s->triangle = p->triangle;
  s->n = n * n;
  light->area = 0;
  for (int q = 0; q < n * n; q++) {
    double phi = rad_graded(sigma[q % n], e->p_phi), r = rad_graded(tau[q / n], e->p_r);
    double t = rad_angle_t(p->angle, phi);
    s->base[q] = p->base;
    rad_patch_mu(p, phi, r, s->mu[q]);
    light->dS[q] = scale * weight[q % n] * weight[q / n] * rad_angle_dt(p->angle, t) * e->p_phi *
                   (phi / sigma[q % n]) * r * e->p_r * (r / tau[q / n]);
    light->area += light->dS[q];
  }
  rad_senders_finish(mesh->scene, s);
  set_flux(w, e, n, lp, lr, light);
}
