#include "estimate/indicator.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "estimate/layout.h"
#include "visibility/visibility.h"

enum { CHECK = 5 }; /* check points per direction and element, odd */

/* Points with this part of the worst error tell how many elements share it. */
#define SPREAD_FROM 0.7

/* Everything that the steps of one estimate share. */
struct work {
  const unsigned char *passive; /* or NULL */
  const struct rad_mesh *mesh;
  const unsigned char *sees;
  int n_band;
  struct rad_mesh fine;
  struct rad_rules rules; /* of fine */
  double *d;              /* owned [n_band, n fine points] u* - u_h, over scale */
  double *star;           /* owned [n_band, n fine points] u* */
  struct rad_point_list check;
  int *place;                    /* owned [n check, 2]: triangle, base */
  double (*mu)[2];               /* owned [n check] */
  int *element;                  /* owned [n check] element of the check point; -1: a limit point */
  double *total, *largest, *sum; /* owned [n check] |rho K d|, largest part, sum of parts */
  double *part;                  /* owned [threads, n_element] */
  struct rad_indicator *x;
};

static int passive(const struct work *w, int element) {
  return w->passive && w->passive[rad_element_triangle(w->mesh, element)];
}

/* Black faces of thermal scenes have a net flux, though no unknowns. */
static int checked(const struct work *w, int element) {
  int t = rad_element_triangle(w->mesh, element);
  return !w->passive || !w->passive[t] ||
         (w->passive[t] == RAD_BLACK && w->mesh->scene->heat != NULL);
}

/* ---- u* and d at the fine points ----------------------------------------------------------- */

static struct rad_point_list all_points(const struct rad_mesh *mesh, int *triangle) {
  for (int t = 0; t < mesh->scene->n_triangle; t++)
    for (int p = mesh->point_first[t]; p < mesh->point_first[t + 1]; p++)
      triangle[p] = t;
  return (struct rad_point_list){mesh->n_point, triangle, mesh->point_base,
                                 (const double(*)[2])mesh->point_mu};
}

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

static enum rad_code set_star(struct work *w, const struct rad_rules *rules, const double *u,
                              struct rad_error *e) {
  size_t n = (size_t)w->fine.n_point, nb = (size_t)w->n_band;
  int *triangle = rad_alloc(n, sizeof(int));
  double *h = rad_alloc(n * nb, sizeof(double));
  w->star = rad_alloc(n * nb, sizeof(double));
  w->d = rad_alloc(n * nb, sizeof(double));
  enum rad_code code = RAD_OK;
  if (!triangle || !h || !w->star || !w->d)
    code = rad_fail_memory(e, "the error estimate", 24.0 * (double)(n * nb));
  if (!code) {
    struct rad_point_list list = all_points(&w->fine, triangle);
    code = rad_irradiance_at(w->mesh, rules, w->sees, &list, w->n_band, u, h, e);
  }
  const struct rad_scene *s = w->mesh->scene;
  for (size_t p = 0; p < n && !code; p++)
    for (size_t b = 0; b < nb; b++) {
      double rho = s->rho[(size_t)triangle[p] * nb + b];
      double *star = &w->star[b * n + p];
      *star = rad_emission(s, triangle[p], (int)b, w->fine.point_base[p], w->fine.point_mu[p]) +
              rho * h[p * nb + b];
      w->x->scale[b] = fmax(w->x->scale[b], fabs(*star));
    }
  free(triangle);
  free(h);
  return code;
}

static void set_difference(struct work *w, const double *u) {
  size_t n = (size_t)w->fine.n_point, nc = (size_t)w->mesh->n_point;
  for (int b = 0; b < w->n_band; b++)
    for (int i = 0; i < w->mesh->n_element; i++) {
      const struct rad_element *c = &w->mesh->element[i], *f = &w->fine.element[i];
      double value[RAD_GAUSS_MAX * RAD_GAUSS_MAX], scale = w->x->scale[b];
      interpolate(w->mesh, c, f, u + (size_t)b * nc + c->first, value);
      for (int q = 0; q < f->n_function; q++) {
        size_t at = (size_t)b * n + (size_t)(f->first + q);
        w->d[at] = passive(w, i) || scale == 0 ? 0 : (w->star[at] - value[q]) / scale;
        w->x->change = fmax(w->x->change, fabs(w->d[at]));
      }
    }
}

/* ---- how the modes of u* decay ------------------------------------------------------------- */

/* e^-rate per degree fitted to the last modes; modes at rounding level decay fast enough. */
static double decay(const double *mode, int n) {
  int from = n > 6 ? n - 6 : 1, count = 0;
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int m = from; m < n; m++) {
    double y = log(fmax(mode[m], 1e-16)), x = m;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
    count++;
  }
  double det = count * sxx - sx * sx;
  return det > 0 ? -(count * sxy - sx * sy) / det : 1;
}

/* Legendre modes of u* on one fine element: what lies beyond the coarse element's, and the decay.
 */
static void modes(struct work *w, int i) {
  const struct rad_element *c = &w->mesh->element[i], *f = &w->fine.element[i];
  const double *xp = rad_gauss_node(&w->fine.gauss, f->k_phi),
               *wp = rad_gauss_weight(&w->fine.gauss, f->k_phi);
  const double *xr = rad_gauss_node(&w->fine.gauss, f->k_r),
               *wr = rad_gauss_weight(&w->fine.gauss, f->k_r);
  double pp[RAD_GAUSS_MAX][RAD_GAUSS_MAX], pr[RAD_GAUSS_MAX][RAD_GAUSS_MAX];
  double mode_phi[RAD_GAUSS_MAX] = {0}, mode_r[RAD_GAUSS_MAX] = {0};
  for (int q = 0; q < f->k_phi; q++)
    rad_legendre(f->k_phi, xp[q], pp[q]);
  for (int q = 0; q < f->k_r; q++)
    rad_legendre(f->k_r, xr[q], pr[q]);
  for (int b = 0; b < w->n_band; b++) {
    if (w->x->scale[b] == 0)
      continue;
    const double *u = w->star + (size_t)b * (size_t)w->fine.n_point + f->first;
    for (int n = 0; n < f->k_r; n++)
      for (int m = 0; m < f->k_phi; m++) {
        double a = 0;
        for (int r = 0; r < f->k_r; r++)
          for (int q = 0; q < f->k_phi; q++)
            a += wp[q] * wr[r] * pp[q][m] * pr[r][n] * u[q + f->k_phi * r];
        a = fabs(a) * (2 * m + 1) * (2 * n + 1) / (4 * w->x->scale[b]);
        mode_phi[m] += a;
        mode_r[n] += a;
      }
  }
  for (int m = c->k_phi; m < f->k_phi; m++)
    w->x->tail_phi[i] += mode_phi[m];
  for (int n = c->k_r; n < f->k_r; n++)
    w->x->tail_r[i] += mode_r[n];
  w->x->rate_phi[i] = decay(mode_phi, f->k_phi);
  w->x->rate_r[i] = decay(mode_r, f->k_r);
}

/* ---- rho K d at the check points ------------------------------------------------------------ */

/* Position i of n in [lo, hi] of a variable with exponent p: from 1e-7 of the very edge inwards;
 * i == n is the limit at the edge. */
static double check_at(int i, int n, double lo, double hi, double p) {
  if (lo == 0 && (i == 0 || i == n))
    return i == n ? RAD_LIMIT : RAD_NEAREST;
  double s = lo + (hi - lo) * (0.002 + 0.996 * 0.5 * (1 - cos(M_PI * i / (n - 1))));
  return p == 1 ? s : pow(s, p);
}

static void free_checks(struct work *w) {
  free(w->place);
  free(w->mu);
  free(w->element);
  free(w->total);
  w->place = w->element = NULL;
  w->mu = NULL;
  w->total = NULL;
}

/* The check points of one pass: first every other one in each direction, then the rest. */
static enum rad_code set_checks(struct work *w, int rest, struct rad_error *e) {
  enum { N = CHECK, SIDE = CHECK + 1 };
  size_t most = (size_t)w->mesh->n_element * (SIDE * SIDE);
  free_checks(w);
  w->place = rad_alloc(2 * most, sizeof(int));
  w->mu = rad_alloc(most, sizeof *w->mu);
  w->element = rad_alloc(most, sizeof(int));
  w->total = rad_calloc(3 * most, sizeof(double));
  if (!w->place || !w->mu || !w->element || !w->total)
    return rad_fail_memory(e, "the check points", 50.0 * (double)most);
  w->largest = w->total + most;
  w->sum = w->largest + most;
  int *triangle = w->place, *base = w->place + most, at = 0;
  for (int i = 0; i < w->mesh->n_element; i++) {
    const struct rad_element *el = &w->mesh->element[i];
    const struct rad_patch *patch = &w->mesh->patch[el->patch];
    for (int q = 0; q < SIDE * SIDE && checked(w, i); q++) {
      int a = q % SIDE, c = q / SIDE, limit = a == N || c == N;
      int later = (a < N && a % 2) || (c < N && c % 2);
      if ((a == N && el->sigma[0] > 0) || (c == N && el->tau[0] > 0) ||
          (limit && patch->corner < 0))
        continue; /* no limit inside the triangle, or where positions are not relative to the edge
                   */
      if (later != rest || (limit && later))
        continue;
      double phi = check_at(a, N, el->sigma[0], el->sigma[1], el->p_phi);
      double r = check_at(c, N, el->tau[0], el->tau[1], el->p_r);
      triangle[at] = patch->triangle;
      base[at] = patch->base;
      rad_patch_mu(patch, phi, r, w->mu[at]);
      w->element[at++] = limit ? -1 : i;
    }
  }
  w->check = (struct rad_point_list){at, triangle, base, (const double(*)[2])w->mu};
  return RAD_OK;
}

/* rho of rho K d; 1 where E is a function, which nothing else would resolve for black faces; in
 * thermal scenes at least 1 - rho, the factor of h in the net flux (15.4). */
static double weight_of(const struct rad_scene *s, int triangle, int band) {
  double rho = s->emission_at ? 1 : s->rho[triangle * s->n_band + band];
  return s->heat ? fmax(rho, 1 - rho) : rho;
}

/* Parts of the elements at the points of one batch. */
static void add_parts(void *context, int thread, int first, int m, const double *row) {
  struct work *w = context;
  const struct rad_mesh *fine = &w->fine;
  int triangle = w->check.triangle[first], n_triangle = fine->scene->n_triangle;
  double *part = w->part + (size_t)thread * (size_t)fine->n_element;
  for (int i = 0; i < m; i++)
    for (int b = 0; b < w->n_band; b++) {
      double rho = weight_of(fine->scene, triangle, b), total = 0, sum = 0, largest = 0;
      const double *d = w->d + (size_t)b * (size_t)fine->n_point;
      for (int j = 0; j < n_triangle && rho > 0; j++) {
        if (!w->sees[(size_t)triangle * n_triangle + j])
          continue;
        int e = fine->element_first[fine->patch_first[j]];
        for (; e < fine->element_first[fine->patch_first[j + 1]]; e++) {
          const struct rad_element *el = &fine->element[e];
          double c = 0;
          for (int f = el->first; f < el->first + el->n_function; f++)
            c += row[(size_t)f * (size_t)m + (size_t)i] * d[f];
          c *= rho;
          total += c;
          sum += fabs(c);
          largest = fmax(largest, fabs(c));
          if (w->element[first + i] >= 0)
            part[e] = fmax(part[e], fabs(c));
        }
      }
      int at = first + i;
      if (!(fabs(total) <= w->total[at]) && !isnan(w->total[at])) { /* a NaN stays */
        w->total[at] = fabs(total);
        w->sum[at] = sum;
        w->largest[at] = largest;
      }
    }
}

static enum rad_code check(struct work *w, struct rad_error *e) {
  int n_thread = omp_get_max_threads(), n_element = w->mesh->n_element;
  free(w->part);
  w->part = rad_calloc((size_t)n_thread * (size_t)n_element, sizeof(double));
  if (!w->part)
    return rad_fail_memory(e, "the error estimate", 8.0 * n_thread * n_element);
  enum rad_code code = rad_visit_rows(&w->fine, &w->rules, w->sees, &w->check, add_parts, w, e);
  struct rad_indicator *x = w->x;
  for (int p = 0; p < w->mesh->n_patch; p++)
    x->limit = w->mesh->patch[p].corner < 0 ? INFINITY : x->limit;
  for (int t = 0; t < n_thread && !code; t++)
    for (int i = 0; i < n_element; i++)
      x->part[i] = fmax(x->part[i], w->part[(size_t)t * (size_t)n_element + (size_t)i]);
  for (int c = 0; c < w->check.n && !code; c++) {
    if (!isfinite(w->total[c]))
      return rad_fail_integral(w->mesh->scene, w->check.triangle[c], e);
    x->limit = fmax(x->limit, w->total[c]);
    if (w->element[c] < 0)
      continue;
    x->local[w->element[c]] = fmax(x->local[w->element[c]], w->total[c]);
    x->worst = fmax(x->worst, w->total[c]);
  }
  for (int c = 0; c < w->check.n && !code; c++)
    if (w->element[c] >= 0 && w->total[c] > SPREAD_FROM * x->worst)
      x->spread = fmax(x->spread, w->sum[c] / w->largest[c]);
  return code;
}

/* -------------------------------------------------------------------------------------------- */

static enum rad_code allocate(struct rad_indicator *x, int n_element, int n_band,
                              struct rad_error *e) {
  double **list[] = {&x->local, &x->part, &x->tail_phi, &x->tail_r, &x->rate_phi, &x->rate_r};
  int failed = !(x->scale = rad_calloc((size_t)n_band, sizeof(double)));
  for (int i = 0; i < 6; i++)
    failed |= !(*list[i] = rad_calloc((size_t)n_element, sizeof(double)));
  return failed ? rad_fail_memory(e, "the error estimate", 48.0 * n_element) : RAD_OK;
}

double rad_indicator_scale(const struct rad_indicator *x, int n_band) {
  double most = 0;
  for (int b = 0; b < n_band; b++)
    most = fmax(most, x->scale[b]);
  return most;
}

void rad_indicator_free(struct rad_indicator *x) {
  free(x->scale);
  free(x->local);
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
  enum rad_code code = rad_mesh_begin(m->scene, NULL, &w->fine, e);
  for (int p = 0; p < m->n_patch && !code; p++) {
    rad_mesh_add_patch(&w->fine, &m->patch[p]);
    for (int i = m->element_first[p]; i < m->element_first[p + 1]; i++) {
      struct rad_element el = m->element[i];
      int more = passive(w, i)                           ? 0
                 : shaded(w, rad_element_triangle(m, i)) ? RAD_MORE_SHADED
                                                         : RAD_MORE;
      el.k_phi += more;
      el.k_r += more;
      rad_mesh_add_element(&w->fine, el);
    }
  }
  return code ? code : rad_mesh_finish(&w->fine, e);
}

enum rad_code rad_indicate(const struct rad_mesh *mesh, const struct rad_rules *rules,
                           const unsigned char *sees, const unsigned char *passive, const double *u,
                           double enough, struct rad_indicator *x, struct rad_error *e) {
  *x = (struct rad_indicator){0};
  struct work w = {
      .passive = passive, .mesh = mesh, .sees = sees, .n_band = mesh->scene->n_band, .x = x};
  enum rad_code code = allocate(x, mesh->n_element, w.n_band, e);
  if (!code)
    code = finer_mesh(&w, e);
  if (!code)
    code = rad_rules_build(&w.fine, rules->tolerance, &w.rules, e);
  if (!code)
    code = set_star(&w, rules, u, e);
  if (!code) {
    set_difference(&w, u);
    for (int i = 0; i < mesh->n_element; i++)
      modes(&w, i);
  }
  x->spread = 1;
  for (int rest = 0; rest < 2 && !code && x->worst <= enough; rest++) {
    code = set_checks(&w, rest, e);
    if (!code)
      code = check(&w, e);
  }
  rad_rules_free(&w.rules);
  rad_mesh_free(&w.fine);
  free(w.d);
  free(w.star);
  free_checks(&w);
  free(w.part);
  return code;
}
