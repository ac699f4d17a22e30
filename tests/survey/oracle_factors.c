// View factors between surfaces: outer points in scrambled
// Sobol sequences on the smaller face of a pair, the inner integral closed; or rays, which share
// nothing with it.
#include "oracle.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static struct oracle_sums new_sums(const struct oracle_scene *s, int replicates) {
  const size_t n = (size_t)s->surfaces;
  return (struct oracle_sums){
      .exchange = oracle_new(replicates * n * n, sizeof(double)),
      .seen = oracle_new((size_t)s->faces * s->faces, sizeof(double)),
      .missed_exchange = oracle_new(n * n, sizeof(double)),
  };
}

void oracle_free_sums(struct oracle_sums *q) {
  free(q->exchange);
  free(q->seen);
  free(q->missed_exchange);
}

// The outer integral of a pair runs over the smaller face.
static bool outer(const struct oracle_scene *s, int a, int t) {
  const double x = s->face[a].area, y = s->face[t].area;
  return (x < y || (x == y && a < t)) && oracle_facing(s, a, t);
}

// A_a F_at, both ways, to the sums of one replicate or to what may be missed.
static void add_pair(const struct oracle_scene *s, double *to, int a, int t, double exchange) {
  const size_t n = (size_t)s->surfaces, i = (size_t)s->face[a].surface,
               j = (size_t)s->face[t].surface;
  to[i * n + j] += exchange;
  to[j * n + i] += exchange;
}

struct row {
  bool *wanted; // faces that a is the outer one of
  double *sum;  // [replicates, faces]
  int *hits;    // points that see something of a face
};

// Sums over points first..last of face a, for each replicate and wanted face.
static void add_points(struct oracle_scene *s, const struct oracle_settings *o, int a,
                       uint32_t first, uint32_t last, struct row *w) {
  for (int r = 0; r < o->replicates; r++) {
    const uint64_t seed = oracle_hash(o->seed * 1000003 + (uint64_t)r * 65537 + (uint64_t)a);
    for (uint32_t k = first; k < last; k++) {
      const struct vec x =
          oracle_point(&s->face[a], oracle_sobol(k, 0, seed), oracle_sobol(k, 1, seed));
      for (int t = 0; t < s->faces; t++) {
        const double f = w->wanted[t] ? oracle_seen(s, a, x, t) : 0;
        w->sum[(size_t)r * s->faces + t] += f;
        w->hits[t] += f > 0;
      }
    }
  }
}

// The largest standard error that the pairs of face a add to a view factor.
static double row_error(const struct oracle_scene *s, const struct oracle_settings *o, int a,
                        uint32_t points, const struct row *w) {
  const struct face *f = &s->face[a];
  double worst = 0, value[oracle_replicates], mean, error;
  for (int j = 0; j < s->surfaces; j++) {
    for (int r = 0; r < o->replicates; r++) {
      value[r] = 0;
      for (int t = 0; t < s->faces; t++)
        if (w->wanted[t] && s->face[t].surface == j)
          value[r] += w->sum[(size_t)r * s->faces + t];
      value[r] *= f->area / points;
    }
    oracle_mean(o->replicates, value, &mean, &error);
    worst = fmax(worst, error / fmin(s->area[f->surface], s->area[j]));
  }
  return worst;
}

// One face of a pair sees of the other at most F. If hardly any of n points see it, an n-th part of
// A F may be missed.
static void add_row(const struct oracle_scene *s, int replicates, struct oracle_sums *q, int a,
                    uint32_t points, const struct row *w) {
  const size_t n = (size_t)s->surfaces;
  for (int t = 0; t < s->faces; t++) {
    if (!w->wanted[t])
      continue;
    double *seen = &q->seen[a * s->faces + t];
    for (int r = 0; r < replicates; r++) {
      const double exchange = w->sum[(size_t)r * s->faces + t] * s->face[a].area / points;
      add_pair(s, q->exchange + r * n * n, a, t, exchange);
      *seen += exchange / replicates;
    }
    const double missed =
        s->face[a].area * oracle_most_seen(s, a, t) / ((double)points * replicates);
    if (w->hits[t] < oracle_few) {
      add_pair(s, q->missed_exchange, a, t, missed);
      *seen += missed;
    }
    q->seen[t * s->faces + a] = *seen;
  }
}

static void add_face(struct oracle_scene *s, const struct oracle_settings *o, int a,
                     struct oracle_sums *q) {
  struct row w = {.wanted = oracle_new((size_t)s->faces, sizeof *w.wanted),
                  .sum = oracle_new((size_t)o->replicates * s->faces, sizeof *w.sum),
                  .hits = oracle_new((size_t)s->faces, sizeof *w.hits)};
  bool any = false;
  for (int t = 0; t < s->faces; t++)
    any |= w.wanted[t] = outer(s, a, t);
  uint32_t points = o->first;
  if (any)
    add_points(s, o, a, 0, points, &w);
  while (any && points < o->most && row_error(s, o, a, points, &w) > o->target / sqrt(s->faces)) {
    add_points(s, o, a, points, 2 * points, &w);
    points *= 2;
  }
  add_row(s, o->replicates, q, a, points, &w);
  free(w.sum);
  free(w.wanted);
  free(w.hits);
}

void oracle_print(const char *what, int i, int j, int n, const double *value, double missed) {
  double mean, error;
  oracle_mean(n, value, &mean, &error);
  printf("%s %d %d %.17g %.6g\n", what, i, j, mean, error + missed);
}

struct oracle_sums oracle_sum_factors(struct oracle_scene *s, const struct oracle_settings *o) {
  struct oracle_sums q = new_sums(s, o->replicates);
  for (int a = 0; a < s->faces; a++)
    add_face(s, o, a, &q);
  return q;
}

void oracle_factors(const struct oracle_scene *s, int replicates, const struct oracle_sums *q) {
  double value[oracle_replicates];
  const size_t n = (size_t)s->surfaces;
  for (size_t i = 0; i < n; i++) {
    double row[oracle_replicates] = {0}, missed = 0;
    for (size_t j = 0; j < n; j++) {
      for (int r = 0; r < replicates; r++)
        row[r] += value[r] = q->exchange[(r * n + i) * n + j] / s->area[i];
      missed += q->missed_exchange[i * n + j] / s->area[i];
      oracle_print("factor", (int)i, (int)j, replicates, value,
                   q->missed_exchange[i * n + j] / s->area[i]);
    }
    oracle_print("row_sum", (int)i, 0, replicates, row, missed);
  }
}

int oracle_pick(const struct oracle_scene *s, int surface, double share) {
  int last = -1;
  double left = share * s->area[surface];
  for (int i = 0; i < s->faces; i++)
    if (s->face[i].surface == surface) {
      last = i;
      if ((left -= s->face[i].area) < 0)
        break;
    }
  return last;
}

// Hits a surface takes of the rays of another, divided by their number.
static void shoot(struct oracle_scene *s, const struct oracle_settings *o, int i, int r,
                  double *share) {
  const uint64_t seed = oracle_hash(o->seed * 7919 + (uint64_t)r * 104729 + (uint64_t)i);
  for (uint32_t k = 0; k < o->first; k++) {
    double z[5];
    for (int d = 0; d < 5; d++)
      z[d] = oracle_sobol(k, d, seed);
    const int a = oracle_pick(s, i, z[4]);
    const struct vec x = oracle_point(&s->face[a], z[0], z[1]);
    struct vec y;
    const int t = oracle_hit(s, a, x, oracle_cosine(s->face[a].normal, z[2], z[3]), &y);
    if (t >= 0 && height(&s->face[t], x) > 0)
      share[s->face[t].surface] += 1. / o->first;
  }
}

void oracle_rays(struct oracle_scene *s, const struct oracle_settings *o) {
  const size_t n = (size_t)s->surfaces;
  double *share = oracle_new(n * o->replicates * n, sizeof *share), value[oracle_replicates];
  for (size_t i = 0; i < n; i++)
    for (int r = 0; r < o->replicates; r++)
      shoot(s, o, (int)i, r, &share[(i * o->replicates + r) * n]);
  for (size_t i = 0; i < n; i++) {
    double row[oracle_replicates] = {0};
    for (size_t j = 0; j < n; j++) {
      const bool own = s->area[i] < s->area[j] || (s->area[i] == s->area[j] && i <= j);
      for (int r = 0; r < o->replicates; r++) {
        row[r] += share[(i * o->replicates + r) * n + j];
        value[r] = own ? share[(i * o->replicates + r) * n + j]
                       : share[(j * o->replicates + r) * n + i] * s->area[j] / s->area[i];
      }
      oracle_print("factor", (int)i, (int)j, o->replicates, value, 0);
    }
    oracle_print("row_sum", (int)i, 0, o->replicates, row, 0);
  }
  free(share);
}
