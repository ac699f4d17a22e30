#include "app/case.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>

#include "app/checkpoint.h"
#include "app/picture.h"
#include "base/clock.h"
#include "base/memory.h"
#include "system/coarse.h"
#include "system/local.h"
#include "visibility/isolated.h"

/* |inverse| over 1/(1 - kappa), kappa known at the collocation points only: with Gauss points it
 * was never above 1.01 (docs/stability.md). */
#define UNSTABLE 1.2

static enum rad_code refuse_unavailable(const struct rad_case *c, struct rad_error *e) {
  if (c->deck.method.matrix == RAD_MATRIX_HIERARCHICAL && c->deck.method.solver == RAD_SOLVER_LU)
    return rad_fail(e, RAD_EINPUT,
                    "%s: error: method.solver: lu needs a dense matrix; use solver: gmres, or "
                    "matrix: dense",
                    c->deck.path);
  if (c->deck.method.mesh == RAD_MESH_UNIFORM && c->deck.method.degree > 1)
    return rad_fail(e, RAD_EINPUT,
                    "%s: error: method.degree is %d, but the uniform mesh has degree 0 or 1 only; "
                    "choose mesh: paper or graded for higher degrees",
                    c->deck.path, c->deck.method.degree);
  return RAD_OK;
}

static enum rad_code refuse_fields(const struct rad_case *c, struct rad_error *e) {
  if (c->scene.heat || !(c->deck.output.fields & (RAD_FIELD_NET_FLUX | RAD_FIELD_TEMPERATURE)))
    return RAD_OK;
  return rad_fail(e, RAD_EINPUT,
                  "%s: error: output.fields asks for net_flux or temperature, but no face of the "
                  "scene has a temperature or flux; leave them out",
                  c->deck.path);
}

/* Part of an asked accuracy that compression of a matrix made by hand may use up. */
#define COMPRESSION_PART 0.02

/* A deck that says nothing of the mesh leaves it to the tolerance; without one, 1e-3. */
static void choose_mode(struct rad_case *c) {
  struct rad_deck_method *m = &c->deck.method;
  c->is_adaptive = !(m->given & RAD_GIVEN_ANY_MESH) && m->solver != RAD_SOLVER_NEUMANN;
  for (int t = 0; t < c->scene.n_triangle; t++)
    if (c->scene.triangle[t].n_grading || c->scene.triangle[t].n_elements)
      c->is_adaptive = 0;
  c->tolerance = c->deck.tolerance > 0 ? c->deck.tolerance : 1e-3;
  c->compression = fmax(m->quadrature_tolerance, COMPRESSION_PART * fmax(c->deck.tolerance, 0));
  int folded = m->mesh == RAD_MESH_UNIFORM && m->degree == 1;
  int suspect = m->nodes.kind != RAD_NODES_GAUSS; /* a number alone would be a trap */
  c->wants_bound = c->is_adaptive || ((c->deck.tolerance > 0 || suspect) &&
                                      m->solver != RAD_SOLVER_NEUMANN && !folded);
}

/* True if rho is so near to 1 somewhere that GMRES may need its coarse problem: that depends on how
 * narrow the scene is, so that half of it is counted. */
static int is_bright(const struct rad_scene *s) {
  double most = 0;
  for (size_t i = 0; i < (size_t)s->n_triangle * (size_t)s->n_band; i++)
    most = fmax(most, s->rho[i]);
  return most > 0.9;
}

/* Of what halving adds: about five points for three cells, and a middle that is looked at for each.
 */
static double halved_bytes(const struct rad_case *c) {
  return c->plan.halved *
         (3 * (24 + 40.0 * c->scene.n_band) + 64 + (double)sizeof(struct rad_tile));
}

/* Sizes of the run, from counts alone. */
static void plan(struct rad_case *c) {
  struct rad_plan *p = &c->plan;
  double elements, n = rad_mesh_count(&c->scene, &c->deck.method, &elements);
  int s = c->deck.output.sampling, nb = c->scene.n_band;
  double mesh = n * 20 + elements * (double)sizeof(struct rad_element);
  double picture = elements * ((s + 1.0) * (s + 1) * (24 + 40.0 * nb) + s * s * 64.0);
  p->unknowns = n;
  p->system = rad_plan_dense(c->deck.method.solver, n, nb);
  p->rest_bytes = mesh + picture + halved_bytes(c);
  if (p->system.solver == RAD_SOLVER_GMRES && is_bright(&c->scene))
    p->rest_bytes += 0.5 * (rad_coarse_bytes(n, nb) + rad_local_bytes(n, nb));
  p->base_bytes = rad_memory_resident();
  p->bytes = p->system.bytes + p->rest_bytes;
  p->available = fmax(rad_memory_available() - rad_memory_reserved(omp_get_max_threads()), 0);
  p->pairs = n * elements;
}

static int may_compress(const struct rad_case *c) {
  return rad_plan_may_compress(c->deck.method.matrix, c->deck.method.solver, c->plan.unknowns);
}

static enum rad_code refuse_too_large(const struct rad_case *c, struct rad_error *e) {
  const struct rad_plan *p = &c->plan;
  if (p->bytes <= p->available)
    return RAD_OK;
  double gmres = rad_solver_bytes(RAD_SOLVER_GMRES, p->unknowns, c->scene.n_band);
  const char *advice = p->system.solver == RAD_SOLVER_LU && gmres < p->available
                           ? "use method.solver: gmres, which needs half of it"
                           : "lower method.elements or method.degree, or use a larger machine";
  return rad_fail(e, RAD_ESYSTEM,
                  "the run needs %.3g GB of memory for %.0f unknowns, but only %.3g GB are "
                  "available; %s",
                  p->bytes / 1e9, p->unknowns, p->available / 1e9, advice);
}

/* Dense or hierarchical, once the mesh can tell what the latter takes; and the estimate, which
 * comes when the matrix is there. */
static enum rad_code choose_matrix(struct rad_case *c, struct rad_error *e) {
  struct rad_plan *p = &c->plan;
  const struct rad_deck_method *m = &c->deck.method;
  enum rad_code code =
      rad_plan_system(c->mesh, m->matrix, m->solver, c->compression, p->available, &p->system, e);
  double estimate = c->wants_bound ? rad_indicate_bytes(c->mesh, m->quadrature_tolerance) : 0;
  p->bytes = fmax(p->system.bytes, p->system.matrix_bytes + estimate) + p->rest_bytes;
  return code ? code : refuse_too_large(c, e);
}

enum rad_code rad_case_keep_form(struct rad_case *c, enum rad_matrix form, struct rad_error *e) {
  if (c->plan.system.matrix == form)
    return RAD_OK;
  c->deck.method.matrix = form;
  plan(c);
  return form == RAD_MATRIX_DENSE ? refuse_too_large(c, e) : choose_matrix(c, e);
}

enum rad_code rad_case_read(const char *deck, int n_set, const char *const *set,
                            struct rad_progress *progress, struct rad_case *c,
                            struct rad_error *e) {
  *c = (struct rad_case){.n_set = n_set, .set = set};
  double start = rad_seconds();
  rad_progress_phase(progress, "scene");
  enum rad_code code = rad_deck_read(deck, n_set, set, &c->deck, e);
  c->seconds_scene = rad_seconds() - start;
  return code;
}

enum rad_code rad_case_prepare(const char *deck, int n_set, const char *const *set,
                               struct rad_progress *progress, struct rad_case *c,
                               struct rad_error *e) {
  enum rad_code code = rad_case_read(deck, n_set, set, progress, c, e);
  return code ? code : rad_case_build(progress, c, e);
}

enum rad_code rad_case_build(struct rad_progress *progress, struct rad_case *c,
                             struct rad_error *e) {
  double start = rad_seconds();
  enum rad_code code = refuse_unavailable(c, e);
  if (!code)
    code = rad_scene_build(&c->deck, &c->scene, &c->notes, e);
  if (!code)
    code = refuse_fields(c, e);
  c->scene.progress = progress;
  rad_progress_phase(progress, "visibility");
  if (!code)
    code = rad_visibility_build(&c->scene, &c->visibility, e);
  if (!code)
    code = rad_check_isolated(&c->scene, c->deck.path, &c->notes, e);
  c->seconds_scene += rad_seconds() - start;
  if (code)
    return code;
  choose_mode(c);
  if (c->is_adaptive)
    return rad_case_check_probes(c, e);
  start = rad_seconds();
  rad_progress_phase(progress, "mesh");
  if (!code) {
    plan(c);
    if (!may_compress(c) || c->plan.rest_bytes > c->plan.available)
      code = refuse_too_large(c, e);
  }
  if (!code && !(c->mesh = rad_calloc(1, sizeof *c->mesh)))
    code = rad_fail_memory(e, "the mesh", 0);
  if (!code)
    code = rad_mesh_build(&c->scene, &c->deck.method, c->mesh, e);
  if (code)
    return code;
  c->seconds_mesh = rad_seconds() - start;
  if (c->wants_bound)
    code = rad_picture_halved(c, &c->plan.halved, e);
  c->plan.rest_bytes += halved_bytes(c);
  code = code ? code : choose_matrix(c, e);
  return code ? code : rad_case_check_probes(c, e);
}

int rad_case_is_read(const struct rad_case *c) {
  return c->deck.output.file != NULL; /* it has a default */
}

/* rho and E at the collocation points. */
static enum rad_code set_data(struct rad_case *c, struct rad_error *e) {
  const struct rad_mesh *m = c->mesh;
  size_t n = (size_t)m->n_point, total = n * (size_t)c->scene.n_band;
  c->rho = rad_alloc(total, sizeof(double));
  c->emission = rad_alloc(total, sizeof(double));
  c->u = rad_calloc(total, sizeof(double));
  c->h = rad_calloc(total, sizeof(double));
  if (!c->rho || !c->emission || !c->u || !c->h)
    return rad_fail_memory(e, "the solution", 32.0 * (double)total);
  rad_mesh_data(c->mesh, c->rho, c->emission);
  return RAD_OK;
}

/* Take the last level of an adaptive run over. */
static void adopt(struct rad_case *c) {
  struct rad_adaptive *a = &c->adaptive;
  c->mesh = a->mesh;
  c->rules = a->rules;
  c->dense = a->dense;
  c->h2 = a->h2;
  c->rho = a->rho;
  c->emission = a->emission;
  c->u = a->u;
  c->h = a->h;
  c->means = a->means;
  c->report = a->report;
  c->report.converged = a->mesh && !a->reason[0];
  c->seconds_assemble = a->seconds_assemble;
  c->seconds_estimate = a->seconds_estimate;
  c->seconds_levels = a->seconds_before;
  a->mesh = NULL;
  a->rules = (struct rad_rules){0};
  a->dense = (struct rad_dense){0};
  a->h2 = (struct rad_h2){0};
  a->rho = a->emission = a->u = a->h = NULL;
  a->means = (struct rad_means){0};
}

static struct rad_goal goal_of(const struct rad_case *c) {
  const struct rad_deck_method *m = &c->deck.method;
  return (struct rad_goal){
      .tolerance = c->tolerance,
      .solver = m->solver,
      .matrix = m->matrix,
      .solver_tolerance = m->given & RAD_GIVEN_SOLVER_TOLERANCE ? m->solver_tolerance : 0,
      .quadrature_tolerance =
          m->given & RAD_GIVEN_QUADRATURE_TOLERANCE ? m->quadrature_tolerance : 0,
      .memory = c->memory_limit > 0 ? fmin(c->memory_limit, rad_memory_available())
                                    : rad_memory_available()};
}

/* The bound of a solution on a mesh made by hand; the estimator has it on loan. */
static enum rad_code estimate_by_hand(struct rad_case *c, struct rad_error *e) {
  struct rad_goal goal = goal_of(c);
  rad_progress_phase(c->scene.progress, "estimate");
  double assemble = c->seconds_assemble;
  c->adaptive = (struct rad_adaptive){.mesh = c->mesh,
                                      .rules = c->rules,
                                      .dense = c->dense,
                                      .h2 = c->h2,
                                      .rho = c->rho,
                                      .emission = c->emission,
                                      .u = c->u,
                                      .h = c->h,
                                      .report = c->report};
  enum rad_code code = rad_adapt_estimate(&c->scene, &goal, &c->adaptive, e);
  adopt(c);
  c->seconds_assemble = assemble;
  c->has_bound = !code;
  return code;
}

static enum rad_code solve_adaptive(struct rad_case *c, struct rad_error *e) {
  struct rad_goal goal = goal_of(c);
  struct rad_stage from;
  enum rad_code code = rad_case_stage(c, &from, e);
  goal.from = from.leaf ? &from : NULL;
  if (!code)
    code = rad_adapt(&c->scene, &goal, &c->adaptive, e);
  rad_stage_free(&from);
  adopt(c);
  c->has_bound = !code;
  if (c->mesh) {
    c->plan.unknowns = c->mesh->n_point;
    c->plan.system = rad_plan_dense(c->report.solver, c->plan.unknowns, c->scene.n_band);
    if (c->h2.mesh) {
      c->plan.system.matrix = RAD_MATRIX_HIERARCHICAL;
      c->plan.system.matrix_bytes = c->h2.bytes;
    }
  }
  return code;
}

enum rad_code rad_case_begin_matrix(struct rad_case *c, struct rad_error *e) {
  enum rad_code code = rad_rules_build(c->mesh, c->deck.method.quadrature_tolerance, &c->rules, e);
  if (code)
    return code;
  return c->plan.system.matrix == RAD_MATRIX_DENSE
             ? rad_dense_begin(c->mesh, NULL, &c->dense, e)
             : rad_h2_begin(c->mesh, c->compression, &c->h2, e);
}

/* The matrix that the plan chose, from files as far as it is there. */
static enum rad_code assemble(struct rad_case *c, struct rad_operator *k, struct rad_error *e) {
  enum rad_code code = rad_case_begin_matrix(c, e);
  if (!code && (c->restart || c->n_part))
    code = rad_case_restore(c, e);
  if (c->plan.system.matrix == RAD_MATRIX_DENSE) {
    *k = rad_operator_dense(&c->dense);
    return code ? code : rad_dense_finish(&c->rules, NULL, &c->dense, e);
  }
  if (!code)
    code = rad_h2_finish(&c->h2, &c->rules, e);
  if (!code)
    code = rad_h2_check(&c->h2, &c->rules, e);
  c->plan.system.matrix_bytes = c->h2.bytes;
  *k = rad_operator_h2(&c->h2);
  return code;
}

/* Without an estimate means are integrated to this part of the largest radiosity. */
#define PLAIN_MEANS 1e-4

/* The solution on a mesh made by hand. */
static enum rad_code solve_by_hand(struct rad_case *c, struct rad_error *e) {
  const struct rad_deck_method *m = &c->deck.method;
  struct rad_operator k;
  double start = rad_seconds();
  enum rad_code code = set_data(c, e);
  rad_progress_phase(c->scene.progress, "matrix");
  if (!code)
    code = assemble(c, &k, e);
  if (code)
    return code;
  c->seconds_assemble = rad_seconds() - start;
  rad_progress_phase(c->scene.progress, "solve");
  struct rad_solve_options o = {m->solver, m->solver_tolerance, m->bounces, c->rules.tolerance,
                                &c->iterate};
  return rad_solve(&k, &o, c->scene.n_band, c->rho, c->emission, c->u, c->h, &c->report, e);
}

static enum rad_code solve_and_estimate(struct rad_case *c, struct rad_error *e) {
  if (c->is_adaptive)
    return solve_adaptive(c, e);
  enum rad_code code = solve_by_hand(c, e);
  if (code)
    return code;
  if (c->wants_bound)
    return estimate_by_hand(c, e);
  rad_progress_phase(c->scene.progress, "means");
  return rad_means_plain(c->mesh, c->u, c->deck.tolerance > 0 ? c->deck.tolerance : PLAIN_MEANS,
                         &c->means, e);
}

enum rad_code rad_case_solve(struct rad_case *c, struct rad_error *e) {
  enum rad_code code = solve_and_estimate(c, e);
  return code ? code : rad_balance_make(&c->scene, &c->means, &c->balance, e);
}

void rad_case_warn(const struct rad_case *c, struct rad_notes *notes) {
  double amplified = c->report.inverse_norm * c->rules.tolerance;
  double most = c->report.kappa < 1 ? 1 / (1 - c->report.kappa) : INFINITY;
  if (c->deck.method.nodes.kind != RAD_NODES_GAUSS)
    rad_notes_add(notes,
                  "collocation at other nodes than Gauss points can be unstable, which the "
                  "residual does not show; use method.nodes: gauss for results");
  if (c->report.inverse_norm > UNSTABLE * most)
    rad_notes_add(notes,
                  "the discrete inverse is too large (|inverse| %.3g, at most 1/(1 - kappa) = %.3g "
                  "for the equation): the method is unstable on this mesh and its values mean "
                  "nothing",
                  c->report.inverse_norm, most);
  if (amplified > 1e-4 && !c->has_bound) /* a bound has it in */
    rad_notes_add(notes,
                  "the scene loses so little light (|inverse| %.2g) that the quadrature tolerance "
                  "%.1g may change the radiosity by %.1g of itself; lower "
                  "method.quadrature_tolerance",
                  c->report.inverse_norm, c->rules.tolerance, amplified);
}

void rad_case_free(struct rad_case *c) {
  rad_adaptive_free(&c->adaptive);
  rad_dense_free(&c->dense);
  rad_h2_free(&c->h2);
  rad_iterate_free(&c->iterate);
  rad_means_free(&c->means);
  rad_rules_free(&c->rules);
  if (c->mesh)
    rad_mesh_free(c->mesh);
  free(c->mesh);
  rad_visibility_free(&c->visibility);
  rad_scene_free(&c->scene);
  rad_notes_free(&c->notes);
  rad_deck_free(&c->deck);
  free(c->rho);
  free(c->emission);
  free(c->u);
  free(c->h);
  *c = (struct rad_case){0};
}
