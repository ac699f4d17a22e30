#include "clip_oracle.h"

#include <math.h>
#include <stdlib.h>

typedef __float128 quad;

enum { MAX_CUT = 8 }; /* a triangle cut by four planes */

/* --- projection: pyramid coordinates L_m(p) = det(p - x, v_{m+1} - x, v_{m+2} - x) / det(v - x),
 * which are >= 0 within the pyramid, with a sum of 1 in the plane of the source and less before it
 * --- */

struct cut {
  int n;
  quad at[MAX_CUT][3];
};

static quad det(const quad a[3], const quad b[3], const quad c[3]) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
         a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* L_0, L_1, L_2 >= 0 and 1 - L_0 - L_1 - L_2 >= 0 */
static quad bound(const quad at[3], int side) {
  return side < 3 ? at[side] : 1 - at[0] - at[1] - at[2];
}

static void cut_at(struct cut *c, int side) {
  struct cut in = *c;
  c->n = 0;
  for (int a = 0; a < in.n; a++) {
    const quad *p = in.at[a], *q = in.at[(a + 1) % in.n];
    quad f = bound(p, side), g = bound(q, side);
    if (f >= 0) {
      for (int m = 0; m < 3; m++)
        c->at[c->n][m] = p[m];
      c->n++;
    }
    if ((f < 0 && g > 0) || (f > 0 && g < 0)) {
      for (int m = 0; m < 3; m++)
        c->at[c->n][m] = (g * p[m] - f * q[m]) / (g - f);
      c->n++;
    }
  }
}

/* --- union --- */

struct shade {
  int n;
  long double corner[MAX_CUT][2], low, high;
};

struct edge {
  long double x0, y0, x1, slope; /* x0 < x1 */
};

struct span {
  long double low, high;
};

static int by_value(const void *a, const void *b) {
  long double p = *(const long double *)a, q = *(const long double *)b;
  return (p > q) - (p < q);
}

/* Length of the union of the shades' sections at abscissa x. */
static long double section(int n, const struct shade *shade, long double x, struct span *span) {
  int n_span = 0;
  for (int k = 0; k < n; k++) {
    const struct shade *s = &shade[k];
    if (!(s->low < x && x < s->high))
      continue;
    struct span found = {INFINITY, -INFINITY};
    for (int a = 0; a < s->n; a++) {
      const long double *p = s->corner[a], *q = s->corner[a + 1 < s->n ? a + 1 : 0];
      if ((p[0] < x) == (q[0] < x))
        continue;
      long double y = p[1] + (x - p[0]) / (q[0] - p[0]) * (q[1] - p[1]);
      found.low = fminl(found.low, y);
      found.high = fmaxl(found.high, y);
    }
    if (found.low < found.high)
      span[n_span++] = found;
  }
  qsort(span, (size_t)n_span, sizeof *span, by_value); /* low comes first */
  long double length = 0, reached = -INFINITY;
  for (int a = 0; a < n_span; a++) {
    if (span[a].high > reached)
      length += span[a].high - fmaxl(span[a].low, reached);
    reached = fmaxl(reached, span[a].high);
  }
  return length;
}

static int make_edges(int n, const struct shade *shade, struct edge *edge) {
  int n_edge = 0;
  for (int k = 0; k < n; k++)
    for (int a = 0; a < shade[k].n; a++) {
      const long double *p = shade[k].corner[a], *q = shade[k].corner[(a + 1) % shade[k].n];
      if (p[0] > q[0]) {
        const long double *swap = p;
        p = q;
        q = swap;
      }
      if (p[0] < q[0])
        edge[n_edge++] = (struct edge){p[0], p[1], q[0], (q[1] - p[1]) / (q[0] - p[0])};
    }
  return n_edge;
}

/* Abscissas of all ends and crossings; owned. */
static long double *make_events(int n_edge, const struct edge *edge, int *n) {
  int room = 2 * n_edge + 1;
  long double *at = malloc((size_t)room * sizeof *at);
  *n = 0;
  for (int a = 0; at && a < n_edge; a++) {
    at[(*n)++] = edge[a].x0;
    at[(*n)++] = edge[a].x1;
  }
  for (int a = 0; at && a < n_edge; a++)
    for (int b = 0; at && b < a; b++) {
      const struct edge *e = &edge[a], *f = &edge[b];
      long double low = fmaxl(e->x0, f->x0), high = fminl(e->x1, f->x1);
      if (low >= high || e->slope == f->slope)
        continue;
      long double gap = e->y0 - f->y0 + (low - e->x0) * e->slope - (low - f->x0) * f->slope;
      long double x = low - gap / (e->slope - f->slope);
      if (x <= low || x >= high)
        continue;
      if (*n == room) {
        room *= 2;
        long double *more = realloc(at, (size_t)room * sizeof *at);
        if (!more)
          free(at);
        at = more;
      }
      if (at)
        at[(*n)++] = x;
    }
  if (at)
    qsort(at, (size_t)*n, sizeof *at, by_value);
  return at;
}

/* Between events the section is linear in x: the midpoint rule is exact. NAN without memory. */
static long double union_area(int n, const struct shade *shade) {
  int n_event = 0;
  struct edge *edge = malloc(((size_t)n * MAX_CUT + 1) * sizeof *edge);
  struct span *span = malloc(((size_t)n + 1) * sizeof *span);
  long double *event = edge ? make_events(make_edges(n, shade, edge), edge, &n_event) : NULL;
  long double sum = edge && span && event ? 0 : NAN;
  for (int a = 0; sum == sum && a + 1 < n_event; a++)
    if (event[a] < event[a + 1])
      sum += (event[a + 1] - event[a]) *
             section(n, shade, event[a] + (event[a + 1] - event[a]) / 2, span);
  free(edge);
  free(span);
  free(event);
  return sum;
}

/* --- both --- */

/* The shade of one blocker in barycentric coordinates; 0 if there is none. */
static int cast(const double blocker[3][3], const quad x[3], const quad v[3][3], quad whole,
                struct shade *shade) {
  struct cut c = {.n = 3};
  for (int a = 0; a < 3; a++) {
    quad r[3];
    for (int d = 0; d < 3; d++)
      r[d] = blocker[a][d] - x[d];
    for (int m = 0; m < 3; m++)
      c.at[a][m] = det(r, v[(m + 1) % 3], v[(m + 2) % 3]) / whole;
  }
  for (int side = 0; side < 4 && c.n > 2; side++)
    cut_at(&c, side);
  if (c.n < 3)
    return 0;
  *shade = (struct shade){.low = INFINITY, .high = -INFINITY};
  for (int a = 0; a < c.n; a++) {
    quad sum = c.at[a][0] + c.at[a][1] + c.at[a][2];
    if (!(sum > 0)) /* the point itself */
      continue;
    long double *corner = shade->corner[shade->n++];
    for (int d = 0; d < 2; d++)
      corner[d] = (long double)(c.at[a][1 + d] / sum);
    shade->low = fminl(shade->low, corner[0]);
    shade->high = fmaxl(shade->high, corner[0]);
  }
  return shade->n > 2;
}

double clip_oracle(const double target[3][3], int base, const double mu[2],
                   const double source[3][3], int n, const double (*blocker)[3][3]) {
  const double *v0 = target[base], *v1 = target[(base + 1) % 3], *v2 = target[(base + 2) % 3];
  quad x[3], v[3][3];
  for (int d = 0; d < 3; d++)
    x[d] = v0[d] + ((quad)mu[0] * ((quad)v1[d] - v0[d]) + (quad)mu[1] * ((quad)v2[d] - v0[d]));
  for (int m = 0; m < 3; m++)
    for (int d = 0; d < 3; d++)
      v[m][d] = source[m][d] - x[d];
  quad whole = det(v[0], v[1], v[2]);
  struct shade *shade = malloc(((size_t)n + 1) * sizeof *shade);
  int n_shade = 0;
  for (int k = 0; shade && k < n; k++)
    n_shade += cast(blocker[k], x, v, whole, &shade[n_shade]);
  long double hidden = shade ? union_area(n_shade, shade) : NAN;
  free(shade);
  return (double)(1 - 2 * hidden);
}
