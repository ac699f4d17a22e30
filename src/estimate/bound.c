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

void rad_set_bound(struct rad_adaptive *a) {
  double least = INFINITY;
  for (int b = 0; b < a->layout.scene->n_band; b++)
    if (a->indicator.scale[b] > 0)
      least = fmin(least, a->indicator.scale[b]);
  double residual = isinf(least) ? 0 : a->report.residual / least;
  double rest = 3 * a->quadrature + a->h2.error + residual, norm = fmax(a->report.inverse_norm, 1);
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

enum rad_code rad_set_element_bound(struct rad_adaptive *a, struct rad_error *e) {
  size_t n = (size_t)a->mesh->n_point;
  struct rad_operator k = rad_adaptive_operator(a);
  double *right = rad_alloc(n, sizeof(double)), *z = rad_alloc(n, sizeof(double));
  a->element_bound = rad_calloc((size_t)a->mesh->n_element, sizeof(double));
  enum rad_code code = RAD_OK;
  if (!right || !z || !a->element_bound)
    code = rad_fail_memory(e, "the error bound", 16.0 * (double)n);
  for (int b = 0; b < a->layout.scene->n_band && !code; b++) {
    for (int i = 0; i < a->mesh->n_element; i++) {
      const struct rad_element *el = &a->mesh->element[i];
      int t = rad_element_triangle(a->mesh, i);
      double found = a->indicator.local[i] + a->indicator.unseen[t];
      double rest = rad_reflects(a, t) * (3 * a->quadrature + a->h2.error);
      for (int f = 0; f < el->n_function; f++)
        right[el->first + f] = rad_safety(a->layout.scene) * found + rest;
    }
    struct rad_linear system = {
        .rho = a->rho + (size_t)b * n, .emission = right, .u = z, .tolerance = 1e-6};
    code = rad_gmres(&k, 1, &system, e);
    int is_known = code != RAD_ENUMERIC; /* else the bound of all elements is that of each */
    code = is_known ? code : RAD_OK;
    for (int i = 0; i < a->mesh->n_element && !code; i++) {
      const struct rad_element *el = &a->mesh->element[i];
      for (int f = 0; f < el->n_function; f++)
        a->element_bound[i] = fmax(a->element_bound[i], is_known ? z[el->first + f] : a->bound);
    }
  }
  free(right);
  free(z);
  return code;
}
