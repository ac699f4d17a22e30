#include "shadow_oracle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef long double real;

static real dot(const real a[3], const real b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void sub(const real a[3], const real b[3], real c[3]) {
  for (int d = 0; d < 3; d++)
    c[d] = a[d] - b[d];
}

static void cross(const real a[3], const real b[3], real c[3]) {
  for (int d = 0; d < 3; d++)
    c[d] = a[(d + 1) % 3] * b[(d + 2) % 3] - a[(d + 2) % 3] * b[(d + 1) % 3];
}

struct eye eye_at(const double v[3][3], int base, const double mu[2], const double normal[3]) {
  struct eye eye;
  for (int d = 0; d < 3; d++) {
    real f1 = (real)v[(base + 1) % 3][d] - v[base][d], f2 = (real)v[(base + 2) % 3][d] - v[base][d];
    eye.x[d] = v[base][d] + mu[0] * f1 + mu[1] * f2;
    eye.normal[d] = normal[d];
  }
  return eye;
}

/* Keep the part where normal.(y - at) >= 0. */
static void cut(struct flat *p, const real at[3], const real normal[3]) {
  struct flat kept = {0};
  real f[MOST_CORNER + 1], r[3];
  for (int i = 0; i < p->n; i++) {
    sub(p->corner[i], at, r);
    f[i] = dot(normal, r);
  }
  for (int i = 0; i < p->n; i++) {
    int next = (i + 1) % p->n;
    if (kept.n + 2 > MOST_CORNER)
      abort();
    if (f[i] >= 0)
      memcpy(kept.corner[kept.n++], p->corner[i], sizeof p->corner[i]);
    if ((f[i] > 0 && f[next] < 0) || (f[i] < 0 && f[next] > 0)) {
      real s = f[i] / (f[i] - f[next]);
      for (int d = 0; d < 3; d++)
        kept.corner[kept.n][d] = p->corner[i][d] + s * (p->corner[next][d] - p->corner[i][d]);
      kept.n++;
    }
  }
  *p = kept;
}

/* Cut to what lies behind a triangle as seen from the eye. */
static void cut_to_shadow(const struct eye *eye, const double blocker[3][3], struct flat *p) {
  real q[3][3], beyond[3], side[3][3], u[3], v[3];
  for (int m = 0; m < 3; m++)
    for (int d = 0; d < 3; d++)
      q[m][d] = blocker[m][d];
  sub(q[1], q[0], u);
  sub(q[2], q[0], v);
  cross(u, v, beyond);
  sub(q[0], eye->x, u);
  real height = dot(beyond, u);
  if (height == 0)
    p->n = 0;
  for (int m = 0; m < 3; m++) {
    sub(q[m], eye->x, u);
    sub(q[(m + 1) % 3], eye->x, v);
    cross(u, v, side[m]);
    for (int d = 0; d < 3; d++)
      side[m][d] = height > 0 ? side[m][d] : -side[m][d];
  }
  for (int d = 0; d < 3; d++)
    beyond[d] = height > 0 ? beyond[d] : -beyond[d];
  cut(p, q[0], beyond);
  for (int m = 0; m < 3; m++)
    cut(p, eye->x, side[m]);
}

static void include(const struct eye *eye, const struct flat *p, int sign, int n,
                    const double (*blocker)[3][3], shadow_visitor *visit, void *context) {
  visit(context, p, sign);
  for (int k = 0; k < n; k++) {
    struct flat shaded = *p;
    cut_to_shadow(eye, blocker[k], &shaded);
    if (shaded.n)
      include(eye, &shaded, -sign, n - k - 1, blocker + k + 1, visit, context);
  }
}

void shadow_visit(const struct eye *eye, const struct flat *polygon, int n,
                  const double (*blocker)[3][3], shadow_visitor *visit, void *context) {
  struct flat front = *polygon;
  cut(&front, eye->x, eye->normal);
  if (front.n)
    include(eye, &front, 1, n, blocker, visit, context);
}

real flat_form_factor(const struct eye *eye, const struct flat *p) {
  real sum = 0, a[3], b[3], c[3];
  for (int i = 0; i < p->n; i++) {
    sub(p->corner[i], eye->x, a);
    sub(p->corner[(i + 1) % p->n], eye->x, b);
    cross(a, b, c);
    real length = sqrtl(dot(c, c));
    if (length > 0)
      sum += atan2l(length, dot(a, b)) * dot(eye->normal, c) / length;
  }
  return fabsl(sum) / (2 * acosl(-1));
}

struct total {
  const struct eye *eye;
  real sum;
};

static void add_form_factor(void *context, const struct flat *polygon, int sign) {
  struct total *t = context;
  t->sum += sign * flat_form_factor(t->eye, polygon);
}

real shadow_form_factor(const struct eye *eye, const double source[3][3], const double normal[3],
                        int n, const double (*blocker)[3][3]) {
  struct total t = {eye, 0};
  struct flat whole = {.n = 3};
  real height = 0;
  for (int m = 0; m < 3; m++)
    for (int d = 0; d < 3; d++)
      whole.corner[m][d] = source[m][d];
  for (int d = 0; d < 3; d++)
    height += normal[d] * (eye->x[d] - source[0][d]);
  if (height > 0)
    shadow_visit(eye, &whole, n, blocker, add_form_factor, &t);
  return t.sum;
}
