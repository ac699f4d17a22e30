#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "system/solve.h"

/* A = I - diag(rho) K, column by column. */
static void form(const struct rad_dense *dense, const double *rho, double *a) {
  size_t n = (size_t)dense->n;
  const double *k = dense->k;
#pragma omp parallel for schedule(static) default(none) shared(n, k, rho, a)
  for (size_t j = 0; j < n; j++) {
    for (size_t i = 0; i < n; i++)
      a[i + n * j] = -rho[i] * k[i + n * j];
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

enum rad_code rad_lu(const struct rad_dense *dense, const struct rad_linear *system, double *w,
                     struct rad_solve_report *report, struct rad_error *e) {
  size_t n = (size_t)dense->n, bytes = n * n * sizeof(double);
  double *a = rad_pages_alloc(bytes);
  int *pivot = rad_alloc(n, sizeof(int));
  double *both = rad_alloc(2 * n, sizeof(double));
  enum rad_code code = RAD_OK;
  if (!a || !pivot || !both) {
    code = rad_fail_memory(e, "LU", (double)bytes);
  } else {
    form(dense, system->rho, a);
    code = factor(a, (int)n, pivot, report, e);
  }
  if (!code) {
    memcpy(both, system->emission, n * sizeof(double));
    for (size_t i = 0; i < n; i++)
      both[n + i] = 1;
    LAPACKE_dgetrs(LAPACK_COL_MAJOR, 'N', (int)n, 2, a, (int)n, pivot, both, (int)n);
    memcpy(system->u, both, n * sizeof(double));
    memcpy(w, both + n, n * sizeof(double));
  }
  rad_pages_free(a, bytes);
  free(pivot);
  free(both);
  return code;
}
