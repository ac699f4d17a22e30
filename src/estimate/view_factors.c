#include "estimate/view_factors.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "estimate/view_cubature.h"

/* Share of the tolerance that the integrator may take, and that the cubature aims at. */
#define QUADRATURE 0.05
#define CUBATURE 0.8

/* Reciprocity errors over the goals of the two factors that the integrator explains. */
#define EXPLAINED 1.25

/* A higher rule is worth it if the last one gained at least this; a new cell always tries one.
 * Fewest points for the closed forms of tests/cases/test_view_factors.c, and about that at kinks.
 */
#define GAIN 0.25

enum { MAX_DEPTH = 40 }; /* corners stay exact */

/* The order in which the cells of a surface are refined. */
struct rank {
  int surface, leaf;
  double weight; /* largest change that counts */
};

struct work {
  struct rad_view_cubature c;
  double goal;  /* of the sums of changes; not below what rounding allows */
  double *rest; /* owned [n_surface, n_column] sums of changes of cells that are not refined */
  struct rank *rank;
  int *list; /* owned: cells to work on */
  int n_list, room;
};

static int compare_rank(const void *a, const void *b) {
  const struct rank *x = a, *y = b;
  if (x->surface != y->surface)
    return x->surface < y->surface ? -1 : 1;
  if (x->weight != y->weight)
    return x->weight > y->weight ? -1 : 1;
  return (x->leaf > y->leaf) - (x->leaf < y->leaf);
}

/* Room in the lists for all cells, each split. */
static enum rad_code reserve(struct work *w, struct rad_error *e) {
  int n = RAD_CELL_CHILDREN * w->c.n;
  if (n <= w->room)
    return RAD_OK;
  free(w->rank);
  int *list = realloc(w->list, sizeof *list * 2 * (size_t)n);
  w->list = list ? list : w->list;
  w->rank = rad_alloc(2 * (size_t)n, sizeof *w->rank);
  w->room = list && w->rank ? 2 * n : 0;
  return w->room ? RAD_OK : rad_fail_memory(e, "the view factors", 64.0 * n);
}

/* Largest sum of changes. */
static double worst(const struct work *w) {
  double most = 0;
  for (int i = 0; i < w->c.scene->n_surface * w->c.n_column; i++)
    most = fmax(most, w->rest[i]);
  return most;
}

/* Cells to refine: in each surface the fewest without which no sum of changes exceeds half of the
 * goal where it exceeds the goal now. */
static void select_cells(struct work *w) {
  const struct rad_view_cubature *c = &w->c;
  int nc = c->n_column;
  for (int i = 0; i < c->scene->n_surface * nc; i++)
    w->rest[i] = w->rest[i] > w->goal ? w->rest[i] : 0;
  for (int i = 0; i < c->n; i++) {
    const double *rest = w->rest + (size_t)c->leaf[i].surface * nc;
    const double *change = c->change + (size_t)i * nc;
    w->rank[i] = (struct rank){c->leaf[i].surface, i, 0};
    for (int t = 0; t < nc && c->leaf[i].cell.depth < MAX_DEPTH; t++)
      if (rest[t] > 0)
        w->rank[i].weight = fmax(w->rank[i].weight, change[t]);
  }
  qsort(w->rank, (size_t)c->n, sizeof *w->rank, compare_rank);
  w->n_list = 0;
  for (int i = 0; i < c->n; i++) {
    double *rest = w->rest + (size_t)w->rank[i].surface * nc, most = 0;
    for (int t = 0; t < nc; t++)
      most = fmax(most, rest[t]);
    if (most <= 0.5 * w->goal || w->rank[i].weight == 0)
      continue;
    const double *change = c->change + (size_t)w->rank[i].leaf * nc;
    for (int t = 0; t < nc; t++)
      rest[t] -= change[t];
    w->list[w->n_list++] = w->rank[i].leaf;
  }
}

/* A higher rule pays where the integrand is smooth. */
static int takes_rule(const struct rad_view_leaf *l) {
  return l->level + 1 < RAD_VIEW_LEVELS && l->change <= GAIN * l->before;
}

/* Split the listed cells that do not take a higher rule, or all; the list then holds what is to be
 * evaluated. */
static enum rad_code divide(struct work *w, int all, struct rad_error *e) {
  int n = w->n_list;
  enum rad_code code = RAD_OK;
  for (int i = 0; i < n && !code; i++) {
    int child[RAD_CELL_CHILDREN], n_child;
    if (!all && takes_rule(&w->c.leaf[w->list[i]]))
      continue;
    code = rad_view_cubature_split(&w->c, w->list[i], child, &n_child, e);
    for (int k = 1; k < n_child && !code; k++)
      w->list[w->n_list++] = child[k];
  }
  return code;
}

/* Points of the next step, if all were split. */
static double step_points(const struct work *w, int all) {
  double n = 0;
  struct rad_view_leaf fresh = {.level = 0};
  for (int i = 0; i < w->n_list; i++) {
    const struct rad_view_leaf *l = &w->c.leaf[w->list[i]];
    n += !all && takes_rule(l) ? rad_view_step_points(l)
                               : RAD_CELL_CHILDREN * rad_view_step_points(&fresh);
  }
  return n;
}

/* |A_s F_st - A_t F_ts| from the sums of values. */
static double defect(const struct rad_view_cubature *c, const double *f, int s, int t) {
  return fabs(c->area[s] * f[(size_t)s * c->n_column + t] -
              c->area[t] * f[(size_t)t * c->n_column + s]);
}

/* All cells of surfaces whose reciprocity the estimates do not explain: a shadow that no point of
 * one of the two has met. */
static void select_suspects(struct work *w, const double *f, unsigned char *suspect) {
  const struct rad_view_cubature *c = &w->c;
  int ns = c->scene->n_surface;
  memset(suspect, 0, (size_t)ns);
  for (int s = 0; s < ns; s++)
    for (int t = 0; t < s; t++)
      if (defect(c, f, s, t) > EXPLAINED * w->goal * (c->area[s] + c->area[t]))
        suspect[s] = suspect[t] = 1;
  w->n_list = 0;
  for (int i = 0; i < c->n; i++)
    if (suspect[c->leaf[i].surface] && c->leaf[i].cell.depth < MAX_DEPTH)
      w->list[w->n_list++] = i;
}

/* Refine until the estimates and reciprocity are met, or a limit is. Leaves the sums of changes in
 * w->rest, those of the values in value. */
static enum rad_code refine(struct work *w, double limit, double *value, unsigned char *suspect,
                            struct rad_view_factors *f, struct rad_error *e) {
  struct rad_view_cubature *c = &w->c;
  enum rad_code code = reserve(w, e);
  for (w->n_list = 0; w->n_list < c->n && !code; w->n_list++)
    w->list[w->n_list] = w->n_list;
  while (!code && !(code = rad_view_cubature_step(c, w->n_list, w->list, e)) &&
         !(code = reserve(w, e))) {
    rad_view_cubature_sum(c, c->change, w->rest);
    double error = worst(w);
    int met = error <= w->goal;
    if (met) {
      rad_view_cubature_sum(c, c->value, value);
      select_suspects(w, value, suspect);
      if (w->n_list == 0)
        break;
    } else {
      select_cells(w);
    }
    const char *bound = w->n_list == 0                                    ? "depth of cells"
                        : (double)c->points + step_points(w, met) > limit ? "number of points"
                        : c->n + RAD_CELL_CHILDREN * (double)w->n_list > c->max_cell ? "memory"
                                                                                     : NULL;
    if (bound) {
      snprintf(f->reason, sizeof f->reason, "the limit on the %s was met with %lld points%s", bound,
               (long long)c->points,
               met ? ", and reciprocity is worse than the error estimates" : "");
      rad_view_cubature_sum(c, c->change, w->rest);
      rad_view_cubature_sum(c, c->value, value);
      break;
    }
    code = divide(w, met, e);
  }
  return code;
}

static enum rad_code init(int n, struct rad_view_factors *f, struct rad_error *e) {
  size_t m = (size_t)n;
  f->n = n;
  f->matrix = rad_alloc(m * m, sizeof(double));
  f->error = rad_alloc(m * m, sizeof(double));
  f->reciprocity = rad_alloc(m * m, sizeof(double));
  f->row_sum = rad_alloc(m, sizeof(double));
  if (!f->matrix || !f->error || !f->reciprocity || !f->row_sum)
    return rad_fail_memory(e, "the view factors", 24.0 * (double)m * (double)m);
  return RAD_OK;
}

/* The matrices from the sums of all cells. */
static void finish(const struct work *w, const double *value, struct rad_view_factors *f) {
  const struct rad_view_cubature *c = &w->c;
  int n = f->n, nc = c->n_column;
  double quadrature = 2 * c->rules.tolerance;
  for (int s = 0; s < n; s++) {
    for (int t = 0; t < n; t++) {
      double worse = defect(c, value, s, t) / fmax(c->area[s], c->area[t]);
      f->matrix[(size_t)s * n + t] = value[(size_t)s * nc + t];
      f->error[(size_t)s * n + t] =
          w->rest[(size_t)s * nc + t] + quadrature * value[(size_t)s * nc + t];
      f->reciprocity[(size_t)s * n + t] = worse;
      f->worst_reciprocity = fmax(f->worst_reciprocity, worse);
    }
    f->row_sum[s] = value[(size_t)s * nc + n];
  }
  f->worst_error = worst(w) + quadrature;
  f->points = c->points;
  if (!f->reason[0] && f->worst_error > f->tolerance)
    snprintf(f->reason, sizeof f->reason, "rounding does not allow less");
  f->converged = !f->reason[0];
}

enum rad_code rad_view_factors(const struct rad_scene *scene, double tolerance, double limit,
                               struct rad_view_factors *f, struct rad_error *e) {
  double start = rad_seconds(), triangles = scene->n_triangle;
  struct work w = {0};
  *f = (struct rad_view_factors){.tolerance = tolerance};
  rad_progress_phase(scene->progress, "view factors");
  limit = limit > 0 ? limit : fmax(1e8 / triangles, 400 * triangles);
  enum rad_code code = init(scene->n_surface, f, e);
  if (!code)
    code = rad_view_cubature_begin(scene, QUADRATURE * tolerance, &w.c, e);
  double *value = rad_calloc((size_t)w.c.n_column * 2, sizeof(double) * (size_t)scene->n_surface);
  unsigned char *suspect = rad_alloc((size_t)scene->n_surface, 1);
  if (!code && (!value || !suspect))
    code = rad_fail_memory(e, "the view factors", 16.0 * w.c.n_column * scene->n_surface);
  if (!code) {
    w.rest = value + (size_t)w.c.n_column * (size_t)scene->n_surface;
    w.goal = fmax(CUBATURE * tolerance, 10 * w.c.rules.tolerance);
    code = refine(&w, limit, value, suspect, f, e);
  }
  if (!code)
    finish(&w, value, f);
  rad_view_cubature_free(&w.c);
  free(value);
  free(suspect);
  free(w.rank);
  free(w.list);
  f->seconds = rad_seconds() - start;
  return code;
}

void rad_view_factors_free(struct rad_view_factors *f) {
  free(f->matrix);
  free(f->error);
  free(f->reciprocity);
  free(f->row_sum);
  *f = (struct rad_view_factors){0};
}
