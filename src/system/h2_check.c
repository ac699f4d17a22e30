#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "base/scramble.h"
#include "base/stop.h"
#include "system/h2.h"
#include "system/h2_near.h"
#include "visibility/visibility.h"

enum {
  GROUPS = 16, /* sampled rows: that many groups of neighbours */
  ROWS = 16,
  PIECES = 256 /* elements at a time */
};

/* Vector v of the check at an unknown: 1; waves of three directions; signs of points, of leaves. */
static double probe(const struct rad_h2 *h, int v, int unknown, int leaf) {
  if (v == 0)
    return 1;
  if (v < 4) {
    double x[3], phase = 0, wave = 6.0 * v / h->mesh->scene->size;
    rad_point_position(h->mesh, unknown, x);
    for (int d = 0; d < 3; d++)
      phase += wave * (rad_scramble_unit((uint64_t)(10 * v + d)) - 0.5) * 2 * x[d];
    return cos(phase);
  }
  uint64_t key = (uint64_t)(v < 6 ? unknown : leaf);
  return rad_scramble_unit(key + ((uint64_t)v << 40)) < 0.5 ? -1 : 1;
}

static void set_probes(const struct rad_h2 *h, double *z) {
  for (int c = 0; c < h->tree.n_cluster; c++)
    for (int i = 0; h->tree.cluster[c].child < 0 && i < h->tree.cluster[c].n; i++) {
      int unknown = h->tree.unknown[h->tree.cluster[c].first + i];
      for (int v = 0; v < RAD_MOST_VECTORS; v++)
        z[(size_t)v * (size_t)h->mesh->n_point + (size_t)unknown] = probe(h, v, unknown, c);
    }
}

/* Neighbouring rows of one triangle. */
struct group {
  int triangle, n, point[ROWS], base[ROWS];
  double mu[ROWS][2];
};

static void set_group(const struct rad_h2 *h, int number, struct group *g) {
  int n = h->mesh->n_point, at = (int)(rad_scramble_unit((uint64_t)number + 12345) * n);
  int t = g->triangle = rad_point_triangle(h->mesh, h->tree.unknown[at]);
  int end = h->mesh->point_first[t + 1];
  g->n = end - at < ROWS ? end - at : ROWS;
  for (int i = 0; i < g->n; i++) {
    g->point[i] = h->tree.unknown[at + i];
    g->base[i] = h->mesh->point_base[g->point[i]];
    memcpy(g->mu[i], h->mesh->point_mu[g->point[i]], sizeof g->mu[i]);
  }
}

/* sum[v, i] += k[i, column] z_v of that column's unknown, for some elements of a patch. */
static void add_pieces(const struct rad_h2 *h, const struct group *g, int from, int n,
                       const double *k, const double *z, double sum[][ROWS]) {
  int column = 0;
  for (int e = from; e < from + n; e++)
    for (int f = 0; f < h->mesh->element[e].n_function; f++, column++)
      for (int v = 0; v < RAD_MOST_VECTORS; v++) {
        double one =
            z[(size_t)v * (size_t)h->mesh->n_point + (size_t)(h->mesh->element[e].first + f)];
        for (int i = 0; i < g->n; i++)
          sum[v][i] += k[g->n * column + i] * one;
      }
}

/* The rows of a group over one source triangle, times the probes; 0 without memory. */
static int multiply_rows(const struct rad_h2 *h, const struct rad_rules *rules,
                         const struct group *g, int source, const double *z,
                         struct rad_scratch *scratch, double sum[][ROWS]) {
  const struct rad_mesh *mesh = h->mesh;
  struct rad_targets targets = {g->triangle, g->n, g->base, (const double(*)[2])g->mu, NULL};
  for (int p = mesh->patch_first[source]; p < mesh->patch_first[source + 1]; p++)
    for (int from = mesh->element_first[p], n; from < mesh->element_first[p + 1]; from += n) {
      int element[PIECES];
      int64_t column[PIECES], total = 0;
      for (n = 0; n < PIECES && from + n < mesh->element_first[p + 1]; n++) {
        element[n] = from + n;
        column[n] = total;
        total += mesh->element[from + n].n_function;
      }
      double *k = rad_alloc((size_t)total * (size_t)g->n, sizeof(double));
      if (!k)
        return 0;
      rad_element_list_block(mesh, rules, &targets, n, element, column, k, g->n, scratch);
      add_pieces(h, g, from, n, k, z, sum);
      free(k);
    }
  return 1;
}

/* Everything the check holds. */
struct check {
  struct group group[GROUPS];
  double *z, *y;                         /* owned [RAD_MOST_VECTORS, n] probes, K_H times them */
  double (*sum)[RAD_MOST_VECTORS][ROWS]; /* owned [GROUPS, n_triangle] */
  struct rad_scratch *scratch;           /* owned [threads] */
};

static int sample_rows(const struct rad_h2 *h, const struct rad_rules *rules, struct check *c) {
  int n = h->mesh->scene->n_triangle, failed = 0;
  const unsigned char *sees = h->mesh->scene->visibility->sight;
  struct rad_progress *progress = h->mesh->scene->progress;
  rad_progress_begin(progress, "pairs checked", (int64_t)GROUPS * n);
#pragma omp parallel for schedule(dynamic) default(none) shared(h, rules, c, n, sees, progress)    \
    reduction(| : failed)
  for (int task = 0; task < GROUPS * n; task++) {
    const struct group *g = &c->group[task / n];
    if (sees[(size_t)g->triangle * (size_t)n + (size_t)(task % n)] && !rad_stop_asked())
      failed |= !multiply_rows(h, rules, g, task % n, c->z, &c->scratch[omp_get_thread_num()],
                               c->sum[task]);
    rad_progress_add(progress, 1);
  }
  return !failed;
}

static void compare(struct rad_h2 *h, const struct check *c) {
  int n = h->mesh->scene->n_triangle;
  h->error = 0;
  for (int g = 0; g < GROUPS; g++)
    for (int v = 0; v < RAD_MOST_VECTORS; v++)
      for (int i = 0; i < c->group[g].n; i++) {
        double exact = 0;
        for (int t = 0; t < n; t++)
          exact += c->sum[g * n + t][v][i];
        size_t at = (size_t)v * (size_t)h->mesh->n_point + (size_t)c->group[g].point[i];
        h->error = fmax(h->error, fabs(exact - c->y[at]));
      }
}

enum rad_code rad_h2_check(struct rad_h2 *h, const struct rad_rules *rules, struct rad_error *e) {
  size_t n = (size_t)h->mesh->n_point, n_triangle = (size_t)h->mesh->scene->n_triangle;
  int n_thread = omp_get_max_threads();
  struct check c = {.z = rad_alloc(n * RAD_MOST_VECTORS, sizeof(double)),
                    .y = rad_alloc(n * RAD_MOST_VECTORS, sizeof(double)),
                    .sum = rad_calloc(GROUPS * n_triangle, sizeof *c.sum),
                    .scratch = rad_scratch_make(h->mesh, n_thread, e)};
  double start = rad_seconds();
  enum rad_code code = c.scratch ? RAD_OK : RAD_ESYSTEM;
  if (!code && (!c.z || !c.y || !c.sum))
    code = rad_fail_memory(e, "the check of the matrix", 128.0 * (double)n);
  if (!code) {
    const double *in[RAD_MOST_VECTORS];
    double *out[RAD_MOST_VECTORS];
    for (size_t v = 0; v < RAD_MOST_VECTORS; v++) {
      in[v] = c.z + v * n;
      out[v] = c.y + v * n;
    }
    set_probes(h, c.z);
    for (int g = 0; g < GROUPS; g++)
      set_group(h, g, &c.group[g]);
    rad_h2_apply(h, RAD_MOST_VECTORS, in, out);
    if (!sample_rows(h, rules, &c))
      code = rad_fail_memory(e, "the check of the matrix", 0);
    else if (rad_stop_asked())
      code = rad_fail_stopped(e);
    else
      compare(h, &c);
  }
  if (c.scratch && rad_scratch_end(c.scratch, n_thread, NULL, e))
    code = code ? code : e->code;
  h->seconds_check = rad_seconds() - start;
  free(c.z);
  free(c.y);
  free(c.sum);
  return code;
}
