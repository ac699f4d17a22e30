#include "estimate/received.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/stop.h"
#include "base/vec.h"
#include "visibility/facing.h"
#include "visibility/visibility.h"

/* With an edge of the receiver nearer to an element's centre than this many radii, rules on the
 * whole element mean nothing: F(y -> T) is analytic but at the edges of T. */
#define NEAR 1.2

/* Standard errors that a stated error has, with Student's t of RAD_REPLICATES in mind. */
#define SIGMAS 5.5

/* Points that miss their share by less than this are kept: most others use less than theirs, and
 * the error that is stated is what they found. */
#define LEFT_TO_CELLS 10

enum {
  MOST_IN_CELLS = 50000, /* points of an element and a receiver in cells */
  BATCHES = 32,          /* of scattered points, before cells are cut */
  CHUNKS = 128,   /* of elements, each with its own sums: the same bits for any number of threads */
  LEAST_RULE = 2, /* points per direction where the bound alone is small enough */
  MORE = 2,       /* points more per direction of the second rule */
  PART_RULE = 5,  /* least points per direction on parts of an element */
  PART_MORE = 3,
  DEEPEST = 60,          /* halvings of an element */
  MOST_IN_PARTS = 400000 /* factors of an element and a receiver */
};

/* Everything that the chunks share. */
struct receive {
  const struct rad_weights *w;
  const struct rad_scene *to;
  int first, n_receiver; /* the receivers are to->triangle[first] .. */
  struct rad_receivers receivers;
  struct rad_pair_engine engine; /* of pairs that something may stand between */
  const double *tolerance;
  double *portion; /* owned [n_element] of the tolerance that an element may use up */
  double *value, *error, *variance; /* owned [CHUNKS, n_receiver, n_weight] */
};

/* Memory of one thread. */
struct worker {
  struct rad_scratch scratch;
  struct rad_cell_scratch *cells; /* owned */
  enum rad_code code;             /* the first error, and its text */
  struct rad_error error;
  struct rad_light scattered[BATCHES];
  int n_scattered;                       /* batches that are set */
  struct rad_light first, second, third; /* of the cell at hand, by rule */
  int64_t factors;
};

/* One receiver and the sums that its cells go to. */
struct receiver {
  int triangle;
  enum rad_sight sight;
  int is_cut;                       /* its plane cuts the element's triangle: F has a kink there */
  double *value, *error, *variance; /* [n_weight] */
};

/* ---- where F(y -> T) is smooth ----------------------------------------------------------------
 */

static double apart(const double a[3], const double b[3]) {
  double way[3];
  rad_sub(a, b, way);
  return rad_norm(way);
}

static double distance_to_segment(const double x[3], const double p[3], const double q[3]) {
  double along[3], way[3], rest[3];
  rad_sub(q, p, along);
  rad_sub(x, p, way);
  double s = fmin(fmax(rad_dot(way, along) / rad_dot(along, along), 0), 1);
  for (int d = 0; d < 3; d++)
    rest[d] = way[d] - s * along[d];
  return rad_norm(rest);
}

/* True if a corner of T is near to the cell; not if the cell touches it: there all looks the same
 * at every distance. */
static int corner_is_near(const struct rad_cell_shape *c, const struct rad_triangle *j, int corner,
                          double reach) {
  return c->vertex != j->vertex[corner] && apart(c->centre, j->v[corner]) < reach;
}

/* True if an edge of T is near to the cell. An edge in the plane of the sender, which T's plane
 * does not cut, is none: only its ends are. */
static int is_near(const struct rad_scene *s, const struct rad_cell_shape *c, int from, int to) {
  const struct rad_triangle *i = &s->triangle[from], *j = &s->triangle[to];
  double reach = NEAR * c->radius, height[3];
  rad_heights(i, j, height);
  for (int a = 0; a < 3; a++) {
    int b = (a + 1) % 3, touches = c->vertex == j->vertex[a] || c->vertex == j->vertex[b];
    if (height[a] == 0 && height[b] == 0) {
      if (corner_is_near(c, j, a, reach) || corner_is_near(c, j, b, reach))
        return 1;
    } else if (!(touches && c->vertex >= 0) &&
               distance_to_segment(c->centre, j->v[a], j->v[b]) < reach) {
      return 1;
    }
  }
  return 0;
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
  rad_point_factors(&r->receivers, &light->senders, to->triangle, to->sight, f, &w->scratch);
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

static void set_lights(const struct receive *r, const struct rad_light_cell *cell, int n, int more,
                       struct worker *w) {
  rad_light_set(r->w, cell, LEAST_RULE, &w->first);
  rad_light_set(r->w, cell, n, &w->second);
  rad_light_set(r->w, cell, n + more, &w->third);
}

/* Cell by cell, where scattered points have not been enough. */
static void by_cells(const struct receive *r, int element, const struct receiver *to, double share,
                     struct worker *w) {
  struct rad_light_at at = {r->w, element};
  double corner[2][3][3], tolerance[RAD_MAX_WEIGHT], value[RAD_MAX_WEIGHT], error[RAD_MAX_WEIGHT];
  int n = rad_light_triangles(r->w->mesh, element, corner);
  struct rad_cell_task task = {.source = w->third.senders.triangle,
                               .target = to->triangle,
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

/* Sums of every replicate over one more batch. */
static void add_batch(const struct receive *r, const struct rad_light *light,
                      const struct receiver *to, double (*sum)[RAD_REPLICATES], struct worker *w) {
  double f[RAD_MAX_SENDER];
  rad_point_factors(&r->receivers, &light->senders, to->triangle, to->sight, f, &w->scratch);
  w->factors += light->senders.n;
  for (int k = 0; k < r->w->n; k++)
    for (int q = 0; q < RAD_SCATTERED; q++)
      sum[k][q / RAD_EACH] += f[q] * light->flux[k][q];
}

/* Mean of the replicates and its variance, not below that of a feature that n points just miss. */
static void judge(const double sum[RAD_REPLICATES], int batches, double unshaded, double *value,
                  double *variance) {
  double mean = 0, square = 0, n = (double)batches * RAD_SCATTERED;
  for (int i = 0; i < RAD_REPLICATES; i++)
    mean += sum[i] / batches / RAD_REPLICATES;
  for (int i = 0; i < RAD_REPLICATES; i++)
    square += (sum[i] / batches - mean) * (sum[i] / batches - mean);
  *value = mean;
  *variance = square / (RAD_REPLICATES * (RAD_REPLICATES - 1.0)) + unshaded * unshaded / (n * n);
}

/* int |w_k| F dS without shadows. */
static void unshaded(const struct receive *r, const struct receiver *to, double *most,
                     struct worker *w) {
  double f[RAD_MAX_SENDER];
  rad_point_factors(&r->receivers, &w->third.senders, to->triangle, RAD_FREE, f, &w->scratch);
  for (int k = 0; k < r->w->n; k++) {
    most[k] = 0;
    for (int q = 0; q < w->third.senders.n; q++)
      most[k] += f[q] * fabs(w->third.flux[k][q]);
  }
}

/* Randomised points on the whole element; errors of elements are independent, so that variances add
 * up. 1 if that was good enough. */
static int by_points(const struct receive *r, const struct rad_light_cell *cell,
                     const struct receiver *to, double share, struct worker *w) {
  double sum[RAD_MAX_WEIGHT][RAD_REPLICATES] = {{0}}, most[RAD_MAX_WEIGHT];
  double value[RAD_MAX_WEIGHT], variance[RAD_MAX_WEIGHT];
  unshaded(r, to, most, w);
  for (int batch = 0; batch < BATCHES; batch++) {
    double spread[RAD_MAX_WEIGHT];
    if (batch == w->n_scattered)
      rad_light_scatter(r->w, cell, w->n_scattered++, &w->scattered[batch]);
    add_batch(r, &w->scattered[batch], to, sum, w);
    for (int k = 0; k < r->w->n; k++) {
      judge(sum[k], batch + 1, most[k], &value[k], &variance[k]);
      spread[k] = SIGMAS * sqrt(variance[k]);
    }
    if (!is_within(r, spread, batch < BATCHES - 1 ? share : LEFT_TO_CELLS * share))
      continue;
    for (int k = 0; k < r->w->n; k++) {
      to->value[k] += value[k];
      to->variance[k] += variance[k];
    }
    return 1;
  }
  return 0;
}

/* Two rules on a cell, whose lights are set; 1 if that was good enough, or the last that is done.
 */
static int by_rules(const struct receive *r, const struct rad_light_cell *cell,
                    const struct receiver *to, double share, int is_last, struct worker *w) {
  const struct rad_scene *scene = r->to;
  struct rad_cell_shape shape;
  double most[RAD_MAX_WEIGHT], low[RAD_MAX_WEIGHT], high[RAD_MAX_WEIGHT];
  rad_light_cell_shape(r->w->mesh, cell, &shape);
  double reach = w->third.area * largest_factor(&scene->triangle[to->triangle], &shape);
  for (int k = 0; k < r->w->n; k++)
    most[k] = w->third.most[k] * reach;
  if (is_last || is_within(r, most, share)) {
    apply(r, &w->first, to, low, w);
    add(r, low, most, to);
    return 1;
  }
  if (to->sight == RAD_PARTLY || to->is_cut ||
      is_near(scene, &shape, w->first.senders.triangle, to->triangle))
    return 0;
  apply(r, &w->second, to, low, w);
  apply(r, &w->third, to, high, w);
  for (int k = 0; k < r->w->n; k++)
    low[k] -= high[k];
  if (!is_within(r, low, share))
    return 0;
  add(r, high, low, to);
  return 1;
}

/* Halve a cell across its longer side. */
static void halve(const struct rad_mesh *mesh, const struct rad_light_cell *cell,
                  struct rad_light_cell child[2]) {
  struct rad_cell_shape s;
  rad_light_cell_shape(mesh, cell, &s);
  double wide = fmax(apart(s.corner[0], s.corner[1]), apart(s.corner[2], s.corner[3]));
  double high = fmax(apart(s.corner[0], s.corner[2]), apart(s.corner[1], s.corner[3]));
  for (int c = 0; c < 2; c++) {
    child[c] = *cell;
    double *side = wide > high ? child[c].sigma : child[c].tau;
    side[1 - c] = 0.5 * (side[0] + side[1]);
  }
}

/* A cell that sees all of the receiver, in halves, depth first. */
static void by_halves(const struct receive *r, const struct rad_light_cell *cell,
                      const struct receiver *to, double share, int depth, int64_t most,
                      struct worker *w) {
  struct rad_light_cell child[2];
  int n = rule_of(&r->w->mesh->element[cell->element]);
  halve(r->w->mesh, cell, child);
  for (int c = 0; c < 2 && !rad_stop_asked(); c++) {
    int is_last = depth == DEEPEST || w->factors > most;
    set_lights(r, &child[c], n > PART_RULE ? n : PART_RULE, PART_MORE, w);
    if (!by_rules(r, &child[c], to, 0.5 * share, is_last, w))
      by_halves(r, &child[c], to, 0.5 * share, depth + 1, most, w);
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

static void send(const struct receive *r, int chunk, int element, struct worker *w) {
  const struct rad_mesh *mesh = r->w->mesh;
  int n = r->to->n_triangle, from = rad_element_triangle(mesh, element);
  const unsigned char *sees = r->to->visibility->sight + (size_t)from * (size_t)n;
  struct rad_light_cell cell = rad_light_cell_whole(mesh, element);
  int rule = rule_of(&mesh->element[element]), is_stale = 1;
  w->n_scattered = 0;
  for (int t = r->first; t < n && !rad_stop_asked(); t++) {
    if (sees[t] == RAD_HIDDEN)
      continue;
    size_t at = ((size_t)chunk * (size_t)r->n_receiver + (size_t)(t - r->first)) * (size_t)r->w->n;
    int is_cut = rad_side_of(&r->to->triangle[t], &r->to->triangle[from]) == RAD_ACROSS;
    struct receiver to = {t, sees[t], is_cut, r->value + at, r->error + at, r->variance + at};
    double half = 0.5 * r->to->triangle[t].area, portion = r->portion[element];
    if (is_stale)
      set_lights(r, &cell, rule, MORE, w);
    is_stale = 0;
    if (by_rules(r, &cell, &to, half * portion, 0, w))
      continue;
    if (to.sight == RAD_FREE && !is_cut) {
      by_halves(r, &cell, &to, half * portion, 0, w->factors + MOST_IN_PARTS, w);
      is_stale = 1;
    } else if (to.sight == RAD_FREE || !by_points(r, &cell, &to, half * sqrt(portion), w)) {
      by_cells(r, element, &to, half * portion, w);
    }
  }
}

static void gather(struct receive *r, struct rad_received *out) {
  size_t n = (size_t)out->n_triangle * (size_t)out->n_weight;
  for (size_t c = 0; c < CHUNKS; c++)
    for (size_t i = 0; i < n; i++) {
      out->value[i] += r->value[c * n + i];
      out->error[i] += r->error[c * n + i];
      r->variance[i] += c ? r->variance[c * n + i] : 0;
    }
  for (size_t i = 0; i < n; i++)
    out->error[i] += SIGMAS * sqrt(r->variance[i]);
}

static void run(struct receive *r, struct worker *worker) {
  int n_element = r->w->mesh->n_element;
  struct rad_progress *progress = r->w->mesh->scene->progress;
  rad_progress_begin(progress, "elements", n_element);
#pragma omp parallel for schedule(dynamic) default(none) shared(r, worker, n_element, progress)
  for (int c = 0; c < CHUNKS; c++)
    for (int i = c; i < n_element; i += CHUNKS) {
      if (r->portion[i] > 0 && !rad_stop_asked())
        send(r, c, i, &worker[omp_get_thread_num()]);
      rad_progress_add(progress, 1);
    }
}

static enum rad_code begin(struct receive *r, struct rad_error *e) {
  size_t n = (size_t)r->n_receiver * (size_t)r->w->n;
  enum rad_code code = rad_receivers_begin(r->to, 1e-12, &r->receivers, e);
  if (!code)
    code = rad_pair_engine_init(r->to, &r->engine, e);
  if (code)
    return code;
  r->portion = rad_alloc((size_t)r->w->mesh->n_element, sizeof(double));
  r->value = rad_calloc(CHUNKS * n, sizeof(double));
  r->error = rad_calloc(CHUNKS * n, sizeof(double));
  r->variance = rad_calloc(CHUNKS * n, sizeof(double));
  return r->portion && r->value && r->error && r->variance
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
    share_out(&r, &worker[0].first, out->sent);
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
