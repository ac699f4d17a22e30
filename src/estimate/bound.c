#include "estimate/bound.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "visibility/visibility.h"

/* d is seen through a finer mesh and at check points only: what they may miss. */
#define SAFETY 1.5
#define SAFETY_SHADED 2.5 /* d has kinks */

double rad_safety(const struct rad_scene *s) {
  return s->visibility->n_partly > 0 ? SAFETY_SHADED : SAFETY;
}

/* What integrals, compression and solver add at every point, over max |u|. */
static double rest_of(const struct rad_adaptive *a) {
  double least = INFINITY;
  for (int b = 0; b < a->layout.scene->n_band; b++)
    if (a->indicator.scale[b] > 0)
      least = fmin(least, a->indicator.scale[b]);
  double residual = isinf(least) ? 0 : a->report.residual / least;
  return 3 * a->quadrature + a->h2.error + residual;
}

void rad_set_bound(struct rad_adaptive *a) {
  double rest = rest_of(a), norm = fmax(a->report.inverse_norm, 1);
  double safety = rad_safety(a->layout.scene);
  double unseen = a->indicator.worst_unseen;
  a->bound = (safety * (a->indicator.worst + unseen) + rest) * norm;
  a->wanted =
      fmax(a->bound, (safety * (a->indicator.wanted + a->indicator.wanted_unseen) + rest) * norm);
  a->bound_limit = (safety * (a->indicator.limit + unseen) + rest) * norm;
}

double rad_reflects(const struct rad_adaptive *a, int triangle) {
  const struct rad_scene *s = a->layout.scene;
  double most = 0;
  if (a->layout.passive && a->layout.passive[triangle])
    return 0;
  for (int b = 0; b < s->n_band; b++)
    most = fmax(most, s->rho[triangle * s->n_band + b]);
  return most;
}

/* g of u, also at the collocation points; and of h = K u_h, which lacks K d and K (u - u*). */
static void set_sources(struct rad_adaptive *a, double *at_points) {
  const struct rad_indicator *x = &a->indicator;
  int nb = a->layout.scene->n_band;
  double safety = rad_safety(a->layout.scene), rest = rest_of(a);
  for (int i = 0; i < a->mesh->n_element; i++) {
    const struct rad_element *el = &a->mesh->element[i];
    int t = rad_element_triangle(a->mesh, i);
    double found = x->local_limit[i] + x->unseen[t];
    a->source[i] = safety * found + rest;
    for (int f = 0; f < el->n_function; f++)
      at_points[el->first + f] = safety * found + rad_reflects(a, t) * rest;
    for (int b = 0; b < nb; b++)
      a->light_source[i * nb + b] =
          safety * (x->received_limit[i * nb + b] + x->unseen_received[t * nb + b]) + rest;
  }
}

enum rad_code rad_set_element_bound(struct rad_adaptive *a, struct rad_error *e) {
  size_t n = (size_t)a->mesh->n_point, nb = (size_t)a->layout.scene->n_band;
  struct rad_operator k = rad_adaptive_operator(a);
  double *right = rad_alloc(n, sizeof(double));
  a->source = rad_alloc((size_t)a->mesh->n_element, sizeof(double));
  a->light_source = rad_alloc((size_t)a->mesh->n_element * nb, sizeof(double));
  a->z = rad_alloc(n * nb, sizeof(double));
  a->element_bound = rad_calloc((size_t)a->mesh->n_element, sizeof(double));
  enum rad_code code = RAD_OK;
  if (!right || !a->source || !a->light_source || !a->z || !a->element_bound)
    code = rad_fail_memory(e, "the error bound", 8.0 * (double)(n + n * nb));
  else
    set_sources(a, right);
  for (size_t b = 0; b < nb && !code; b++) {
    double *z = a->z + b * n;
    struct rad_linear system = {
        .rho = a->rho + b * n, .emission = right, .u = z, .tolerance = 1e-6};
    code = rad_gmres(&k, 1, &system, e);
    if (code == RAD_ENUMERIC) { /* the bound of all elements is that of each */
      code = RAD_OK;
      for (size_t i = 0; i < n; i++)
        z[i] = a->bound_limit;
    }
    for (int i = 0; i < a->mesh->n_element && !code; i++) {
      const struct rad_element *el = &a->mesh->element[i];
      for (int f = 0; f < el->n_function; f++)
        a->element_bound[i] = fmax(a->element_bound[i], z[el->first + f]);
    }
  }
  free(right);
  return code;
}
