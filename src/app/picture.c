/* The picture of a solved case: points and cells of its elements, with the values there. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/case.h"
#include "base/memory.h"

/* VTK's limit on the order of its Lagrange cells. */
enum { MOST_ORDER = 10, VTK_TRIANGLE = 5, VTK_QUAD = 9, VTK_LAGRANGE_QUADRILATERAL = 70 };

static int larger(int a, int b) {
  return a > b ? a : b;
}

/* Points per direction of an element, less one. Linear cells: as asked, and in adaptive runs at
 * least half its degree, or its shape is lost. One Lagrange cell: its degree, and enough for its
 * coordinates, which are polynomials of degree p in a graded variable (times tan of one). */
static int steps_of(const struct rad_case *c, int element) {
  const struct rad_element *e = &c->mesh->element[element];
  int s = c->deck.output.sampling, k = larger(e->k_phi, e->k_r);
  if (c->deck.output.cells == RAD_CELLS_LINEAR)
    return c->is_adaptive ? larger(s, (k + 1) / 2) : s;
  s = larger(larger(s, k - 1), 2 * (int)ceil(fmax(e->p_phi, e->p_r)));
  return s < MOST_ORDER ? s : MOST_ORDER;
}

static size_t cells_of(const struct rad_case *c, int element) {
  size_t s = (size_t)steps_of(c, element);
  return c->deck.output.cells == RAD_CELLS_LINEAR ? s * s : 1;
}

/* Where the points of a picture lie on their triangles. */
struct sites {
  int *triangle, *base; /* owned [n_point] */
  double (*mu)[2];      /* owned [n_point] */
};

/* The same place from the vertex that weighs most. Patches that start at a vertex are exact there
 * and along their edge, however near; elsewhere what is as small as rounding is on an edge. */
static void set_site(const struct rad_patch *patch, double phi, double r, int64_t at,
                     struct sites *sites) {
  double *mu = sites->mu[at];
  rad_patch_mu(patch, phi > 0 ? phi : RAD_LIMIT, r > 0 ? r : RAD_LIMIT, mu);
  sites->triangle[at] = patch->triangle;
  sites->base[at] = patch->base;
  double weight[3];
  weight[patch->base] = 1 - mu[0] - mu[1];
  weight[(patch->base + 1) % 3] = mu[0];
  weight[(patch->base + 2) % 3] = mu[1];
  if (patch->corner >= 0 && weight[patch->base] >= fmax(mu[0], mu[1]) * (1 - 1e-14)) {
    rad_place_limit(mu);
  } else {
    struct rad_place place = rad_place_weighted(patch->triangle, weight);
    sites->base[at] = place.base;
    memcpy(mu, place.mu, sizeof place.mu);
  }
}

/* Position and values of u_h at one point of the picture. */
static void picture_point(const struct rad_case *c, int element, double phi, double r, int64_t at,
                          struct rad_picture *p, struct sites *sites) {
  const struct rad_element *e = &c->mesh->element[element];
  const struct rad_patch *patch = &c->mesh->patch[e->patch];
  double value[RAD_GAUSS_MAX * RAD_GAUSS_MAX], mu[2];
  rad_patch_mu(patch, phi, r, mu);
  rad_triangle_point(&c->scene.triangle[patch->triangle], patch->base, mu, p->point + 3 * at);
  set_site(patch, phi, r, at, sites);
  rad_element_basis(c->mesh, element, phi, r, value);
  int nb = c->scene.n_band;
  for (int b = 0; b < nb; b++) {
    const double *u = c->u + (size_t)b * c->mesh->n_point + e->first;
    const double *h = c->h + (size_t)b * c->mesh->n_point + e->first;
    double su = 0, sh = 0;
    for (int f = 0; f < e->n_function; f++) {
      su += value[f] * u[f];
      sh += value[f] * h[f];
    }
    p->radiosity[at * nb + b] = su;
    p->irradiance[at * nb + b] = sh;
  }
}

/* Append a cell whose points are already in the list. */
static void add_cell(struct rad_picture *p, int triangle, int type, int64_t n) {
  p->type[p->n_cell] = (unsigned char)type;
  p->triangle[p->n_cell] = triangle;
  p->n_cell++;
  p->offset[p->n_cell] = p->offset[p->n_cell - 1] + n;
}

/* s x s linear cells; those at r = 0 are triangles. */
static void add_linear(struct rad_picture *p, int triangle, int64_t first, int s, int has_tip) {
  for (int j = 0; j < s; j++)
    for (int i = 0; i < s; i++) {
      int64_t corner = first + j * (s + 1) + i, *list = p->connectivity + p->offset[p->n_cell];
      int tip = j == 0 && has_tip, n = 0;
      list[n++] = corner;
      if (!tip)
        list[n++] = corner + 1;
      list[n++] = corner + s + 2;
      list[n++] = corner + s + 1;
      add_cell(p, triangle, tip ? VTK_TRIANGLE : VTK_QUAD, n);
    }
}

/* Place of node (i, j), 0..s, in VTK's order: corners round the cell, then sides (both pairs in the
 * same direction), then the inside row by row. */
static int lagrange_place(int i, int j, int s) {
  int side_i = i == 0 || i == s, side_j = j == 0 || j == s, m = s - 1;
  if (side_i && side_j)
    return i ? (j ? 2 : 1) : (j ? 3 : 0);
  if (side_j)
    return 4 + i - 1 + (j ? 2 * m : 0);
  if (side_i)
    return 4 + j - 1 + (i ? m : 3 * m);
  return 4 + 4 * m + (i - 1) + m * (j - 1);
}

/* One cell of order s. At r = 0 its side has the length 0, but a value for each direction. */
static void add_lagrange(struct rad_picture *p, int triangle, int64_t first, int s) {
  int64_t *list = p->connectivity + p->offset[p->n_cell];
  for (int j = 0; j <= s; j++)
    for (int i = 0; i <= s; i++)
      list[lagrange_place(i, j, s)] = first + j * (s + 1) + i;
  add_cell(p, triangle, VTK_LAGRANGE_QUADRILATERAL, (int64_t)(s + 1) * (s + 1));
}

/* Points and cells of one element, equally spaced in its graded variables. */
static void picture_element(const struct rad_case *c, int element, struct rad_picture *p,
                            struct sites *sites) {
  const struct rad_element *e = &c->mesh->element[element];
  int s = steps_of(c, element), triangle = rad_element_triangle(c->mesh, element);
  int64_t first = p->n_point;
  for (int j = 0; j <= s; j++)
    for (int i = 0; i <= s; i++) {
      double sigma = e->sigma[0] + (e->sigma[1] - e->sigma[0]) * i / s;
      double tau = e->tau[0] + (e->tau[1] - e->tau[0]) * j / s;
      picture_point(c, element, pow(sigma, e->p_phi), pow(tau, e->p_r), p->n_point++, p, sites);
    }
  if (c->deck.output.cells == RAD_CELLS_LINEAR)
    add_linear(p, triangle, first, s, e->tau[0] == 0);
  else
    add_lagrange(p, triangle, first, s);
}

/* The estimate of each cell's element, in W/m2. */
static enum rad_code add_estimates(const struct rad_case *c, struct rad_picture *p,
                                   struct rad_error *e) {
  double unit = rad_indicator_scale(&c->adaptive.indicator, c->scene.n_band);
  p->indicator = rad_alloc((size_t)p->n_cell, sizeof(double));
  p->bound = rad_alloc((size_t)p->n_cell, sizeof(double));
  if (!p->indicator || !p->bound)
    return rad_fail_memory(e, "the picture (output.sampling)", 16.0 * (double)p->n_cell);
  int64_t cell = 0;
  for (int i = 0; i < c->mesh->n_element; i++)
    for (size_t n = cells_of(c, i); n > 0; n--, cell++) {
      p->indicator[cell] = c->adaptive.indicator.local[i] * unit;
      p->bound[cell] = c->adaptive.element_bound[i] * unit;
    }
  return RAD_OK;
}

/* An adaptive run reports u* = E + rho K u_h everywhere. */
static enum rad_code use_iterated(const struct rad_case *c, struct rad_picture *p,
                                  struct sites *sites, struct rad_error *e) {
  size_t n = (size_t)p->n_point, nb = (size_t)c->scene.n_band;
  int *first = rad_alloc(2 * (size_t)c->mesh->n_element, sizeof(int)), at = 0;
  int *count = first + c->mesh->n_element;
  double *h = rad_alloc(n * nb, sizeof(double));
  if (!first || !h) {
    free(first);
    free(h);
    return rad_fail_memory(e, "the picture (output.sampling)", 8.0 * (double)(n * nb));
  }
  for (int i = 0; i < c->mesh->n_element; i++) {
    int side = steps_of(c, i) + 1;
    first[i] = at;
    count[i] = side * side;
    at += count[i];
  }
  struct rad_element_points points = {first, count, sites->base, (const double(*)[2])sites->mu};
  struct rad_point_list list = {(int)p->n_point, sites->triangle, sites->base, points.mu};
  enum rad_code code = rad_irradiance_on(c->mesh, &c->rules, &points, at, (int)nb, c->u, h, e);
  for (size_t b = 0; b < nb && !code; b++)
    for (size_t i = 0; i < n; i++)
      p->irradiance[i * nb + b] = h[b * n + i];
  if (!code)
    rad_iterated(&c->scene, &list, p->irradiance, p->radiosity);
  free(first);
  free(h);
  return code;
}

enum rad_code rad_case_picture(const struct rad_case *c, struct rad_picture *p,
                               struct rad_error *e) {
  size_t points = 0, cells = 0, corners = 0, nb = (size_t)c->scene.n_band;
  for (int i = 0; i < c->mesh->n_element; i++) {
    size_t s = (size_t)steps_of(c, i), own = cells_of(c, i);
    points += (s + 1) * (s + 1);
    cells += own;
    corners += own == s * s ? 4 * own : (s + 1) * (s + 1);
  }
  *p = (struct rad_picture){.point = rad_alloc(points, 3 * sizeof(double)),
                            .connectivity = rad_alloc(corners, sizeof(int64_t)),
                            .offset = rad_calloc(cells + 1, sizeof(int64_t)),
                            .type = rad_alloc(cells, 1),
                            .triangle = rad_alloc(cells, sizeof(int)),
                            .radiosity = rad_alloc(points * nb, sizeof(double)),
                            .irradiance = rad_alloc(points * nb, sizeof(double))};
  struct sites sites = {rad_alloc(points, sizeof(int)), rad_alloc(points, sizeof(int)),
                        rad_alloc(points, sizeof *sites.mu)};
  enum rad_code code = RAD_OK;
  if (!p->point || !p->connectivity || !p->offset || !p->type || !p->triangle || !p->radiosity ||
      !p->irradiance || !sites.triangle || !sites.base || !sites.mu)
    code = rad_fail_memory(e, "the picture (output.sampling)",
                           (double)points * (48 + 16.0 * (double)nb));
  for (int i = 0; i < c->mesh->n_element && !code; i++)
    picture_element(c, i, p, &sites);
  if (!code && c->has_bound)
    code = use_iterated(c, p, &sites, e);
  if (!code && c->has_bound)
    code = add_estimates(c, p, e);
  free(sites.triangle);
  free(sites.base);
  free(sites.mu);
  return code;
}
