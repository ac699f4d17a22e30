#include "factors/pairs.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/scramble.h"
#include "base/stop.h"
#include "factors/cells.h"
#include "factors/exchange.h"
#include "factors/pair.h"

#define PARTLY 0.95 /* of the tolerance: for partly visible pairs */
#define WHOLLY 0.02 /* of the tolerance: goal of exchange for the others, over A A / (pi D^2) */
#define ROUGH 1e-2  /* goal of an estimate */
#define SAMPLE 0.01 /* share of pairs that are integrated from both sides */
#define LEAST_SAMPLE 200

/* What the shares of the tolerance follow from. */
struct shares {
  double *area, *sum; /* [n_surface] of the surface; of its partly visible pairs, unobstructed */
  double *count;      /* [n_surface] partly visible pairs */
};

static unsigned char sight_of(const struct rad_pairs *p, int i, int64_t k) {
  return p->g->visibility->sight[(size_t)i * (size_t)p->n + (size_t)p->other[k]];
}

static enum rad_code list_pairs(struct rad_pairs *p, struct rad_error *e) {
  const unsigned char *sight = p->g->visibility->sight;
  size_t n = (size_t)p->n;
  int64_t count = 0;
  p->first = rad_calloc(n + 1, sizeof *p->first);
  if (!p->first)
    return rad_fail_memory(e, "the view factors", 8.0 * (double)n);
  for (size_t i = 0; i < n; i++) {
    for (size_t j = i + 1; j < n; j++)
      count += sight[i * n + j] != RAD_HIDDEN;
    p->first[i + 1] = count;
  }
  p->other = rad_alloc((size_t)count, sizeof *p->other);
  p->value = rad_calloc((size_t)count, sizeof *p->value);
  p->error = rad_calloc((size_t)count, sizeof *p->error);
  p->from_other = rad_alloc((size_t)count, sizeof *p->from_other);
  if (!p->other || !p->value || !p->error || !p->from_other)
    return rad_fail_memory(e, "the view factors", 28.0 * (double)count);
  count = 0;
  for (size_t i = 0; i < n; i++)
    for (size_t j = i + 1; j < n; j++)
      if (sight[i * n + j] != RAD_HIDDEN) {
        p->from_other[count] = NAN;
        p->other[count++] = (int)j;
        p->n_partly += sight[i * n + j] == RAD_PARTLY;
      }
  return RAD_OK;
}

/* Unobstructed, both triangles cut at each other's plane. */
static double unobstructed(struct rad_pair *pair, double goal, double *error) {
  static const double whole[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  struct rad_polygon part;
  struct rad_flat f;
  rad_pair_front(pair, whole, &part);
  f.n = part.n;
  memcpy(f.normal, pair->s->normal, sizeof f.normal);
  for (int c = 0; c < part.n; c++) {
    const double lambda[3] = {1 - part.corner[c][0] - part.corner[c][1], part.corner[c][0],
                              part.corner[c][1]};
    rad_at_lambda(pair->s->v, lambda, f.corner[c]);
  }
  rad_flat_orient(&f);
  return rad_exchange(&pair->g->gauss, &f, &pair->face, goal, error);
}

/* One thread's tools. */
struct worker {
  struct rad_pair pair;
  struct rad_cell_scratch *scratch;
};

/* Values of wholly visible pairs of row i, estimates of the others. */
static void wholly_visible(struct rad_pairs *p, struct worker *w, int i, double goal) {
  for (int64_t k = p->first[i]; k < p->first[i + 1] && !rad_stop_asked(); k++) {
    int partly = sight_of(p, i, k) == RAD_PARTLY;
    int seen = rad_pair_set_unobstructed(p->g, i, p->other[k], &w->pair);
    if (seen > 0)
      p->value[k] = unobstructed(&w->pair, partly ? ROUGH : goal, &p->error[k]);
  }
}

static void add_shares(const struct rad_pairs *p, struct shares *s) {
  const struct rad_triangle *t = p->g->scene->triangle;
  for (int i = 0; i < p->n; i++) {
    s->area[t[i].surface] += t[i].area;
    for (int64_t k = p->first[i]; k < p->first[i + 1]; k++) {
      int a = t[i].surface, b = t[p->other[k]].surface;
      if (sight_of(p, i, k) != RAD_PARTLY)
        continue;
      s->sum[a] += p->value[k] + p->error[k];
      s->count[a]++;
      if (a != b) {
        s->sum[b] += p->value[k] + p->error[k];
        s->count[b]++;
      }
    }
  }
}

/* Half of a row's tolerance by what is unobstructed, half evenly; a pair within a surface is in its
 * row twice. */
static double share_of(const struct rad_pairs *p, const struct shares *s, int i, int64_t k,
                       double tolerance) {
  const struct rad_triangle *t = p->g->scene->triangle;
  int surface[2] = {t[i].surface, t[p->other[k]].surface};
  double least = INFINITY, own = p->value[k] + p->error[k];
  for (int m = 0; m < 2; m++) {
    int a = surface[m];
    double share = 0.5 * (s->sum[a] > 0 ? own / s->sum[a] : 1) + 0.5 / s->count[a];
    least = fmin(least, PARTLY * tolerance * s->area[a] * share);
  }
  return surface[0] == surface[1] ? 0.5 * least : least;
}

/* The smaller triangle is the outer one: from there the other changes less. */
static int outer_of(const struct rad_pairs *p, int i, int j) {
  const struct rad_triangle *t = p->g->scene->triangle;
  return t[j].area < t[i].area ? j : i;
}

static int is_sampled(const struct rad_pairs *p, int64_t k, int partly) {
  double share = fmax(SAMPLE, partly ? LEAST_SAMPLE / (double)p->n_partly : 0);
  return partly && rad_scramble_unit((uint64_t)k) < share;
}

/* Partly visible pairs of row i. */
static enum rad_code partly_visible(struct rad_pairs *p, struct worker *w, const struct shares *s,
                                    int i, const double goal[2], struct rad_error *e) {
  int64_t points = 0, n_limited = 0;
  enum rad_code code = RAD_OK;
  for (int64_t k = p->first[i]; k < p->first[i + 1] && !code; k++) {
    int j = p->other[k], outer = outer_of(p, i, j);
    if (sight_of(p, i, k) != RAD_PARTLY)
      continue;
    double tolerance = share_of(p, s, i, k, goal[0]), error;
    struct rad_cell_task task = {.source = outer,
                                 .target = i + j - outer,
                                 .corner = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                 .n_weight = 1,
                                 .tolerance = &tolerance,
                                 .limit = (int64_t)goal[1]};
    code = rad_cell_integrate(p->g, w->scratch, &task, &p->value[k], &p->error[k], e);
    points += rad_cell_points(w->scratch);
    n_limited += p->error[k] > tolerance;
    if (code || !is_sampled(p, k, 1))
      continue;
    task.source = i + j - outer;
    task.target = outer;
    code = rad_cell_integrate(p->g, w->scratch, &task, &p->from_other[k], &error, e);
    points += rad_cell_points(w->scratch);
    double scale = fmin(p->g->scene->triangle[i].area, p->g->scene->triangle[j].area);
    if (!code && !(fabs(p->from_other[k] - p->value[k]) <= error + p->error[k] + 1e-13 * scale))
      code =
          rad_fail(e, RAD_ENUMERIC,
                   "an error of the program: triangles %d and %d exchange %.9g +- %.1e m2 seen "
                   "from the first and %.9g +- %.1e m2 from the second; please report the scene",
                   outer + 1, i + j - outer + 1, p->value[k], p->error[k], p->from_other[k], error);
  }
#pragma omp atomic
  p->points += points;
#pragma omp atomic
  p->n_limited += n_limited;
  return code;
}

/* All rows, first what is wholly visible (shares is NULL), then the rest. */
static enum rad_code all_rows(struct rad_pairs *p, const struct shares *shares,
                              const double goal[2], struct rad_error *e) {
  enum rad_code code = RAD_OK;
  int n = p->n;
  struct rad_progress *progress = p->g->scene->progress;
  rad_progress_begin(progress, shares ? "rows of partly visible pairs" : "rows", n);
#pragma omp parallel default(none) shared(p, shares, goal, e, code, n, progress)
  {
    struct worker w = {.scratch = rad_cell_scratch_new()};
    struct rad_error own;
    enum rad_code mine = w.scratch ? RAD_OK : rad_fail_memory(&own, "the view factors", 1e6);
#pragma omp for schedule(dynamic)
    for (int i = 0; i < n; i++) {
      if (!mine && !shares)
        wholly_visible(p, &w, i, goal[0]);
      else if (!mine)
        mine = partly_visible(p, &w, shares, i, goal, &own);
      rad_progress_add(progress, 1);
    }
    if (mine) {
#pragma omp critical(rad_pairs)
      if (!code) {
        code = mine;
        *e = own;
      }
    }
    rad_pair_free(&w.pair);
    rad_cell_scratch_free(w.scratch);
  }
  return !code && rad_stop_asked() ? rad_fail_stopped(e) : code;
}

enum rad_code rad_pairs_integrate(const struct rad_pair_engine *g, double tolerance, int64_t limit,
                                  struct rad_pairs *p, struct rad_error *e) {
  *p = (struct rad_pairs){.g = g, .n = g->scene->n_triangle};
  size_t n = (size_t)g->scene->n_surface;
  struct shares s = {rad_calloc(n, 8), rad_calloc(n, 8), rad_calloc(n, 8)};
  enum rad_code code = list_pairs(p, e);
  if (!code && (!s.area || !s.sum || !s.count))
    code = rad_fail_memory(e, "the view factors", 24.0 * (double)n);
  const double goal[2] = {WHOLLY * tolerance, 0};
  const double goals[2] = {tolerance,
                           fmax(1e4, fmin(5e5, (double)limit / (double)(p->n_partly + 1)))};
  if (!code)
    code = all_rows(p, NULL, goal, e);
  if (!code && p->n_partly) {
    add_shares(p, &s);
    code = all_rows(p, &s, goals, e);
  }
  free(s.area);
  free(s.sum);
  free(s.count);
  return code;
}

void rad_pairs_free(struct rad_pairs *p) {
  free(p->first);
  free(p->other);
  free(p->value);
  free(p->error);
  free(p->from_other);
  *p = (struct rad_pairs){0};
}
