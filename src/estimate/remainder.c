#include "estimate/remainder.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/scramble.h"
#include "estimate/feet.h"
#include "estimate/iterate.h"
#include "estimate/light_cell.h"
#include "visibility/visibility.h"

enum { PER_ELEMENT = 2 };

/* Points of the elements that have unknowns and are near a face. */
struct points {
  int n;
  int *first, *count, *base; /* owned [n_element], [n_element], [n] */
  double (*mu)[2], (*at)[2]; /* owned [n]; at: (phi, r) */
};

static void free_points(struct points *p) {
  free(p->first);
  free(p->count);
  free(p->base);
  free(p->mu);
  free(p->at);
}

/* ---- elements near a face that they do not touch ----------------------------------------------
 */

static double distance_to(const struct rad_triangle *t, const double x[3]) {
  double weight[3];
  return rad_nearest_point(t, x, weight);
}

static int touch(const struct rad_triangle *a, const struct rad_triangle *b) {
  double small = 1e-9 * sqrt(a->area + b->area);
  for (int k = 0; k < 3; k++)
    if (distance_to(a, b->v[k]) <= small || distance_to(b, a->v[k]) <= small)
      return 1;
  return 0;
}

/* True if a face that the element's triangle sees, and does not touch, is nearer to
 * the element's middle than its radius: there K d may change between the check points, and is not
 * seen by them. */
static int is_near(const struct rad_mesh *mesh, int element) {
  const struct rad_scene *s = mesh->scene;
  size_t own = (size_t)rad_element_triangle(mesh, element);
  struct rad_light_cell whole = rad_light_cell_whole(mesh, element);
  struct rad_cell_shape shape;
  rad_light_cell_shape(mesh, &whole, &shape);
  for (int t = 0; t < s->n_triangle; t++)
    if (s->visibility->sight[own * (size_t)s->n_triangle + (size_t)t] &&
        distance_to(&s->triangle[t], shape.centre) < shape.radius &&
        !touch(&s->triangle[own], &s->triangle[t]))
      return 1;
  return 0;
}

/* ---- points ------------------------------------------------------------------------------------
 */

/* A place in [lo, hi] of a variable with exponent p. */
static double place(const double side[2], double p, uint64_t key) {
  double s = side[0] + rad_scramble_unit(key) * (side[1] - side[0]);
  return p == 1 ? s : pow(s, p);
}

static void set_points(const struct rad_mesh *mesh, const unsigned char *passive,
                       struct points *p) {
  for (int i = 0; i < mesh->n_element; i++) {
    const struct rad_element *el = &mesh->element[i];
    p->first[i] = p->n;
    p->count[i] =
        (passive && passive[rad_element_triangle(mesh, i)]) || !is_near(mesh, i) ? 0 : PER_ELEMENT;
    for (int q = 0; q < p->count[i]; q++, p->n++) {
      uint64_t key = ((uint64_t)i * PER_ELEMENT + (uint64_t)q) * 2;
      p->at[p->n][0] = place(el->sigma, el->p_phi, key);
      p->at[p->n][1] = place(el->tau, el->p_r, key + 1);
      p->base[p->n] = mesh->patch[el->patch].base;
      rad_patch_mu(&mesh->patch[el->patch], p->at[p->n][0], p->at[p->n][1], p->mu[p->n]);
    }
  }
}

/* |u* - I u*| / scale at a point of an element, of the worst band; h [n_band, n]. */
static double left_out(const struct rad_indicator *x, const struct points *p, int element,
                       int point, const double *h) {
  const struct rad_mesh *fine = &x->fine;
  const struct rad_scene *s = fine->scene;
  const struct rad_element *el = &fine->element[element];
  int t = rad_element_triangle(fine, element);
  double basis[RAD_GAUSS_MAX * RAD_GAUSS_MAX], most = 0;
  rad_element_basis(fine, element, p->at[point][0], p->at[point][1], basis);
  for (int b = 0; b < s->n_band; b++) {
    const double *star = x->star + (size_t)b * (size_t)fine->n_point + el->first;
    double left = rad_emission(s, t, b, p->base[point], p->mu[point]) +
                  s->rho[t * s->n_band + b] * h[(size_t)b * (size_t)p->n + (size_t)point];
    for (int f = 0; f < el->n_function; f++)
      left -= basis[f] * star[f];
    if (x->scale[b] > 0)
      most = fmax(most, fabs(left) / x->scale[b]);
  }
  return most;
}

enum rad_code rad_remainder(const struct rad_mesh *mesh, const struct rad_rules *rules,
                            const unsigned char *passive, const double *u,
                            const struct rad_indicator *x, double *remainder, struct rad_error *e) {
  size_t n_element = (size_t)mesh->n_element, room = n_element * PER_ELEMENT;
  struct points p = {.first = rad_alloc(n_element, sizeof(int)),
                     .count = rad_alloc(n_element, sizeof(int)),
                     .base = rad_alloc(room, sizeof(int)),
                     .mu = rad_alloc(room, sizeof *p.mu),
                     .at = rad_alloc(room, sizeof *p.at)};
  double *h = rad_alloc(room * (size_t)mesh->scene->n_band, sizeof(double));
  enum rad_code code = RAD_OK;
  if (!p.first || !p.count || !p.base || !p.mu || !p.at || !h) {
    code = rad_fail_memory(e, "the means", 50.0 * (double)room);
  } else {
    set_points(mesh, passive, &p);
    struct rad_element_points points = {p.first, p.count, p.base, (const double(*)[2])p.mu};
    code = rad_irradiance_on(mesh, rules, &points, p.n, mesh->scene->n_band, u, h, e);
  }
  for (int i = 0; i < mesh->n_element && !code; i++) {
    remainder[i] = 0;
    for (int q = 0; q < p.count[i]; q++)
      remainder[i] = fmax(remainder[i], left_out(x, &p, i, p.first[i] + q, h));
  }
  free_points(&p);
  free(h);
  return code;
}
