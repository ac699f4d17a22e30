/* Random pairs of triangles with whole coordinates, turned, scaled and shifted: what is said of
 * them, against what exact arithmetic says of the whole numbers. */
#include <check.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "scene_help.h"
#include "suite.h"

enum { MOST = 6, N_PAIR = 6000 };

#define TOLERANCE 1e-9              /* of the scene's size, docs/format.md */
#define ROUNDING (16 * DBL_EPSILON) /* of the farthest coordinate */

enum outcome { SILENT, TOUCHES, CROSSES, REFUSED, N_OUTCOME };

static const char *const NAME[] = {"silent", "touches", "crosses", "refused"};

struct pair {
  int x[2][3][3];   /* triangle, vertex, coordinate */
  double gap;       /* of the second, along the normal of the first */
  int turned[2];    /* the vertices' order */
  int two_sided;    /* the second */
  double size, far; /* of the moved scene [m] */
  double scale;
};

/* --- the oracle --- */

static void subtract(const int *p, const int *q, int *d) {
  for (int m = 0; m < 3; m++)
    d[m] = p[m] - q[m];
}

static void normal_of(const int t[3][3], int n[3]) {
  int u[3], v[3];
  subtract(t[1], t[0], u);
  subtract(t[2], t[0], v);
  for (int m = 0; m < 3; m++)
    n[m] = u[(m + 1) % 3] * v[(m + 2) % 3] - u[(m + 2) % 3] * v[(m + 1) % 3];
}

static int height_of(const int p[3], const int t[3][3]) {
  int n[3], r[3];
  normal_of(t, n);
  subtract(p, t[0], r);
  return n[0] * r[0] + n[1] * r[1] + n[2] * r[2];
}

/* Least barycentric coordinate of a point in the plane of t: above 0 inside. */
static double inside(const double x[3], const int t[3][3]) {
  int n[3];
  normal_of(t, n);
  double square = (double)(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), least = 1;
  for (int m = 0; m < 3; m++) {
    const int *p = t[(m + 1) % 3], *q = t[(m + 2) % 3];
    double u[3], r[3], c[3];
    for (int d = 0; d < 3; d++) {
      u[d] = q[d] - p[d];
      r[d] = x[d] - p[d];
    }
    rad_cross(u, r, c);
    least = fmin(least, (c[0] * n[0] + c[1] * n[1] + c[2] * n[2]) / square);
  }
  return least;
}

/* Points that the common part of both is spanned by. */
struct points {
  int n;
  double x[30][3];
};

static void keep(struct points *p, const double x[3], const int t[3][3]) {
  int known = inside(x, t) < -1e-9;
  for (int k = 0; k < p->n && !known; k++)
    known = hypot(p->x[k][0] - x[0], hypot(p->x[k][1] - x[1], p->x[k][2] - x[2])) < 1e-9;
  if (!known)
    memcpy(p->x[p->n++], x, sizeof p->x[0]);
}

/* Where edges p q of one meet the other: its plane, or in one plane its edges. */
static void meet(struct points *points, const int a[3][3], const int b[3][3], int flat) {
  for (int m = 0; m < 3; m++) {
    const int *p = a[m], *q = a[(m + 1) % 3];
    int hp = height_of(p, b), hq = height_of(q, b);
    double x[3];
    for (int d = 0; d < 3; d++)
      x[d] = hp == 0 ? p[d] : p[d] + (double)hp / (hp - hq) * (q[d] - p[d]);
    if (flat || hp == 0 || (long)hp * hq < 0)
      keep(points, x, b);
    for (int o = 0; flat && o < 3; o++) {
      const int *r = b[o], *s = b[(o + 1) % 3];
      int det = (q[0] - p[0]) * (s[1] - r[1]) - (q[1] - p[1]) * (s[0] - r[0]);
      double share =
          det ? (double)((r[0] - p[0]) * (s[1] - r[1]) - (r[1] - p[1]) * (s[0] - r[0])) / det : -1;
      for (int d = 0; d < 3; d++)
        x[d] = p[d] + share * (q[d] - p[d]);
      if (share >= 0 && share <= 1)
        keep(points, x, b);
    }
  }
}

/* Whether the common part of both has inner points of both: the mean of what spans it is one. */
static int have_common_inside(const int a[3][3], const int b[3][3], int flat) {
  struct points points = {0};
  double mean[3] = {0};
  meet(&points, a, b, flat);
  meet(&points, b, a, flat);
  for (int k = 0; k < points.n; k++)
    for (int d = 0; d < 3; d++)
      mean[d] += points.x[k][d] / points.n;
  double least = points.n ? fmin(inside(mean, a), inside(mean, b)) : -1;
  ck_assert(points.n <= 12 && (least < 1e-9 || least > 1e-5)); /* whole numbers are clear */
  return least > 1e-5;
}

/* --- pairs --- */

static void random_triangle(int flat, int t[3][3]) {
  int n[3];
  do {
    for (int m = 0; m < 9; m++)
      t[m / 3][m % 3] = flat && m % 3 == 2 ? 0 : (int)uniform(0, MOST + 1);
    normal_of(t, n);
  } while (!n[0] && !n[1] && !n[2]);
}

static int share_vertices(const struct pair *p) {
  int n = 0;
  for (int m = 0; m < 9; m++)
    n += !memcmp(p->x[0][m / 3], p->x[1][m % 3], sizeof p->x[0][0]);
  return n;
}

/* The second triangle takes up to two vertices of the first. */
static void random_pair(int flat, struct pair *p) {
  int n[3];
  memset(p, 0, sizeof *p);
  do {
    random_triangle(flat, p->x[0]);
    random_triangle(flat, p->x[1]);
    for (int m = 0, shared = (int)uniform(0, 4) % 3; m < shared; m++)
      memcpy(p->x[1][m], p->x[0][m], sizeof p->x[0][0]);
    normal_of(p->x[1], n);
  } while ((!n[0] && !n[1] && !n[2]) || share_vertices(p) == 3);
  p->turned[0] = uniform(0, 1) < 0.5;
  p->turned[1] = uniform(0, 1) < 0.5;
}

/* Turned at random, 1e-3 to 1e3 in scale, and up to 1e6 away. */
static struct motion far_motion(int k) {
  struct motion m = random_motion(3);
  double away = k % 3 ? pow(10, uniform(-1, 6)) : 0;
  for (int d = 0; d < 3; d++)
    m.shift[d] = away * uniform(-1, 1);
  return m;
}

static enum outcome said_of(struct pair *p, const struct motion *motion) {
  struct rad_deck deck = {0};
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  p->far = 0;
  p->scale = motion->scale;
  for (int i = 0; i < 2; i++) {
    double v[3][3];
    for (int m = 0; m < 3; m++) {
      const int *whole = p->x[i][p->turned[i] ? 2 - m : m];
      const double x[3] = {whole[0], whole[1], whole[2] + (i ? p->gap : 0)};
      move(motion, x, v[m]);
      for (int d = 0; d < 3; d++) {
        low[d] = fmin(low[d], v[m][d]);
        high[d] = fmax(high[d], v[m][d]);
        p->far = fmax(p->far, fabs(v[m][d]));
      }
    }
    add(&deck, i ? "b" : "a", v)->optics.side = i && p->two_sided ? RAD_SIDE_BOTH : RAD_SIDE_FRONT;
  }
  p->size = hypot(high[0] - low[0], hypot(high[1] - low[1], high[2] - low[2]));
  struct built b = build(&deck);
  enum outcome outcome = b.code                                                  ? REFUSED
                         : b.notes.n == 0                                        ? SILENT
                         : strstr(b.notes.text[0], "(b) crosses triangle 1 (a)") ? CROSSES
                                                                                 : TOUCHES;
  if (b.code)
    ck_assert_msg(strstr(b.error.text,
                         "room.yml:11: error: triangle 2 (b): overlaps triangle 1 (a, "
                         "line 10), in the same plane and facing the same way"),
                  "%s", b.error.text);
  ck_assert_int_le(b.notes.n, 1);
  drop(&b, &deck);
  return outcome;
}

static void expect(enum outcome is, enum outcome wanted, const struct pair *p, int k, int *count) {
  ck_assert_msg(is == wanted || (wanted == TOUCHES && is == SILENT),
                "%s, expected %s: pair %d, seed %llu, gap %g, size %g, far %g", NAME[is],
                NAME[wanted], k, seed(), p->gap * p->scale, p->size, p->far);
  count[wanted]++;
}

/* Of one plane: overlapping faces are refused where a side of one is the side of the other, and
 * legal back to back; what has no area in common, in this plane or across a gap, is no overlap. */
START_TEST(one_plane) {
  int count[N_OUTCOME] = {0}, n_gap = 0;
  start_random();
  for (int k = 0; k < N_PAIR; k++) {
    struct pair p;
    random_pair(1, &p);
    p.two_sided = k % 8 == 0;
    p.gap = k % 2 ? (uniform(0, 1) < 0.5 ? -1 : 1) * MOST * pow(10, uniform(-12, -3)) : 0;
    int n[2][3];
    normal_of(p.x[0], n[0]);
    normal_of(p.x[1], n[1]);
    int up = (n[0][2] > 0) ^ p.turned[0], same = up == ((n[1][2] > 0) ^ p.turned[1]);
    struct motion motion = far_motion(k);
    enum outcome is = said_of(&p, &motion);
    double tolerance = fmax(TOLERANCE * p.size, ROUNDING * p.far), gap = fabs(p.gap) * p.scale;
    int area = have_common_inside(p.x[0], p.x[1], 1);
    if (gap > 0.5 * tolerance && gap < 2 * tolerance)
      continue;
    if (!area || gap > tolerance) {
      expect(is, TOUCHES, &p, k, count); /* or silent */
      n_gap += area;
    } else if (same || p.two_sided) {
      expect(is, REFUSED, &p, k, count);
    } else if (gap == 0 || (p.gap > 0) != up) { /* behind one another */
      expect(is, SILENT, &p, k, count);
    } else {
      expect(is, TOUCHES, &p, k, count);
    }
  }
  ck_assert(count[REFUSED] > 500 && count[SILENT] > 300 && count[TOUCHES] > 500 && n_gap > 300);
}
END_TEST

/* In space: crossing is told from standing on, from touching and from being apart. */
START_TEST(in_space) {
  int count[N_OUTCOME] = {0};
  start_random();
  for (int k = 0; k < N_PAIR; k++) {
    struct pair p;
    random_pair(0, &p);
    int flat = 1;
    for (int m = 0; m < 3; m++)
      flat &= height_of(p.x[1][m], p.x[0]) == 0;
    if (flat)
      continue;
    struct motion motion = far_motion(k);
    enum outcome is = said_of(&p, &motion);
    expect(is, have_common_inside(p.x[0], p.x[1], 0) ? CROSSES : TOUCHES, &p, k, count);
  }
  ck_assert(count[CROSSES] > 500 && count[TOUCHES] > 500);
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", seed());
  Suite *suite = suite_create("intersect");
  TCase *pairs = tcase_create("pairs");
  tcase_add_test(pairs, one_plane);
  tcase_add_test(pairs, in_space);
  tcase_set_timeout(pairs, 120);
  suite_add_tcase(suite, pairs);
  return run_suite(suite);
}
