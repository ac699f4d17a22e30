// Mean irradiance and radiosity of surfaces. With a constant v for each surface, about its mean
// radiosity, u = v + e, and e is the radiosity that the residual r takes the place of emission for:
//   e = r + rho K e,  r = E - v + rho K v;   mean of h = sum of F v + mean of K e.
// F is that of oracle_factors.c, r is closed at each point. K e is summed over points x of the
// surface: three points y by three ways, so that each face, each lit spot and each direction gets
// its share, then paths of rays from y on.
#include "oracle.h"

#include <math.h>
#include <stdlib.h>

struct spectrum {
  double b[oracle_bands];
};
struct paths {
  struct oracle_scene *s;
  const struct oracle_settings *o;
  struct spectrum *v; // of surfaces
  int mirrors, *mirror;
  double largest, power; // radiosity; sum of strength times area
};
struct spot {
  int face; // -1: none
  struct vec at;
};
// What one surface receives from reflecting faces.
struct gain {
  double sum[oracle_replicates][oracle_bands], largest[oracle_bands];
  int *hits, *tails; // of each first face: points with a weight, paths that bring light from beyond
};

static double strength(const struct face *f, int bands) {
  double most = 0;
  for (int b = 0; b < bands; b++)
    most = fmax(most, fabs(f->emission[b]));
  return most;
}

static double most_reflected(const struct face *f, int bands) {
  double most = 0;
  for (int b = 0; b < bands; b++)
    most = fmax(most, f->rho[b]);
  return most;
}

// v = E + rho F v, by iteration.
static void guess(struct paths *p, const struct oracle_sums *f) {
  const struct oracle_scene *s = p->s;
  const size_t n = (size_t)s->surfaces;
  struct spectrum *next = oracle_new(n, sizeof *next);
  for (int step = 0; step < 100; step++) {
    for (int k = 0; k < s->faces; k++) {
      const size_t i = (size_t)s->face[k].surface;
      for (int b = 0; b < s->bands; b++) {
        double h = 0;
        for (size_t j = 0; j < n; j++)
          h += f->exchange[i * n + j] / s->area[i] * p->v[j].b[b];
        next[i].b[b] = s->face[k].emission[b] + s->face[k].rho[b] * h;
      }
    }
    struct spectrum *swap = p->v;
    p->v = next;
    next = swap;
  }
  free(next);
}

static struct paths new_paths(struct oracle_scene *s, const struct oracle_settings *o,
                              const struct oracle_sums *f) {
  struct paths p = {.s = s, .o = o};
  p.v = oracle_new((size_t)s->surfaces, sizeof *p.v);
  p.mirror = oracle_new((size_t)s->faces, sizeof *p.mirror);
  for (int i = 0; i < s->faces; i++) {
    const double e = strength(&s->face[i], s->bands);
    p.largest = fmax(p.largest, e);
    p.power += e * s->face[i].area;
    if (most_reflected(&s->face[i], s->bands) > 0)
      p.mirror[p.mirrors++] = i;
  }
  guess(&p, f);
  return p;
}

// Residual at y of face t: r(y) = E - v + rho sum of v F(y, face); returned: sum of E F(y,
// emitter).
static double residual(const struct paths *p, int t, struct vec y, struct spectrum *r) {
  const struct oracle_scene *s = p->s;
  const struct face *g = &s->face[t];
  double lit = 0;
  for (int b = 0; b < s->bands; b++)
    r->b[b] = g->emission[b] - p->v[g->surface].b[b];
  for (int i = 0; i < s->faces; i++) {
    const struct spectrum *v = &p->v[s->face[i].surface];
    bool dark = true;
    for (int b = 0; b < s->bands; b++)
      dark &= v->b[b] == 0;
    if (dark || !oracle_facing(s, t, i))
      continue;
    const double f = oracle_seen(p->s, t, y, i);
    lit += f * strength(&s->face[i], s->bands);
    for (int b = 0; b < s->bands; b++)
      r->b[b] += g->rho[b] * f * v->b[b];
  }
  return lit;
}

static struct spot by_ray(const struct paths *p, int a, struct vec x, double c, double d) {
  struct spot y;
  y.face = oracle_hit(p->s, a, x, oracle_cosine(p->s->face[a].normal, c, d), &y.at);
  if (y.face >= 0 && height(&p->s->face[y.face], x) <= 0)
    y.face = -1;
  return y;
}

// Where a ray from an emitter arrives, emitters by their power: density sum of E F(y, emitter) /
// power.
static struct spot by_light(const struct paths *p, uint64_t *state) {
  const struct oracle_scene *s = p->s;
  double left = oracle_random(state) * p->power;
  int a = -1;
  for (int i = 0; i < s->faces && left >= 0; i++) {
    const double power = strength(&s->face[i], s->bands) * s->face[i].area;
    if (power > 0)
      a = i;
    left -= power;
  }
  if (a < 0)
    return (struct spot){.face = -1};
  const double c = oracle_random(state), d = oracle_random(state);
  const struct vec x = oracle_point(&s->face[a], c, d);
  const double e = oracle_random(state), f = oracle_random(state);
  return by_ray(p, a, x, e, f);
}

// Each reflecting face as often as any other: density 1 / (number area).
static struct spot by_area(const struct paths *p, const double z[3]) {
  const int k = (int)(z[0] * p->mirrors), t = p->mirror[k < p->mirrors ? k : p->mirrors - 1];
  return (struct spot){t, oracle_point(&p->s->face[t], z[1], z[2])};
}

// G(x, y) = cos cos / (pi d^2), 0 if x and y do not see each other.
static double kernel(const struct paths *p, int a, struct vec x, struct spot y, bool seen) {
  const struct face *f = &p->s->face[a], *g = &p->s->face[y.face];
  const struct vec d = sub(y.at, x);
  const double up = height(f, y.at), down = height(g, x), square = dot(d, d);
  struct vec at;
  if (up <= 0 || down <= 0 || p->s->coplanar[a * p->s->faces + y.face] ||
      (!seen && oracle_hit(p->s, a, x, d, &at) != y.face))
    return 0;
  return up * down / (M_PI * square * square);
}

// Sum of share e over what rays meet from y on. The first points of a path take r in closed form,
// then E - v there and rho v where the next ray arrives. True if there is light at all.
static bool follow(const struct paths *p, struct spot y, struct spectrum share, uint64_t *state,
                   struct spectrum *sum) {
  const struct oracle_scene *s = p->s;
  double start = 0;
  bool any = false;
  for (int b = 0; b < s->bands; b++)
    start = fmax(start, share.b[b]);
  for (int bounce = 0;; bounce++) {
    const double c = oracle_random(state), d = oracle_random(state);
    y = by_ray(p, y.face, y.at, c, d);
    if (y.face < 0)
      return any;
    const struct face *g = &s->face[y.face];
    struct spectrum r = {{0}};
    if (bounce < p->o->closed)
      any |= most_reflected(g, s->bands) > 0 && residual(p, y.face, y.at, &r) > 0;
    double most = 0;
    for (int b = 0; b < s->bands; b++) {
      const double v = p->v[g->surface].b[b];
      any |= bounce >= p->o->closed && v > 0;
      sum->b[b] += share.b[b] * (bounce < p->o->closed ? r.b[b] : g->emission[b] - v);
      if (bounce > p->o->closed)
        sum->b[b] += share.b[b] * v;
      most = fmax(most, share.b[b] *= g->rho[b]);
    }
    const double stay = bounce < 2 ? 1 : fmin(1, 3 * most / start);
    if (most <= 0 || (stay < 1 && oracle_random(state) >= stay))
      return any;
    for (int b = 0; b < s->bands; b++)
      share.b[b] /= stay;
  }
}

// One point y for x: e(y) G(x, y) / (G(x, y) + densities of the other two ways).
static void add_spot(const struct paths *p, int a, struct vec x, struct spot y, bool seen,
                     uint64_t *state, struct gain *q, struct spectrum *sum) {
  const struct oracle_scene *s = p->s;
  if (y.face < 0 || most_reflected(&s->face[y.face], s->bands) == 0)
    return;
  const double g = kernel(p, a, x, y, seen);
  if (g == 0)
    return;
  struct spectrum r, share = {{0}};
  const double lit = residual(p, y.face, y.at, &r) / p->power;
  const double weight = g / (g + lit + 1 / (p->mirrors * s->face[y.face].area));
  for (int b = 0; b < s->bands; b++) {
    share.b[b] = weight * s->face[y.face].rho[b];
    sum->b[b] += weight * r.b[b];
  }
  q->hits[y.face] += lit > 0;
  q->tails[y.face] += follow(p, y, share, state, sum);
}

static void gather(const struct paths *p, int surface, uint32_t first, uint32_t last,
                   struct gain *q) {
  for (int r = 0; r < p->o->replicates; r++) {
    const uint64_t seed =
        oracle_hash(p->o->seed * 15485863 + (uint64_t)r * 32452843 + (uint64_t)surface);
    for (uint32_t k = first; k < last; k++) {
      double z[8];
      for (int d = 0; d < 8; d++)
        z[d] = oracle_sobol(k, d, seed);
      uint64_t state = oracle_hash(seed ^ ((uint64_t)k << 32));
      const int a = oracle_pick(p->s, surface, z[4]);
      const struct vec x = oracle_point(&p->s->face[a], z[0], z[1]);
      struct spectrum h = {{0}};
      add_spot(p, a, x, by_ray(p, a, x, z[2], z[3]), true, &state, q, &h);
      add_spot(p, a, x, by_light(p, &state), false, &state, q, &h);
      add_spot(p, a, x, by_area(p, &z[5]), false, &state, q, &h);
      for (int b = 0; b < p->s->bands; b++) {
        q->sum[r][b] += h.b[b];
        q->largest[b] = fmax(q->largest[b], fabs(h.b[b]));
      }
    }
  }
}

// The largest standard error over the mean itself, if that is not far below the largest radiosity.
static double worst_error(const struct paths *p, const struct gain *q, const double *own,
                          uint32_t points) {
  double worst = 0, value[oracle_replicates], mean, error;
  for (int b = 0; b < p->s->bands; b++) {
    for (int r = 0; r < p->o->replicates; r++)
      value[r] = q->sum[r][b] / points;
    oracle_mean(p->o->replicates, value, &mean, &error);
    worst = fmax(worst, error / fmax(mean + own[b], 1e-3 * p->largest));
  }
  return worst;
}

// Irradiance of t by emission is nowhere above sum of E F.
static double most_lit(const struct paths *p, int t, int b) {
  double sum = 0;
  for (int i = 0; i < p->s->faces; i++)
    if (p->s->face[i].emission[b] != 0)
      sum += fabs(p->s->face[i].emission[b]) * oracle_most_seen(p->s, t, i);
  return sum;
}

// Mean F from surface i to face t, or the most that a point of t sends to i, times A_t / A_i.
static double between(const struct paths *p, const struct oracle_sums *f, int i, int t, bool most) {
  const struct oracle_scene *s = p->s;
  double sum = 0;
  for (int a = 0; a < s->faces; a++)
    if (s->face[a].surface == i)
      sum += most ? oracle_most_seen(s, t, a) * s->face[t].area : f->seen[a * s->faces + t];
  return sum / s->area[i];
}

// What hardly any of n points have met may bring by way of face t: all that t sends at most,
// rho_t h_t F(i, t), or what comes from the part 1 / thin of the pairs of points.
static double missed_spots(const struct paths *p, const struct oracle_sums *f, int i, int t, int b,
                           double thin) {
  const struct oracle_scene *s = p->s;
  double mean = 0, seen = 0;
  for (int k = 0; k < s->faces; k++)
    mean += f->seen[t * s->faces + k] * s->face[k].emission[b] / s->face[t].area;
  for (int a = 0; a < s->faces; a++)
    if (s->face[a].surface == i)
      seen += oracle_most_seen(s, a, t) * s->face[a].area / s->area[i];
  const double lit = most_lit(p, t, b), flat = mean * between(p, f, i, t, true);
  return s->face[t].rho[b] * fmin(flat, lit * fmin(between(p, f, i, t, false), seen * thin));
}

// The same by way of t and one face more.
static double missed_paths(const struct paths *p, const struct oracle_sums *f, int i, int t, int b,
                           double thin) {
  const struct oracle_scene *s = p->s;
  const double mean = between(p, f, i, t, false), most = between(p, f, i, t, true);
  double sum = 0;
  for (int k = 0; k < p->mirrors && mean > 0; k++) {
    const int z = p->mirror[k];
    const double rare = mean * fmin(oracle_most_seen(s, t, z), thin),
                 flat = most * f->seen[t * s->faces + z] / s->face[t].area;
    sum += rare > 0 ? s->face[z].rho[b] * most_lit(p, z, b) * fmin(rare, flat) : 0;
  }
  return s->face[t].rho[b] * sum;
}

static double missed(const struct paths *p, const struct oracle_sums *f, const struct gain *q,
                     int i, int b, double n) {
  const double thin = fmin(1, p->mirrors / n);
  double sum = q->largest[b] / n;
  for (int k = 0; k < p->mirrors; k++) {
    const int t = p->mirror[k];
    if (q->hits[t] < oracle_few)
      sum += missed_spots(p, f, i, t, b, thin);
    if (q->tails[t] < oracle_few)
      sum += missed_paths(p, f, i, t, b, thin);
  }
  return sum;
}

// sum of F v, of a replicate.
static double steady(const struct paths *p, const struct oracle_sums *f, int r, int i, int b) {
  const size_t n = (size_t)p->s->surfaces;
  double sum = 0;
  for (size_t j = 0; j < n; j++)
    sum += f->exchange[(r * n + i) * n + j] * p->v[j].b[b];
  return sum / p->s->area[i];
}

// u = E + rho h, net = u - h; rho and E of a surface's faces are the same.
static void report(const struct paths *p, const struct oracle_sums *f, const struct gain *q, int i,
                   uint32_t points) {
  const struct oracle_scene *s = p->s;
  const int n = p->o->replicates;
  const size_t m = (size_t)s->surfaces;
  const struct face *own = s->face;
  while (own->surface != i)
    own++;
  for (int b = 0; b < s->bands; b++) {
    const double rho = own->rho[b], e = own->emission[b];
    double less = missed(p, f, q, i, b, (double)points * n);
    for (size_t j = 0; j < m; j++)
      less += f->missed_exchange[i * m + j] / s->area[i] * p->v[j].b[b];
    double h[oracle_replicates], u[oracle_replicates], net[oracle_replicates];
    for (int r = 0; r < n; r++) {
      h[r] = steady(p, f, r, i, b) + q->sum[r][b] / points;
      u[r] = e + rho * h[r];
      net[r] = e + (rho - 1) * h[r];
    }
    oracle_print("irradiance", i, b, n, h, less);
    oracle_print("radiosity", i, b, n, u, rho * less);
    oracle_print("net", i, b, n, net, fabs(1 - rho) * less);
  }
}

static void surface_means(const struct paths *p, const struct oracle_sums *f, int i) {
  const struct oracle_scene *s = p->s;
  struct gain q = {.hits = oracle_new((size_t)s->faces, sizeof *q.hits),
                   .tails = oracle_new((size_t)s->faces, sizeof *q.tails)};
  double own[oracle_bands];
  for (int b = 0; b < s->bands; b++)
    own[b] = steady(p, f, 0, i, b);
  uint32_t points = p->o->rays;
  if (p->mirrors && p->power > 0) {
    gather(p, i, 0, points, &q);
    while (points < p->o->paths && worst_error(p, &q, own, points) > p->o->target) {
      gather(p, i, points, 2 * points, &q);
      points *= 2;
    }
  }
  report(p, f, &q, i, points);
  free(q.hits);
  free(q.tails);
}

void oracle_means(struct oracle_scene *s, const struct oracle_settings *o,
                  const struct oracle_sums *f) {
  const struct paths p = new_paths(s, o, f);
  for (int i = 0; i < s->surfaces; i++)
    surface_means(&p, f, i);
  free(p.v);
  free(p.mirror);
}
