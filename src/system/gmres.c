#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/stop.h"
#include "system/coarse.h"
#include "system/solve.h"

enum { RESTART = 40, LONGEST = 320, MAX_STEPS = 4000 };

/* The state of one system. It asks for one product K `next` at a time; `product` receives it. */
struct krylov {
  struct rad_linear *system;
  int n, step, done;          /* step: of the cycle; -1: the true residual is due */
  int length;                 /* steps of this cycle at most */
  int is_slow;                /* this cycle, the second or a later one, is preconditioned */
  double scale, target;       /* max |u|; residual to reach */
  double before;              /* residual that the present cycle began with */
  double *basis[LONGEST + 1]; /* owned [n] each, as they are needed */
  double *product;            /* owned [n] */
  double *aim, *means;        /* owned [n] M v of the last column v, scratch of M; NULL without M */
  const double *next;
  const struct rad_coarse *coarse; /* M, once a system is slow */
  enum rad_code code;
  struct rad_error error;         /* of this system */
  double h[LONGEST + 1][LONGEST]; /* Hessenberg, then triangular */
  double cs[LONGEST], sn[LONGEST], g[LONGEST + 1];
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

/* v_{j+1} from A z = z - rho K z, z = M v_j or v_j, by modified Gram-Schmidt; column j of H. */
static void arnoldi(struct krylov *s, int j) {
  size_t n = (size_t)s->n;
  const double *v = s->next;
  double *next = s->basis[j + 1];
  for (size_t i = 0; i < n; i++)
    next[i] = v[i] - s->system->rho[i] * s->product[i];
  for (int m = 0; m <= j; m++) {
    const double *vm = s->basis[m];
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
  double y[LONGEST + 1] = {0}, target = 0.5 * s->target, most = 0, *r = s->product;
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
      r[i] += y[j] * s->basis[j][i];
  for (int i = 0; i < s->n; i++)
    most = fmax(most, fabs(r[i]));
  return most <= target;
}

/* u += M V y, H y = g, for the first m columns. */
static void update(struct krylov *s, int m) {
  double y[LONGEST], *change = s->product;
  for (int i = m - 1; i >= 0; i--) {
    y[i] = s->g[i];
    for (int j = i + 1; j < m; j++)
      y[i] -= s->h[i][j] * y[j];
    y[i] = s->h[i][i] > 0 ? y[i] / s->h[i][i] : 0;
  }
  memset(change, 0, sizeof(double) * (size_t)s->n);
  for (int j = 0; j < m; j++)
    for (int i = 0; i < s->n; i++)
      change[i] += y[j] * s->basis[j][i];
  if (s->is_slow && s->coarse)
    rad_coarse_apply(s->coarse, s->system->rho, change, s->means, change);
  for (int i = 0; i < s->n; i++)
    s->system->u[i] += change[i];
}

/* The product is K u: stop, or begin a cycle from the true residual. The first cycle is plain, for
 * most scenes need no other. */
static enum rad_code begin_cycle(struct krylov *s, struct rad_error *e) {
  struct rad_linear *l = s->system;
  double left = 0;
  for (int i = 0; i < s->n; i++) {
    s->basis[0][i] = l->emission[i] - l->u[i] + l->rho[i] * s->product[i];
    left = fmax(left, fabs(s->basis[0][i]));
  }
  s->scale = 0;
  for (int i = 0; i < s->n; i++)
    s->scale = fmax(s->scale, fabs(l->u[i]));
  s->target = l->tolerance * s->scale;
  s->done = left <= s->target;
  if (s->done)
    return RAD_OK;
  int is_stuck = left > 0.9 * s->before && l->steps > RESTART;
  if (!isfinite(left) || l->steps >= MAX_STEPS || is_stuck)
    return rad_fail(
        e, RAD_ENUMERIC,
        "GMRES did not converge: relative residual %.2e, asked for %.2e, after %d steps; "
        "raise method.solver_tolerance or use method.solver: lu",
        left / s->scale, s->target / s->scale, l->steps);
  l->before = s->before; /* where a stopped run goes on, this cycle begins again */
  s->before = left;
  s->is_slow = l->steps > 0;
  s->length = l->steps < RESTART ? RESTART : l->steps < LONGEST ? l->steps : LONGEST;
  double norm = sqrt(dot(s->n, s->basis[0], s->basis[0]));
  for (int i = 0; i < s->n; i++)
    s->basis[0][i] /= norm;
  memset(s->g, 0, sizeof s->g);
  s->g[0] = norm;
  s->step = 0;
  s->next = s->basis[0];
  return RAD_OK;
}

static enum rad_code add_column(struct krylov *s, int j, struct rad_error *e) {
  if (!s->basis[j])
    s->basis[j] = rad_alloc((size_t)s->n, sizeof(double));
  return s->basis[j] ? RAD_OK : rad_fail_memory(e, "GMRES", 8.0 * s->n);
}

/* Use the product that was asked for. */
static enum rad_code advance(struct krylov *s, struct rad_error *e) {
  if (s->step < 0)
    return begin_cycle(s, e);
  enum rad_code code = add_column(s, s->step + 1, e);
  if (code)
    return code;
  arnoldi(s, s->step);
  double left = rotate(s, s->step);
  s->step++;
  s->system->steps++;
  if (s->step < s->length && !is_small(s, s->step, left)) {
    s->next = s->basis[s->step];
    return RAD_OK;
  }
  update(s, s->step);
  s->step = -1;
  s->next = s->system->u;
  return RAD_OK;
}

/* The preconditioner, for all systems that are not done, once one of them is slow. */
static enum rad_code precondition(const struct rad_operator *k, int n_system, struct krylov *s,
                                  struct rad_coarse *coarse, struct rad_error *e) {
  const double *rho[2 * RAD_MAX_BAND];
  int n = 0, is_slow = 0;
  for (int i = 0; i < n_system; i++) {
    is_slow |= !s[i].done && s[i].is_slow;
    if (!s[i].done)
      rho[n++] = s[i].system->rho;
  }
  if (!is_slow || coarse->tree)
    return RAD_OK;
  enum rad_code code = rad_coarse_build(k, n, rho, coarse, e);
  for (int i = 0; i < n_system && !code && coarse->aggregates.n; i++)
    if (!s[i].done) {
      s[i].coarse = coarse;
      s[i].aim = rad_alloc((size_t)k->n, sizeof(double));
      s[i].means = rad_alloc(2 * (size_t)coarse->aggregates.n, sizeof(double));
      if (!s[i].aim || !s[i].means)
        code = rad_fail_memory(e, "the preconditioner", 8.0 * k->n);
    }
  return code;
}

/* What a column is multiplied as: M v. */
static void aim(struct krylov *s) {
  if (s->done || s->step < 0 || !s->is_slow || !s->coarse)
    return;
  rad_coarse_apply(s->coarse, s->system->rho, s->next, s->means, s->aim);
  s->next = s->aim;
}

static enum rad_code start(struct krylov *s, int n, struct rad_linear *l, struct rad_error *e) {
  if (!l->goes_on) {
    memcpy(l->u, l->emission, sizeof(double) * (size_t)n);
    l->steps = 0;
    l->before = INFINITY;
  }
  *s = (struct krylov){.system = l, .n = n, .step = -1, .before = l->before, .next = l->u};
  s->product = rad_alloc((size_t)n, sizeof(double));
  if (!s->product)
    return rad_fail_memory(e, "GMRES", 8.0 * n);
  return add_column(s, 0, e);
}

/* Back to where the present cycle began. */
static void step_back(struct krylov *s) {
  if (s->step >= 0)
    s->system->steps -= s->step;
  else
    s->system->before = s->before;
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

static void aim_all(int n_system, struct krylov *s) {
#pragma omp parallel for schedule(dynamic) default(none) shared(n_system, s)
  for (int i = 0; i < n_system; i++)
    aim(&s[i]);
}

/* Every system uses its product, each on one thread. */
static enum rad_code advance_all(int n_system, struct krylov *s, struct rad_error *e) {
#pragma omp parallel for schedule(dynamic) default(none) shared(n_system, s)
  for (int i = 0; i < n_system; i++)
    if (!s[i].done)
      s[i].code = advance(&s[i], &s[i].error);
  for (int i = 0; i < n_system; i++)
    if (s[i].code) {
      *e = s[i].error;
      return s[i].code;
    }
  return RAD_OK;
}

enum rad_code rad_gmres(const struct rad_operator *k, int n_system, struct rad_linear *system,
                        struct rad_error *e) {
  struct krylov *s = rad_calloc((size_t)n_system, sizeof *s);
  struct rad_coarse coarse = {0};
  if (!s)
    return rad_fail_memory(e, "GMRES", (double)n_system * sizeof *s);
  enum rad_code code = RAD_OK;
  for (int i = 0; i < n_system && !code; i++)
    code = start(&s[i], k->n, &system[i], e);
  struct rad_progress *progress = k->mesh->scene->progress;
  rad_progress_begin(progress, "products", 0);
  for (int n; !code && (n = multiply(k, n_system, s)) > 0; rad_progress_add(progress, n)) {
    code = advance_all(n_system, s, e);
    if (!code && rad_stop_asked())
      code = rad_fail_stopped(e);
    if (!code)
      code = precondition(k, n_system, s, &coarse, e);
    if (!code)
      aim_all(n_system, s);
  }
  for (int i = 0; i < n_system && code == RAD_ESTOPPED; i++)
    step_back(&s[i]);
  rad_coarse_free(&coarse);
  for (int i = 0; i < n_system; i++) {
    for (int j = 0; j <= LONGEST; j++)
      free(s[i].basis[j]);
    free(s[i].product);
    free(s[i].aim);
    free(s[i].means);
  }
  free(s);
  return code;
}
