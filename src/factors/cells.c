#include "factors/cells.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/stop.h"
#include "factors/critical.h"
#include "factors/exchange.h"
#include "factors/pair.h"
#include "factors/proof.h"
#include "factors/skew.h"
#include "factors/triangle_rule.h"

#define ROUGH 1e-2        /* goal of an exchange that only bounds */
#define EXACT 1e-11       /* goal of one that is a value */
#define SAFETY 3.0        /* of the difference of two rules where F is analytic */
#define LUCK 0.05         /* rules that agree to less of the curvature do so by chance */
#define LUCK_AGAIN 0.01   /* the same of the error before */
#define GAIN 0.2          /* a higher rule is worth it if the last one gained this */
#define LIMIT 200000      /* points of a task */
#define LEAST_PIECE 1e-13 /* of a cell's area */
enum { RULE_LOW = 1, RULE_FIRST = 3, MOST_DEPTH = 40 };

/* What is to be done with a cell if its error is too large. */
enum state { DONE, SMOOTH, CUT, SPLIT };

struct cell {
  double corner[3][3]; /* barycentric */
  double skew;         /* what may hinge on three edges in a ray: in every error [m2] */
  int first, n;        /* blockers, in the scratch's list */
  int depth, rule;
  enum state state;
};

struct rad_cell_scratch {
  struct rad_pair pair;
  struct cell *cell;
  double *value, *error; /* [cells, n_weight] */
  int *heap, n_heap, n_cell;
  size_t cell_room, value_room, error_room, heap_room;
  int *list, n_list; /* of all cells, one after another */
  size_t list_room;
  int *mark, now; /* [occluders.n] */
  int failed;
  int64_t points;
  double total_value[RAD_MAX_WEIGHT], total_error[RAD_MAX_WEIGHT];
};

struct rad_cell_scratch *rad_cell_scratch_new(void) {
  return rad_calloc(1, sizeof(struct rad_cell_scratch));
}

void rad_cell_scratch_free(struct rad_cell_scratch *s) {
  if (!s)
    return;
  rad_pair_free(&s->pair);
  free(s->cell);
  free(s->value);
  free(s->error);
  free(s->heap);
  free(s->list);
  free(s->mark);
  free(s);
}

int64_t rad_cell_points(const struct rad_cell_scratch *s) {
  return s->points;
}

/* ---- the worst cell first ---- */

static double urgency(const struct rad_cell_scratch *s, const struct rad_cell_task *t, int cell) {
  double most = 0;
  for (int k = 0; k < t->n_weight; k++)
    most = fmax(most, s->error[(size_t)cell * t->n_weight + k] / t->tolerance[k]);
  return most;
}

/* Numbers break ties: the same order in every run. */
static int before(const struct rad_cell_scratch *s, const struct rad_cell_task *t, int a, int b) {
  double x = urgency(s, t, a), y = urgency(s, t, b);
  return x > y || (x == y && a < b);
}

static void push(struct rad_cell_scratch *s, const struct rad_cell_task *t, int cell) {
  if (!rad_reserve((void **)&s->heap, (size_t)s->n_heap + 1, &s->heap_room, sizeof *s->heap)) {
    s->failed = 1;
    return;
  }
  int at = s->n_heap++;
  for (; at > 0 && before(s, t, cell, s->heap[(at - 1) / 2]); at = (at - 1) / 2)
    s->heap[at] = s->heap[(at - 1) / 2];
  s->heap[at] = cell;
}

static int pop(struct rad_cell_scratch *s, const struct rad_cell_task *t) {
  int top = s->heap[0], last = s->heap[--s->n_heap], at = 0;
  for (;;) {
    int child = 2 * at + 1;
    if (child >= s->n_heap)
      break;
    if (child + 1 < s->n_heap && before(s, t, s->heap[child + 1], s->heap[child]))
      child++;
    if (!before(s, t, s->heap[child], last))
      break;
    s->heap[at] = s->heap[child];
    at = child;
  }
  s->heap[at] = last;
  return top;
}

/* ---- points ---- */

/* What a rule says of each weight. */
struct sums {
  double sum[RAD_MAX_WEIGHT], most[RAD_MAX_WEIGHT], curvature[RAD_MAX_WEIGHT];
};

/* How much w F differs between the centre and the rings of three points of the rule of seven, over
 * the cell: a rule that is exact for linear functions may be wrong by that. */
static double curvature(const double *at, int stride, double area) {
  double ring[2] = {0, 0};
  for (int q = 0; q < 6; q++)
    ring[q / 3] += at[(1 + q) * stride] / 3;
  return area * fmax(fabs(at[0] - ring[0]), fabs(at[0] - ring[1]));
}

/* sums [n_weight] of a rule: int w F dS; largest |w| into most; for the rule of seven points also
 * the curvature. */
static void apply_rule(struct rad_cell_scratch *s, const struct rad_cell_task *t,
                       const struct cell *c, int rule, double area, struct sums *r) {
  double lambda[RAD_TRIANGLE_POINTS][3], at[RAD_TRIANGLE_POINTS][3], weight[RAD_TRIANGLE_POINTS];
  double w[RAD_TRIANGLE_POINTS * RAD_MAX_WEIGHT];
  int n = rad_triangle_points[rule];
  rad_triangle_rule(&s->pair.g->gauss, rule, lambda, weight);
  for (int q = 0; q < n; q++)
    rad_at_lambda(c->corner, lambda[q], at[q]);
  if (t->weight)
    t->weight(t->context, n, (const double(*)[3])at, w);
  for (int k = 0; k < t->n_weight; k++)
    r->sum[k] = r->most[k] = 0;
  for (int q = 0; q < n; q++) {
    double f = rad_pair_seen(&s->pair, c->n, s->list + c->first, at[q]);
    s->failed |= f < 0;
    for (int k = 0; k < t->n_weight; k++) {
      double wk = t->weight ? w[q * t->n_weight + k] : 1;
      r->sum[k] += area * weight[q] * f * wk;
      r->most[k] = fmax(r->most[k], fabs(wk));
      w[q * t->n_weight + k] = f * wk;
    }
  }
  for (int k = 0; k < t->n_weight && rule == RULE_FIRST; k++)
    r->curvature[k] = curvature(w + k, t->n_weight, area);
  s->points += n;
}

/* ---- what is known of a cell ---- */

static void flatten(const struct rad_pair *p, const double corner[3][3], struct rad_flat *f) {
  f->n = 3;
  memcpy(f->normal, p->s->normal, sizeof f->normal);
  for (int c = 0; c < 3; c++)
    rad_at_lambda(p->s->v, corner[c], f->corner[c]);
  rad_flat_orient(f);
}

/* Blockers of the parent that reach into the cell's shaft. */
static void cull(struct rad_cell_scratch *s, const struct rad_flat *cell, int first, int n,
                 struct rad_shaft *shaft, struct cell *c) {
  const struct rad_occluders *o = &s->pair.g->visibility->occluders;
  c->first = s->n_list;
  c->n = 0;
  if (n == 0)
    return;
  if (!rad_reserve((void **)&s->list, (size_t)(s->n_list + n), &s->list_room, sizeof *s->list)) {
    s->failed = 1;
    return;
  }
  rad_shaft_make(cell, &s->pair.face, o->slack, shaft);
  s->now++;
  for (int i = 0; i < n; i++) {
    int number = s->list[first + i];
    const struct rad_occluder *k = &o->occluder[s->pair.blocker[number]];
    const double *corner[RAD_MAX_OCCLUDER_CORNER];
    for (int m = 0; m < k->n; m++)
      corner[m] = o->scene->vertex[o->corner[k->first + m]];
    if (rad_shaft_misses(shaft, k->n, corner))
      continue;
    s->list[c->first + c->n++] = number;
    s->mark[s->pair.blocker[number]] = s->now;
  }
  s->n_list += c->n;
}

/* A higher rule would not help where much of the error is what hinges on three edges. */
static void judge(const struct rad_cell_scratch *s, const struct rad_cell_task *t, struct cell *c,
                  const double *most, int at) {
  double hinge = 0;
  for (int k = 0; k < t->n_weight; k++)
    hinge = fmax(hinge, c->skew * most[k] / t->tolerance[k]);
  if (hinge > 0.5 * urgency(s, t, at))
    c->state = SPLIT;
}

/* Values by two rules, errors by their difference, or by the range if that says less or they mean
 * nothing. */
static void by_rules(struct rad_cell_scratch *s, const struct rad_cell_task *t, struct cell *c,
                     const struct rad_range *range, double area, int at) {
  struct sums low, high;
  double *value = s->value + (size_t)at * t->n_weight, *error = s->error + (size_t)at * t->n_weight;
  if (c->state == SMOOTH)
    apply_rule(s, t, c, RULE_LOW, area, &low);
  apply_rule(s, t, c, c->state == SMOOTH ? RULE_FIRST : RULE_LOW, area, &high);
  for (int k = 0; k < t->n_weight; k++) {
    double most = high.most[k];
    value[k] = t->weight ? high.sum[k] : fmin(fmax(high.sum[k], range->low), range->high);
    error[k] = t->weight ? most * range->high + fabs(value[k])
                         : fmax(range->high - value[k], value[k] - range->low);
    if (c->state != SMOOTH)
      continue;
    double told = fmax(fabs(high.sum[k] - low.sum[k]), LUCK * high.curvature[k]);
    error[k] = fmin(error[k], SAFETY * told + c->skew * most);
  }
  if (c->state == SMOOTH && c->skew > 0)
    judge(s, t, c, high.most, at);
}

static void set_exact(struct rad_cell_scratch *s, const struct rad_cell_task *t, int at,
                      double value, double error) {
  for (int k = 0; k < t->n_weight; k++) {
    s->value[(size_t)at * t->n_weight + k] = value;
    s->error[(size_t)at * t->n_weight + k] = error;
  }
}

/* A target without blockers: exact, or by rules that are told of by two of them. */
static void wholly_seen(struct rad_cell_scratch *s, const struct rad_cell_task *t,
                        const struct rad_flat *flat, struct cell *c, double area, int at) {
  struct rad_critical none = {0};
  double error, value = rad_exchange(&s->pair.g->gauss, flat, &s->pair.face,
                                     t->weight ? ROUGH : EXACT, &error);
  c->state = t->weight ? SMOOTH : DONE;
  if (t->weight) {
    struct rad_range range = {fmax(0, value - error), value + error};
    c->state = rad_critical_far(&s->pair, flat, &none) ? SMOOTH : SPLIT;
    by_rules(s, t, c, &range, area, at);
  } else {
    set_exact(s, t, at, value, error);
  }
}

static void partly_seen(struct rad_cell_scratch *s, const struct rad_cell_task *t,
                        const struct rad_flat *flat, const struct rad_shaft *shaft, struct cell *c,
                        double area, int at) {
  struct rad_critical critical;
  struct rad_range range;
  const int *list = s->list + c->first;
  double all[2];
  all[0] = rad_exchange(&s->pair.g->gauss, flat, &s->pair.face, ROUGH, &all[1]);
  int hidden = rad_proof_range(&s->pair, flat, c->n, list, all, &range);
  s->failed |= hidden < 0;
  c->state = DONE;
  if (hidden) {
    set_exact(s, t, at, 0, 0);
    return;
  }
  rad_critical_find(&s->pair, flat, shaft, c->n, list, s->mark, s->now, &critical);
  c->state = critical.crowded                              ? SPLIT
             : critical.n_line                             ? CUT
             : rad_critical_far(&s->pair, flat, &critical) ? SMOOTH
                                                           : SPLIT;
  if (c->state == SMOOTH && critical.skew)
    c->skew = rad_skew_bound(&s->pair, flat, shaft, &critical, range.high);
  by_rules(s, t, c, &range, area, at);
}

/* Add a cell with its value and error; the parent's blockers are list[first .. first + n]. */
static void add_cell(struct rad_cell_scratch *s, const struct rad_cell_task *t,
                     const double corner[3][3], int depth, int first, int n) {
  int at = s->n_cell;
  size_t need = (size_t)(at + 1) * (size_t)t->n_weight;
  if (!rad_reserve((void **)&s->cell, (size_t)at + 1, &s->cell_room, sizeof *s->cell) ||
      !rad_reserve((void **)&s->value, need, &s->value_room, sizeof *s->value) ||
      !rad_reserve((void **)&s->error, need, &s->error_room, sizeof *s->error)) {
    s->failed = 1;
    return;
  }
  s->n_cell++;
  struct cell c = {.depth = depth, .rule = RULE_FIRST};
  struct rad_flat flat;
  struct rad_shaft shaft;
  memcpy(c.corner, corner, sizeof c.corner);
  flatten(&s->pair, corner, &flat);
  double area = rad_flat_area(&flat);
  cull(s, &flat, first, n, &shaft, &c);
  if (s->failed)
    return;
  if (c.n)
    partly_seen(s, t, &flat, &shaft, &c, area, at);
  else
    wholly_seen(s, t, &flat, &c, area, at);
  if (depth >= MOST_DEPTH && c.state != SMOOTH)
    c.state = DONE;
  s->cell[at] = c;
  for (int k = 0; k < t->n_weight; k++) {
    s->total_value[k] += s->value[(size_t)at * t->n_weight + k];
    s->total_error[k] += s->error[(size_t)at * t->n_weight + k];
  }
  if (c.state != DONE)
    push(s, t, at);
}

/* ---- refinement ---- */

static void take_out(struct rad_cell_scratch *s, const struct rad_cell_task *t, int at) {
  for (int k = 0; k < t->n_weight; k++) {
    s->total_value[k] -= s->value[(size_t)at * t->n_weight + k];
    s->total_error[k] -= s->error[(size_t)at * t->n_weight + k];
    s->value[(size_t)at * t->n_weight + k] = s->error[(size_t)at * t->n_weight + k] = 0;
  }
}

static void split(struct rad_cell_scratch *s, const struct rad_cell_task *t, const struct cell *c) {
  double middle[3][3], child[4][3][3];
  for (int m = 0; m < 3; m++)
    rad_between(c->corner[(m + 1) % 3], c->corner[(m + 2) % 3], 0.5, middle[m]);
  memcpy(child[3], middle, sizeof middle);
  for (int m = 0; m < 3; m++) {
    memcpy(child[m][0], c->corner[m], sizeof middle[0]);
    memcpy(child[m][1], middle[(m + 2) % 3], sizeof middle[0]);
    memcpy(child[m][2], middle[(m + 1) % 3], sizeof middle[0]);
  }
  for (int k = 0; k < 4; k++)
    add_cell(s, t, (const double(*)[3])child[k], c->depth + 1, c->first, c->n);
}

/* True if triangle k of a polygon's fan is not too small; coordinates (m1, m2) of a cell. */
static int is_piece(const struct rad_polygon *part, int k) {
  const double *a = part->corner[0], *b = part->corner[k], *c = part->corner[k + 1];
  return fabs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) > LEAST_PIECE;
}

static void add_fan(struct rad_cell_scratch *s, const struct rad_cell_task *t, const struct cell *c,
                    const struct rad_polygon *part) {
  for (int k = 1; k + 1 < part->n; k++) {
    double corner[3][3];
    const double *at[3] = {part->corner[0], part->corner[k], part->corner[k + 1]};
    if (!is_piece(part, k))
      continue;
    for (int m = 0; m < 3; m++) {
      const double mu[3] = {1 - at[m][0] - at[m][1], at[m][0], at[m][1]};
      rad_at_lambda(c->corner, mu, corner[m]);
    }
    add_cell(s, t, (const double(*)[3])corner, c->depth + 1, c->first, c->n);
  }
}

enum { MOST_PIECES = 1 + RAD_MAX_LINE * (RAD_MAX_LINE + 1) / 2 };

static void cut(struct rad_cell_scratch *s, const struct rad_cell_task *t, const struct cell *c) {
  struct rad_polygon piece[MOST_PIECES] = {{.n = 3, .corner = {{0, 0}, {1, 0}, {0, 1}}}};
  struct rad_critical critical;
  struct rad_shaft shaft;
  struct rad_flat flat;
  int n = 1, n_triangle = 0;
  flatten(&s->pair, c->corner, &flat);
  /* corners of `flat` are oriented; lines are wanted in the order of the cell's */
  struct rad_flat plain = flat;
  for (int m = 0; m < 3; m++)
    rad_at_lambda(s->pair.s->v, c->corner[m], plain.corner[m]);
  rad_shaft_make(&flat, &s->pair.face, s->pair.g->visibility->occluders.slack, &shaft);
  s->now++;
  for (int i = 0; i < c->n; i++)
    s->mark[s->pair.blocker[s->list[c->first + i]]] = s->now;
  rad_critical_find(&s->pair, &plain, &shaft, c->n, s->list + c->first, s->mark, s->now, &critical);
  for (int l = 0; l < critical.n_line; l++) {
    const double *f = critical.line[l];
    for (int k = 0, end = n; k < end; k++) {
      struct rad_polygon above, below;
      rad_split(&piece[k], f[0], f[1] - f[0], f[2] - f[0], &above, &below);
      if (above.n < 3 || below.n < 3 || n == MOST_PIECES)
        continue;
      piece[k] = above;
      piece[n++] = below;
    }
  }
  for (int k = 0; k < n; k++)
    for (int m = 1; m + 1 < piece[k].n; m++)
      n_triangle += is_piece(&piece[k], m);
  if (n_triangle == 1) /* lines along the border: they would be found again for ever */
    split(s, t, c);
  for (int k = 0; k < n && n_triangle > 1; k++)
    add_fan(s, t, c, &piece[k]);
}

/* The next rule; its difference from the last tells the error. */
static void raise_rule(struct rad_cell_scratch *s, const struct rad_cell_task *t, int at) {
  struct cell *c = &s->cell[at];
  struct sums r;
  struct rad_flat flat;
  flatten(&s->pair, c->corner, &flat);
  double last = urgency(s, t, at), area = rad_flat_area(&flat);
  apply_rule(s, t, c, ++c->rule, area, &r);
  for (int k = 0; k < t->n_weight; k++) {
    double *value = &s->value[(size_t)at * t->n_weight + k];
    double *error = &s->error[(size_t)at * t->n_weight + k];
    double skew = c->skew * r.most[k], before = fmax(0, *error - skew);
    double now = skew + fmax(SAFETY * fabs(r.sum[k] - *value), LUCK_AGAIN * before);
    s->total_value[k] += r.sum[k] - *value;
    s->total_error[k] += now - *error;
    *value = r.sum[k];
    *error = now;
  }
  if (c->rule + 1 == RAD_TRIANGLE_RULES || urgency(s, t, at) > GAIN * last)
    c->state = SPLIT;
  if (c->skew > 0)
    judge(s, t, c, r.most, at);
  if (c->state == SPLIT && c->depth >= MOST_DEPTH)
    c->state = DONE;
  if (c->state != DONE)
    push(s, t, at);
}

static void refine(struct rad_cell_scratch *s, const struct rad_cell_task *t) {
  int at = pop(s, t);
  if (s->cell[at].state == SMOOTH) {
    raise_rule(s, t, at);
    return;
  }
  struct cell c = s->cell[at];
  take_out(s, t, at);
  if (c.state == CUT)
    cut(s, t, &c);
  else
    split(s, t, &c);
}

/* ---- a task ---- */

static int is_met(const struct rad_cell_scratch *s, const struct rad_cell_task *t) {
  for (int k = 0; k < t->n_weight; k++)
    if (!(s->total_error[k] <= t->tolerance[k]))
      return 0;
  return 1;
}

static void begin(struct rad_cell_scratch *s, const struct rad_cell_task *t) {
  struct rad_polygon part;
  struct cell whole;
  int n = s->pair.n_blocker;
  s->n_cell = s->n_heap = 0;
  s->n_list = n;
  s->points = 0;
  if (!rad_reserve((void **)&s->list, (size_t)n, &s->list_room, sizeof *s->list)) {
    s->failed = 1;
    return;
  }
  for (int k = 0; k < n; k++)
    s->list[k] = k;
  memcpy(whole.corner, t->corner, sizeof whole.corner);
  rad_pair_front(&s->pair, t->corner, &part);
  for (int k = 1; k + 1 < part.n; k++) {
    double corner[3][3];
    const double *at[3] = {part.corner[0], part.corner[k], part.corner[k + 1]};
    for (int m = 0; m < 3; m++) {
      corner[m][0] = 1 - at[m][0] - at[m][1];
      corner[m][1] = at[m][0];
      corner[m][2] = at[m][1];
    }
    add_cell(s, t, (const double(*)[3])corner, 0, 0, n);
  }
}

/* Best so far: refining a cell may tell a larger error at first. */
struct best {
  double measure, value[RAD_MAX_WEIGHT], error[RAD_MAX_WEIGHT];
};

static void keep_best(const struct rad_cell_scratch *s, const struct rad_cell_task *t,
                      struct best *best) {
  double measure = 0;
  for (int k = 0; k < t->n_weight; k++)
    measure = fmax(measure, s->total_error[k] / t->tolerance[k]);
  if (measure >= best->measure)
    return;
  best->measure = measure;
  memcpy(best->value, s->total_value, sizeof best->value);
  memcpy(best->error, s->total_error, sizeof best->error);
}

enum rad_code rad_cell_integrate(const struct rad_pair_engine *g, struct rad_cell_scratch *s,
                                 const struct rad_cell_task *task, double *value, double *error,
                                 struct rad_error *e) {
  struct best best = {.measure = INFINITY};
  memset(s->total_value, 0, sizeof s->total_value);
  memset(s->total_error, 0, sizeof s->total_error);
  memset(value, 0, sizeof(double) * (size_t)task->n_weight);
  memset(error, 0, sizeof(double) * (size_t)task->n_weight);
  s->failed = 0;
  s->points = 0;
  if (!s->mark)
    s->mark = rad_calloc((size_t)g->visibility->occluders.n, sizeof *s->mark);
  int seen = s->mark ? rad_pair_set(g, task->source, task->target, &s->pair) : -1;
  if (seen == 0)
    return RAD_OK;
  int64_t limit = task->limit > 0 ? task->limit : LIMIT;
  if (seen > 0 && task->most_blockers && s->pair.n_blocker > task->most_blockers) {
    for (int k = 0; k < task->n_weight; k++)
      error[k] = INFINITY;
    return RAD_OK;
  }
  if (seen > 0)
    begin(s, task);
  while (seen > 0 && !s->failed && !rad_stop_asked()) {
    keep_best(s, task, &best);
    if (is_met(s, task) || !s->n_heap || s->points >= limit)
      break;
    refine(s, task);
  }
  if (seen < 0 || s->failed)
    return rad_fail_memory(e, "the integrals between triangles", 1e6);
  if (rad_stop_asked())
    return rad_fail_stopped(e);
  memcpy(value, best.value, sizeof(double) * (size_t)task->n_weight);
  memcpy(error, best.error, sizeof(double) * (size_t)task->n_weight);
  return RAD_OK;
}
