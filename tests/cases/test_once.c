/* Products that are made once, at any points, against rows of the exact integrals. */
#include <check.h>
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "adaptive_scenes.h"
#include "estimate/iterate.h"
#include "suite.h"
#include "system/h2_once.h"

enum { BLOCKER = -1, N_VECTOR = 4, EACH = 5 };

static const struct problem {
  const char *name;
  int scene; /* of adaptive_scene, or BLOCKER */
  const char *mesh;
  double tolerance;
  int leaf;
} problems[] = {
    {"S1, P(8,1), degree 1", 0, "mesh: paper, elements: 8, degree: 1", 1e-6, 64},
    {"S1, P(4,2), degree 1", 0, "mesh: paper, elements: 4, grading: 2, degree: 1", 1e-4, 20},
    {"S2, graded, degree 4", 1, "mesh: graded, elements: 3, grading: 2, degree: 4", 1e-8, 64},
    {"angle 10, degree 3", 3, "mesh: paper, elements: 3, degree: 3", 1e-6, 100},
    {"cube, degree 2", 8, "mesh: paper, elements: 2, degree: 2", 1e-10, 64},
    {"cube, degree 0", 8, "mesh: uniform, elements: 14, degree: 0", 1e-5, 30},
    {"box 1:1:30", 9, "mesh: graded, elements: 2, grading: 3, degree: 5", 1e-7, 40},
    {"blocker, degree 0", BLOCKER, "mesh: uniform, elements: 12, degree: 0", 1e-5, 30},
    {"blocker, degree 3", BLOCKER, "mesh: graded, elements: 4, degree: 3", 1e-6, 64},
};
enum { N_PROBLEM = sizeof problems / sizeof *problems };

static const unsigned seed = 20261125;

/* A case with functions and points; quadrature is ten times finer than the interpolation. */
struct setting {
  struct rad_case c;
  struct rad_element_points points;
  int n, *first, *count, *triangle, *base; /* n points */
  double (*mu)[2];
  double *u, *data; /* [N_VECTOR, n_point] */
  const double *vector[N_VECTOR];
};

/* Points anywhere in every element, one of them 1e-7 from its lower sides. */
static void set_points(struct setting *s) {
  const struct rad_mesh *mesh = s->c.mesh;
  int most = mesh->n_element * EACH;
  s->first = malloc(sizeof(int) * (size_t)mesh->n_element);
  s->count = malloc(sizeof(int) * (size_t)mesh->n_element);
  s->triangle = malloc(sizeof(int) * (size_t)most);
  s->base = malloc(sizeof(int) * (size_t)most);
  s->mu = malloc(sizeof *s->mu * (size_t)most);
  srand48(seed);
  for (int i = 0; i < mesh->n_element; i++) {
    const struct rad_element *e = &mesh->element[i];
    const struct rad_patch *patch = &mesh->patch[e->patch];
    s->first[i] = s->n;
    s->count[i] = EACH - i % 3;
    for (int q = 0; q < s->count[i]; q++, s->n++) {
      double a = q ? drand48() : 1e-7, b = q ? drand48() : 1e-7;
      double sigma = e->sigma[0] + a * (e->sigma[1] - e->sigma[0]);
      double tau = e->tau[0] + b * (e->tau[1] - e->tau[0]);
      s->triangle[s->n] = patch->triangle;
      s->base[s->n] = patch->base;
      rad_patch_mu(patch, pow(sigma, e->p_phi), pow(tau, e->p_r), s->mu[s->n]);
    }
  }
  s->points = (struct rad_element_points){s->first, s->count, s->base, (const double(*)[2])s->mu};
}

/* A wave, random signs, numbers on one element of three only, and these again: |u| <= 1. */
static void set_vectors(struct setting *s) {
  const struct rad_mesh *mesh = s->c.mesh;
  size_t n = (size_t)mesh->n_point;
  s->u = calloc(N_VECTOR * n, sizeof(double));
  for (int i = 0; i < mesh->n_element; i++)
    for (int f = 0; f < mesh->element[i].n_function; f++) {
      double x[3];
      size_t at = (size_t)(mesh->element[i].first + f);
      rad_point_position(mesh, (int)at, x);
      s->u[at] = cos(3 * x[0] + 2 * x[1] - 5 * x[2]);
      s->u[n + at] = drand48() < 0.5 ? -1 : 1;
      s->u[2 * n + at] = i % 3 ? 0 : drand48();
      s->u[3 * n + at] = s->u[2 * n + at];
    }
  for (size_t v = 0; v < N_VECTOR; v++)
    s->vector[v] = s->u + v * n;
}

static void begin(const struct problem *p, struct setting *s) {
  struct deck_text *d = malloc(sizeof *d);
  struct rad_error e;
  *s = (struct setting){0};
  if (p->scene == BLOCKER)
    blocker_scene(d);
  else
    adaptive_scene(p->scene, d);
  deck_add(d, "method: {%s, matrix: dense}\n", p->mesh);
  ck_assert_msg(deck_prepare(d, &s->c, &e) == RAD_OK, "%s", e.text);
  ck_assert_int_eq(rad_rules_build(s->c.mesh, 0.1 * p->tolerance, &s->c.rules, &e), RAD_OK);
  free(d);
  set_points(s);
  set_vectors(s);
}

static void end(struct setting *s) {
  free(s->first);
  free(s->count);
  free(s->triangle);
  free(s->base);
  free(s->mu);
  free(s->u);
  rad_case_free(&s->c);
}

/* What near elements sent of vector 2, [n]. */
static void collect(void *context, int thread, int element, int target, int n, const int *point,
                    const double *value) {
  double *sum = context;
  (void)thread;
  (void)element;
  (void)target;
  for (int i = 0; i < n; i++)
    sum[point[i]] += value[2 * n + i];
}

/* y [N_VECTOR, n], near parts of the last vector left out; near [n]. */
static void product(const struct problem *p, struct setting *s, double *y, double *near) {
  struct rad_once o;
  struct rad_error e;
  double *out[N_VECTOR];
  for (int v = 0; v < N_VECTOR; v++)
    out[v] = y + (size_t)v * (size_t)s->n;
  memset(near, 0, sizeof *near * (size_t)s->n);
  ck_assert_int_eq(rad_once_begin(s->c.mesh, &s->c.rules, p->leaf, p->tolerance, &o, &e), RAD_OK);
  ck_assert_msg(o.blocks.far.first[o.tree.n_cluster] > 0, "%s: nothing is far", p->name);
  ck_assert_int_eq(rad_once_gather(&o, 1, s->vector + 1, &e), RAD_OK); /* may be done again */
  ck_assert_int_eq(rad_once_gather(&o, N_VECTOR, s->vector, &e), RAD_OK);
  ck_assert_int_eq(rad_once_at(&o, &s->points, N_VECTOR - 1, out, collect, near, &e), RAD_OK);
  rad_once_free(&o);
  rad_once_free(&o);
}

START_TEST(agrees_with_rows) {
  const struct problem *p = &problems[_i];
  struct setting s;
  struct rad_error e;
  begin(p, &s);
  size_t n = (size_t)s.n;
  double *y = malloc(sizeof *y * N_VECTOR * n), *exact = malloc(sizeof *y * N_VECTOR * n);
  double *near = malloc(sizeof *near * n), worst = 0, split = 0;
  product(p, &s, y, near);
  struct rad_point_list list = {s.n, s.triangle, s.base, (const double(*)[2])s.mu};
  ck_assert_int_eq(rad_irradiance_at(s.c.mesh, &s.c.rules, &list, N_VECTOR, s.u, exact, &e),
                   RAD_OK);
  for (size_t i = 0; i < n; i++) {
    for (size_t v = 0; v + 1 < N_VECTOR; v++)
      worst = fmax(worst, fabs(y[v * n + i] - exact[i * N_VECTOR + v]));
    split = fmax(split, fabs(y[3 * n + i] + near[i] - y[2 * n + i])); /* far and near are all */
  }
  if (getenv("POLYRAD_TEST_VERBOSE"))
    printf("%-22s n %5d, %6d points: error %.2g of the tolerance\n", p->name, s.c.mesh->n_point,
           s.n, worst / p->tolerance);
  ck_assert_msg(worst <= p->tolerance, "%s: error %g, seed %u", p->name, worst, seed);
  ck_assert_msg(worst > 0, "%s: nothing was interpolated", p->name);
  ck_assert_msg(split <= 1e-14, "%s: parts differ from the whole by %g", p->name, split);
  free(y);
  free(exact);
  free(near);
  end(&s);
}
END_TEST

/* 1, 2 and 7 threads. */
START_TEST(same_bits) {
  static const int which[] = {0, 7}, threads[] = {1, 2, 7};
  const struct problem *p = &problems[which[_i]];
  double *y[3], *near[3];
  for (int t = 0; t < 3; t++) {
    struct setting s;
    omp_set_num_threads(threads[t]);
    begin(p, &s);
    size_t n = (size_t)s.n;
    y[t] = malloc(sizeof **y * N_VECTOR * n);
    near[t] = malloc(sizeof **near * n);
    product(p, &s, y[t], near[t]);
    ck_assert_int_eq(memcmp(y[0], y[t], sizeof **y * N_VECTOR * n), 0);
    ck_assert_int_eq(memcmp(near[0], near[t], sizeof **near * n), 0);
    end(&s);
  }
  for (int t = 0; t < 3; t++) {
    free(y[t]);
    free(near[t]);
  }
}
END_TEST

int main(void) {
  Suite *s = suite_create("once");
  TCase *c = tcase_create("once");
  tcase_set_timeout(c, 600);
  tcase_add_loop_test(c, agrees_with_rows, 0, N_PROBLEM);
  tcase_add_loop_test(c, same_bits, 0, 2);
  suite_add_tcase(s, c);
  return run_suite(s);
}
