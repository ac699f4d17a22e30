#include "estimate/adapt.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "estimate/approach.h"
#include "estimate/bound.h"
#include "estimate/remainder.h"
#include "system/cluster.h"
#include "visibility/visibility.h"

enum { MAX_LEVEL = 40 };

/* A refined part is meant to become this much smaller than its share, more so at later levels, and
 * parts that are nearly too large are refined as well: a level costs more than the unknowns that
 * more caution would save. */
#define OVERSHOOT 3.1
#define NEARLY 0.5

/* A bound this many tolerances large needs no finer look. */
#define FAR_OFF 3

/* Where means miss the tolerance, the bound is to become this part of what would just do. */
#define BELOW 0.6
#define LEAST_TARGET 1e-3 /* of the tolerance */

/* Part of the tolerance that remainders may leave out of a mean. */
#define LEFT_OUT 0.3

/* Parts of the tolerance that quadrature and solver may use up. */
#define QUADRATURE_PART 0.1
#define SOLVER_PART 0.01

static void free_level(struct rad_adaptive *a) {
  rad_dense_free(&a->dense);
  rad_h2_free(&a->h2);
  rad_rules_free(&a->rules);
  if (a->mesh)
    rad_mesh_free(a->mesh);
  free(a->mesh);
  free(a->rho);
  free(a->emission);
  free(a->u);
  free(a->h);
  rad_indicator_free(&a->indicator);
  a->mesh = NULL;
  a->rho = a->emission = a->u = a->h = NULL;
}

void rad_adaptive_free(struct rad_adaptive *a) {
  free_level(a);
  rad_layout_free(&a->layout);
  rad_stage_free(&a->stage);
  rad_means_free(&a->means);
  free(a->element_bound);
  free(a->remainder);
  free(a->least_weight);
  free(a->source);
  free(a->light_source);
  free(a->z);
  *a = (struct rad_adaptive){0};
}

struct rad_operator rad_adaptive_operator(const struct rad_adaptive *a) {
  return a->h2.mesh ? rad_operator_h2(&a->h2) : rad_operator_dense(&a->dense);
}

/* rho and E at the collocation points; 0 on passive triangles, where u = E. */
static enum rad_code set_data(const struct rad_scene *s, struct rad_adaptive *a,
                              struct rad_error *e) {
  const struct rad_mesh *m = a->mesh;
  size_t n = (size_t)m->n_point, total = n * (size_t)s->n_band;
  a->rho = rad_alloc(total, sizeof(double));
  a->emission = rad_alloc(total, sizeof(double));
  a->u = rad_calloc(total, sizeof(double));
  a->h = rad_calloc(total, sizeof(double));
  if (!a->rho || !a->emission || !a->u || !a->h)
    return rad_fail_memory(e, "the solution", 32.0 * (double)total);
  rad_mesh_data(a->mesh, a->rho, a->emission);
  for (int t = 0; t < s->n_triangle; t++)
    for (int i = a->mesh->point_first[t]; a->layout.passive[t] && i < a->mesh->point_first[t + 1];
         i++)
      for (size_t b = 0; b < (size_t)s->n_band; b++)
        a->rho[b * n + (size_t)i] = 0;
  return RAD_OK;
}

/* Quadrature may use its part of the tolerance after the inverse has amplified it. */
static double quadrature_tolerance(const struct rad_goal *g, double inverse_norm) {
  return g->quadrature_tolerance > 0
             ? g->quadrature_tolerance
             : fmin(fmax(0.5 * QUADRATURE_PART * g->tolerance / inverse_norm, 1e-13), 2e-5);
}

static double matrix_bytes(const struct rad_adaptive *a) {
  double n = a->mesh ? a->mesh->n_point : 0;
  return a->h2.mesh ? a->h2.bytes : 8 * n * n;
}

/* The stage to go on from, if the present level begins there. */
static const struct rad_stage *stage_of(const struct rad_goal *g, const struct rad_adaptive *a) {
  return g->from && a->levels == g->from->levels ? g->from : NULL;
}

/* The matrix of the present mesh; refused if it and the estimate do not fit beside `before`. */
static enum rad_code plan_level(const struct rad_goal *g, const struct rad_adaptive *before,
                                const struct rad_adaptive *a, struct rad_system_plan *plan,
                                struct rad_error *e) {
  /* The coarsest mesh is tried in any case: it is small, and there is nothing better. */
  double reserved = before->mesh ? rad_memory_reserved(omp_get_max_threads()) : 0;
  double left = fmin(g->memory - matrix_bytes(before), rad_memory_available() - reserved);
  const struct rad_stage *from = stage_of(g, a);
  enum rad_code code = rad_plan_system(a->mesh, from ? from->matrix : g->matrix, g->solver,
                                       a->quadrature, left, plan, e);
  double need = plan->bytes + rad_indicate_bytes(a->mesh, a->quadrature) + 100.0 * a->mesh->n_point;
  if (code || need <= left)
    return code;
  return rad_fail(e, RAD_ESYSTEM,
                  "the %s mesh, with %.0f unknowns, needs %.3g GB of memory and %.3g GB may be "
                  "used; allow more or give %s",
                  before->mesh ? "next" : "coarsest", rad_layout_unknowns(&a->layout), need / 1e9,
                  fmax(left, 0) / 1e9, before->mesh ? "a larger tolerance" : "fewer triangles");
}

static enum rad_code assemble_h2(const struct rad_stage *from, struct rad_adaptive *a,
                                 struct rad_error *e) {
  enum rad_code code = rad_h2_begin(a->mesh, a->rules.tolerance, &a->h2, e);
  if (!code && from)
    code = from->read(from->context, NULL, &a->h2, e);
  if (!code)
    code = rad_h2_finish(&a->h2, &a->rules, e);
  return code ? code : rad_h2_check(&a->h2, &a->rules, e);
}

/* Blocks of a dense matrix that did not change come from `before`. */
static enum rad_code assemble_dense(const struct rad_stage *from, const struct rad_adaptive *before,
                                    struct rad_adaptive *a, struct rad_error *e) {
  int *origin = rad_alloc((size_t)a->layout.n_leaf, sizeof(int));
  if (!origin)
    return rad_fail_memory(e, "the mesh", 4.0 * a->layout.n_leaf);
  for (int i = 0; i < a->layout.n_leaf; i++)
    origin[i] = a->layout.leaf[i].origin;
  int same = before->dense.k && before->rules.tolerance == a->rules.tolerance;
  struct rad_reuse reuse = {same ? &before->dense : NULL, origin, a->layout.passive};
  enum rad_code code = rad_dense_begin(a->mesh, &reuse, &a->dense, e);
  if (!code && from)
    code = from->read(from->context, &a->dense, NULL, e);
  if (!code)
    code = rad_dense_finish(&a->rules, &reuse, &a->dense, e);
  free(origin);
  return code;
}

/* Mesh, matrix and solution of the present layout. */
static enum rad_code solve_level(const struct rad_scene *scene, const struct rad_goal *g,
                                 const struct rad_adaptive *before, struct rad_adaptive *a,
                                 struct rad_error *e) {
  double start = rad_seconds();
  struct rad_system_plan plan;
  rad_progress_phase(scene->progress, "level %d, matrix", a->levels + 1);
  a->mesh = rad_calloc(1, sizeof *a->mesh);
  if (!a->mesh)
    return rad_fail_memory(e, "the mesh", 0);
  enum rad_code code = rad_layout_mesh(&a->layout, a->mesh, e);
  if (!code)
    code = plan_level(g, before, a, &plan, e);
  if (!code)
    code = rad_rules_build(a->mesh, a->quadrature, &a->rules, e);
  if (!code)
    code = plan.matrix == RAD_MATRIX_HIERARCHICAL ? assemble_h2(stage_of(g, a), a, e)
                                                  : assemble_dense(stage_of(g, a), before, a, e);
  a->seconds_assemble += rad_seconds() - start;
  if (!code)
    code = set_data(scene, a, e);
  if (code)
    return code;
  struct rad_solve_options o = {
      .solver = g->solver, .tolerance = g->solver_tolerance, .quadrature = a->rules.tolerance};
  if (o.tolerance == 0)
    o.tolerance = fmax(SOLVER_PART * g->tolerance, 1e-14);
  struct rad_operator k = rad_adaptive_operator(a);
  rad_progress_phase(scene->progress, "level %d, solve", a->levels + 1);
  return rad_solve(&k, &o, scene->n_band, a->rho, a->emission, a->u, a->h, &a->report, e);
}

/* Degrees to add in one direction, or a split: what reduces its tail by `factor` at less cost. */
static void refine_direction(double factor, double rate, int *k, int *split) {
  double more = log(factor) / fmax(rate, 1e-3);
  if ((*k >= 6 && more > 0.8 * *k) || *k >= RAD_MAX_POINTS_1D) {
    *split = 1;
    return;
  }
  int add = (int)ceil(fmin(fmax(more, 1), 6));
  *k = *k + add < RAD_MAX_POINTS_1D ? *k + add : RAD_MAX_POINTS_1D;
}

/* The effect from which on a foot matters: all together, they do wanted_unseen. */
static double least_effect(const struct rad_indicator *x, double share) {
  double most = 0;
  for (int i = 0; i < x->feet.n_foot; i++)
    most = fmax(most, x->feet.foot[i].effect);
  return NEARLY * share * most / fmax(x->wanted_unseen, 1e-300);
}

/* What an element's remainder does to the mean that is worst, at most. */
static double to_mean(const struct rad_adaptive *a, int element) {
  double area = a->layout.scene->triangle[a->means.worst_triangle].area;
  return a->remainder[element] * fmin(1, rad_element_area(a->mesh, element) / area);
}

/* Elements with a remainder; 0 if no means were made of this mesh. */
static int count_left_out(const struct rad_adaptive *a) {
  int n = 0;
  for (int i = 0; a->remainder && i < a->mesh->n_element; i++)
    n += a->remainder[i] > 0;
  return n;
}

/* How many times an element leaves more out of a mean than its share of the tolerance, n have one.
 */
static double mean_factor(const struct rad_goal *g, const struct rad_adaptive *a, int element,
                          int n) {
  return n > 0 ? to_mean(a, element) * n / (LEFT_OUT * g->tolerance) : 0;
}

/* True if remainders alone may be what a mean misses the tolerance by. */
static int is_left_out(const struct rad_goal *g, const struct rad_adaptive *a) {
  double sum = 0;
  for (int i = 0; i < a->mesh->n_element; i++)
    sum += to_mean(a, i);
  return sum > LEFT_OUT * g->tolerance && a->levels < MAX_LEVEL / 2;
}

static enum rad_code refine(const struct rad_goal *g, struct rad_adaptive *a, struct rad_error *e) {
  struct rad_layout *l = &a->layout;
  const struct rad_indicator *x = &a->indicator;
  struct rad_refinement *what = rad_calloc((size_t)l->n_leaf, sizeof *what);
  if (!what)
    return rad_fail_memory(e, "the refinement", (double)l->n_leaf * sizeof *what);
  double share =
      0.8 * a->target / (rad_safety(l->scene) * fmax(a->report.inverse_norm, 1) * x->spread);
  double over = OVERSHOOT * pow(1.15, a->levels);
  int n_left_out = count_left_out(a);
  for (int i = 0; i < l->n_leaf; i++) {
    const struct rad_leaf *f = &l->leaf[i];
    struct rad_refinement *w = &what[i];
    *w = (struct rad_refinement){.k_phi = f->k_phi, .k_r = f->k_r};
    double factor = fmax(x->part[i] / share, mean_factor(g, a, i, n_left_out));
    double most = fmax(x->tail_phi[i], x->tail_r[i]);
    if (l->passive[l->patch[f->patch].triangle] || factor <= NEARLY)
      continue;
    /* both tails are to fall to the same level */
    double need = over * factor / fmax(most, 1e-300);
    if (need * x->tail_phi[i] > 1)
      refine_direction(need * x->tail_phi[i], x->rate_phi[i], &w->k_phi, &w->split_phi);
    if (need * x->tail_r[i] > 1)
      refine_direction(need * x->tail_r[i], x->rate_r[i], &w->k_r, &w->split_r);
  }
  enum rad_code code = rad_layout_refine(l, what, e);
  free(what);
  free(a->remainder); /* of the mesh before */
  a->remainder = NULL;
  return code ? code : rad_approach(&x->feet, least_effect(x, share), l, e);
}

/* With `whole`, at all check points even if the bound is far off. */
static enum rad_code estimate(int whole, struct rad_adaptive *a, struct rad_error *e) {
  double enough =
      FAR_OFF * a->target / (rad_safety(a->layout.scene) * fmax(a->report.inverse_norm, 1));
  rad_indicator_free(&a->indicator);
  enum rad_code code = rad_indicate(a->mesh, &a->rules, a->layout.passive, a->least_weight, a->u,
                                    whole ? INFINITY : enough, &a->indicator, e);
  if (!code)
    rad_set_bound(a);
  return code;
}

/* One level: solve and estimate. The level before is freed at the end, or put back if the new one
 * is stopped, or, with the reason, if it runs out of memory or cannot be solved. */
static enum rad_code level(const struct rad_scene *scene, const struct rad_goal *g,
                           struct rad_adaptive *a, struct rad_error *e) {
  struct rad_adaptive before = *a;
  a->mesh = NULL;
  a->dense = (struct rad_dense){0};
  a->h2 = (struct rad_h2){0};
  a->rules = (struct rad_rules){0};
  a->indicator = (struct rad_indicator){0};
  a->rho = a->emission = a->u = a->h = NULL;
  a->seconds_assemble = a->seconds_estimate = 0;
  enum rad_code code = solve_level(scene, g, &before, a, e);
  double start = rad_seconds();
  rad_progress_phase(scene->progress, "level %d, estimate", a->levels + 1);
  if (!code)
    code = estimate(0, a, e);
  a->seconds_estimate = rad_seconds() - start;
  a->levels++;
  int is_lost = code == RAD_ESYSTEM || code == RAD_ENUMERIC;
  if ((!is_lost && code != RAD_ESTOPPED) || !before.mesh) {
    free_level(&before);
    return code;
  }
  free_level(a);
  before.layout = a->layout;
  *a = before;
  a->quadrature = a->rules.tolerance; /* that of its matrix, not of the one that was tried */
  if (!is_lost)
    return code;
  snprintf(a->reason, sizeof a->reason, "%.250s", e->text);
  return RAD_OK;
}

/* The remainder; then with z, and what integrals and compression leave in u* itself: sources. */
static enum rad_code bound_sources(struct rad_adaptive *a, double *sources, struct rad_error *e) {
  int is_dark = rad_indicator_scale(&a->indicator, a->layout.scene->n_band) == 0;
  double safety = rad_safety(a->layout.scene);
  enum rad_code code = RAD_OK;
  if (!is_dark)
    code =
        rad_remainder(a->mesh, &a->rules, a->layout.passive, a->u, &a->indicator, a->remainder, e);
  for (int i = 0; i < a->mesh->n_element; i++) {
    a->remainder[i] *= safety;
    sources[i] = a->remainder[i] + a->element_bound[i] +
                 rad_reflects(a, rad_element_triangle(a->mesh, i)) * (a->quadrature + a->h2.error);
  }
  return code;
}

/* z and the means, of the last estimate. */
static enum rad_code conclude(const struct rad_goal *g, struct rad_adaptive *a,
                              struct rad_error *e) {
  double start = rad_seconds();
  double *sources = rad_alloc((size_t)a->mesh->n_element, sizeof(double));
  free(a->element_bound);
  free(a->remainder);
  free(a->source);
  free(a->light_source);
  free(a->z);
  a->remainder = rad_calloc((size_t)a->mesh->n_element, sizeof(double));
  a->element_bound = a->source = a->light_source = a->z = NULL;
  rad_means_free(&a->means);
  rad_progress_phase(a->layout.scene->progress, "means");
  enum rad_code code = rad_set_element_bound(a, e);
  if (!code && (!sources || !a->remainder))
    code = rad_fail_memory(e, "the means", 8.0 * a->mesh->n_element);
  if (!code)
    code = bound_sources(a, sources, e);
  if (!code)
    code = rad_means_estimated(&(struct rad_estimate){&a->indicator, sources}, g->tolerance,
                               &a->means, e);
  free(sources);
  a->seconds_estimate += rad_seconds() - start;
  return code;
}

enum rad_code rad_adapt_estimate(const struct rad_scene *scene, const struct rad_goal *g,
                                 struct rad_adaptive *a, struct rad_error *e) {
  double start = rad_seconds();
  struct rad_rules kept = a->rules; /* may be finer than the estimate needs */
  a->layout.scene = scene;
  a->levels = 1;
  a->target = g->tolerance;
  a->quadrature = fmax(kept.tolerance, quadrature_tolerance(g, fmax(a->report.inverse_norm, 2.5)));
  enum rad_code code = rad_rules_build(a->mesh, a->quadrature, &a->rules, e);
  if (!code)
    code = estimate(1, a, e);
  a->seconds_estimate = rad_seconds() - start;
  if (!code)
    code = conclude(g, a, e);
  rad_rules_free(&a->rules);
  a->rules = kept;
  return code;
}

/* A copy, or NULL if there is none or no memory. */
static double *copy_weights(const struct rad_scene *s, const double *weight) {
  size_t n = (size_t)s->n_triangle * (size_t)s->n_band;
  double *copy = weight ? rad_alloc(n, sizeof(double)) : NULL;
  if (copy)
    memcpy(copy, weight, n * sizeof(double));
  return copy;
}

/* The layout of the first level, or of the one to go on from. */
static enum rad_code begin(const struct rad_scene *scene, const struct rad_goal *g,
                           struct rad_adaptive *a, struct rad_error *e) {
  *a = (struct rad_adaptive){
      .quadrature = quadrature_tolerance(g, 2.5), .least = INFINITY, .target = g->tolerance};
  rad_progress_phase(scene->progress, "exponents");
  enum rad_code code =
      rad_layout_begin(scene, scene->visibility->sight, g->tolerance, &a->layout, e);
  if (code || !g->from)
    return code;
  if (g->from->least_weight && !(a->least_weight = copy_weights(scene, g->from->least_weight)))
    return rad_fail_memory(e, "the means", 8.0 * scene->n_triangle * scene->n_band);
  a->levels = g->from->levels;
  a->stuck = g->from->stuck;
  a->least = g->from->least;
  a->target = g->from->target;
  a->quadrature = g->from->quadrature;
  return rad_stage_restore(g->from, &a->layout, e);
}

/* A level; once it is done, the stage where it began. */
static enum rad_code staged_level(const struct rad_scene *scene, const struct rad_goal *g,
                                  struct rad_adaptive *a, struct rad_error *e) {
  struct rad_stage now = {.levels = a->levels,
                          .stuck = a->stuck,
                          .least = a->least,
                          .target = a->target,
                          .quadrature = a->quadrature};
  enum rad_code code = rad_stage_take(&a->layout, &now, e);
  now.least_weight = copy_weights(scene, a->least_weight);
  if (!code && a->least_weight && !now.least_weight)
    code = rad_fail_memory(e, "the means", 8.0 * scene->n_triangle * scene->n_band);
  if (!code)
    code = level(scene, g, a, e);
  if (code || a->reason[0]) {
    rad_stage_free(&now);
    return code;
  }
  now.matrix = a->h2.mesh ? RAD_MATRIX_HIERARCHICAL : RAD_MATRIX_DENSE;
  rad_stage_free(&a->stage);
  a->stage = now;
  return RAD_OK;
}

/* Where means of irradiance miss the tolerance, K d counts in full. Returns 1 if that is news. */
static int weigh_means(const struct rad_goal *g, struct rad_adaptive *a, struct rad_error *e,
                       enum rad_code *code) {
  size_t n = (size_t)a->means.n * (size_t)a->means.n_band;
  int news = 0;
  if (!a->least_weight && !(a->least_weight = rad_calloc(n, sizeof(double))))
    *code = rad_fail_memory(e, "the means", 8.0 * (double)n);
  for (size_t i = 0; i < n && !*code; i++)
    if (a->least_weight[i] == 0 &&
        a->means.error_irradiance[i] >
            g->tolerance * a->indicator.scale[i % (size_t)a->means.n_band])
      news = a->least_weight[i] = 1;
  return news;
}

/* All is done when the means have met the tolerance too; else it becomes harder. */
static int is_done(const struct rad_goal *g, struct rad_adaptive *a, struct rad_error *e,
                   enum rad_code *code) {
  if (a->means.worst <= g->tolerance)
    return 1;
  a->stuck = 0;
  a->least = INFINITY;
  if (weigh_means(g, a, e, code) || *code)
    return *code != RAD_OK;
  if (is_left_out(g, a))
    return 0;
  a->target = BELOW * a->wanted * fmin(g->tolerance / a->means.worst, 1);
  if (a->target >= g->tolerance * LEAST_TARGET)
    return 0;
  int t = a->means.worst_triangle;
  snprintf(a->reason, sizeof a->reason,
           "refinement does not lower the error of the mean over triangle %d (%s), %.2e", t + 1,
           a->layout.scene->surface_name[a->layout.scene->triangle[t].surface], a->means.worst);
  return 1;
}

/* Refinement that leads nowhere ends. */
static void give_up(struct rad_adaptive *a) {
  a->stuck = a->wanted < 0.7 * a->least ? 0 : a->stuck + 1;
  a->least = fmin(a->least, a->wanted);
  if (a->stuck == 6 || a->levels >= MAX_LEVEL)
    snprintf(
        a->reason, sizeof a->reason,
        "refinement no longer lowers the bound: rounding or the inner tolerances are in the way");
}

enum rad_code rad_adapt(const struct rad_scene *scene, const struct rad_goal *g,
                        struct rad_adaptive *a, struct rad_error *e) {
  double start = rad_seconds(), began = start;
  enum rad_code code = begin(scene, g, a, e);
  int concluded = 0;
  while (!code) {
    began = rad_seconds();
    if ((code = staged_level(scene, g, a, e)) || a->reason[0])
      break;
    concluded = a->wanted <= a->target;
    if (concluded && ((code = conclude(g, a, e)) || is_done(g, a, e, &code)))
      break;
    a->quadrature = fmin(a->quadrature, quadrature_tolerance(g, a->report.inverse_norm));
    if (!concluded) /* else what is wanted has become more */
      give_up(a);
    if (a->reason[0] || (code = refine(g, a, e)))
      break;
  }
  a->seconds_before = began - start;
  if (!code && a->wanted > FAR_OFF * a->target) /* the last look was not a whole one */
    code = estimate(1, a, e);
  return code || concluded ? code : conclude(g, a, e);
}
