// What a point sees of a face: the face less the shadows of all others, as convex pieces.
#include "oracle.h"

#include <math.h>
#include <stdlib.h>

enum { most_corners = 48 };
struct piece {
  int n;
  struct vec p[most_corners]; // from the eye
};
struct pieces {
  int n, capacity;
  struct piece *list;
};

static void add(struct pieces *s, const struct piece *q) {
  if (q->n < 3)
    return;
  if (s->n == s->capacity) {
    s->capacity = 2 * s->capacity + 16;
    s->list = realloc(s->list, (size_t)s->capacity * sizeof *s->list);
    if (!s->list)
      oracle_die("no memory");
  }
  s->list[s->n++] = *q;
}

static void push(struct piece *q, struct vec p) {
  if (q->n == most_corners)
    oracle_die("a piece has more than %d corners", most_corners);
  q->p[q->n++] = p;
}

// Parts of q where m . p > c, and where m . p < c.
static void cut(const struct piece *q, struct vec m, double c, struct piece *above,
                struct piece *below) {
  above->n = below->n = 0;
  for (int k = 0; k < q->n; k++) {
    const struct vec a = q->p[k], b = q->p[(k + 1) % q->n];
    const double x = dot(m, a) - c, y = dot(m, b) - c;
    if (x >= 0)
      push(above, a);
    if (x <= 0)
      push(below, a);
    if ((x > 0 && y < 0) || (x < 0 && y > 0)) {
      const struct vec p = along(a, x / (x - y), sub(b, a));
      push(above, p);
      push(below, p);
    }
  }
}

static bool outside(const struct piece *q, struct vec m, double c) {
  for (int k = 0; k < q->n; k++)
    if (dot(m, q->p[k]) > c)
      return false;
  return true;
}

struct shadow {
  struct vec m[4];
  double c[4]; // hidden: m . p > c for all four
};

// Shadow of b seen from x: the pyramid over b, beyond b.
static bool make_shadow(const struct face *b, struct vec x, struct shadow *h) {
  const double up = height(b, x);
  if (up == 0)
    return false;
  const struct vec v[3] = {sub(b->v[0], x), sub(b->v[1], x), sub(b->v[2], x)};
  const double sign = up > 0 ? -1 : 1;
  for (int k = 0; k < 3; k++) {
    const struct vec m = cross(v[k], v[(k + 1) % 3]);
    h->m[k] = along((struct vec){0, 0, 0}, sign, m);
    h->c[k] = 0;
  }
  h->m[3] = along((struct vec){0, 0, 0}, sign, b->normal);
  h->c[3] = sign * -up;
  return true;
}

static void subtract(struct pieces *from, struct pieces *to, const struct shadow *h) {
  to->n = 0;
  for (int i = 0; i < from->n; i++) {
    const struct piece *q = &from->list[i];
    bool touched = true;
    for (int k = 0; k < 4 && touched; k++)
      touched = !outside(q, h->m[k], h->c[k]);
    if (!touched) {
      add(to, q);
      continue;
    }
    struct piece rest = *q, above, below;
    for (int k = 0; k < 4 && rest.n >= 3; k++) {
      cut(&rest, h->m[k], h->c[k], &above, &below);
      add(to, &below);
      rest = above;
    }
  }
}

// Lambert's form: sum over edges of their angle times the cosine of their plane's normal, over 2
// pi.
static double lambert(const struct piece *q, struct vec normal) {
  double sum = 0;
  for (int k = 0; k < q->n; k++) {
    const struct vec a = q->p[k], b = q->p[(k + 1) % q->n], c = cross(a, b);
    const double sine = sqrt(dot(c, c));
    if (sine > 0)
      sum += atan2(sine, dot(a, b)) * dot(normal, c) / sine;
  }
  return fabs(sum) / (2 * M_PI);
}

double oracle_seen(struct oracle_scene *s, int a, struct vec x, int t) {
  static struct pieces now, next;
  const struct face *f = &s->face[a], *g = &s->face[t];
  if (s->coplanar[a * s->faces + t] || height(g, x) <= 0)
    return 0;
  struct piece whole = {.n = 3}, above, below;
  for (int k = 0; k < 3; k++)
    whole.p[k] = sub(g->v[k], x);
  cut(&whole, f->normal, 0, &above, &below);
  now.n = 0;
  add(&now, &above);
  const struct blockers *list = oracle_between(s, a, t);
  for (int i = 0; i < list->n && now.n; i++) {
    struct shadow h;
    if (!make_shadow(&s->face[list->face[i]], x, &h))
      continue;
    subtract(&now, &next, &h);
    const struct pieces swap = now;
    now = next;
    next = swap;
  }
  double sum = 0;
  for (int i = 0; i < now.n; i++)
    sum += lambert(&now.list[i], f->normal);
  return sum;
}
