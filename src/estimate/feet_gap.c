#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec.h"
#include "estimate/feet.h"
#include "estimate/iterate.h"
#include "integrate/strips.h"
#include "system/cluster.h"
#include "visibility/visibility.h"

/* Irradiance at the feet, [n_foot, n_band], then u*. */
static enum rad_code star_at(const struct rad_mesh *mesh, const struct rad_rules *rules,
                             const double *u, const struct rad_feet *feet, double *value,
                             struct rad_error *e) {
  size_t n = (size_t)feet->n_foot;
  int *triangle = rad_alloc(2 * n, sizeof(int)), *base = triangle + n;
  double(*mu)[2] = rad_alloc(n, sizeof *mu);
  enum rad_code code = RAD_OK;
  if (!triangle || !mu)
    code = rad_fail_memory(e, "the error estimate", 24.0 * (double)n);
  for (size_t i = 0; i < n && !code; i++) {
    triangle[i] = feet->feature[feet->foot[i].feature].face;
    base[i] = feet->foot[i].base;
    memcpy(mu[i], feet->foot[i].mu, sizeof mu[i]);
  }
  struct rad_point_list list = {(int)n, triangle, base, (const double(*)[2])mu};
  if (!code)
    code = rad_irradiance_at(mesh, rules, &list, mesh->scene->n_band, u, value, e);
  if (!code)
    rad_iterated(mesh->scene, &list, value, value);
  free(triangle);
  free(mu);
  return code;
}

/* The largest |d| that the samples of an element see. */
static double seen(const struct rad_element *el, const double *d) {
  double most = 0;
  for (int q = 0; q < el->n_function; q++)
    most = fmax(most, fabs(d[el->first + q]));
  return most;
}

/* (6.10): |u* - its interpolant| over scale, as far as it is more than the samples of the element
 * see of d anyway; value: u*, then the gaps. In terms of the irradiance, whole: `missed`. */
static void set_gaps(const struct rad_mesh *fine, const double *star, const double *d,
                     const double *scale, struct rad_feet *feet, double *value) {
  size_t nb = (size_t)fine->scene->n_band;
  double basis[RAD_GAUSS_MAX * RAD_GAUSS_MAX];
  for (int i = 0; i < feet->n_foot; i++) {
    struct rad_foot *f = &feet->foot[i];
    const struct rad_element *el = &fine->element[f->element];
    const double *rho = fine->scene->rho + (size_t)rad_element_triangle(fine, f->element) * nb;
    f->missed = 0;
    rad_element_basis(fine, f->element, f->phi, f->r, basis);
    for (size_t b = 0; b < nb; b++) {
      double sum = 0, *gap = &value[(size_t)i * nb + b];
      const double *at = star + b * (size_t)fine->n_point + el->first;
      for (int q = 0; q < el->n_function; q++)
        sum += basis[q] * at[q];
      if (rho[b] > 0)
        f->missed = fmax(f->missed, fabs(*gap - sum) / rho[b]);
      double rest = scale[b] > 0 ? fabs(*gap - sum) / scale[b] : 0;
      *gap = fmax(rest - seen(el, d + b * (size_t)fine->n_point), 0);
    }
  }
}

/* Longest way between the corners of an element [m]. */
static double diameter_of(const struct rad_mesh *mesh, int element) {
  const struct rad_element *el = &mesh->element[element];
  const struct rad_patch *p = &mesh->patch[el->patch];
  struct rad_polygon corners; /* (r, r t) */
  double most = 0;
  rad_element_polygon(p, el, &corners);
  for (int c = 0; c < corners.n; c++)
    for (int o = 0; o < c; o++) {
      double r = corners.corner[c][0] - corners.corner[o][0], way[3];
      double rt = corners.corner[c][1] - corners.corner[o][1];
      for (int d = 0; d < 3; d++)
        way[d] = r * p->a[d] + rt * p->b[d];
      most = fmax(most, rad_norm(way));
    }
  return most;
}

/* A bound of the form factor of an element from points of a triangle, the foot's being its place.
 */
static double most_view(const struct rad_mesh *mesh, const struct rad_foot *f, double area,
                        double diameter, int triangle) {
  double weight[3];
  double distance = rad_nearest_point(&mesh->scene->triangle[triangle], f->x, weight) - diameter;
  return distance > 0 ? fmin(1, area / (M_PI * distance * distance)) : 1;
}

/* Of one band and triangle: what all elements' gaps may do, and no more than the largest of them.
 */
struct total {
  double sum, most;
};

/* The gaps of one element; factor [n_band]: most of weight times form factor. */
static void spread(const struct rad_mesh *mesh, const double *weight, const double *gap,
                   const struct rad_foot *f, struct total *total, double *factor) {
  size_t n = (size_t)mesh->scene->n_triangle, nb = (size_t)mesh->scene->n_band;
  size_t face = (size_t)rad_element_triangle(mesh, f->element);
  double area = rad_element_area(mesh, f->element), diameter = diameter_of(mesh, f->element);
  memset(factor, 0, sizeof *factor * nb);
  for (size_t t = 0; t < n; t++) {
    if (!mesh->scene->visibility->sight[face * n + t])
      continue;
    double view = most_view(mesh, f, area, diameter, (int)t);
    for (size_t b = 0; b < nb; b++) {
      factor[b] = fmax(factor[b], weight[t * nb + b] * view);
      total[t * nb + b].sum += view * gap[b];
      total[t * nb + b].most = fmax(total[t * nb + b].most, gap[b]);
    }
  }
}

/* Element by element: the largest gap of its feet, at the first of them. */
static void spread_all(const struct rad_mesh *mesh, const double *weight, const double *value,
                       struct rad_feet *feet, int *first, double *most, struct total *total) {
  size_t nb = (size_t)mesh->scene->n_band;
  double factor[RAD_MAX_BAND];
  for (int i = 0; i < mesh->n_element; i++)
    first[i] = -1;
  for (int i = feet->n_foot - 1; i >= 0; i--) {
    int element = feet->foot[i].element;
    first[element] = i;
    for (size_t b = 0; b < nb; b++)
      most[(size_t)element * nb + b] =
          fmax(most[(size_t)element * nb + b], value[(size_t)i * nb + b]);
  }
  for (int i = 0; i < mesh->n_element; i++) {
    if (first[i] < 0)
      continue;
    spread(mesh, weight, &most[(size_t)i * nb], &feet->foot[first[i]], total, factor);
    for (int k = first[i]; k < feet->n_foot; k++)
      for (size_t b = 0; b < nb && feet->foot[k].element == i; b++)
        feet->foot[k].effect = fmax(feet->foot[k].effect, factor[b] * value[(size_t)k * nb + b]);
  }
}

enum rad_code rad_feet_gaps(const struct rad_mesh *mesh, const struct rad_mesh *fine,
                            const struct rad_rules *rules, const double *u, const double *star,
                            const double *d, const double *scale, const double *weight,
                            struct rad_feet *feet, double *received, struct rad_error *e) {
  size_t nb = (size_t)mesh->scene->n_band, n = (size_t)mesh->scene->n_triangle;
  size_t n_element = (size_t)mesh->n_element;
  memset(received, 0, sizeof *received * n * nb);
  if (!feet->n_foot)
    return RAD_OK;
  double *value = rad_alloc((size_t)feet->n_foot * nb, sizeof(double));
  double *most = rad_calloc(n_element * nb, sizeof(double));
  int *first = rad_alloc(n_element, sizeof(int));
  struct total *total = rad_calloc(n * nb, sizeof *total);
  enum rad_code code = RAD_OK;
  if (!value || !most || !first || !total)
    code = rad_fail_memory(e, "the error estimate", 16.0 * (double)(n_element * nb));
  if (!code)
    code = star_at(mesh, rules, u, feet, value, e);
  if (!code) {
    set_gaps(fine, star, d, scale, feet, value);
    spread_all(mesh, weight, value, feet, first, most, total);
    for (size_t i = 0; i < n * nb; i++)
      received[i] = fmin(total[i].sum, total[i].most);
  }
  free(value);
  free(most);
  free(first);
  free(total);
  return code;
}
