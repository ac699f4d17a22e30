#include "estimate/light_cell.h"

#include <math.h>
#include <string.h>

#include "base/scramble.h"
#include "base/vec.h"

struct rad_light_cell rad_light_cell_whole(const struct rad_mesh *mesh, int element) {
  const struct rad_element *e = &mesh->element[element];
  return (struct rad_light_cell){element, {e->sigma[0], e->sigma[1]}, {e->tau[0], e->tau[1]}};
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

/* One point of a patch; returns dS over dsigma dtau. */
static double place(const struct rad_element *e, const struct rad_patch *p, const double at[2],
                    struct rad_senders *s, int q) {
  double phi = rad_graded(at[0], e->p_phi), r = rad_graded(at[1], e->p_r);
  double t = rad_angle_t(p->angle, phi);
  s->base[q] = p->base;
  rad_patch_mu(p, phi, r, s->mu[q]);
  return p->a1 * p->b2 * rad_angle_dt(p->angle, t) * e->p_phi * (phi / at[0]) * r * e->p_r *
         (r / at[1]);
}

void rad_light_set(const struct rad_weights *w, const struct rad_light_cell *cell, int n,
                   struct rad_light *light) {
  const struct rad_mesh *mesh = w->mesh;
  const struct rad_element *e = &mesh->element[cell->element];
  const struct rad_patch *p = &mesh->patch[e->patch];
  const double *weight = rad_gauss_weight(&mesh->gauss, n);
  double sigma[RAD_GAUSS_MAX], tau[RAD_GAUSS_MAX];
  double lp[RAD_GAUSS_MAX][RAD_GAUSS_MAX], lr[RAD_GAUSS_MAX][RAD_GAUSS_MAX];
  double scale = 0.25 * (cell->sigma[1] - cell->sigma[0]) * (cell->tau[1] - cell->tau[0]);
  struct rad_senders *s = &light->senders;
  direction(mesh, e->k_phi, cell->sigma, e->sigma, n, sigma, lp);
  direction(mesh, e->k_r, cell->tau, e->tau, n, tau, lr);
  s->triangle = p->triangle;
  s->n = n * n;
  light->area = 0;
  for (int q = 0; q < n * n; q++) {
    const double at[2] = {sigma[q % n], tau[q / n]};
    light->dS[q] = scale * weight[q % n] * weight[q / n] * place(e, p, at, s, q);
    light->area += light->dS[q];
  }
  rad_senders_finish(mesh->scene, s);
  set_flux(w, e, n, lp, lr, light);
}

/* All w_k on one element, ready for values at single points. */
struct spread {
  const struct rad_mesh *mesh;
  const struct rad_element *element;
  int n;
  double c[RAD_MAX_WEIGHT][RAD_GAUSS_MAX * RAD_GAUSS_MAX];
};

static void spread_set(const struct rad_weights *w, const struct rad_element *e, struct spread *s) {
  s->mesh = w->mesh;
  s->element = e;
  s->n = w->n;
  for (int k = 0; k < w->n; k++)
    coefficients(e, w->w[k], s->c[k]);
}

static void spread_at(const struct spread *s, double sigma, double tau, double *value) {
  const struct rad_element *e = s->element;
  double lp[RAD_GAUSS_MAX], lr[RAD_GAUSS_MAX];
  rad_lagrange(&s->mesh->nodes, e->k_phi,
               2 * (sigma - e->sigma[0]) / (e->sigma[1] - e->sigma[0]) - 1, lp);
  rad_lagrange(&s->mesh->nodes, e->k_r, 2 * (tau - e->tau[0]) / (e->tau[1] - e->tau[0]) - 1, lr);
  for (int k = 0; k < s->n; k++) {
    value[k] = 0;
    for (int b = 0; b < e->k_r; b++)
      for (int a = 0; a < e->k_phi; a++)
        value[k] += s->c[k][a + e->k_phi * b] * lp[a] * lr[b];
  }
}

const struct rad_lattice rad_lattice[RAD_N_LATTICE] = {
    {5, 3, 16}, {13, 8, 16}, {55, 34, 4}, {233, 144, 1}};

static double tent(double x) {
  return 1 - fabs(2 * (x - floor(x)) - 1);
}

/* A cell in the variables t and r^2 / 2, in which all of its points count the same. */
struct even {
  double t[2], r2[2];
};

static struct even even_of(const struct rad_mesh *mesh, const struct rad_light_cell *cell) {
  const struct rad_element *e = &mesh->element[cell->element];
  const struct rad_patch *p = &mesh->patch[e->patch];
  struct even v;
  for (int k = 0; k < 2; k++) {
    double r = rad_graded(cell->tau[k], e->p_r);
    v.t[k] = rad_angle_t(p->angle, rad_graded(cell->sigma[k], e->p_phi));
    v.r2[k] = r * r;
  }
  return v;
}

static double between(const double range[2], double x) {
  return range[0] + x * (range[1] - range[0]);
}

static double within(double x, const double range[2]) {
  return fmin(fmax(x, range[0]), range[1]);
}

void rad_light_scatter(const struct rad_weights *w, const struct rad_light_cell *cell,
                       const struct rad_lattice *lattice, int first, struct rad_light *light) {
  const struct rad_mesh *mesh = w->mesh;
  const struct rad_element *e = &mesh->element[cell->element];
  const struct rad_patch *p = &mesh->patch[e->patch];
  const struct even even = even_of(mesh, cell);
  int n = lattice->n;
  struct rad_senders *s = &light->senders;
  struct spread spread;
  spread_set(w, e, &spread);
  memset(light->most, 0, sizeof light->most);
  s->triangle = p->triangle;
  s->n = n * lattice->at_once;
  light->area = 0.5 * p->a1 * p->b2 * (even.t[1] - even.t[0]) * (even.r2[1] - even.r2[0]);
  for (int q = 0; q < s->n; q++) {
    uint64_t copy = (uint64_t)(first + q / n) + (uint64_t)n * RAD_REPLICATES;
    uint64_t seed = ((uint64_t)cell->element << 20) + 2 * copy;
    double x = tent((double)(q % n) / n + rad_scramble_unit(seed));
    double y = tent((double)(q % n) * lattice->step / n + rad_scramble_unit(seed + 1));
    double phi = rad_angle_phi(p->angle, between(even.t, x));
    double r = sqrt(fmax(between(even.r2, y), 1e-24 * even.r2[1]));
    s->base[q] = p->base;
    rad_patch_mu(p, phi, r, s->mu[q]);
    light->dS[q] = light->area / n;
    double value[RAD_MAX_WEIGHT];
    spread_at(&spread, within(rad_ungraded(phi, e->p_phi), cell->sigma),
              within(rad_ungraded(r, e->p_r), cell->tau), value);
    for (int k = 0; k < w->n; k++) {
      light->most[k] = fmax(light->most[k], fabs(value[k]));
      light->flux[k][q] = value[k] * light->dS[q];
    }
  }
  rad_senders_finish(mesh->scene, s);
}

/* (r, r t) of the patch from barycentric coordinates. */
static void to_patch(const struct rad_patch *p, const double lambda[3], double *r, double *rt) {
  double m1 = lambda[(p->base + 1) % 3] - p->mu0[0], m2 = lambda[(p->base + 2) % 3] - p->mu0[1];
  double det = p->mu_a[0] * p->mu_b[1] - p->mu_a[1] * p->mu_b[0];
  *r = (m1 * p->mu_b[1] - m2 * p->mu_b[0]) / det;
  *rt = (p->mu_a[0] * m2 - p->mu_a[1] * m1) / det;
}

void rad_light_at(void *context, int n, const double (*lambda)[3], double *value) {
  const struct rad_light_at *at = context;
  const struct rad_mesh *mesh = at->w->mesh;
  const struct rad_element *e = &mesh->element[at->element];
  const struct rad_patch *p = &mesh->patch[e->patch];
  struct spread spread;
  spread_set(at->w, e, &spread);
  for (int i = 0; i < n; i++) {
    double r, rt;
    to_patch(p, lambda[i], &r, &rt);
    double phi = rad_angle_phi(p->angle, fmin(fmax(r > 0 ? rt / r : 0, 0), 1));
    spread_at(&spread, within(rad_ungraded(phi, e->p_phi), e->sigma),
              within(rad_ungraded(fmax(r, 0), e->p_r), e->tau), value + i * at->w->n);
  }
}

int rad_light_triangles(const struct rad_mesh *mesh, int element, double corner[2][3][3]) {
  const struct rad_element *e = &mesh->element[element];
  const struct rad_patch *p = &mesh->patch[e->patch];
  double at[4][3]; /* around the element */
  for (int c = 0; c < 4; c++) {
    double phi = rad_graded(e->sigma[c == 1 || c == 2], e->p_phi), mu[2];
    rad_patch_mu(p, phi, rad_graded(e->tau[c / 2], e->p_r), mu);
    at[c][p->base] = 1 - mu[0] - mu[1];
    at[c][(p->base + 1) % 3] = mu[0];
    at[c][(p->base + 2) % 3] = mu[1];
  }
  for (int d = 0; d < 3; d++) {
    corner[0][0][d] = at[0][d];
    corner[0][1][d] = at[2][d];
    corner[0][2][d] = at[3][d];
    corner[1][0][d] = at[0][d];
    corner[1][1][d] = at[1][d];
    corner[1][2][d] = at[2][d];
  }
  return e->tau[0] > 0 ? 2 : 1;
}
