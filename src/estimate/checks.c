#include "estimate/checks.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "estimate/far_parts.h"

enum { CHECK = 5, SIDE = CHECK + 1 }; /* check points per direction and element, odd; and a limit */
_Static_assert(SIDE *SIDE == RAD_CHECKS, "points of an element");

/* Position i of CHECK in [lo, hi] of a variable with exponent p: from 1e-7 of the very edge
 * inwards; i == CHECK is the limit at the edge. */
static double check_at(int i, double lo, double hi, double p) {
  if (lo == 0 && (i == 0 || i == CHECK))
    return i == CHECK ? RAD_LIMIT : RAD_NEAREST;
  double s = lo + (hi - lo) * (0.002 + 0.996 * 0.5 * (1 - cos(M_PI * i / (CHECK - 1))));
  return p == 1 ? s : pow(s, p);
}

void rad_checks_free(struct rad_checks *c) {
  free(c->first);
  free(c->count);
  free(c->base);
  free(c->mu);
  free(c->limit);
  free(c->total);
  free(c->far);
  free(c->sum);
  free(c->largest);
  free(c->part);
  *c = (struct rad_checks){0};
}

/* The points of one element. */
static void set_element(const struct rad_mesh *mesh, int i, int rest, struct rad_checks *c) {
  const struct rad_element *el = &mesh->element[i];
  const struct rad_patch *patch = &mesh->patch[el->patch];
  for (int q = 0; q < RAD_CHECKS; q++) {
    int a = q % SIDE, b = q / SIDE, limit = a == CHECK || b == CHECK;
    int later = (a < CHECK && a % 2) || (b < CHECK && b % 2);
    if ((a == CHECK && el->sigma[0] > 0) || (b == CHECK && el->tau[0] > 0) ||
        (limit && patch->corner < 0))
      continue; /* no limit inside the triangle, or where positions are not relative to the edge */
    if (later != rest || (limit && later))
      continue;
    double phi = check_at(a, el->sigma[0], el->sigma[1], el->p_phi);
    double r = check_at(b, el->tau[0], el->tau[1], el->p_r);
    c->base[c->n] = patch->base;
    rad_patch_mu(patch, phi, r, c->mu[c->n]);
    c->limit[c->n++] = (unsigned char)limit;
    c->count[i]++;
  }
}

enum rad_code rad_checks_set(const struct rad_mesh *mesh, const unsigned char *checked, int rest,
                             struct rad_checks *c, struct rad_error *e) {
  size_t n_element = (size_t)mesh->n_element, most = n_element * RAD_CHECKS;
  size_t n_thread = (size_t)omp_get_max_threads();
  *c = (struct rad_checks){.n_band = mesh->scene->n_band,
                           .first = rad_alloc(n_element, sizeof(int)),
                           .count = rad_calloc(n_element, sizeof(int)),
                           .base = rad_alloc(most, sizeof(int)),
                           .mu = rad_alloc(most, sizeof *c->mu),
                           .limit = rad_alloc(most, 1),
                           .part = rad_calloc(n_thread * n_element, sizeof(double))};
  int done = c->first && c->count && c->base && c->mu && c->limit && c->part;
  for (int i = 0; i < mesh->n_element && done; i++) {
    c->first[i] = c->n;
    if (checked[rad_element_triangle(mesh, i)])
      set_element(mesh, i, rest, c);
  }
  size_t total = (size_t)c->n * (size_t)c->n_band;
  c->total = rad_calloc(total, sizeof(double));
  c->far = rad_calloc(total, sizeof(double));
  c->sum = rad_calloc(total, sizeof(double));
  c->largest = rad_calloc(total, sizeof(double));
  done = done && c->total && c->far && c->sum && c->largest;
  return done ? RAD_OK : rad_fail_memory(e, "the check points", 60.0 * (double)most);
}

/* A pass, for the visitor. */
struct pass {
  const struct rad_once *o;
  const double *weight;
  struct rad_checks *c;
};

/* Parts of one near element at some points, which are all of one triangle. */
static void add_part(void *context, int thread, int element, int target, int n, const int *point,
                     const double *value) {
  const struct pass *pass = context;
  struct rad_checks *c = pass->c;
  double *part = &c->part[(size_t)thread * (size_t)pass->o->mesh->n_element + (size_t)element];
  for (int b = 0; b < c->n_band; b++) {
    double rho = pass->weight[target * c->n_band + b], most = 0;
    for (int i = 0; i < n; i++) {
      double one = fabs(value[b * n + i]);
      size_t at = (size_t)b * (size_t)c->n + (size_t)point[i];
      c->sum[at] += one;
      c->largest[at] = fmax(c->largest[at], one);
      if (!c->limit[point[i]])
        most = fmax(most, one);
    }
    *part = fmax(*part, rho * most);
  }
}

/* Far parts to those of near elements; far: [n_band, n_element]. */
static void add_far(const struct rad_mesh *mesh, const double *far, struct rad_checks *c) {
  size_t n_element = (size_t)mesh->n_element;
  for (int b = 0; b < c->n_band; b++)
    for (size_t i = 0; i < n_element; i++)
      for (int q = c->first[i]; q < c->first[i] + c->count[i]; q++) {
        size_t at = (size_t)b * (size_t)c->n + (size_t)q;
        c->sum[at] += fabs(c->far[at]);
        c->largest[at] = fmax(c->largest[at], far[(size_t)b * n_element + i]);
      }
}

enum rad_code rad_checks_run(struct rad_once *o, const double *integral, const double *weight,
                             struct rad_checks *c, struct rad_error *e) {
  struct pass pass = {o, weight, c};
  struct rad_element_points points = {c->first, c->count, c->base, (const double(*)[2])c->mu};
  double *y[2 * RAD_MAX_BAND], *far;
  size_t n_element = (size_t)o->mesh->n_element;
  for (int b = 0; b < c->n_band; b++) {
    y[b] = c->total + (size_t)b * (size_t)c->n;
    y[c->n_band + b] = c->far + (size_t)b * (size_t)c->n;
  }
  enum rad_code code = rad_once_at(o, &points, c->n_band, y, add_part, &pass, e);
  if (code || o->blocks.far.first[o->tree.n_cluster] == 0)
    return code;
  far = rad_alloc((size_t)c->n_band * n_element, sizeof(double));
  if (!far)
    return rad_fail_memory(e, "the error estimate", 8.0 * c->n_band * (double)n_element);
  code = rad_far_parts(o, c->n_band, integral, weight, far, c->part, e);
  add_far(o->mesh, far, c);
  free(far);
  return code;
}
