// Mean irradiance and radiosity of surfaces: paths that begin on the surface. What a few bright
// faces (the lamps) give is taken in closed form at each point of a path; where a lamp is smaller
// than the face it shines on, its direct part is integrated over the lamp instead. All else is
// collected by the rays themselves.
#include "oracle.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

struct paths {
  struct oracle_scene *s;
  const struct oracle_settings *o;
  bool *lamp;
  int lamps, *lamp_face;
  double largest; // radiosity
};
struct spectrum {
  double b[oracle_bands];
};
// Per replicate: irradiance h, radiosity u, u - h.
struct means {
  double h[oracle_replicates][oracle_bands], u[oracle_replicates][oracle_bands],
      q[oracle_replicates][oracle_bands];
};

static double strength(const struct oracle_scene *s, const struct face *f) {
  double sum = 0;
  for (int b = 0; b < s->bands; b++)
    sum = fmax(sum, fabs(f->emission[b]));
  return sum;
}

// The brightest faces, as many as asked for.
static void choose_lamps(struct paths *p) {
  const struct oracle_scene *s = p->s;
  p->lamp = oracle_new((size_t)s->faces, sizeof *p->lamp);
  p->lamp_face = oracle_new((size_t)s->faces, sizeof *p->lamp_face);
  while (p->lamps < p->o->lamps) {
    int best = -1;
    for (int i = 0; i < s->faces; i++)
      if (!p->lamp[i] && strength(s, &s->face[i]) > (best < 0 ? 0 : strength(s, &s->face[best])))
        best = i;
    if (best < 0)
      break;
    p->lamp[best] = true;
    p->lamp_face[p->lamps++] = best;
  }
}

static bool lamp_is_outer(const struct oracle_scene *s, int lamp, int face) {
  return s->face[lamp].area < s->face[face].area;
}

static void add_lamps(const struct paths *p, int a, struct vec x, bool first, struct spectrum *h) {
  for (int k = 0; k < p->lamps; k++) {
    const int t = p->lamp_face[k];
    if ((first && lamp_is_outer(p->s, t, a)) || !oracle_facing(p->s, a, t))
      continue;
    const double f = oracle_seen(p->s, a, x, t);
    for (int b = 0; b < p->s->bands; b++)
      h->b[b] += f * p->s->face[t].emission[b];
  }
}

// Irradiance at x of face a by one path; z begins the path, then come random numbers.
static struct spectrum follow(const struct paths *p, int a, struct vec x, const double z[3],
                              uint64_t *state) {
  const struct oracle_scene *s = p->s;
  struct spectrum h = {{0}}, share;
  for (int b = 0; b < s->bands; b++)
    share.b[b] = 1;
  add_lamps(p, a, x, true, &h);
  for (int bounce = 0;; bounce++) {
    const double c = bounce ? oracle_random(state) : z[0], d = bounce ? oracle_random(state) : z[1];
    struct vec y;
    const int t = oracle_hit(s, a, x, oracle_cosine(s->face[a].normal, c, d), &y);
    if (t < 0 || height(&s->face[t], x) <= 0)
      return h;
    const struct face *g = &s->face[t];
    double most = 0;
    struct spectrum there = {{0}};
    for (int b = 0; b < s->bands; b++) {
      if (!p->lamp[t])
        h.b[b] += share.b[b] * g->emission[b];
      most = fmax(most, share.b[b] *= g->rho[b]);
    }
    if (most <= 0)
      return h;
    const double stay = fmin(1, 10 * most);
    if (stay < 1 && oracle_random(state) >= stay)
      return h;
    add_lamps(p, t, y, false, &there);
    for (int b = 0; b < s->bands; b++) {
      share.b[b] /= stay;
      h.b[b] += share.b[b] * there.b[b];
    }
    a = t;
    x = y;
  }
}

static void add(const struct oracle_scene *s, struct means *m, int r, const struct face *f,
                const struct spectrum *h, double weight) {
  for (int b = 0; b < s->bands; b++) {
    m->h[r][b] += weight * h->b[b];
    m->u[r][b] += weight * f->rho[b] * h->b[b];
    m->q[r][b] += weight * (f->rho[b] - 1) * h->b[b];
  }
}

static void gather(const struct paths *p, int surface, uint32_t first, uint32_t last,
                   struct means *m) {
  for (int r = 0; r < p->o->replicates; r++) {
    const uint64_t seed =
        oracle_hash(p->o->seed * 15485863 + (uint64_t)r * 32452843 + (uint64_t)surface);
    for (uint32_t k = first; k < last; k++) {
      double z[5];
      for (int d = 0; d < 5; d++)
        z[d] = oracle_sobol(k, d, seed);
      uint64_t state = oracle_hash(seed ^ ((uint64_t)k << 32));
      const int a = oracle_pick(p->s, surface, z[4]);
      const struct face *f = &p->s->face[a];
      const struct spectrum h = follow(p, a, oracle_point(f, z[0], z[1]), &z[2], &state);
      add(p->s, m, r, f, &h, 1);
    }
  }
}

// Direct light of the lamps on the larger faces, over points of the lamps.
static void shine(const struct paths *p, int lamp, uint32_t points, struct means *m) {
  struct oracle_scene *s = p->s;
  const struct face *g = &s->face[lamp];
  for (int r = 0; r < p->o->replicates; r++) {
    const uint64_t seed =
        oracle_hash(p->o->seed * 86028121 + (uint64_t)r * 122949823 + (uint64_t)lamp);
    for (uint32_t k = 0; k < points; k++) {
      const struct vec x = oracle_point(g, oracle_sobol(k, 0, seed), oracle_sobol(k, 1, seed));
      for (int t = 0; t < s->faces; t++) {
        if (!lamp_is_outer(s, lamp, t) || !oracle_facing(s, lamp, t))
          continue;
        const double f = oracle_seen(s, lamp, x, t);
        struct spectrum h;
        for (int b = 0; b < s->bands; b++)
          h.b[b] = f * g->emission[b];
        const int j = s->face[t].surface;
        add(s, &m[j], r, &s->face[t], &h, g->area / s->area[j] / points);
      }
    }
  }
}

static double worst_error(const struct paths *p, const struct means *m, uint32_t points) {
  double worst = 0, value[oracle_replicates], mean, error;
  for (int b = 0; b < p->s->bands; b++) {
    for (int r = 0; r < p->o->replicates; r++)
      value[r] = m->h[r][b] / points;
    oracle_mean(p->o->replicates, value, &mean, &error);
    worst = fmax(worst, error);
  }
  return worst / p->largest;
}

static void print(const struct paths *p, int i, const char *what, double own,
                  double (*value)[oracle_bands], int b) {
  double list[oracle_replicates], mean, error;
  for (int r = 0; r < p->o->replicates; r++)
    list[r] = own + value[r][b];
  oracle_mean(p->o->replicates, list, &mean, &error);
  printf("%s %d %d %.17g %.6g\n", what, i, b, mean, error);
}

static void report(const struct paths *p, int i, struct means *m) {
  const struct oracle_scene *s = p->s;
  for (int b = 0; b < s->bands; b++) {
    double own = 0;
    for (int t = 0; t < s->faces; t++)
      if (s->face[t].surface == i)
        own += s->face[t].emission[b] * s->face[t].area / s->area[i];
    print(p, i, "irradiance", 0, m->h, b);
    print(p, i, "radiosity", own, m->u, b);
    print(p, i, "net", own, m->q, b);
  }
}

void oracle_means(struct oracle_scene *s, const struct oracle_settings *o) {
  struct paths p = {.s = s, .o = o};
  struct means *direct = oracle_new((size_t)s->surfaces, sizeof *direct);
  choose_lamps(&p);
  for (int i = 0; i < s->faces; i++)
    p.largest = fmax(p.largest, strength(s, &s->face[i]));
  if (p.largest == 0)
    p.largest = 1;
  for (int k = 0; k < p.lamps; k++)
    shine(&p, p.lamp_face[k], o->most / 4 > o->first ? o->most / 4 : o->first, direct);
  for (int i = 0; i < s->surfaces; i++) {
    struct means m = {0};
    uint32_t points = o->first;
    gather(&p, i, 0, points, &m);
    while (points < o->most && worst_error(&p, &m, points) > o->target) {
      gather(&p, i, points, 2 * points, &m);
      points *= 2;
    }
    for (int r = 0; r < o->replicates; r++)
      for (int b = 0; b < s->bands; b++) {
        m.h[r][b] = m.h[r][b] / points + direct[i].h[r][b];
        m.u[r][b] = m.u[r][b] / points + direct[i].u[r][b];
        m.q[r][b] = m.q[r][b] / points + direct[i].q[r][b];
      }
    report(&p, i, &m);
  }
  free(direct);
  free(p.lamp);
  free(p.lamp_face);
}
