#include "estimate/transfer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/stop.h"
#include "base/vec.h"
#include "visibility/facing.h"
#include "visibility/visibility.h"

/* Rules on a cell are trusted from this axis on (rad_smoothness): each point more divides the error
 * by 6.9. */
#define LEAST_AXIS 1.5

/* Part of a tolerance that the factors of points may use up, by their quadrature and by rounding.
 */
#define FACTORS_PART 0.01

/* A spread that is a larger part of the integral without shadows says that copies differ much, and
 * then those that would count most may be missing. */
#define TRUSTED 0.25

/* Of so many standard errors the share of a pair is made: the sum of many pairs uses less than its
 * part. */
#define SHARE_SIGMAS 4

/* Part of the tolerance for errors that add up by chance. */
#define BY_CHANCE 0.5

/* Least part of its share that a small cell of an element gets. */
#define LEAST_PART 0.02

/* Points that miss their share by less than this are kept: most others use less than theirs, and
 * the error that is stated is what they found. */
#define LEFT_TO_CELLS 3

enum {
  MOST_IN_CELLS = 500000, /* points of an element and a receiver in cells */
  FIRST_IN_CELLS = 300,   /* the same before scattered points are tried, for constant elements: most
                             small pairs take less; with weights cells cost more than points */
  FEW_BLOCKERS = 8,       /* with more, scattered points come first */
  LEAST_RULE = 2,         /* points per direction where the bound alone is small enough */
  PART_RULE = 4, /* least points per direction of those to compare, on parts of an element */
  DEEPEST = 60,  /* halvings of an element */
  MOST_IN_PARTS = 1000000 /* factors of an element and a receiver */
};

/* One receiver and the sums that its cells go to. */
struct receiver {
  struct rad_receiver at;
  struct rad_singular singular;
  double centre[3], radius;    /* of a sphere round it */
  int is_broken;               /* F has kinks on the element's triangle */
  double most[RAD_MAX_WEIGHT]; /* if it is broken: int |w| F without shadows [W] */
  double portion;              /* of the tolerance */
  double share;                /* of it, for errors that add up, times the area */
  int64_t most_factors;        /* from there on cells are not halved */
  struct rad_transfer_sums sums;
};

static double apart(const double a[3], const double b[3]) {
  double way[3];
  rad_sub(a, b, way);
  return rad_norm(way);
}

static void set_sphere(const struct rad_triangle *t, struct receiver *to) {
  double way[3];
  for (int d = 0; d < 3; d++)
    to->centre[d] = (t->v[0][d] + t->v[1][d] + t->v[2][d]) / 3;
  for (int k = 0; k < 3; k++) {
    rad_sub(t->v[k], to->centre, way);
    to->radius = fmax(to->radius, rad_norm(way));
  }
}

/* F(y -> T) <= A_T / (pi d^2), and <= 1. */
static double largest_factor(const struct receiver *to, double area,
                             const struct rad_cell_shape *c) {
  double way[3];
  rad_sub(c->centre, to->centre, way);
  double gap = rad_norm(way) - to->radius - c->radius;
  return gap > 0 ? fmin(1, area / (M_PI * gap * gap)) : 1;
}

/* ---- one cell and one receiver ------------------------------------------------------------------
 */

static void apply(const struct rad_transfer *r, const struct rad_light *light,
                  const struct receiver *to, double *sum, struct rad_transfer_scratch *w) {
  double f[RAD_MAX_SENDER];
  rad_point_factors(&r->receivers, &light->senders, &to->at, f, &w->patch);
  w->factors += light->senders.n;
  for (int k = 0; k < r->w->n; k++) {
    sum[k] = 0;
    for (int q = 0; q < light->senders.n; q++)
      sum[k] += f[q] * light->flux[k][q];
  }
}

/* True if |x_k| of all weights is within its share; tolerance per area of the receiver. */
static int is_within(const struct rad_transfer *r, const double *x, double share) {
  for (int k = 0; k < r->w->n; k++)
    if (!(fabs(x[k]) <= share * r->tolerance[k]))
      return 0;
  return 1;
}

static void add(const struct rad_transfer *r, const double *value, const double *error,
                const struct receiver *to) {
  for (int k = 0; k < r->w->n; k++) {
    to->sums.value[k] += value[k];
    to->sums.error[k] += fabs(error[k]);
  }
}

int rad_transfer_rule(const struct rad_element *e) {
  int k = e->k_phi > e->k_r ? e->k_phi : e->k_r;
  return k / 2 + 1 > LEAST_RULE ? k / 2 + 1 : LEAST_RULE;
}

static const struct rad_light *light_of(const struct rad_transfer *r, struct rad_lights *l,
                                        unsigned rule) {
  static const int more[RAD_N_RULE] = {0, 0, 2, 5};
  for (; l->n <= rule; l->n++)
    rad_light_set(r->w, &l->cell, l->n == 0 ? LEAST_RULE : l->points + more[l->n], &l->rule[l->n]);
  return &l->rule[rule];
}

static void begin_cell(const struct rad_transfer *r, struct rad_light_cell cell, int points,
                       struct rad_lights *l) {
  l->cell = cell;
  l->points = points;
  l->n = 0;
  rad_light_cell_shape(r->w->mesh, &cell, &l->shape);
}

/* ---- scattered points ---------------------------------------------------------------------------
 */

/* What every copy of a lattice finds. */
static void sum_copies(const struct rad_transfer *r, int set, const struct receiver *to,
                       double (*sum)[RAD_REPLICATES], struct rad_transfer_scratch *w) {
  const struct rad_lattice *lattice = &rad_lattice[set];
  int light = 0;
  for (int s = 0; s < set; s++)
    light += RAD_REPLICATES / rad_lattice[s].at_once;
  for (int first = 0; first < RAD_REPLICATES; first += lattice->at_once, light++) {
    double f[RAD_MAX_SENDER];
    struct rad_light *l = &w->scattered[light];
    if (!w->is_scattered[light])
      rad_light_scatter(r->w, &w->whole.cell, lattice, first, l);
    w->is_scattered[light] = 1;
    rad_point_factors(&r->receivers, &l->senders, &to->at, f, &w->patch);
    w->factors += l->senders.n;
    for (int k = 0; k < r->w->n; k++)
      for (int q = 0; q < l->senders.n; q++)
        sum[k][first + q / lattice->n] += f[q] * l->flux[k][q];
  }
}

/* Mean of the copies and its variance, not below that of a feature that n points just miss. */
static void judge(const double sum[RAD_REPLICATES], int n, double unshaded, double *value,
                  double *variance) {
  double mean = 0, square = 0, missed = unshaded / n;
  for (int i = 0; i < RAD_REPLICATES; i++)
    mean += sum[i] / RAD_REPLICATES;
  for (int i = 0; i < RAD_REPLICATES; i++)
    square += (sum[i] - mean) * (sum[i] - mean);
  *value = mean;
  *variance = square / (RAD_REPLICATES * (RAD_REPLICATES - 1.0)) + missed * missed;
}

void rad_transfer_open(const struct rad_transfer *r, int triangle, double rounding, double *most,
                       struct rad_transfer_scratch *w) {
  const struct rad_light *light = light_of(r, &w->whole, 2);
  const struct rad_receiver open = {triangle, RAD_FREE, rounding};
  double f[RAD_MAX_SENDER];
  rad_point_factors(&r->receivers, &light->senders, &open, f, &w->patch);
  for (int k = 0; k < r->w->n; k++) {
    most[k] = 0;
    for (int q = 0; q < light->senders.n; q++)
      most[k] += f[q] * fabs(light->flux[k][q]);
  }
}

/* True if the variances are within their share, times more. Half of it goes by element, half by
 * what is sent: strong pairs may have larger ones, which takes the fewest points in all. */
static int is_certain(const struct rad_transfer *r, const struct receiver *to,
                      const double *variance, double times) {
  double area = BY_CHANCE * r->to->triangle[to->at.triangle].area;
  const double *open = r->open[to->at.triangle - r->first].sum;
  for (int k = 0; k < r->w->n; k++) {
    double part = 0.5 * (to->portion + (open[k] > 0 ? to->most[k] / open[k] : 0));
    if (RAD_SIGMAS * sqrt(variance[k]) > TRUSTED * to->most[k] ||
        !(SHARE_SIGMAS * sqrt(variance[k]) <= times * area * r->tolerance[k] * sqrt(part)))
      return 0;
  }
  return 1;
}

/* Randomised points on the whole element; errors of elements are independent, so that variances add
 * up. 1 if that was good enough. */
static int by_points(const struct rad_transfer *r, const struct receiver *to,
                     struct rad_transfer_scratch *w) {
  double value[RAD_MAX_WEIGHT], variance[RAD_MAX_WEIGHT];
  for (int set = 0; set < RAD_N_LATTICE; set++) {
    double sum[RAD_MAX_WEIGHT][RAD_REPLICATES] = {{0}};
    double times = set < RAD_N_LATTICE - 1 ? 1 : LEFT_TO_CELLS;
    int n = rad_lattice[set].n * RAD_REPLICATES;
    for (int k = 0; k < r->w->n; k++)
      judge(sum[k], n, to->most[k], &value[k], &variance[k]);
    if (!is_certain(r, to, variance, times)) /* so few points can not be enough */
      continue;
    sum_copies(r, set, to, sum, w);
    for (int k = 0; k < r->w->n; k++)
      judge(sum[k], n, to->most[k], &value[k], &variance[k]);
    if (!is_certain(r, to, variance, times))
      continue;
    for (int k = 0; k < r->w->n; k++) {
      to->sums.value[k] += value[k];
      to->sums.variance[k] += variance[k];
    }
    return 1;
  }
  return 0;
}

/* ---- cells ------------------------------------------------------------------------------------
 */

/* Tolerance of cells: half by what is sent without shadows, half evenly, among the elements that
 * the receiver sees in part. */
static void share_of_cells(const struct rad_transfer *r, const struct receiver *to, double *share) {
  double area = r->to->triangle[to->at.triangle].area;
  const struct rad_open *open = &r->open[to->at.triangle - r->first];
  for (int k = 0; k < r->w->n; k++) {
    double part = (open->sum[k] > 0 ? to->most[k] / open->sum[k] : 0) + 1.0 / open->n;
    share[k] = (1 - BY_CHANCE) * area * r->tolerance[k] * 0.5 * part;
  }
}

/* The task of an element of one function: w_k F is w_k times one integral. */
static void make_plain(const struct rad_transfer *r, int element, struct rad_cell_task *task,
                       double *tolerance) {
  *tolerance = INFINITY;
  for (int k = 0; k < r->w->n; k++)
    *tolerance =
        fmin(*tolerance, task->tolerance[k] / fabs(r->w->w[k][r->w->mesh->element[element].first]));
  task->n_weight = 1;
  task->weight = NULL;
  task->tolerance = tolerance;
}

static void times_weight(const struct rad_transfer *r, int element, double *value, double *error) {
  for (int k = r->w->n - 1; k >= 0; k--) {
    double one = r->w->w[k][r->w->mesh->element[element].first];
    value[k] = one * value[0];
    error[k] = fabs(one) * error[0];
  }
}

/* Cell by cell; 1 if that was good enough, or if it was the last resort. */
static int by_cells(const struct rad_transfer *r, const struct receiver *to, int64_t limit,
                    struct rad_transfer_scratch *w) {
  int element = w->whole.cell.element, is_last = limit == MOST_IN_CELLS;
  struct rad_light_at at = {r->w, element};
  double corner[2][3][3], share[RAD_MAX_WEIGHT], plain;
  double value[2][RAD_MAX_WEIGHT], error[2][RAD_MAX_WEIGHT];
  int n = rad_light_triangles(r->w->mesh, element, corner);
  struct rad_cell_task task = {.source = rad_element_triangle(r->w->mesh, element),
                               .target = to->at.triangle,
                               .n_weight = r->w->n,
                               .weight = rad_light_at,
                               .context = &at,
                               .limit = limit / n,
                               .most_blockers = is_last ? 0 : FEW_BLOCKERS,
                               .tolerance = share};
  share_of_cells(r, to, share);
  for (int k = 0; k < r->w->n; k++)
    share[k] /= n;
  if (r->w->mesh->element[element].n_function == 1)
    make_plain(r, element, &task, &plain);
  for (int i = 0; i < n; i++) {
    memcpy(task.corner, corner[i], sizeof task.corner);
    w->code = rad_cell_integrate(&r->engine, w->cells, &task, value[i], error[i], &w->error);
    if (w->code)
      return 1;
    if (!task.weight)
      times_weight(r, element, value[i], error[i]);
    for (int k = 0; k < r->w->n && !is_last; k++)
      if (!(error[i][k] <= share[k]))
        return 0;
  }
  for (int i = 0; i < n; i++)
    add(r, value[i], error[i], to);
  return 1;
}

/* ---- rules -----------------------------------------------------------------------------------
 */

static int is_smooth(struct rad_lights *l, const struct receiver *to) {
  rad_smoothness(&l->shape, &to->singular, l->axis);
  return fmin(l->axis[0], l->axis[1]) >= LEAST_AXIS;
}

/* Rules on a cell; 1 if two of them agreed, or if it is the last that is done. */
static int by_rules(const struct rad_transfer *r, struct rad_lights *l, const struct receiver *to,
                    double share, int is_last, struct rad_transfer_scratch *w) {
  const struct rad_light *fine = light_of(r, l, 2);
  double most[RAD_MAX_WEIGHT], low[RAD_MAX_WEIGHT], high[RAD_MAX_WEIGHT];
  const struct rad_triangle *t = &r->to->triangle[to->at.triangle];
  double reach =
      fmin(fine->area * largest_factor(to, t->area, &l->shape), t->area); /* by reciprocity */
  for (int k = 0; k < r->w->n; k++)
    most[k] = fine->most[k] * reach;
  if (is_last || is_within(r, most, share)) {
    apply(r, light_of(r, l, r->as_it_comes ? 1 : 0), to, low, w);
    add(r, low, most, to);
    return 1;
  }
  if (to->is_broken || !is_smooth(l, to))
    return 0;
  apply(r, light_of(r, l, 1), to, high, w);
  for (unsigned rule = 2; rule < RAD_N_RULE; rule++) {
    memcpy(low, high, sizeof low);
    apply(r, light_of(r, l, rule), to, high, w);
    for (int k = 0; k < r->w->n; k++)
      low[k] -= high[k];
    if (is_within(r, low, share)) {
      add(r, high, low, to);
      return 1;
    }
  }
  return 0;
}

/* Halve a cell that by_rules looked at, in the direction that is the less smooth, or across its
 * longer side. */
static void halve(const struct rad_lights *l, struct rad_light_cell child[2]) {
  const double(*c)[3] = l->shape.corner;
  double wide = fmax(apart(c[0], c[1]), apart(c[2], c[3]));
  double high = fmax(apart(c[0], c[2]), apart(c[1], c[3]));
  int is_rough[2] = {l->axis[0] < LEAST_AXIS, l->axis[1] < LEAST_AXIS};
  int is_across = is_rough[0] == is_rough[1] ? wide > high : is_rough[0];
  for (int i = 0; i < 2; i++) {
    child[i] = l->cell;
    double *side = is_across ? child[i].sigma : child[i].tau;
    side[1 - i] = 0.5 * (side[0] + side[1]);
  }
}

/* A cell that sees all of the receiver, in halves, depth first. The share of a half is half of it,
 * down to a least part: few cells are small, those towards a corner. */
static void by_halves(const struct rad_transfer *r, const struct rad_lights *l,
                      const struct receiver *to, double share, int depth,
                      struct rad_transfer_scratch *w) {
  struct rad_light_cell child[2];
  halve(l, child); /* l may be w->part, which is used again now */
  share = fmax(0.5 * share, LEAST_PART * to->share);
  for (int c = 0; c < 2 && !rad_stop_asked(); c++) {
    int is_last = depth == DEEPEST || w->factors > to->most_factors;
    int points = w->whole.points > PART_RULE ? w->whole.points : PART_RULE;
    begin_cell(r, child[c], points, &w->part);
    if (!by_rules(r, &w->part, to, share, is_last, w))
      by_halves(r, &w->part, to, share, depth + 1, w);
  }
}

/* ---- a pair -----------------------------------------------------------------------------------
 */

/* Absolute error of the factors that changes none of the sums by more than its part. */
static double rounding(const struct rad_transfer *r, const struct rad_light *light, double share) {
  double least = 1e-6;
  for (int k = 0; k < r->w->n; k++)
    if (light->most[k] > 0)
      least = fmin(least, FACTORS_PART * share * r->tolerance[k] / (light->most[k] * light->area));
  return least;
}

static enum rad_sight sight_of(const struct rad_transfer *r, int from, int to) {
  return r->to->visibility->sight[(size_t)from * (size_t)r->to->n_triangle + (size_t)to];
}

int rad_transfer_is_broken(const struct rad_transfer *r, int from, int to) {
  const struct rad_triangle *t = r->to->triangle;
  enum rad_sight sight = sight_of(r, from, to);
  return sight == RAD_PARTLY || (sight == RAD_FREE && rad_side_of(&t[to], &t[from]) == RAD_ACROSS);
}

void rad_transfer_element(const struct rad_transfer *r, int element,
                          struct rad_transfer_scratch *w) {
  begin_cell(r, rad_light_cell_whole(r->w->mesh, element),
             rad_transfer_rule(&r->w->mesh->element[element]), &w->whole);
  memset(w->is_scattered, 0, sizeof w->is_scattered);
}

void rad_transfer_to(const struct rad_transfer *r, int triangle, double portion,
                     const struct rad_transfer_sums *sums, struct rad_transfer_scratch *w) {
  size_t from = (size_t)rad_element_triangle(r->w->mesh, w->whole.cell.element);
  const struct rad_triangle *s = &r->to->triangle[from], *t = &r->to->triangle[triangle];
  enum rad_sight sight = sight_of(r, (int)from, triangle);
  struct receiver to = {.at = {triangle, sight, 0},
                        .is_broken = rad_transfer_is_broken(r, (int)from, triangle),
                        .portion = portion,
                        .share = (1 - BY_CHANCE) * t->area * portion,
                        .most_factors = w->factors + MOST_IN_PARTS,
                        .sums = *sums};
  set_sphere(t, &to);
  if (!r->as_it_comes)
    rad_singular_set(s, t, &to.singular);
  to.at.rounding = rounding(r, light_of(r, &w->whole, 2), to.share);
  if (by_rules(r, &w->whole, &to, to.share, 0, w))
    return;
  if (!to.is_broken) {
    by_halves(r, &w->whole, &to, to.share, 0, w);
    return;
  }
  int is_constant = r->w->mesh->element[w->whole.cell.element].n_function == 1;
  rad_transfer_open(r, triangle, to.at.rounding, to.most, w);
  if (is_constant && by_cells(r, &to, FIRST_IN_CELLS, w))
    return;
  if (sight == RAD_FREE || !by_points(r, &to, w))
    by_cells(r, &to, MOST_IN_CELLS, w);
}

static double accuracy(const struct rad_weights *w, const double *tolerance) {
  double least = 1e-4;
  for (int k = 0; k < w->n; k++) {
    double most = 0;
    for (int i = 0; i < w->mesh->n_point; i++)
      most = fmax(most, fabs(w->w[k][i]));
    if (most > 0)
      least = fmin(least, FACTORS_PART * tolerance[k] / most);
  }
  return fmax(least, 1e-12);
}

enum rad_code rad_transfer_begin(const struct rad_weights *w, const struct rad_scene *to, int first,
                                 const double *tolerance, struct rad_transfer *t,
                                 struct rad_error *e) {
  size_t n = (size_t)(to->n_triangle - first);
  *t = (struct rad_transfer){.w = w,
                             .to = to,
                             .tolerance = tolerance,
                             .first = first,
                             .as_it_comes = isinf(tolerance[0]),
                             .accuracy = accuracy(w, tolerance),
                             .open = rad_calloc(n, sizeof(struct rad_open))};
  enum rad_code code = rad_receivers_begin(to, t->accuracy, &t->receivers, e);
  if (!code && !t->as_it_comes)
    code = rad_pair_engine_init(to, &t->engine, e);
  if (!code && !t->open)
    code = rad_fail_memory(e, "the means", (double)(n * sizeof(struct rad_open)));
  return code;
}

void rad_transfer_free(struct rad_transfer *t) {
  rad_pair_engine_free(&t->engine);
  rad_receivers_free(&t->receivers);
  free(t->open);
  *t = (struct rad_transfer){0};
}

enum rad_code rad_transfer_scratch_init(const struct rad_transfer *t,
                                        struct rad_transfer_scratch *w, struct rad_error *e) {
  enum rad_code code = rad_scratch_init(&t->receivers.mesh, &w->patch, e);
  if (!code && !(w->cells = rad_cell_scratch_new()))
    code = rad_fail_memory(e, "the means", 0);
  return code;
}

void rad_transfer_scratch_free(struct rad_transfer_scratch *w) {
  rad_scratch_free(&w->patch);
  rad_cell_scratch_free(w->cells);
  w->cells = NULL;
}
