#include "factors/view_factors.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "factors/pairs.h"

#define LIMIT 3e8     /* points in all */
#define ROUNDING 1e-9 /* of a row's sum, at most */

static enum rad_code init(int n, struct rad_view_factors *f, struct rad_error *e) {
  size_t m = (size_t)n;
  f->n = n;
  f->matrix = rad_calloc(m * m, sizeof(double));
  f->error = rad_calloc(m * m, sizeof(double));
  f->reciprocity = rad_alloc(m * m, sizeof(double));
  f->row_sum = rad_calloc(m, sizeof(double));
  if (!f->matrix || !f->error || !f->reciprocity || !f->row_sum)
    return rad_fail_memory(e, "the view factors", 24.0 * (double)m * (double)m);
  for (size_t k = 0; k < m * m; k++)
    f->reciprocity[k] = NAN;
  return RAD_OK;
}

/* Sums of the pairs [m2] in the upper half and the diagonal of both matrices. */
static void add_pairs(const struct rad_pairs *p, struct rad_view_factors *f, const double *area) {
  const struct rad_triangle *t = p->g->scene->triangle;
  for (int i = 0; i < p->n; i++)
    for (int64_t k = p->first[i]; k < p->first[i + 1]; k++) {
      int a = t[i].surface, b = t[p->other[k]].surface, twice = a == b ? 2 : 1;
      size_t at = (size_t)(a < b ? a : b) * (size_t)f->n + (size_t)(a < b ? b : a);
      size_t across = (size_t)(a < b ? b : a) * (size_t)f->n + (size_t)(a < b ? a : b);
      f->matrix[at] += twice * p->value[k];
      f->error[at] += twice * p->error[k];
      if (isnan(p->from_other[k]))
        continue;
      double worse = fabs(p->value[k] - p->from_other[k]) / fmax(area[a], area[b]);
      f->reciprocity[at] = f->reciprocity[across] = fmax(worse, f->reciprocity[at]);
      f->worst_reciprocity = fmax(f->worst_reciprocity, worse);
    }
}

/* More than 1 is an error of the program. */
static enum rad_code fail_row(const struct rad_scene *scene, int s, double sum, double error,
                              struct rad_error *e) {
  int t = 0;
  while (scene->triangle[t].surface != s)
    t++;
  return rad_fail(e, RAD_ENUMERIC,
                  "the view factors of surface '%s' (triangle %d and others) sum to %.9g, and no "
                  "more than 1 is possible (to their error, %.1g): an error of polyrad; please "
                  "report the deck",
                  scene->surface_name[s], t + 1, sum, error);
}

/* Factors of both directions from the sums. */
static enum rad_code finish(const struct rad_scene *scene, const double *area,
                            struct rad_view_factors *f, struct rad_error *e) {
  size_t n = (size_t)f->n;
  for (size_t s = 0; s < n; s++)
    for (size_t t = s; t < n; t++) {
      double value = f->matrix[s * n + t], error = f->error[s * n + t];
      f->matrix[s * n + t] = value / area[s];
      f->matrix[t * n + s] = value / area[t];
      f->error[s * n + t] = error / area[s];
      f->error[t * n + s] = error / area[t];
    }
  for (size_t s = 0; s < n; s++) {
    double error = 0;
    for (size_t t = 0; t < n; t++) {
      f->row_sum[s] += f->matrix[s * n + t];
      error += f->error[s * n + t];
    }
    f->worst_error = fmax(f->worst_error, error);
    if (!(f->row_sum[s] <= 1 + error + ROUNDING))
      return fail_row(scene, (int)s, f->row_sum[s], error + ROUNDING, e);
  }
  return RAD_OK;
}

static void judge(const struct rad_pairs *p, struct rad_view_factors *f) {
  f->points = p->points;
  f->converged = f->worst_error <= f->tolerance;
  if (!f->converged && p->n_limited)
    snprintf(f->reason, sizeof f->reason,
             "the limit on the number of points was met by %lld of %lld pairs of triangles, with "
             "%lld points",
             (long long)p->n_limited, (long long)p->n_partly, (long long)p->points);
  else if (!f->converged)
    snprintf(f->reason, sizeof f->reason, "rounding does not allow less");
}

enum rad_code rad_view_factors(const struct rad_scene *scene, double tolerance, double limit,
                               struct rad_view_factors *f, struct rad_error *e) {
  double start = rad_seconds();
  struct rad_pair_engine g = {0};
  struct rad_pairs p = {0};
  *f = (struct rad_view_factors){.tolerance = tolerance};
  rad_progress_phase(scene->progress, "view factors");
  double *area = rad_calloc((size_t)scene->n_surface, sizeof *area);
  enum rad_code code = area ? init(scene->n_surface, f, e)
                            : rad_fail_memory(e, "the view factors", 8.0 * scene->n_surface);
  if (!code)
    code = rad_pair_engine_init(scene, &g, e);
  if (!code)
    code = rad_pairs_integrate(&g, tolerance, (int64_t)(limit > 0 ? limit : LIMIT), &p, e);
  for (int t = 0; t < scene->n_triangle && !code; t++)
    area[scene->triangle[t].surface] += scene->triangle[t].area;
  if (!code) {
    add_pairs(&p, f, area);
    code = finish(scene, area, f, e);
    judge(&p, f);
  }
  rad_pairs_free(&p);
  rad_pair_engine_free(&g);
  free(area);
  f->seconds = rad_seconds() - start;
  return code;
}

void rad_view_factors_free(struct rad_view_factors *f) {
  free(f->matrix);
  free(f->error);
  free(f->reciprocity);
  free(f->row_sum);
  *f = (struct rad_view_factors){0};
}
