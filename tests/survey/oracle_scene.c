// The oracle's scene: reader, planes, who may stand between whom, rays.
#include "oracle.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

_Noreturn void oracle_die(const char *format, ...) {
  va_list list;
  va_start(list, format);
  fputs("oracle: ", stderr);
  vfprintf(stderr, format, list);
  fputc('\n', stderr);
  va_end(list);
  exit(2);
}

void *oracle_new(size_t n, size_t size) {
  void *p = calloc(n ? n : 1, size);
  if (!p)
    oracle_die("no memory");
  return p;
}

static double number(FILE *f) {
  double x;
  if (fscanf(f, "%lf", &x) != 1)
    oracle_die("a number is missing");
  return x;
}

static struct vec point(FILE *f) {
  const double x = number(f), y = number(f), z = number(f);
  return (struct vec){x, y, z};
}

static void planes(struct face *f) {
  const struct vec n = cross(sub(f->v[1], f->v[0]), sub(f->v[2], f->v[0]));
  const double twice = sqrt(dot(n, n));
  f->area = .5 * twice;
  f->normal = along((struct vec){0, 0, 0}, 1 / twice, n);
  f->offset = (dot(f->normal, f->v[0]) + dot(f->normal, f->v[1]) + dot(f->normal, f->v[2])) / 3;
  f->size = 0;
  for (int k = 0; k < 3; k++) {
    const struct vec e = sub(f->v[(k + 1) % 3], f->v[k]);
    const double length = sqrt(dot(e, e));
    f->side[k] = cross(f->normal, along((struct vec){0, 0, 0}, 1 / length, e));
    f->reach[k] = .5 * (dot(f->side[k], f->v[k]) + dot(f->side[k], f->v[(k + 1) % 3]));
    f->size = fmax(f->size, length);
  }
}

// Highest point of face b over the plane of a.
static double highest(const struct face *a, const struct face *b) {
  return fmax(height(a, b->v[0]), fmax(height(a, b->v[1]), height(a, b->v[2])));
}

static double farthest(const struct face *a, const struct face *b) {
  double most = 0;
  for (int k = 0; k < 3; k++)
    most = fmax(most, fabs(height(a, b->v[k])));
  return most;
}

// What lies within rounding of a plane lies in it: the scenes hold no gaps as small as that.
static double rounding(const struct face *a, const struct face *b) {
  return 1e-11 * (a->size + b->size) + 1e-13;
}

static void find_coplanar(struct oracle_scene *s) {
  const int n = s->faces;
  s->coplanar = oracle_new((size_t)n * n, sizeof *s->coplanar);
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      const struct face *a = &s->face[i], *b = &s->face[j];
      s->coplanar[i * n + j] = fmin(farthest(a, b), farthest(b, a)) < rounding(a, b);
    }
}

struct oracle_scene *oracle_read(const char *path) {
  FILE *f = fopen(path, "r");
  if (!f)
    oracle_die("cannot read %s", path);
  struct oracle_scene *s = oracle_new(1, sizeof *s);
  s->faces = (int)number(f), s->surfaces = (int)number(f), s->bands = (int)number(f);
  if (s->faces < 1 || s->surfaces < 1 || s->bands < 1 || s->bands > oracle_bands)
    oracle_die("%s: faces, surfaces or bands out of range", path);
  s->face = oracle_new((size_t)s->faces, sizeof *s->face);
  s->area = oracle_new((size_t)s->surfaces, sizeof *s->area);
  for (int i = 0; i < s->faces; i++) {
    struct face *g = &s->face[i];
    g->surface = (int)number(f);
    if (g->surface < 0 || g->surface >= s->surfaces)
      oracle_die("%s: face %d has no surface", path, i);
    for (int k = 0; k < 3; k++)
      g->v[k] = point(f);
    for (int b = 0; b < s->bands; b++)
      g->rho[b] = number(f);
    for (int b = 0; b < s->bands; b++)
      g->emission[b] = number(f);
    planes(g);
    s->area[g->surface] += g->area;
  }
  fclose(f);
  find_coplanar(s);
  s->between = oracle_new((size_t)s->faces * s->faces, sizeof(struct blockers *));
  return s;
}

void oracle_free(struct oracle_scene *s) {
  for (int i = 0; i < s->faces * s->faces; i++)
    if (s->between[i]) {
      free(s->between[i]->face);
      free(s->between[i]);
    }
  free(s->between);
  free(s->coplanar);
  free(s->area);
  free(s->face);
  free(s);
}

bool oracle_facing(const struct oracle_scene *s, int a, int b) {
  const struct face *f = &s->face[a], *g = &s->face[b];
  const double eps = rounding(f, g);
  return !s->coplanar[a * s->faces + b] && highest(f, g) > eps && highest(g, f) > eps;
}

static struct vec middle(const struct face *f) {
  return along(along(f->v[0], 1 / 3., sub(f->v[1], f->v[0])), 1 / 3., sub(f->v[2], f->v[0]));
}

// Width of the slab across direction n that lies between both faces, or <= 0.
static double gap(const struct face *f, const struct face *g, struct vec n) {
  double least = INFINITY, most = -INFINITY;
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++) {
      const double d = dot(n, sub(g->v[k], f->v[i]));
      least = fmin(least, d);
      most = fmax(most, d);
    }
  return fmax(least, -most) / sqrt(dot(n, n));
}

// F <= A_t / (pi d^2), d a bound of the distance.
double oracle_most_seen(const struct oracle_scene *s, int a, int t) {
  const struct face *f = &s->face[a], *g = &s->face[t];
  if (!oracle_facing(s, a, t))
    return 0;
  double d = fmax(gap(f, g, f->normal), gap(f, g, g->normal));
  const struct vec n = sub(middle(g), middle(f));
  if (dot(n, n) > 0)
    d = fmax(d, gap(f, g, n));
  return d > 0 ? fmin(1, g->area / (M_PI * d * d)) : 1;
}

static void widen(const struct face *f, double low[3], double high[3]) {
  for (int k = 0; k < 3; k++) {
    const double v[3] = {f->v[k].x, f->v[k].y, f->v[k].z};
    for (int d = 0; d < 3; d++) {
      low[d] = fmin(low[d], v[d]);
      high[d] = fmax(high[d], v[d]);
    }
  }
}

// Is there a plane through two corners of one face and a corner of the other that has both on one
// side and c on the other? Then c meets no line between them.
static bool apart(const struct face *f, const struct face *g, const struct face *c) {
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++) {
      const struct vec at = f->v[i], m = cross(sub(f->v[(i + 1) % 3], at), sub(g->v[k], at));
      const double eps = 1e-10 * sqrt(dot(m, m)) * (f->size + g->size + c->size);
      for (int sign = -1; sign <= 1; sign += 2) {
        bool parts = true;
        for (int l = 0; l < 3 && parts; l++)
          parts = sign * dot(m, sub(f->v[l], at)) <= eps &&
                  sign * dot(m, sub(g->v[l], at)) <= eps && sign * dot(m, sub(c->v[l], at)) > eps;
        if (parts)
          return true;
      }
    }
  return false;
}

static bool may_block(const struct oracle_scene *s, int a, int b, int c) {
  const struct face *f = &s->face[a], *g = &s->face[b], *h = &s->face[c];
  const int n = s->faces;
  if (c == a || c == b || s->coplanar[a * n + c] || s->coplanar[b * n + c])
    return false;
  if (highest(f, h) <= rounding(f, h) || highest(g, h) <= rounding(g, h))
    return false;
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  double least[3] = {INFINITY, INFINITY, INFINITY}, most[3] = {-INFINITY, -INFINITY, -INFINITY};
  widen(f, low, high);
  widen(g, low, high);
  widen(h, least, most);
  for (int d = 0; d < 3; d++)
    if (least[d] > high[d] || most[d] < low[d])
      return false;
  return !apart(f, g, h) && !apart(g, f, h);
}

const struct blockers *oracle_between(struct oracle_scene *s, int a, int b) {
  struct blockers **slot = &s->between[a * s->faces + b];
  if (*slot)
    return *slot;
  struct blockers *list = oracle_new(1, sizeof *list);
  list->face = oracle_new((size_t)s->faces, sizeof *list->face);
  for (int c = 0; c < s->faces; c++)
    if (may_block(s, a, b, c))
      list->face[list->n++] = c;
  *slot = list;
  return list;
}

static bool inside(const struct face *f, struct vec p) {
  return dot(f->side[0], p) >= f->reach[0] && dot(f->side[1], p) >= f->reach[1] &&
         dot(f->side[2], p) >= f->reach[2];
}

// Of faces back to back at p the one that x is in front of.
static int front_of(const struct oracle_scene *s, int hit, struct vec x, struct vec p) {
  if (height(&s->face[hit], x) > 0)
    return hit;
  for (int i = 0; i < s->faces; i++)
    if (s->coplanar[hit * s->faces + i] && height(&s->face[i], x) > 0 && inside(&s->face[i], p))
      return i;
  return hit;
}

int oracle_hit(const struct oracle_scene *s, int a, struct vec x, struct vec direction,
               struct vec *at) {
  double first = INFINITY;
  int hit = -1;
  const bool *coplanar = &s->coplanar[a * s->faces];
  for (int i = 0; i < s->faces; i++) {
    const struct face *f = &s->face[i];
    const double down = -height(f, x), slope = dot(f->normal, direction);
    // Distance: down / slope, where it is positive and below the least so far
    if (coplanar[i] || down * slope <= 0 || fabs(down) >= first * fabs(slope))
      continue;
    const struct vec p = along(x, down / slope, direction);
    if (inside(f, p)) {
      first = down / slope;
      hit = i;
      *at = p;
    }
  }
  return hit < 0 ? -1 : front_of(s, hit, x, *at);
}
