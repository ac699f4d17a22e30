#include "estimate/received.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/stop.h"
#include "base/vec.h"
#include "estimate/smooth.h"
#include "visibility/facing.h"
#include "visibility/visibility.h"

/* Rules on a cell are trusted from this axis on (rad_smoothness): each point more divides the error
 * by 6.9. */
#define LEAST_AXIS 1.5

/* Part of a tolerance that the factors of points may use up, by their quadrature and by rounding.
 */
#define FACTORS_PART 0.01

/* Standard errors that a stated error has, with Student's t of RAD_REPLICATES in mind. */
#define SIGMAS 5.5

/* A spread that is a larger part of the integral without shadows says that copies differ much, and
 * then those that would count most may be missing. */
#define TRUSTED 0.25

/* Of these the share of a pair is made: the sum of many pairs uses less than its part. */
#define SHARE_SIGMAS 4

/* Part of the tolerance for errors that add up by chance; the others are mostly far below theirs.
 */
#define BY_CHANCE 0.8

/* Least part of its share that a small cell of an element gets. */
#define LEAST_PART 0.02

/* Points that miss their share by less than this are kept: most others use less than theirs, and
 * the error that is stated is what they found. */
#define LEFT_TO_CELLS 3

enum {
  MOST_IN_CELLS = 500000, /* points of an element and a receiver in cells */
  CHUNKS = 128,   /* of elements, each with its own sums: the same bits for any number of threads */
  LEAST_RULE = 2, /* points per direction where the bound alone is small enough */
  PART_RULE = 4,  /* least points per direction of those to compare, on parts of an element */
  N_RULE = 4,     /* rules on a cell: the least; two to compare; one more, if these differ */
  DEEPEST = 60,   /* halvings of an element */
  MOST_IN_PARTS = 1000000 /* factors of an element and a receiver */
};

/* Everything that the chunks share. */
struct receive {
  const struct rad_weights *w;
  const struct rad_scene *to;
  int first, n_receiver; /* the receivers are to->triangle[first] .. */
  struct rad_receivers receivers;
  struct rad_pair_engine engine; /* of pairs that something may stand between */
  const double *tolerance;
  double accuracy; /* of the factors, relative */
  double *portion; /* owned [n_element] of the tolerance that an element may use up */
  double *open;    /* owned [n_receiver, n_weight] int |w| F without the shadows that may fall */
  double *value, *error, *variance; /* owned [CHUNKS, n_receiver, n_weight] */
};

/* What a cell sends, by rule; made when it is asked for. */
struct lights {
  struct rad_light_cell cell;
  int points; /* per direction of the first two rules to compare */
  unsigned n; /* rules that are set */
  struct rad_light rule[N_RULE];
};

/* Memory of one thread. */
struct worker {
  struct rad_scratch scratch;
  struct rad_cell_scratch *cells; /* owned */
  enum rad_code code;             /* the first error, and its text */
  struct rad_error error;
  struct rad_light scattered[RAD_SCATTERED];
  unsigned char is_scattered[RAD_SCATTERED]; /* those that are set */
  struct lights whole, part;                 /* of the element at hand, of a cell of it */
  int64_t factors;
};

/* One receiver and the sums that its cells go to. */
struct receiver {
  struct rad_receiver at;
  struct rad_singular singular;
  int is_cut;                       /* its plane cuts the element's triangle: F has a kink there */
  double *value, *error, *variance; /* [n_weight] */
};

static double apart(const double a[3], const double b[3]) {
  double way[3];
  rad_sub(a, b, way);
  return rad_norm(way);
}

/* F(y -> T) <= A_T / (pi d^2), and <= 1. */
static double largest_factor(const struct rad_triangle *t, const struct rad_cell_shape *c) {
  double centre[3], way[3], radius = 0;
  for (int d = 0; d < 3; d++)
    centre[d] = (t->v[0][d] + t->v[1][d] + t->v[2][d]) / 3;
  for (int k = 0; k < 3; k++) {
    rad_sub(t->v[k], centre, way);
    radius = fmax(radius, rad_norm(way));
  }
  rad_sub(c->centre, centre, way);
  double gap = rad_norm(way) - radius - c->radius;
  return gap > 0 ? fmin(1, t->area / (M_PI * gap * gap)) : 1;
}

/* ---- one cell and one receiver ------------------------------------------------------------------
 */

static void apply(const struct receive *r, const struct rad_light *light, const struct receiver *to,
                  double *sum, struct worker *w) {
  double f[RAD_MAX_SENDER];
  rad_point_factors(&r->receivers, &light->senders, &to->at, f, &w->scratch);
  w->factors += light->senders.n;
  for (int k = 0; k < r->w->n; k++) {
    sum[k] = 0;
    for (int q = 0; q < light->senders.n; q++)
      sum[k] += f[q] * light->flux[k][q];
  }
}

/* True if |x_k| of all weights is within its share; tolerance per area of the receiver. */
static int is_within(const struct receive *r, const double *x, double share) {
  for (int k = 0; k < r->w->n; k++)
    if (!(fabs(x[k]) <= share * r->tolerance[k]))
      return 0;
  return 1;
}

static void add(const struct receive *r, const double *value, const double *error,
                const struct receiver *to) {
  for (int k = 0; k < r->w->n; k++) {
    to->value[k] += value[k];
    to->error[k] += fabs(error[k]);
  }
}

/* Points per direction that integrate w exactly, and F where it is nearly constant. */
static int rule_of(const struct rad_element *e) {
  int k = e->k_phi > e->k_r ? e->k_phi : e->k_r;
  return k / 2 + 1 > LEAST_RULE ? k / 2 + 1 : LEAST_RULE;
}

static const struct rad_light *light_of(const struct receive *r, struct lights *l, unsigned rule) {
  static const int more[N_RULE] = {0, 0, 2, 5};
  for (; l->n <= rule; l->n++)
    rad_light_set(r->w, &l->cell, l->n == 0 ? LEAST_RULE : l->points + more[l->n], &l->rule[l->n]);
  return &l->rule[rule];
}

/* Cell by cell, where scattered points have not been enough. */
static void by_cells(const struct receive *r, int element, const struct receiver *to, double share,
                     struct worker *w) {
  struct rad_light_at at = {r->w, element};
  double corner[2][3][3], tolerance[RAD_MAX_WEIGHT], value[RAD_MAX_WEIGHT], error[RAD_MAX_WEIGHT];
  int n = rad_light_triangles(r->w->mesh, element, corner);
  struct rad_cell_task task = {.source = rad_element_triangle(r->w->mesh, element),
                               .target = to->at.triangle,
                               .n_weight = r->w->n,
                               .weight = rad_light_at,
                               .context = &at,
                               .limit = MOST_IN_CELLS,
                               .tolerance = tolerance};
  for (int k = 0; k < r->w->n; k++)
    tolerance[k] = share / n * r->tolerance[k];
  for (int i = 0; i < n && !w->code; i++) {
    memcpy(task.corner, corner[i], sizeof task.corner);
    w->code = rad_cell_integrate(&r->engine, w->cells, &task, value, error, &w->error);
    if (!w->code)
      add(r, value, error, to);
  }
}

/* ---- scattered points ---------------------------------------------------------------------------
 */

/* What every copy of a lattice finds. */
static void sum_copies(const struct receive *r, int set, const struct receiver *to,
                       double (*sum)[RAD_REPLICATES], struct worker *w) {
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
    rad_point_factors(&r->receivers, &l->senders, &to->at, f, &w->scratch);
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

/* int |w_k| F dS without shadows. */
static void unshaded(const struct receive *r, const struct receiver *to, double *most,
                     struct worker *w) {
  const struct rad_light *light = light_of(r, &w->whole, 2);
  double f[RAD_MAX_SENDER];
  struct rad_receiver open = to->at;
  open.sight = RAD_FREE;
  rad_point_factors(&r->receivers, &light->senders, &open, f, &w->scratch);
  for (int k = 0; k < r->w->n; k++) {
    most[k] = 0;
    for (int q = 0; q < light->senders.n; q++)
      most[k] += f[q] * fabs(light->flux[k][q]);
  }
}

/* True if the variances are within their share, times more. Half of it goes by element, half by
 * what is sent: strong pairs may have larger ones, which takes the fewest points in all. */
static int is_certain(const struct receive *r, const struct receiver *to, double portion,
                      const double *most, const double *variance, double times) {
  double area = BY_CHANCE * r->to->triangle[to->at.triangle].area;
  const double *open = r->open + (size_t)(to->at.triangle - r->first) * (size_t)r->w->n;
  for (int k = 0; k < r->w->n; k++) {
    double part = 0.5 * (portion + (open[k] > 0 ? most[k] / open[k] : 0));
    if (SIGMAS * sqrt(variance[k]) > TRUSTED * most[k] ||
        !(SHARE_SIGMAS * sqrt(variance[k]) <= times * area * r->tolerance[k] * sqrt(part)))
      return 0;
  }
  return 1;
}

/* Randomised points on the whole element; errors of elements are independent, so that variances add
 * up. 1 if that was good enough. */
static int by_points(const struct receive *r, const struct receiver *to, double portion,
                     struct worker *w) {
  double most[RAD_MAX_WEIGHT], value[RAD_MAX_WEIGHT], variance[RAD_MAX_WEIGHT];
  unshaded(r, to, most, w);
  for (int set = 0; set < RAD_N_LATTICE; set++) {
    double sum[RAD_MAX_WEIGHT][RAD_REPLICATES] = {{0}};
    double times = set < RAD_N_LATTICE - 1 ? 1 : LEFT_TO_CELLS;
    int n = rad_lattice[set].n * RAD_REPLICATES;
    for (int k = 0; k < r->w->n; k++)
      judge(sum[k], n, most[k], &value[k], &variance[k]);
    if (!is_certain(r, to, portion, most, variance, times)) /* so few points can not be enough */
      continue;
    sum_copies(r, set, to, sum, w);
    for (int k = 0; k < r->w->n; k++)
      judge(sum[k], n, most[k], &value[k], &variance[k]);
    if (!is_certain(r, to, portion, most, variance, times))
      continue;
    for (int k = 0; k < r->w->n; k++) {
      to->value[k] += value[k];
      to->variance[k] += variance[k];
    }
    return 1;
  }
  return 0;
}

static int is_smooth(const struct rad_cell_shape *shape, const struct receiver *to) {
  double axis[2];
  rad_smoothness(shape, &to->singular, axis);
  return fmin(axis[0], axis[1]) >= LEAST_AXIS;
}

/* Rules on a cell; 1 if two of them agreed, or if it is the last that is done. */
static int by_rules(const struct receive *r, struct lights *l, const struct receiver *to,
                    double share, int is_last, struct worker *w) {
  const struct rad_light *fine = light_of(r, l, 2);
  struct rad_cell_shape shape;
  double most[RAD_MAX_WEIGHT], low[RAD_MAX_WEIGHT], high[RAD_MAX_WEIGHT];
  rad_light_cell_shape(r->w->mesh, &l->cell, &shape);
  const struct rad_triangle *t = &r->to->triangle[to->at.triangle];
  double reach = fmin(fine->area * largest_factor(t, &shape), t->area); /* by reciprocity */
  for (int k = 0; k < r->w->n; k++)
    most[k] = fine->most[k] * reach;
  if (is_last || is_within(r, most, share)) {
    int rule = isinf(r->tolerance[0]) ? 1 : 0; /* as it comes: the points that are exact for w */
    apply(r, light_of(r, l, (unsigned)rule), to, low, w);
    add(r, low, most, to);
    return 1;
  }
  if (to->at.sight == RAD_PARTLY || to->is_cut || !is_smooth(&shape, to))
    return 0;
  apply(r, light_of(r, l, 1), to, high, w);
  for (unsigned rule = 2; rule < N_RULE; rule++) {
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

/* Halve a cell in the direction that is the less smooth, or across its longer side. */
static void halve(const struct rad_mesh *mesh, const struct rad_light_cell *cell,
                  const struct receiver *to, struct rad_light_cell child[2]) {
  struct rad_cell_shape s;
  double axis[2];
  rad_light_cell_shape(mesh, cell, &s);
  rad_smoothness(&s, &to->singular, axis);
  double wide = fmax(apart(s.corner[0], s.corner[1]), apart(s.corner[2], s.corner[3]));
  double high = fmax(apart(s.corner[0], s.corner[2]), apart(s.corner[1], s.corner[3]));
  int is_rough[2] = {axis[0] < LEAST_AXIS, axis[1] < LEAST_AXIS};
  int is_across = is_rough[0] == is_rough[1] ? wide > high : is_rough[0];
  for (int c = 0; c < 2; c++) {
    child[c] = *cell;
    double *side = is_across ? child[c].sigma : child[c].tau;
    side[1 - c] = 0.5 * (side[0] + side[1]);
  }
}

/* A cell that sees all of the receiver, in halves, depth first. The share of a half is half of it,
 * down to least: few cells are small, those towards a corner. */
static void by_halves(const struct receive *r, const struct rad_light_cell *cell,
                      const struct receiver *to, double share, double least, int depth,
                      int64_t most, struct worker *w) {
  struct rad_light_cell child[2];
  halve(r->w->mesh, cell, to, child);
  share = fmax(0.5 * share, least);
  for (int c = 0; c < 2 && !rad_stop_asked(); c++) {
    int is_last = depth == DEEPEST || w->factors > most;
    w->part.cell = child[c];
    w->part.n = 0;
    w->part.points = w->whole.points > PART_RULE ? w->whole.points : PART_RULE;
    if (!by_rules(r, &w->part, to, share, is_last, w))
      by_halves(r, &child[c], to, share, least, depth + 1, most, w);
  }
}

/* ---- all elements -----------------------------------------------------------------------------
 */

static int sends(const struct receive *r, int element) {
  const struct rad_element *e = &r->w->mesh->element[element];
  for (int k = 0; k < r->w->n; k++)
    for (int f = 0; f < e->n_function; f++)
      if (r->w->w[k][e->first + f] != 0)
        return 1;
  return 0;
}

/* What all elements send. Half of the tolerance by area, half by number, so that neither one large
 * element nor many small ones use it up. */
static void share_out(struct receive *r, struct rad_light *light, double *sent) {
  const struct rad_mesh *mesh = r->w->mesh;
  double area = 0;
  int n = 0;
  for (int i = 0; i < mesh->n_element; i++) {
    r->portion[i] = 0;
    if (!sends(r, i))
      continue;
    struct rad_light_cell cell = rad_light_cell_whole(mesh, i);
    rad_light_set(r->w, &cell, rule_of(&mesh->element[i]), light);
    r->portion[i] = light->area;
    area += light->area;
    n++;
    for (int k = 0; k < r->w->n; k++)
      for (int q = 0; q < light->senders.n; q++)
        sent[k] += light->flux[k][q];
  }
  for (int i = 0; i < mesh->n_element; i++)
    if (r->portion[i] > 0)
      r->portion[i] = 0.5 * (r->portion[i] / area + 1.0 / n);
}

/* Absolute error of the factors that changes none of the sums by more than its part. */
static double rounding(const struct receive *r, const struct rad_light *light, double share) {
  double least = 1e-6;
  for (int k = 0; k < r->w->n; k++)
    if (light->most[k] > 0)
      least = fmin(least, FACTORS_PART * share * r->tolerance[k] / (light->most[k] * light->area));
  return least;
}

static void begin_element(const struct receive *r, int element, struct worker *w) {
  w->whole.cell = rad_light_cell_whole(r->w->mesh, element);
  w->whole.n = 0;
  w->whole.points = rule_of(&r->w->mesh->element[element]);
  memset(w->is_scattered, 0, sizeof w->is_scattered);
}

static void send(const struct receive *r, int chunk, int element, struct worker *w) {
  const struct rad_mesh *mesh = r->w->mesh;
  int n = r->to->n_triangle, from = rad_element_triangle(mesh, element);
  const unsigned char *sees = r->to->visibility->sight + (size_t)from * (size_t)n;
  begin_element(r, element, w);
  for (int t = r->first; t < n && !rad_stop_asked(); t++) {
    if (sees[t] == RAD_HIDDEN)
      continue;
    size_t at = ((size_t)chunk * (size_t)r->n_receiver + (size_t)(t - r->first)) * (size_t)r->w->n;
    int is_cut = rad_side_of(&r->to->triangle[t], &r->to->triangle[from]) == RAD_ACROSS;
    struct receiver to = {.at = {t, sees[t], 0},
                          .is_cut = is_cut,
                          .value = r->value + at,
                          .error = r->error + at,
                          .variance = r->variance + at};
    if (isfinite(r->tolerance[0]))
      rad_singular_set(&r->to->triangle[from], &r->to->triangle[t], &to.singular);
    double portion = r->portion[element];
    double share = (1 - BY_CHANCE) * r->to->triangle[t].area * portion;
    to.at.rounding = rounding(r, light_of(r, &w->whole, 2), share);
    if (by_rules(r, &w->whole, &to, share, 0, w))
      continue;
    if (to.at.sight == RAD_FREE && !is_cut)
      by_halves(r, &w->whole.cell, &to, share, LEAST_PART * share, 0, w->factors + MOST_IN_PARTS,
                w);
    else if (to.at.sight == RAD_FREE || !by_points(r, &to, portion, w))
      by_cells(r, element, &to, share, w);
  }
}

/* What a receiver would get from elements that it sees in part if nothing stood between. */
static void set_open(const struct receive *r, int triangle, struct worker *w) {
  int n = r->to->n_triangle;
  const unsigned char *sight = r->to->visibility->sight;
  double *open = r->open + (size_t)(triangle - r->first) * (size_t)r->w->n, most[RAD_MAX_WEIGHT];
  const struct receiver to = {.at = {triangle, RAD_FREE, 1e-3}};
  for (int i = 0; i < r->w->mesh->n_element && !rad_stop_asked(); i++) {
    size_t from = (size_t)rad_element_triangle(r->w->mesh, i);
    if (!(r->portion[i] > 0) || sight[from * (size_t)n + (size_t)triangle] != RAD_PARTLY)
      continue;
    begin_element(r, i, w);
    unshaded(r, &to, most, w);
    for (int k = 0; k < r->w->n; k++)
      open[k] += most[k];
  }
}

static void gather(struct receive *r, struct rad_received *out) {
  size_t n = (size_t)out->n_triangle * (size_t)out->n_weight;
  for (size_t c = 0; c < CHUNKS; c++)
    for (size_t i = 0; i < n; i++) {
      out->value[i] += r->value[c * n + i];
      out->error[i] += r->error[c * n + i] + r->accuracy * fabs(r->value[c * n + i]);
      r->variance[i] += c ? r->variance[c * n + i] : 0;
    }
  for (size_t i = 0; i < n; i++)
    out->error[i] += SIGMAS * sqrt(r->variance[i]);
}

static void run(struct receive *r, struct worker *worker) {
  int n_element = r->w->mesh->n_element;
  struct rad_progress *progress = r->w->mesh->scene->progress;
#pragma omp parallel for schedule(dynamic) default(none) shared(r, worker)
  for (int t = r->first; t < r->to->n_triangle; t++)
    set_open(r, t, &worker[omp_get_thread_num()]);
  rad_progress_begin(progress, "elements", n_element);
#pragma omp parallel for schedule(dynamic) default(none) shared(r, worker, n_element, progress)
  for (int c = 0; c < CHUNKS; c++)
    for (int i = c; i < n_element; i += CHUNKS) {
      if (r->portion[i] > 0 && !rad_stop_asked())
        send(r, c, i, &worker[omp_get_thread_num()]);
      rad_progress_add(progress, 1);
    }
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

static enum rad_code begin(struct receive *r, struct rad_error *e) {
  size_t n = (size_t)r->n_receiver * (size_t)r->w->n;
  r->accuracy = accuracy(r->w, r->tolerance);
  enum rad_code code = rad_receivers_begin(r->to, r->accuracy, &r->receivers, e);
  if (!code)
    code = rad_pair_engine_init(r->to, &r->engine, e);
  if (code)
    return code;
  r->portion = rad_alloc((size_t)r->w->mesh->n_element, sizeof(double));
  r->open = rad_calloc(n, sizeof(double));
  r->value = rad_calloc(CHUNKS * n, sizeof(double));
  r->error = rad_calloc(CHUNKS * n, sizeof(double));
  r->variance = rad_calloc(CHUNKS * n, sizeof(double));
  return r->portion && r->open && r->value && r->error && r->variance
             ? RAD_OK
             : rad_fail_memory(e, "the means", 16.0 * CHUNKS * (double)n);
}

static enum rad_code finish(struct receive *r, int n_thread, struct worker *worker,
                            struct rad_received *out, struct rad_error *e) {
  enum rad_code code = rad_stop_asked() ? rad_fail_stopped(e) : RAD_OK;
  for (int t = 0; t < n_thread && !code; t++) {
    out->factors += worker[t].factors;
    if (worker[t].scratch.shade.failed)
      code = rad_fail_memory(e, "the shadows", 0);
    else if (worker[t].code) {
      *e = worker[t].error;
      code = worker[t].code;
    }
  }
  if (!code)
    gather(r, out);
  return code;
}

enum rad_code rad_receive(const struct rad_weights *w, const struct rad_scene *to, int first,
                          const double *tolerance, struct rad_received *out, struct rad_error *e) {
  int n_thread = omp_get_max_threads(), n_receiver = to->n_triangle - first;
  size_t n = (size_t)n_receiver * (size_t)w->n;
  struct receive r = {
      .w = w, .to = to, .first = first, .n_receiver = n_receiver, .tolerance = tolerance};
  *out = (struct rad_received){.n_triangle = n_receiver,
                               .n_weight = w->n,
                               .value = rad_calloc(n, sizeof(double)),
                               .error = rad_calloc(n, sizeof(double))};
  struct worker *worker = rad_calloc((size_t)n_thread, sizeof *worker);
  enum rad_code code = begin(&r, e);
  if (!code && (!worker || !out->value || !out->error))
    code = rad_fail_memory(e, "the means", 16.0 * (double)n);
  for (int t = 0; t < n_thread && !code; t++)
    if (!(code = rad_scratch_init(&r.receivers.mesh, &worker[t].scratch, e)) &&
        !(worker[t].cells = rad_cell_scratch_new()))
      code = rad_fail_memory(e, "the means", 0);
  if (!code) {
    share_out(&r, &worker[0].whole.rule[0], out->sent);
    run(&r, worker);
    code = finish(&r, n_thread, worker, out, e);
  }
  for (int t = 0; worker && t < n_thread; t++) {
    rad_scratch_free(&worker[t].scratch);
    rad_cell_scratch_free(worker[t].cells);
  }
  rad_pair_engine_free(&r.engine);
  free(worker);
  rad_receivers_free(&r.receivers);
  free(r.portion);
  free(r.open);
  free(r.value);
  free(r.error);
  free(r.variance);
  return code;
}

void rad_received_free(struct rad_received *r) {
  free(r->value);
  free(r->error);
  *r = (struct rad_received){0};
}
