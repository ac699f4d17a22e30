#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/stop.h"
#include "system/coarse.h"
#include "system/local.h"
#include "system/solve.h"

enum { RESTART = 40, LONGEST = 320, MAX_STEPS = 4000 };

/* A relative residual that longer cycles do not lower. */
#define ROUNDING 1e-11

/* M of (5.7), for all systems, once one of them is slow. */
struct preconditioner {
  struct rad_coarse coarse;
  struct rad_local local;
};

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
  const double *next;
  const struct preconditioner *m; /* NULL: none */
  int is_second;                  /* the second product of a step is due: of the coarse part */
  double *aim;                    /* owned [n] B v, then P x of the last column v */
  double *x[LONGEST];             /* owned [aggregates] coarse part of M v, for each column v */
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

/* v_{j+1} from A M v_j, which is in its place, by modified Gram-Schmidt; column j of H. */
static void arnoldi(struct krylov *s, int j) {
  size_t n = (size_t)s->n;
  double *next = s->basis[j + 1];
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

static int is_preconditioned(const struct krylov *s) {
  return s->is_slow && s->m;
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
  if (is_preconditioned(s)) {
    double *x = s->x[0];
    int n = s->m->coarse.aggregates.n;
    for (int i = 0; i < n; i++)
      x[i] *= y[0];
    for (int j = 1; j < m; j++)
      for (int i = 0; i < n; i++)
        x[i] += y[j] * s->x[j][i];
    for (int g = 0; g < s->m->local.groups.n; g++)
      rad_local_apply(&s->m->local, s->system->rho, g, change, s->aim);
    rad_coarse_spread(&s->m->coarse, x, change);
    for (int i = 0; i < s->n; i++)
      change[i] += s->aim[i];
  }
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
  int is_stuck = left > 0.9 * s->before && (s->length == LONGEST || left < ROUNDING * s->scale);
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
  int coarse = is_preconditioned(s) ? s->m->coarse.aggregates.n : 0;
  if (!s->basis[j])
    s->basis[j] = rad_alloc((size_t)s->n, sizeof(double));
  if (coarse && j && !s->x[j - 1])
    s->x[j - 1] = rad_alloc((size_t)coarse, sizeof(double));
  return s->basis[j] && (!coarse || !j || s->x[j - 1]) ? RAD_OK
                                                       : rad_fail_memory(e, "GMRES", 8.0 * s->n);
}

/* A M v = A B v + A P x of the last column v, x = A_c^(-1) R (v - A B v): of each product in turn.
 * Returns 1 if the second one is due. */
static int use_product(struct krylov *s) {
  size_t n = (size_t)s->n;
  const double *rho = s->system->rho, *v = s->basis[s->step], *z = s->next;
  double *sum = s->basis[s->step + 1], *rest = s->product;
  for (size_t i = 0; i < n; i++)
    sum[i] = (s->is_second ? sum[i] : 0) + (z[i] - rho[i] * s->product[i]);
  s->is_second = is_preconditioned(s) && !s->is_second;
  if (!s->is_second)
    return 0;
  for (size_t i = 0; i < n; i++)
    rest[i] = v[i] - sum[i];
  rad_coarse_solve(&s->m->coarse, rho, rest, s->x[s->step]);
  rad_coarse_spread(&s->m->coarse, s->x[s->step], s->aim);
  s->next = s->aim;
  return 1;
}

/* Use the product that was asked for. */
static enum rad_code advance(struct krylov *s, struct rad_error *e) {
  if (s->step < 0)
    return begin_cycle(s, e);
  enum rad_code code = add_column(s, s->step + 1, e);
  if (code || use_product(s))
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
                                  struct preconditioner *m, struct rad_error *e) {
  const double *rho[2 * RAD_MAX_BAND];
  int n = 0, is_slow = 0;
  for (int i = 0; i < n_system; i++) {
    is_slow |= !s[i].done && s[i].is_slow;
    if (!s[i].done)
      rho[n++] = s[i].system->rho;
  }
  if (!is_slow || m->coarse.tree)
    return RAD_OK;
  enum rad_code code = rad_coarse_build(k, n, rho, &m->coarse, e);
  if (code || !m->coarse.aggregates.n)
    return code;
  code = rad_local_build(k, m->coarse.tree, n, rho, &m->local, e);
  for (int i = 0; i < n_system && !code; i++)
    if (!s[i].done) {
      s[i].m = m;
      s[i].aim = rad_alloc((size_t)k->n, sizeof(double));
      if (!s[i].aim)
        code = rad_fail_memory(e, "the preconditioner", 8.0 * k->n);
    }
  return code;
}

/* B v of the last column v is what is multiplied first. */
static void aim_all(int n_system, struct krylov *s, const struct rad_local *local) {
  struct krylov *aims[2 * RAD_MAX_BAND];
  int n = 0, n_group = local->groups.n;
  for (int i = 0; i < n_system; i++)
    if (!s[i].done && s[i].step >= 0 && is_preconditioned(&s[i]) && !s[i].is_second)
      aims[n++] = &s[i];
#pragma omp parallel for schedule(static) collapse(2) default(none) shared(n, n_group, aims, local)
  for (int i = 0; i < n; i++)
    for (int g = 0; g < n_group; g++)
      rad_local_apply(local, aims[i]->system->rho, g, aims[i]->basis[aims[i]->step], aims[i]->aim);
  for (int i = 0; i < n; i++)
    aims[i]->next = aims[i]->aim;
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
  struct preconditioner m = {0};
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
      code = precondition(k, n_system, s, &m, e);
    if (!code)
      aim_all(n_system, s, &m.local);
  }
  for (int i = 0; i < n_system && code == RAD_ESTOPPED; i++)
    step_back(&s[i]);
  rad_coarse_free(&m.coarse);
  rad_local_free(&m.local);
  for (int i = 0; i < n_system; i++) {
    for (int j = 0; j <= LONGEST; j++)
      free(s[i].basis[j]);
    for (int j = 0; j < LONGEST; j++)
      free(s[i].x[j]);
    free(s[i].product);
    free(s[i].aim);
  }
  free(s);
  return code;
}
