#include "estimate/indicator.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "estimate/checks.h"
#include "estimate/iterate.h"
#include "estimate/layout.h"
#include "estimate/modes.h"
#include "visibility/visibility.h"

/* Points with this part of the worst error tell how many elements share it. */
#define SPREAD_FROM 0.7

/* Largest tolerance of K d. */
#define COARSEST 1e-4

/* Everything that the steps of one estimate share. */
struct work {
  const unsigned char *passive; /* or NULL */
  const struct rad_mesh *mesh;
  const unsigned char *sees;
  int n_band;
  struct rad_rules rules; /* of x->fine, to the tolerance that K d needs */
  double *d;           /* owned [2 n_band, n fine points] u* - u_h, over scale; then the same with
                          the signs of its elements' integrals */
  double *integral;    /* owned [n_band, n_element] of d over each element */
  double *weight;      /* owned [n_triangle, n_band] of K d, rho mostly */
  const double *least; /* [n_triangle, n_band] or NULL: what the caller wants */
  double *wanted;      /* owned [n_triangle, n_band] the larger of both */
  unsigned char *checked; /* owned [n_triangle] light may arrive there */
  struct rad_once once;   /* K d */
  struct rad_checks checks;
  struct rad_indicator *x;
};

static int passive(const struct work *w, int element) {
  return w->passive && w->passive[rad_element_triangle(w->mesh, element)];
}

/* Black faces have an irradiance, though no unknowns. */
static int receives(const struct work *w, int triangle) {
  return !w->passive || !w->passive[triangle] || w->passive[triangle] == RAD_BLACK;
}

/* In thermal scenes they have a net flux as well, which is to meet the tolerance at every point. */
static int matters(const struct work *w, int triangle) {
  return !w->passive || !w->passive[triangle] ||
         (w->passive[triangle] == RAD_BLACK && w->mesh->scene->heat != NULL);
}

/* ---- u* and d at the fine points ----------------------------------------------------------- */

/* Values of u_h of element e at the fine element's points: tensor interpolation. */
static void interpolate(const struct rad_mesh *mesh, const struct rad_element *e,
                        const struct rad_element *f, const double *u, double *value) {
  double lp[RAD_GAUSS_MAX][RAD_GAUSS_MAX], lr[RAD_GAUSS_MAX][RAD_GAUSS_MAX];
  for (int i = 0; i < f->k_phi; i++)
    rad_lagrange(&mesh->nodes, e->k_phi, rad_gauss_node(&mesh->gauss, f->k_phi)[i], lp[i]);
  for (int j = 0; j < f->k_r; j++)
    rad_lagrange(&mesh->nodes, e->k_r, rad_gauss_node(&mesh->gauss, f->k_r)[j], lr[j]);
  for (int j = 0; j < f->k_r; j++)
    for (int i = 0; i < f->k_phi; i++) {
      double sum = 0;
      for (int c = 0; c < e->k_r; c++)
        for (int a = 0; a < e->k_phi; a++)
          sum += u[a + e->k_phi * c] * lp[i][a] * lr[j][c];
      value[i + f->k_phi * j] = sum;
    }
}

/* star = K u_h at the fine points, but on passive triangles. */
static enum rad_code integrate_star(struct work *w, const struct rad_rules *rules, const double *u,
                                    struct rad_error *e) {
  size_t n_element = (size_t)w->mesh->n_element;
  int *first = rad_alloc(2 * n_element, sizeof(int)), *count = first + n_element;
  if (!first)
    return rad_fail_memory(e, "the error estimate", 8.0 * (double)n_element);
  for (int i = 0; i < w->mesh->n_element; i++) {
    first[i] = w->x->fine.element[i].first;
    count[i] = passive(w, i) ? 0 : w->x->fine.element[i].n_function;
  }
  struct rad_element_points points = {first, count, w->x->fine.point_base,
                                      (const double(*)[2])w->x->fine.point_mu};
  enum rad_code code =
      rad_irradiance_on(w->mesh, rules, &points, w->x->fine.n_point, w->n_band, u, w->x->star, e);
  free(first);
  return code;
}

static enum rad_code set_star(struct work *w, const struct rad_rules *rules, const double *u,
                              struct rad_error *e) {
  const struct rad_mesh *fine = &w->x->fine;
  const struct rad_scene *s = fine->scene;
  size_t n = (size_t)fine->n_point, nb = (size_t)w->n_band;
  w->x->star = rad_calloc(n * nb, sizeof(double));
  w->d = rad_alloc(2 * n * nb, sizeof(double));
  if (!w->x->star || !w->d)
    return rad_fail_memory(e, "the error estimate", 24.0 * (double)(n * nb));
  enum rad_code code = integrate_star(w, rules, u, e);
  for (int t = 0; t < s->n_triangle && !code; t++)
    for (int p = fine->point_first[t]; p < fine->point_first[t + 1]; p++)
      for (size_t b = 0; b < nb; b++) {
        double *star = &w->x->star[b * n + (size_t)p];
        *star = rad_emission(s, t, (int)b, fine->point_base[p], fine->point_mu[p]) +
                s->rho[(size_t)t * nb + b] * *star;
        w->x->scale[b] = fmax(w->x->scale[b], fabs(*star));
      }
  return code;
}

static void set_difference(struct work *w, const double *u) {
  size_t n = (size_t)w->x->fine.n_point, nc = (size_t)w->mesh->n_point;
  for (int b = 0; b < w->n_band; b++)
    for (int i = 0; i < w->mesh->n_element; i++) {
      const struct rad_element *c = &w->mesh->element[i], *f = &w->x->fine.element[i];
      double value[RAD_GAUSS_MAX * RAD_GAUSS_MAX], scale = w->x->scale[b];
      interpolate(w->mesh, c, f, u + (size_t)b * nc + c->first, value);
      for (int q = 0; q < f->n_function; q++) {
        size_t at = (size_t)b * n + (size_t)(f->first + q);
        w->d[at] = passive(w, i) || scale == 0 ? 0 : (w->x->star[at] - value[q]) / scale;
        w->x->change = fmax(w->x->change, fabs(w->d[at]));
      }
    }
}

/* ---- rho K d at the check points ------------------------------------------------------------ */

/* int of the Lagrange polynomials of one direction, with its Jacobian. */
static void panel_integrals(const struct rad_panel *panel, double *integral) {
  int n = rad_order[RAD_N_ORDER - 1];
  const double *weight = panel->weight[RAD_N_ORDER - 1];
  for (int a = 0; a < panel->k; a++) {
    integral[a] = 0;
    for (int q = 0; q < n; q++)
      integral[a] += weight[a * n + q];
  }
}

/* The integrals of d over the elements, and d with their signs. */
static void set_integrals(struct work *w) {
  size_t n = (size_t)w->x->fine.n_point, n_element = (size_t)w->mesh->n_element;
  for (int i = 0; i < w->mesh->n_element; i++) {
    const struct rad_element *f = &w->x->fine.element[i];
    const struct rad_patch *patch = &w->x->fine.patch[f->patch];
    double phi[RAD_GAUSS_MAX], r[RAD_GAUSS_MAX];
    panel_integrals(&w->rules.panel[w->rules.angular[i]], phi);
    panel_integrals(&w->rules.panel[w->rules.radial[i]], r);
    for (size_t b = 0; b < (size_t)w->n_band; b++) {
      double *d = w->d + b * n + f->first, sum = 0;
      double *with_sign = d + (size_t)w->n_band * n;
      for (int q = 0; q < f->n_function; q++)
        sum += d[q] * phi[q % f->k_phi] * r[q / f->k_phi];
      for (int q = 0; q < f->n_function; q++)
        with_sign[q] = sum < 0 ? -d[q] : d[q];
      w->integral[b * n_element + (size_t)i] = sum * patch->a1 * patch->b2;
    }
  }
}

/* rho of rho K d, 0 where nothing is checked; 1 where E is a function, which nothing else would
 * resolve for black faces; in thermal scenes at least 1 - rho, the factor of h in the net flux
 * (15.4). */
static void set_weights(struct work *w) {
  const struct rad_scene *s = w->mesh->scene;
  for (int i = 0; i < s->n_triangle * s->n_band; i++) {
    double rho = s->emission_at ? 1 : s->rho[i];
    w->weight[i] = !matters(w, i / s->n_band) ? 0 : s->heat ? fmax(rho, 1 - rho) : rho;
    w->wanted[i] =
        w->least && receives(w, i / s->n_band) ? fmax(w->weight[i], w->least[i]) : w->weight[i];
    w->checked[i / s->n_band] = (unsigned char)receives(w, i / s->n_band);
  }
}

/* K is wanted no better than d is small: errors of K d are to be like those of u*. */
static enum rad_code begin_checks(struct work *w, double tolerance, struct rad_error *e) {
  size_t n_element = (size_t)w->mesh->n_element, nb = (size_t)w->n_band;
  const double *in[2 * RAD_MAX_BAND];
  double loose = fmax(tolerance, fmin(tolerance / fmax(w->x->change, 1e-300), COARSEST));
  w->integral = rad_alloc(n_element * nb, sizeof(double));
  w->weight = rad_alloc((size_t)w->mesh->scene->n_triangle * nb, sizeof(double));
  w->wanted = rad_alloc((size_t)w->mesh->scene->n_triangle * nb, sizeof(double));
  w->checked = rad_alloc((size_t)w->mesh->scene->n_triangle, 1);
  if (!w->integral || !w->weight || !w->wanted || !w->checked)
    return rad_fail_memory(e, "the error estimate", 8.0 * (double)(n_element * nb));
  enum rad_code code = rad_rules_build(&w->x->fine, loose, &w->rules, e);
  if (code)
    return code;
  set_weights(w);
  set_integrals(w);
  for (size_t b = 0; b < 2 * nb; b++)
    in[b] = w->d + b * (size_t)w->x->fine.n_point;
  code = rad_once_begin(&w->x->fine, &w->rules, RAD_ONCE_LEAF, loose, &w->once, e);
  return code ? code : rad_once_gather(&w->once, 2 * w->n_band, in, e);
}

/* The largest |K d| of each band at a check point of an element, to [n_element, n_band]. */
static void keep_received(const struct work *w, int element, int point, double *to) {
  for (int b = 0; b < w->n_band; b++) {
    double one = fabs(w->checks.total[(size_t)b * (size_t)w->checks.n + (size_t)point]);
    double *most = &to[(size_t)element * (size_t)w->n_band + (size_t)b];
    *most = fmax(*most, one);
  }
}

/* |rho K d| of a check point in the band where it is largest; *at: where its numbers are. */
static double worst_band(const struct work *w, const double *weight, int triangle, int point,
                         size_t *at) {
  double most = 0;
  *at = (size_t)point;
  for (int b = 0; b < w->n_band; b++) {
    size_t here = (size_t)b * (size_t)w->checks.n + (size_t)point;
    double one = weight[triangle * w->n_band + b] * fabs(w->checks.total[here]);
    if (one > most || isnan(one)) {
      most = one;
      *at = here;
    }
  }
  return most;
}

/* What the points of a pass found. */
static enum rad_code gather(struct work *w, struct rad_error *e) {
  const struct rad_checks *c = &w->checks;
  struct rad_indicator *x = w->x;
  size_t at;
  int n_element = w->mesh->n_element, n_thread = omp_get_max_threads();
  for (int p = 0; p < w->mesh->n_patch; p++)
    x->limit = w->mesh->patch[p].corner < 0 ? INFINITY : x->limit;
  for (int i = 0; i < n_element; i++) {
    int triangle = rad_element_triangle(w->mesh, i);
    for (int t = 0; t < n_thread; t++)
      x->part[i] = fmax(x->part[i], c->part[(size_t)t * (size_t)n_element + (size_t)i]);
    for (int q = c->first[i]; q < c->first[i] + c->count[i]; q++) {
      double one = worst_band(w, w->weight, triangle, q, &at);
      if (!isfinite(one))
        return rad_fail_integral(w->mesh->scene, triangle, e);
      x->limit = fmax(x->limit, one);
      x->local_limit[i] = fmax(x->local_limit[i], one);
      keep_received(w, i, q, x->received_limit);
      if (c->limit[q])
        continue;
      keep_received(w, i, q, x->received);
      x->local[i] = fmax(x->local[i], one);
      x->worst = fmax(x->worst, one);
      x->wanted = fmax(x->wanted, worst_band(w, w->wanted, triangle, q, &at));
    }
  }
  for (int i = 0; i < n_element; i++)
    for (int q = c->first[i]; q < c->first[i] + c->count[i]; q++)
      if (!c->limit[q] && worst_band(w, w->wanted, rad_element_triangle(w->mesh, i), q, &at) >
                              SPREAD_FROM * x->wanted)
        x->spread = fmax(x->spread, c->sum[at] / c->largest[at]);
  return RAD_OK;
}

static enum rad_code check(struct work *w, int rest, struct rad_error *e) {
  rad_checks_free(&w->checks);
  enum rad_code code = rad_checks_set(w->mesh, w->checked, rest, &w->checks, e);
  if (!code)
    code = rad_checks_run(&w->once, w->integral, w->wanted, &w->checks, e);
  return code ? code : gather(w, e);
}

/* ---- d between the samples ------------------------------------------------------------------- */

static enum rad_code look_below(struct work *w, const struct rad_rules *rules, const double *u,
                                struct rad_error *e) {
  struct rad_indicator *x = w->x;
  enum rad_code code = rad_feet_find(w->mesh, w->sees, w->passive, &x->feet, e);
  if (!code)
    code = rad_feet_gaps(w->mesh, &w->x->fine, rules, u, w->x->star, w->d, x->scale, w->wanted,
                         &x->feet, x->unseen_received, e);
  for (int i = 0; i < w->mesh->scene->n_triangle * w->n_band; i++) {
    double *unseen = &x->unseen[i / w->n_band];
    *unseen = fmax(*unseen, w->weight[i] * x->unseen_received[i]);
    x->worst_unseen = fmax(x->worst_unseen, *unseen);
    x->wanted_unseen = fmax(x->wanted_unseen, w->wanted[i] * x->unseen_received[i]);
  }
  return code;
}

/* -------------------------------------------------------------------------------------------- */

static enum rad_code allocate(struct rad_indicator *x, int n_element, int n_triangle, int n_band,
                              struct rad_error *e) {
  double **list[] = {&x->local,  &x->local_limit, &x->part,  &x->tail_phi,
                     &x->tail_r, &x->rate_phi,    &x->rate_r};
  int failed = !(x->scale = rad_calloc((size_t)n_band, sizeof(double)));
  failed |= !(x->unseen = rad_calloc((size_t)n_triangle, sizeof(double)));
  failed |= !(x->unseen_received = rad_calloc((size_t)n_triangle * (size_t)n_band, sizeof(double)));
  failed |= !(x->received = rad_calloc((size_t)n_element * (size_t)n_band, sizeof(double)));
  failed |= !(x->received_limit = rad_calloc((size_t)n_element * (size_t)n_band, sizeof(double)));
  for (int i = 0; i < 7; i++)
    failed |= !(*list[i] = rad_calloc((size_t)n_element, sizeof(double)));
  return failed ? rad_fail_memory(e, "the error estimate", 56.0 * n_element) : RAD_OK;
}

double rad_indicator_scale(const struct rad_indicator *x, int n_band) {
  double most = 0;
  for (int b = 0; b < n_band; b++)
    most = fmax(most, x->scale[b]);
  return most;
}

void rad_indicator_free(struct rad_indicator *x) {
  rad_feet_free(&x->feet);
  rad_mesh_free(&x->fine);
  free(x->star);
  free(x->received);
  free(x->received_limit);
  free(x->unseen_received);
  free(x->unseen);
  free(x->scale);
  free(x->local);
  free(x->local_limit);
  free(x->part);
  free(x->tail_phi);
  free(x->tail_r);
  free(x->rate_phi);
  free(x->rate_r);
  *x = (struct rad_indicator){0};
}

/* True if something may stand between the triangle and another. */
static int shaded(const struct work *w, int triangle) {
  int n = w->mesh->scene->n_triangle;
  return memchr(w->sees + (size_t)triangle * (size_t)n, RAD_PARTLY, (size_t)n) != NULL;
}

/* The mesh with more points in each direction of every element that has unknowns. */
static enum rad_code finer_mesh(struct work *w, struct rad_error *e) {
  const struct rad_mesh *m = w->mesh;
  enum rad_code code = rad_mesh_begin(m->scene, NULL, &w->x->fine, e);
  for (int p = 0; p < m->n_patch && !code; p++) {
    rad_mesh_add_patch(&w->x->fine, &m->patch[p]);
    for (int i = m->element_first[p]; i < m->element_first[p + 1]; i++) {
      struct rad_element el = m->element[i];
      int more = passive(w, i)                           ? 0
                 : shaded(w, rad_element_triangle(m, i)) ? RAD_MORE_SHADED
                                                         : RAD_MORE;
      el.k_phi += more;
      el.k_r += more;
      rad_mesh_add_element(&w->x->fine, el);
    }
  }
  return code ? code : rad_mesh_finish(&w->x->fine, e);
}

/* Points of the finer mesh, at most. */
static double count_fine(const struct rad_mesh *mesh) {
  double fine = 0;
  int more = mesh->scene->visibility->n_partly > 0 ? RAD_MORE_SHADED : RAD_MORE;
  for (int i = 0; i < mesh->n_element; i++)
    fine += (mesh->element[i].k_phi + more) * (double)(mesh->element[i].k_r + more);
  return fine;
}

double rad_indicate_points(const struct rad_mesh *mesh) {
  return count_fine(mesh) + (double)RAD_CHECKS * mesh->n_element;
}

double rad_indicate_bytes(const struct rad_mesh *mesh, double tolerance) {
  struct rad_interpolation star, d;
  double fine = count_fine(mesh), nb = mesh->scene->n_band, elements = mesh->n_element;
  rad_interpolation_init(&star, tolerance);
  rad_interpolation_init(&d, fmax(tolerance, COARSEST));
  double vectors = fine * (24 * nb + 20), checks = elements * RAD_CHECKS * (32 * nb + 30);
  double clusters =
      2 * fmin(elements, 2 * fine / RAD_ONCE_LEAF); /* leaves are at least half full */
  return vectors + checks + clusters * 16 * nb * fmax(star.n, 2 * d.n);
}

static void free_work(struct work *w) {
  rad_once_free(&w->once);
  rad_checks_free(&w->checks);
  rad_rules_free(&w->rules);
  free(w->d);
  free(w->checked);
  free(w->integral);
  free(w->weight);
  free(w->wanted);
}

enum rad_code rad_indicate(const struct rad_mesh *mesh, const struct rad_rules *rules,
                           const unsigned char *passive, const double *wanted, const double *u,
                           double enough, struct rad_indicator *x, struct rad_error *e) {
  *x = (struct rad_indicator){0};
  struct work w = {.passive = passive,
                   .mesh = mesh,
                   .sees = mesh->scene->visibility->sight,
                   .least = wanted,
                   .n_band = mesh->scene->n_band,
                   .x = x};
  enum rad_code code = allocate(x, mesh->n_element, mesh->scene->n_triangle, w.n_band, e);
  if (!code)
    code = finer_mesh(&w, e);
  if (!code)
    code = set_star(&w, rules, u, e);
  if (!code) {
    set_difference(&w, u);
    for (int i = 0; i < mesh->n_element; i++)
      rad_modes(&x->fine, i, &mesh->element[i], w.n_band, x->star, x->scale,
                (struct rad_modes){&x->tail_phi[i], &x->tail_r[i], &x->rate_phi[i], &x->rate_r[i]});
  }
  if (code || rad_indicator_scale(x, w.n_band) == 0) { /* no light: nothing is left out */
    free_work(&w);
    x->spread = 1;
    return code;
  }
  code = begin_checks(&w, rules->tolerance, e);
  if (!code)
    code = look_below(&w, rules, u, e);
  x->spread = 1;
  for (int rest = 0; rest < 2 && !code && x->wanted <= enough; rest++)
    code = check(&w, rest, e);
  free_work(&w);
  return code;
}
