/* The C library of include/polyrad.h: the program's steps behind a handle. */
#include "app/library.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/provenance.h"

/* ---- errors and threads --------------------------------------------------------------------- */

/* Sentences of the program start with the file, which a scene of arrays has not. */
static const char *without_file(const char *text) {
  static const char *const head[] = {"scene: error: ", "scene: warning: ", "error: "};
  for (int i = 0; i < 3; i++)
    if (!strncmp(text, head[i], strlen(head[i])))
      return text + strlen(head[i]);
  return text;
}

const char *polyrad_error_text(const polyrad *p) {
  return p ? without_file(p->error.text)
           : "the polyrad handle is NULL; make one with polyrad_create, which gives NULL only "
             "for NULL arguments or without memory";
}

int rad_library_enter(polyrad *p) {
  int before = omp_get_max_threads();
  p->error = (struct rad_error){0};
  p->bad_triangle = -1;
  if (p->threads)
    omp_set_num_threads(p->threads);
  return before;
}

polyrad_status rad_library_leave(polyrad *p, int threads_before, enum rad_code code) {
  omp_set_num_threads(threads_before);
  return (polyrad_status)rad_library_judge(p, code);
}

enum rad_code rad_library_fail_null(polyrad *p, const char *what) {
  return rad_fail(&p->error, RAD_EINPUT, "%s is NULL; give an array", what);
}

enum rad_code rad_library_refuse_unsolved(polyrad *p) {
  if (p->solved)
    return RAD_OK;
  return rad_fail(&p->error, RAD_EINPUT, "there is no solution yet; call polyrad_solve first");
}

/* ---- making and solving --------------------------------------------------------------------- */

polyrad_status polyrad_create(const struct polyrad_scene *scene, polyrad **p) {
  if (!p)
    return POLYRAD_INPUT;
  if (!(*p = rad_calloc(1, sizeof **p)))
    return POLYRAD_SYSTEM;
  int before = rad_library_enter(*p);
  enum rad_code code = scene ? rad_library_scene(scene, *p) : rad_library_fail_null(*p, "scene");
  return rad_library_leave(*p, before, code);
}

const char *polyrad_warning(const polyrad *p, int i) {
  return p && i >= 0 && i < p->run.notes.n ? without_file(p->run.notes.text[i]) : NULL;
}

static enum rad_code check_options(polyrad *p, const struct polyrad_options *o) {
  if (!(o->tolerance == 0 || (o->tolerance >= 1e-12 && o->tolerance < 1)))
    return rad_fail(&p->error, RAD_EINPUT, "tolerance is %g; give a number from 1e-12 to 1, or 0",
                    o->tolerance);
  if (!(o->memory_limit >= 0))
    return rad_fail(&p->error, RAD_EINPUT, "memory_limit is %g; give bytes, or 0 for no limit",
                    o->memory_limit);
  if (o->threads < 0 || o->threads > 4096)
    return rad_fail(&p->error, RAD_EINPUT, "threads is %d; give 1 to 4096, or 0", o->threads);
  return RAD_OK;
}

/* Drop the solution, keep scene and visibility. */
static void forget(polyrad *p) {
  struct rad_case kept = {
      .scene = p->run.scene, .visibility = p->run.visibility, .notes = p->run.notes};
  p->run.scene = (struct rad_scene){0};
  p->run.visibility = (struct rad_visibility){0};
  p->run.notes = (struct rad_notes){0};
  rad_case_free(&p->run);
  p->run = kept;
  p->solved = 0;
}

static enum rad_code solve(polyrad *p, const struct polyrad_options *o) {
  struct rad_case *c = &p->run;
  forget(p);
  c->is_adaptive = 1;
  c->tolerance = o->tolerance > 0 ? o->tolerance : 1e-3;
  c->memory_limit = o->memory_limit;
  enum rad_code code = rad_library_judge(p, rad_case_solve(c, &p->error));
  p->solved = !code;
  if (code) {
    forget(p); /* what a failed run leaves behind is of no use */
  } else if (c->adaptive.reason[0]) {
    code = rad_fail(&p->error, RAD_ENUMERIC,
                    "the tolerance %.3g was not reached, the bound is %.2e: %s", c->tolerance,
                    c->adaptive.bound, c->adaptive.reason);
  }
  return code;
}

polyrad_status polyrad_solve(polyrad *p, const struct polyrad_options *options) {
  static const struct polyrad_options defaults = {0};
  const struct polyrad_options *o = options ? options : &defaults;
  if (!p)
    return POLYRAD_INPUT;
  int before = rad_library_enter(p);
  enum rad_code code = check_options(p, o);
  if (!code && !p->run.scene.visibility)
    code = rad_fail(&p->error, RAD_EINPUT, "there is no scene: polyrad_create has failed");
  if (!code) {
    p->threads = o->threads;
    omp_set_num_threads(o->threads ? o->threads : before);
    code = solve(p, o);
  }
  return rad_library_leave(p, before, code);
}

polyrad_status polyrad_get_summary(polyrad *p, struct polyrad_summary *summary) {
  if (!p)
    return POLYRAD_INPUT;
  int before = rad_library_enter(p);
  enum rad_code code =
      summary ? rad_library_refuse_unsolved(p) : rad_library_fail_null(p, "summary");
  if (!code) {
    const struct rad_adaptive *a = &p->run.adaptive;
    double most = rad_indicator_scale(&a->indicator, p->run.scene.n_band);
    *summary = (struct polyrad_summary){.unknowns = p->run.mesh->n_point,
                                        .elements = p->run.mesh->n_element,
                                        .levels = a->levels,
                                        .error_bound = a->bound * most,
                                        .error_bound_limit = a->bound_limit * most,
                                        .relative_bound = a->bound,
                                        .residual = p->run.report.residual,
                                        .converged = p->run.report.converged};
  }
  return rad_library_leave(p, before, code);
}

/* ---- the end -------------------------------------------------------------------------------- */

void polyrad_free(polyrad *p) {
  if (!p)
    return;
  rad_case_free(&p->run);
  for (int i = 0; p->name && i < p->n_surface; i++)
    free(p->name[i]);
  free(p->name);
  free(p->caller);
  free(p);
}

const char *polyrad_version(void) {
  struct rad_provenance p;
  rad_provenance_get(&p);
  return p.version;
}
