/* polyrad check: a deck is looked at, its sizes, memory and time told; nothing is solved. */
#include "app/case.h"
#include "app/command.h"
#include "app/summary.h"
#include "base/memory.h"

static void print_exponent(FILE *out, double x, double tolerance) {
  if (x < 1)
    fprintf(out, " %8.6f p=%d", x, rad_layout_grading(x, tolerance));
  else
    fprintf(out, " %12s", "-");
}

/* Exponents and gradings, for scenes that a person can read. */
static void print_exponents(const struct rad_case *c, const struct rad_layout *l, FILE *out) {
  enum { READABLE = 24 };
  int n = c->scene.n_triangle < READABLE ? c->scene.n_triangle : READABLE;
  fprintf(out, "  exponents of triangles: edges v0v1, v1v2, v2v0; vertices v0, v1, v2\n");
  for (int t = 0; t < n; t++) {
    fprintf(out, "  %4d %-12.12s", t + 1, c->scene.surface_name[c->scene.triangle[t].surface]);
    for (int i = 0; i < 3; i++)
      print_exponent(out, l->exponents.beta[t][i], c->tolerance);
    fprintf(out, "  |");
    for (int i = 0; i < 3; i++)
      print_exponent(out, l->exponents.alpha[t][i], c->tolerance);
    fprintf(out, "\n");
  }
  if (n < c->scene.n_triangle)
    fprintf(out, "  and %d more triangles\n", c->scene.n_triangle - n);
}

/* polyrad check of an adaptive run: its start; where it ends, only solving can tell. */
static enum rad_code check_adaptive(const struct rad_case *c, FILE *out, struct rad_error *e) {
  struct rad_layout l = {0};
  rad_progress_phase(c->scene.progress, "exponents");
  enum rad_code code = rad_layout_begin(&c->scene, c->visibility.sight, c->tolerance, &l, e);
  rad_progress_clear(c->scene.progress);
  if (!code) {
    double unknowns = rad_layout_unknowns(&l);
    fprintf(out, "  mesh     adaptive, starts with %d elements, %.0f unknowns, %.4g MB\n", l.n_leaf,
            unknowns, 8e-6 * unknowns * unknowns);
    fprintf(out, "  memory   %.4g MB available\n", rad_memory_available() / 1e6);
    rad_print_passive(&l, out);
    print_exponents(c, &l, out);
  }
  rad_layout_free(&l);
  return code;
}

enum rad_code rad_app_check(const struct rad_command *command, struct rad_error *e) {
  struct rad_case c;
  struct rad_progress line, *progress = command->quiet ? NULL : &line;
  rad_progress_init(&line, command->log);
  enum rad_code code =
      rad_case_prepare(command->deck, command->n_set, command->set, progress, &c, e);
  rad_progress_clear(progress);
  rad_print_notes(&c, command->log);
  if (!code && c.is_adaptive) {
    rad_print_head(&c, command->out);
    code = check_adaptive(&c, command->out, e);
    rad_case_free(&c);
    return code;
  }
  rad_progress_phase(progress, "prediction");
  if (!code)
    code = rad_case_predict(&c, e);
  rad_progress_clear(progress);
  if (!code) {
    const struct rad_plan *p = &c.plan;
    rad_print_head(&c, command->out);
    fprintf(command->out, "  matrix   %.4g MB, %s; the run holds %.4g MB of %.4g MB available\n",
            p->system.matrix_bytes / 1e6,
            p->system.matrix == RAD_MATRIX_DENSE ? "dense" : "hierarchical",
            (p->base_bytes + p->bytes) / 1e6, (p->base_bytes + p->available) / 1e6);
    fprintf(command->out, "  solver   %s\n", rad_solver_name(p->system.solver));
    fprintf(command->out,
            "  skipped  %.1f %% of %.4g point-element pairs: coplanar or facing away\n",
            100 * p->skipped / p->pairs, p->pairs);
    fprintf(command->out, "  time     about %.2g s\n", p->seconds);
  }
  rad_case_free(&c);
  return code;
}
