#include <lapacke.h>
#include <math.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/memory.h"
#include "system/solve.h"

/* A = I - diag(rho) K of the points in index [n], column by column. */
static void form(const struct rad_dense *dense, const double *rho, size_t n, const int *index,
                 double *a) {
  size_t ld = (size_t)dense->n;
  const double *k = dense->k;
#pragma omp parallel for schedule(static) default(none) shared(n, index, ld, k, rho, a)
  for (size_t j = 0; j < n; j++) {
    const double *column = k + ld * (size_t)index[j];
    for (size_t i = 0; i < n; i++)
      a[i + n * j] = -rho[index[i]] * column[index[i]];
    a[j + n * j] += 1;
  }
}

/* Factor a in place; condition estimate in the max norm. */
static enum rad_code factor(double *a, int n, int *pivot, struct rad_solve_report *report,
                            struct rad_error *e) {
  double norm = LAPACKE_dlange(LAPACK_COL_MAJOR, 'I', n, n, a, n), rcond = 0;
  double start = rad_seconds();
  int info = (int)LAPACKE_dgetrf(LAPACK_COL_MAJOR, n, n, a, n, pivot);
  report->seconds_factor += rad_seconds() - start;
  if (info < 0)
    return rad_fail(e, RAD_ENUMERIC,
                    "the matrix holds a number that is not finite; check rho and the geometry");
  if (info == 0 && LAPACKE_dgecon(LAPACK_COL_MAJOR, 'I', n, a, n, norm, &rcond))
    rcond = 0;
  double condition = rcond > 0 ? 1 / rcond : INFINITY;
  report->condition_estimate =
      isnan(report->condition_estimate) ? condition : fmax(report->condition_estimate, condition);
  if (condition > 1e14)
    return rad_fail(e, RAD_ENUMERIC,
                    "the matrix is singular (condition estimate %.2g); a part of the scene loses "
                    "almost no light: lower rho or open the scene",
                    condition);
  return RAD_OK;
}

/* Points of the triangles of one part; returns their number. */
static int list_points(const struct rad_mesh *mesh, const int *part, int which, int *index) {
  int n = 0;
  for (int t = 0; t < mesh->scene->n_triangle; t++)
    for (int p = mesh->point_first[t]; part[t] == which && p < mesh->point_first[t + 1]; p++)
      index[n++] = p;
  return n;
}

/* One part: u and w at its points. */
static enum rad_code solve_part(const struct rad_dense *dense, int n, const int *index,
                                const struct rad_linear *system, double *w,
                                struct rad_solve_report *report, struct rad_error *e) {
  size_t size = (size_t)n, bytes = size * size * sizeof(double);
  double *a = rad_pages_alloc(bytes), *both = rad_alloc(2 * size, sizeof(double));
  int *pivot = rad_alloc(size, sizeof(int));
  enum rad_code code = RAD_OK;
  if (!a || !pivot || !both) {
    code = rad_fail_memory(e, "LU", (double)bytes);
  } else {
    form(dense, system->rho, size, index, a);
    code = factor(a, n, pivot, report, e);
  }
  if (!code) {
    for (size_t i = 0; i < size; i++) {
      both[i] = system->emission[index[i]];
      both[size + i] = 1;
    }
    LAPACKE_dgetrs(LAPACK_COL_MAJOR, 'N', n, 2, a, n, pivot, both, n);
    for (size_t i = 0; i < size; i++) {
      system->u[index[i]] = both[i];
      w[index[i]] = both[size + i];
    }
  }
  rad_pages_free(a, bytes);
  free(pivot);
  free(both);
  return code;
}

enum rad_code rad_lu(const struct rad_dense *dense, int n_part, const int *part,
                     const struct rad_linear *system, double *w, struct rad_solve_report *report,
                     struct rad_error *e) {
  int *index = rad_alloc((size_t)dense->n, sizeof(int));
  enum rad_code code = index ? RAD_OK : rad_fail_memory(e, "LU", 4.0 * dense->n);
  for (int p = 0; p < n_part && !code; p++) {
    int n = list_points(dense->mesh, part, p, index);
    code = solve_part(dense, n, index, system, w, report, e);
  }
  free(index);
  return code;
}
