#include "app/grid.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"

const char *const rad_grid_name[] = {"closed", "crowded"};
const char *const rad_values_name[] = {"", ", solution", ", reported"};

static int side_of(enum rad_grid grid) {
  return grid == RAD_GRID_CLOSED ? RAD_GRID : RAD_CROWD;
}

static double coordinate(enum rad_grid grid, int i) {
  return grid == RAD_GRID_CLOSED ? i / (RAD_GRID - 1.0) : pow(1e-6, 1 - i / (RAD_CROWD - 1.0));
}

size_t rad_grid_points(enum rad_grid grid, int n_triangle) {
  size_t side = (size_t)side_of(grid);
  return (size_t)n_triangle * RAD_N_SUB * side * side;
}

size_t rad_grid_size(const struct rad_scene *scene, enum rad_grid grid) {
  return rad_grid_points(grid, scene->n_triangle) * (size_t)scene->n_band;
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

/* u_h on all points. */
static void evaluate_uh(const struct rad_case *c, enum rad_grid grid, double *value) {
  int n_sub = c->scene.n_triangle * RAD_N_SUB, nb = c->scene.n_band, side = side_of(grid);
#pragma omp parallel for schedule(dynamic) default(none) shared(c, grid, value, n_sub, nb, side)
  for (int s = 0; s < n_sub; s++) {
    struct rad_patch sub;
    rad_patch_sub_triangle(&c->scene, s / RAD_N_SUB, s % RAD_N_SUB, RAD_ANGLE_POLAR, &sub);
    for (int q = 0; q < side * side; q++)
      grid_point(c, &sub, coordinate(grid, q % side), coordinate(grid, q / side),
                 value + ((size_t)s * (size_t)(side * side) + (size_t)q) * (size_t)nb);
  }
}

/* u* on all points. */
static enum rad_code evaluate_star(const struct rad_case *c, enum rad_grid grid, double *value,
                                   struct rad_error *e) {
  int nb = c->scene.n_band, side = side_of(grid);
  size_t n = rad_grid_size(&c->scene, grid) / (size_t)nb;
  int *triangle = rad_alloc(n, 2 * sizeof(int)), *base = triangle + n;
  double(*mu)[2] = rad_alloc(n, sizeof *mu);
  enum rad_code code = RAD_OK;
  if (!triangle || !mu)
    code = rad_fail_memory(e, "the comparison grid", 24.0 * (double)n);
  for (size_t i = 0; i < n && !code; i++) {
    struct rad_patch sub;
    int s = (int)(i / (size_t)(side * side)), q = (int)(i % (size_t)(side * side));
    rad_patch_sub_triangle(&c->scene, s / RAD_N_SUB, s % RAD_N_SUB, RAD_ANGLE_POLAR, &sub);
    triangle[i] = sub.triangle;
    base[i] = sub.base;
    rad_patch_mu(&sub, coordinate(grid, q % side), coordinate(grid, q / side), mu[i]);
  }
  struct rad_point_list list = {(int)n, triangle, base, (const double(*)[2])mu};
  if (!code)
    code = rad_irradiance_at(c->mesh, &c->rules, &list, nb, c->u, value, e);
  if (!code)
    rad_iterated(&c->scene, &list, value, value);
  free(triangle);
  free(mu);
  return code;
}

enum rad_code rad_grid_evaluate(const struct rad_case *c, enum rad_grid grid, int star,
                                double *value, struct rad_error *e) {
  if (star)
    return evaluate_star(c, grid, value, e);
  evaluate_uh(c, grid, value);
  return RAD_OK;
}

/* Part of point i in an integral over [0, 1]. */
static double trapezoid(enum rad_grid grid, int i) {
  int last = side_of(grid) - 1;
  return 0.5 * (coordinate(grid, i < last ? i + 1 : i) - coordinate(grid, i > 0 ? i - 1 : i));
}

/* Part of a grid point in an integral over a sub-triangle (theory 2.1), but for the area. */
static double weight_of(enum rad_grid grid, int q) {
  int i = q % side_of(grid), j = q / side_of(grid);
  double t = rad_angle_t(RAD_ANGLE_POLAR, coordinate(grid, i));
  return trapezoid(grid, i) * trapezoid(grid, j) * coordinate(grid, j) *
         rad_angle_dt(RAD_ANGLE_POLAR, t);
}

struct rad_difference rad_grid_difference(enum rad_grid grid, int n_triangle, int n_band,
                                          const double *area, const double *a, const double *b) {
  struct rad_difference d = {0, 0};
  int n = side_of(grid) * side_of(grid);
  double sum[RAD_MAX_BAND] = {0}, whole = 0;
  for (int s = 0; s < n_triangle * RAD_N_SUB; s++)
    for (int q = 0; q < n; q++) {
      double w = area[s / RAD_N_SUB] * weight_of(grid, q);
      size_t at = ((size_t)s * (size_t)n + (size_t)q) * (size_t)n_band;
      whole += w;
      for (int k = 0; k < n_band; k++) {
        double e = fabs(a[at + (size_t)k] - b[at + (size_t)k]);
        d.largest = fmax(d.largest, e);
        sum[k] += w * e * e;
      }
    }
  for (int k = 0; k < n_band; k++)
    d.mean_square = fmax(d.mean_square, sqrt(sum[k] / whole));
  return d;
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
