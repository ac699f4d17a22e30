#include "integrate/rule.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

const int rad_order[RAD_N_ORDER] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 20, 24, 32, 48};

/* Below this, rounding hides the quadrature error. */
#define SMALLEST 4e-14

/* The model integrand's samples for one rule: position z in [-1,1], weight with and without T. */
struct sample {
  int n;
  double z[RAD_GAUSS_MAX], with[RAD_GAUSS_MAX], without[RAD_GAUSS_MAX];
};

/* r or t of a value of tau or sigma, and the derivative with the area's factor r. */
static double position(const struct rad_panel *p, double tau) {
  double value = p->p == 1 ? tau : pow(tau, p->p);
  return p->radial ? value : rad_angle_t(p->angle, value);
}

static double jacobian(const struct rad_panel *p, double tau, double at) {
  double slope = p->p == 1 ? 1 : p->p * pow(tau, p->p - 1);
  return slope * (p->radial ? at : rad_angle_dt(p->angle, at));
}

static void set_sample(const struct rad_gauss *g, int n, const struct rad_panel *panel,
                       struct sample *s) {
  const double *x = rad_gauss_node(g, n), *w = rad_gauss_weight(g, n);
  double a = position(panel, panel->lo), b = position(panel, panel->hi);
  s->n = n;
  for (int q = 0; q < n; q++) {
    double tau = panel->lo + 0.5 * (1 + x[q]) * (panel->hi - panel->lo), at = position(panel, tau);
    s->z[q] = (2 * at - a - b) / (b - a);
    s->without[q] = w[q] * jacobian(panel, tau, at);
    s->with[q] = s->without[q] * cos((panel->k - 1) * acos(x[q])) * (1 + s->z[q]);
  }
}

static double model(const struct sample *s, const double *weight, double re, double im) {
  double sum = 0;
  for (int q = 0; q < s->n; q++) {
    double dz = s->z[q] - re, d2 = dz * dz + im * im;
    sum += weight[q] / (d2 * d2);
  }
  return sum;
}

/* Largest relative error of a rule over poles on the ellipse |z - 1| + |z + 1| = 2 D. */
static double worst_error(const struct sample *rule, const struct sample *fine, double distance) {
  enum { N_DIRECTION = 9 };
  double worst = 0;
  for (int i = 0; i < N_DIRECTION; i++) {
    double theta = M_PI * i / (N_DIRECTION - 1);
    double re = distance * cos(theta), im = sqrt(distance * distance - 1) * sin(theta);
    double error = model(rule, rule->with, re, im) - model(fine, fine->with, re, im);
    worst = fmax(worst, fabs(error) / model(fine, fine->without, re, im));
  }
  return worst;
}

void rad_panel_reach(const struct rad_gauss *g, const struct rad_panel *panel, double tolerance,
                     double reach[RAD_N_ORDER]) {
  struct sample rule, fine;
  set_sample(g, RAD_GAUSS_MAX, panel, &fine);
  for (int o = 0; o < RAD_N_ORDER; o++) {
    set_sample(g, rad_order[o], panel, &rule);
    double near = log(1.05), far = log(1e3);
    if (worst_error(&rule, &fine, exp(far)) > tolerance) {
      reach[o] = INFINITY;
      continue;
    }
    while (far - near > 0.01) { /* D to one percent */
      double mid = 0.5 * (near + far);
      if (worst_error(&rule, &fine, exp(mid)) > tolerance)
        near = mid;
      else
        far = mid;
    }
    reach[o] = exp(far);
  }
}

static enum rad_code set_tables(const struct rad_mesh *mesh, struct rad_panel *p,
                                struct rad_error *e) {
  const struct rad_gauss *g = &mesh->gauss;
  size_t total = 0;
  for (int o = 0; o < RAD_N_ORDER; o++)
    total += (size_t)rad_order[o] * (size_t)(p->k + 1);
  double *next = p->block = rad_alloc(total, sizeof(double));
  if (!next)
    return rad_fail_memory(e, "the quadrature rules", 8.0 * (double)total);
  for (int o = 0; o < RAD_N_ORDER; o++) {
    int n = rad_order[o];
    const double *x = rad_gauss_node(g, n), *w = rad_gauss_weight(g, n);
    p->point[o] = next;
    p->weight[o] = next + n;
    next += n * (p->k + 1);
    for (int q = 0; q < n; q++) {
      double half = 0.5 * (p->hi - p->lo), tau = p->lo + (1 + x[q]) * half, lagrange[RAD_GAUSS_MAX];
      rad_lagrange(&mesh->nodes, p->k, x[q], lagrange);
      p->point[o][q] = position(p, tau);
      double factor = w[q] * half * jacobian(p, tau, p->point[o][q]);
      for (int a = 0; a < p->k; a++)
        p->weight[o][a * n + q] = factor * lagrange[a];
    }
  }
  return RAD_OK;
}

static int compare_panel(const void *left, const void *right) {
  const struct rad_panel *a = left, *b = right;
  double key_a[] = {a->k, a->radial, a->angle, a->p, a->lo, a->hi};
  double key_b[] = {b->k, b->radial, b->angle, b->p, b->lo, b->hi};
  for (int i = 0; i < 6; i++)
    if (key_a[i] != key_b[i])
      return key_a[i] < key_b[i] ? -1 : 1;
  return 0;
}

static struct rad_panel panel_of(const struct rad_mesh *mesh, int element, int radial) {
  const struct rad_element *e = &mesh->element[element];
  const double *range = radial ? e->tau : e->sigma;
  return (struct rad_panel){.lo = range[0],
                            .hi = range[1],
                            .p = radial ? e->p_r : e->p_phi,
                            .k = radial ? e->k_r : e->k_phi,
                            .radial = radial,
                            .angle = radial ? RAD_ANGLE_DUFFY : mesh->patch[e->patch].angle};
}

/* Sorted list of the distinct intervals, and each element's place in it. */
static enum rad_code collect(const struct rad_mesh *mesh, struct rad_rules *rules,
                             struct rad_error *e) {
  size_t n = (size_t)mesh->n_element;
  rules->angular = rad_alloc(n, sizeof(int));
  rules->radial = rad_alloc(n, sizeof(int));
  rules->panel = rad_alloc(2 * n, sizeof *rules->panel);
  if (!rules->angular || !rules->radial || !rules->panel)
    return rad_fail_memory(e, "the quadrature rules", (double)n * 2 * sizeof *rules->panel);
  for (int i = 0; i < mesh->n_element; i++)
    for (int radial = 0; radial < 2; radial++)
      rules->panel[2 * i + radial] = panel_of(mesh, i, radial);
  qsort(rules->panel, 2 * n, sizeof *rules->panel, compare_panel);
  int kept = 0;
  for (size_t i = 0; i < 2 * n; i++)
    if (!kept || compare_panel(&rules->panel[kept - 1], &rules->panel[i]))
      rules->panel[kept++] = rules->panel[i];
  rules->n_panel = kept;
  for (int i = 0; i < mesh->n_element; i++)
    for (int radial = 0; radial < 2; radial++) {
      struct rad_panel key = panel_of(mesh, i, radial);
      struct rad_panel *at = bsearch(&key, rules->panel, (size_t)kept, sizeof key, compare_panel);
      (radial ? rules->radial : rules->angular)[i] = (int)(at - rules->panel);
    }
  return RAD_OK;
}

/* The panel whose reach serves p: itself if graded. A plain radial one takes that of [0, 1], the
 * worst; a plain angular one that of a width 2^-m at least its own, next to the map's pole. */
static struct rad_panel model_panel(const struct rad_panel *p) {
  struct rad_panel m = *p;
  if (p->p != 1)
    return m;
  m.hi = 1;
  m.lo = p->radial || p->angle == RAD_ANGLE_DUFFY ? 0 : 1 - exp2(ceil(log2(p->hi - p->lo)));
  return m;
}

/* Reach of panel i, copied if an earlier one has the same model. */
static void set_reach(const struct rad_mesh *mesh, struct rad_rules *rules, int i) {
  struct rad_panel *p = &rules->panel[i], model = model_panel(p);
  for (int j = 0; j < i && p->p == 1; j++) {
    struct rad_panel other = model_panel(&rules->panel[j]);
    if (!compare_panel(&model, &other)) {
      memcpy(p->reach, rules->panel[j].reach, sizeof p->reach);
      return;
    }
  }
  /* both directions may have lost as much; what rounding hides cannot be asked for */
  double loss = mesh->nodes.loss[p->k], tolerance = 0.25 * rules->tolerance / (loss * loss);
  rad_panel_reach(&mesh->gauss, &model, fmax(tolerance, 0.25 * SMALLEST), p->reach);
}

enum rad_code rad_rules_build(const struct rad_mesh *mesh, double tolerance,
                              struct rad_rules *rules, struct rad_error *e) {
  *rules = (struct rad_rules){.tolerance = fmax(tolerance, SMALLEST)};
  enum rad_code code = collect(mesh, rules, e);
  if (code)
    return code;
  for (int i = 0; i < rules->n_panel; i++) {
    struct rad_panel *p = &rules->panel[i];
    set_reach(mesh, rules, i);
    if ((code = set_tables(mesh, p, e)))
      return code;
  }
  return RAD_OK;
}

void rad_rules_free(struct rad_rules *rules) {
  for (int i = 0; i < rules->n_panel && rules->panel; i++)
    free(rules->panel[i].block);
  free(rules->panel);
  free(rules->angular);
  free(rules->radial);
  *rules = (struct rad_rules){0};
}
