#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "system/solve.h"

enum { RESTART = 40, MAX_STEPS = 4000 };

/* The state of one system. It asks for one product K `next` at a time; `product` receives it. */
struct krylov {
  struct rad_linear *system;
  int n, step, done;       /* step: of the cycle; -1: the true residual is due */
  double scale, target;    /* max |u|; residual to reach */
  double before;           /* residual of the last cycle */
  double *basis, *product; /* owned [RESTART + 1, n], [n] */
  const double *next;
  double h[RESTART + 1][RESTART]; /* Hessenberg, then triangular */
  double cs[RESTART], sn[RESTART], g[RESTART + 1];
};

/* Block by block: a plain sum of n equal terms, as of a nearly constant solution, rounds always to
 * the same side, by up to n/4 ulp in all, and the basis would lose its orthogonality to that. */
static double dot(int n, const double *x, const double *y) {
  enum { BLOCK = 64, LANES = 8 };
  double sum = 0;
  for (int first = 0; first < n; first += BLOCK) {
    double part[LANES] = {0};
    int end = n - first < BLOCK ? n : first + BLOCK, i = first;
    for (; i + LANES <= end; i += LANES)
      for (int l = 0; l < LANES; l++)
        part[l] += x[i + l] * y[i + l];
    for (; i < end; i++)
      part[0] += x[i] * y[i];
    sum +=
        ((part[0] + part[1]) + (part[2] + part[3])) + ((part[4] + part[5]) + (part[6] + part[7]));
  }
  return sum;
}

/* v_{j+1} from A v_j = v_j - rho K v_j by modified Gram-Schmidt; column j of H. */
static void arnoldi(struct krylov *s, int j) {
  size_t n = (size_t)s->n;
  const double *v = s->basis + n * (size_t)j;
  double *next = s->basis + n * (size_t)(j + 1);
  for (size_t i = 0; i < n; i++)
    next[i] = v[i] - s->system->rho[i] * s->product[i];
  for (int m = 0; m <= j; m++) {
    const double *vm = s->basis + n * (size_t)m;
    double h = s->h[m][j] = dot(s->n, next, vm);
    for (size_t i = 0; i < n; i++)
      next[i] -= h * vm[i];
  }
  double norm = s->h[j + 1][j] = sqrt(dot(s->n, next, next));
  for (size_t i = 0; norm > 0 && i < n; i++)
    next[i] /= norm;
}

/* Givens rotations make column j triangular; returns the Euclidean residual. */
static double rotate(struct krylov *s, int j) {
  for (int m = 0; m < j; m++) {
    double a = s->h[m][j], b = s->h[m + 1][j];
    s->h[m][j] = s->cs[m] * a + s->sn[m] * b;
    s->h[m + 1][j] = -s->sn[m] * a + s->cs[m] * b;
  }
  double a = s->h[j][j], b = s->h[j + 1][j], r = hypot(a, b);
  s->cs[j] = r > 0 ? a / r : 1;
  s->sn[j] = r > 0 ? b / r : 0;
  s->h[j][j] = r;
  s->g[j + 1] = -s->sn[j] * s->g[j];
  s->g[j] *= s->cs[j];
  return fabs(s->g[j + 1]);
}

/* True if the residual V Q^T (0 .. 0 g_m), of Euclidean length left, is small in the max norm, with
 * a margin for rounding. That may be true sqrt(n) times earlier than the length tells: a few
 * products, each of which costs more than m vectors. */
static int is_small(struct krylov *s, int m, double left) {
  double y[RESTART + 1] = {0}, target = 0.5 * s->target, most = 0, *r = s->product;
  if (left <= target || left > target * sqrt(s->n))
    return left <= target;
  y[m] = s->g[m];
  for (int j = m - 1; j >= 0; j--) {
    double a = y[j], b = y[j + 1];
    y[j] = s->cs[j] * a - s->sn[j] * b;
    y[j + 1] = s->sn[j] * a + s->cs[j] * b;
  }
  memset(r, 0, sizeof(double) * (size_t)s->n);
  for (int j = 0; j <= m; j++)
    for (int i = 0; i < s->n; i++)
      r[i] += y[j] * s->basis[(size_t)j * (size_t)s->n + (size_t)i];
  for (int i = 0; i < s->n; i++)
    most = fmax(most, fabs(r[i]));
  return most <= target;
}

/* u += V y, H y = g, for the first m columns. */
static void update(struct krylov *s, int m) {
  double y[RESTART];
  for (int i = m - 1; i >= 0; i--) {
    y[i] = s->g[i];
    for (int j = i + 1; j < m; j++)
      y[i] -= s->h[i][j] * y[j];
    y[i] = s->h[i][i] > 0 ? y[i] / s->h[i][i] : 0;
  }
  for (int j = 0; j < m; j++)
    for (int i = 0; i < s->n; i++)
      s->system->u[i] += y[j] * s->basis[(size_t)j * (size_t)s->n + (size_t)i];
}

/* The product is K u: stop, or begin a cycle from the true residual. */
static enum rad_code begin_cycle(struct krylov *s, struct rad_error *e) {
  struct rad_linear *l = s->system;
  double left = 0;
  for (int i = 0; i < s->n; i++) {
    s->basis[i] = l->emission[i] - l->u[i] + l->rho[i] * s->product[i];
    left = fmax(left, fabs(s->basis[i]));
  }
  s->scale = 0;
  for (int i = 0; i < s->n; i++)
    s->scale = fmax(s->scale, fabs(l->u[i]));
  s->target = l->tolerance * s->scale;
  s->done = left <= s->target;
  if (s->done)
    return RAD_OK;
  if (!isfinite(left) || l->steps >= MAX_STEPS || left > 0.9 * s->before)
    return rad_fail(
        e, RAD_ENUMERIC,
        "GMRES did not converge: relative residual %.2e, asked for %.2e, after %d steps; "
        "raise method.solver_tolerance or use method.solver: lu",
        left / s->scale, s->target / s->scale, l->steps);
  s->before = left;
  double norm = sqrt(dot(s->n, s->basis, s->basis));
  for (int i = 0; i < s->n; i++)
    s->basis[i] /= norm;
  memset(s->g, 0, sizeof s->g);
  s->g[0] = norm;
  s->step = 0;
  s->next = s->basis;
  return RAD_OK;
}

/* Use the product that was asked for. */
static enum rad_code advance(struct krylov *s, struct rad_error *e) {
  if (s->step < 0)
    return begin_cycle(s, e);
  arnoldi(s, s->step);
  double left = rotate(s, s->step);
  s->step++;
  s->system->steps++;
  if (s->step < RESTART && !is_small(s, s->step, left)) {
    s->next = s->basis + (size_t)s->step * (size_t)s->n;
    return RAD_OK;
  }
  update(s, s->step);
  s->step = -1;
  s->next = s->system->u;
  return RAD_OK;
}

static enum rad_code start(struct krylov *s, int n, struct rad_linear *l, struct rad_error *e) {
  *s = (struct krylov){.system = l, .n = n, .step = -1, .before = INFINITY, .next = l->u};
  s->basis = rad_alloc((size_t)n * (RESTART + 1), sizeof(double));
  s->product = rad_alloc((size_t)n, sizeof(double));
  if (!s->basis || !s->product)
    return rad_fail_memory(e, "GMRES", 8.0 * n * (RESTART + 2));
  memcpy(l->u, l->emission, sizeof(double) * (size_t)n);
  l->steps = 0;
  return RAD_OK;
}

/* One product for every system that still wants one; returns how many did. */
static int multiply(const struct rad_operator *k, int n_system, struct krylov *s) {
  int total = 0;
  for (int first = 0; first < n_system;) {
    const double *in[RAD_MAX_PRODUCT];
    double *out[RAD_MAX_PRODUCT];
    int n = 0;
    for (; first < n_system && n < RAD_MAX_PRODUCT; first++)
      if (!s[first].done) {
        in[n] = s[first].next;
        out[n++] = s[first].product;
      }
    if (n)
      rad_operator_apply(k, n, in, out);
    total += n;
  }
  return total;
}

enum rad_code rad_gmres(const struct rad_operator *k, int n_system, struct rad_linear *system,
                        struct rad_error *e) {
  struct krylov *s = rad_calloc((size_t)n_system, sizeof *s);
  if (!s)
    return rad_fail_memory(e, "GMRES", (double)n_system * sizeof *s);
  enum rad_code code = RAD_OK;
  for (int i = 0; i < n_system && !code; i++)
    code = start(&s[i], k->n, &system[i], e);
  struct rad_progress *progress = k->mesh->scene->progress;
  rad_progress_begin(progress, "products", 0);
  for (int n; !code && (n = multiply(k, n_system, s)) > 0; rad_progress_add(progress, n))
    for (int i = 0; i < n_system && !code; i++)
      if (!s[i].done)
        code = advance(&s[i], e);
  for (int i = 0; i < n_system; i++) {
    free(s[i].basis);
    free(s[i].product);
  }
  free(s);
  return code;
}
