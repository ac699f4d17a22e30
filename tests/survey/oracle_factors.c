// View factors between surfaces, and the irradiance by emission alone: outer points in scrambled
// Sobol sequences on the smaller face of a pair, the inner integral closed; or rays, which share
// nothing with it.
#include "oracle.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

struct sums {
  int replicates, surfaces, bands;
  double *exchange;   // [replicates, surfaces, surfaces]: A_i F_ij
  double *irradiance; // [replicates, surfaces, bands]: A_i times the mean irradiance by emission
};

static struct sums new_sums(const struct oracle_scene *s, int replicates) {
  const size_t n = (size_t)s->surfaces;
  return (struct sums){replicates, s->surfaces, s->bands,
                       oracle_new(replicates * n * n, sizeof(double)),
                       oracle_new(replicates * n * (size_t)s->bands, sizeof(double))};
}

static void free_sums(struct sums *q) {
  free(q->exchange);
  free(q->irradiance);
}

// The outer integral of a pair runs over the smaller face.
static bool outer(const struct oracle_scene *s, int a, int t) {
  const double x = s->face[a].area, y = s->face[t].area;
  return (x < y || (x == y && a < t)) && oracle_facing(s, a, t);
}

static void add_pair(const struct oracle_scene *s, struct sums *q, int r, int a, int t,
                     double exchange) {
  const struct face *f = &s->face[a], *g = &s->face[t];
  const size_t n = (size_t)q->surfaces, i = (size_t)f->surface, j = (size_t)g->surface;
  q->exchange[(r * n + i) * n + j] += exchange;
  q->exchange[(r * n + j) * n + i] += exchange;
  for (int b = 0; b < s->bands; b++) {
    q->irradiance[(r * n + i) * s->bands + b] += exchange * g->emission[b];
    q->irradiance[(r * n + j) * s->bands + b] += exchange * f->emission[b];
  }
}

// Sums over points first..last of face a, for each replicate and face that a is the outer one of.
static void add_points(struct oracle_scene *s, const struct oracle_settings *o, int a,
                       uint32_t first, uint32_t last, const bool *wanted, double *sum) {
  for (int r = 0; r < o->replicates; r++) {
    const uint64_t seed = oracle_hash(o->seed * 1000003 + (uint64_t)r * 65537 + (uint64_t)a);
    for (uint32_t k = first; k < last; k++) {
      const struct vec x =
          oracle_point(&s->face[a], oracle_sobol(k, 0, seed), oracle_sobol(k, 1, seed));
      for (int t = 0; t < s->faces; t++)
        if (wanted[t])
          sum[(size_t)r * s->faces + t] += oracle_seen(s, a, x, t);
    }
  }
}

// The largest standard error that the pairs of face a add to a view factor.
static double row_error(const struct oracle_scene *s, const struct oracle_settings *o, int a,
                        uint32_t points, const bool *wanted, const double *sum) {
  const struct face *f = &s->face[a];
  double worst = 0, value[oracle_replicates], mean, error;
  for (int j = 0; j < s->surfaces; j++) {
    for (int r = 0; r < o->replicates; r++) {
      value[r] = 0;
      for (int t = 0; t < s->faces; t++)
        if (wanted[t] && s->face[t].surface == j)
          value[r] += sum[(size_t)r * s->faces + t];
      value[r] *= f->area / points;
    }
    oracle_mean(o->replicates, value, &mean, &error);
    worst = fmax(worst, error / fmin(s->area[f->surface], s->area[j]));
  }
  return worst;
}

static void add_face(struct oracle_scene *s, const struct oracle_settings *o, int a,
                     struct sums *q) {
  bool *wanted = oracle_new((size_t)s->faces, sizeof *wanted);
  double *sum = oracle_new((size_t)o->replicates * s->faces, sizeof *sum);
  bool any = false;
  for (int t = 0; t < s->faces; t++)
    any |= wanted[t] = outer(s, a, t);
  uint32_t points = o->first;
  if (any)
    add_points(s, o, a, 0, points, wanted, sum);
  while (any && points < o->most &&
         row_error(s, o, a, points, wanted, sum) > o->target / sqrt(s->faces)) {
    add_points(s, o, a, points, 2 * points, wanted, sum);
    points *= 2;
  }
  for (int r = 0; r < o->replicates; r++)
    for (int t = 0; t < s->faces; t++)
      if (wanted[t])
        add_pair(s, q, r, a, t, sum[(size_t)r * s->faces + t] * s->face[a].area / points);
  free(sum);
  free(wanted);
}

static void print(const char *what, int i, int j, int n, const double *value) {
  double mean, error;
  oracle_mean(n, value, &mean, &error);
  printf("%s %d %d %.17g %.6g\n", what, i, j, mean, error);
}

void oracle_factors(struct oracle_scene *s, const struct oracle_settings *o) {
  struct sums q = new_sums(s, o->replicates);
  double value[oracle_replicates];
  for (int a = 0; a < s->faces; a++)
    add_face(s, o, a, &q);
  const size_t n = (size_t)s->surfaces;
  for (size_t i = 0; i < n; i++) {
    double row[oracle_replicates] = {0};
    for (size_t j = 0; j < n; j++) {
      for (int r = 0; r < o->replicates; r++)
        row[r] += value[r] = q.exchange[(r * n + i) * n + j] / s->area[i];
      print("factor", (int)i, (int)j, o->replicates, value);
    }
    print("row_sum", (int)i, 0, o->replicates, row);
    for (int b = 0; b < s->bands; b++) {
      for (int r = 0; r < o->replicates; r++)
        value[r] = q.irradiance[(r * n + i) * s->bands + b] / s->area[i];
      print("direct_irradiance", (int)i, b, o->replicates, value);
    }
  }
  free_sums(&q);
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
      print("factor", (int)i, (int)j, o->replicates, value);
    }
    print("row_sum", (int)i, 0, o->replicates, row);
  }
  free(share);
}
