/* K d at check points and the elements' parts in it, against rows of the exact integrals. */
#include <check.h>
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "adaptive_scenes.h"
#include "estimate/checks.h"
#include "suite.h"

enum { BLOCKER = -1 };
#define TOLERANCE 1e-6

static const struct problem {
  const char *name;
  int scene; /* of adaptive_scene, or BLOCKER */
  const char *mesh;
  int all_near; /* parts are exact */
} problems[] = {
    {"S1, degree 5", 0, "mesh: graded, elements: 1, grading: 2, degree: 5", 1},
    {"S2, degree 1", 1, "mesh: paper, elements: 6, degree: 1", 0},
    {"cube, degree 3", 8, "mesh: graded, elements: 2, grading: 2, degree: 3", 0},
    {"box 1:1:30, degree 2", 9, "mesh: graded, elements: 3, degree: 2", 0},
    {"blocker, degree 2", BLOCKER, "mesh: graded, elements: 3, degree: 2", 0},
};
enum { N_PROBLEM = sizeof problems / sizeof *problems };

/* The integral of d over an element, by a rule of its own. */
static double integrate(const struct rad_mesh *mesh, int element, const double *d) {
  enum { N = 24 };
  const struct rad_element *e = &mesh->element[element];
  const struct rad_patch *patch = &mesh->patch[e->patch];
  const double *x = rad_gauss_node(&mesh->gauss, N), *w = rad_gauss_weight(&mesh->gauss, N);
  double sum = 0, value[RAD_GAUSS_MAX * RAD_GAUSS_MAX];
  double half_s = 0.5 * (e->sigma[1] - e->sigma[0]), half_t = 0.5 * (e->tau[1] - e->tau[0]);
  for (int i = 0; i < N; i++)
    for (int j = 0; j < N; j++) {
      double sigma = e->sigma[0] + (1 + x[i]) * half_s, tau = e->tau[0] + (1 + x[j]) * half_t;
      double phi = pow(sigma, e->p_phi), r = pow(tau, e->p_r), u = 0;
      double slope = e->p_phi * pow(sigma, e->p_phi - 1) * e->p_r * pow(tau, e->p_r - 1);
      rad_element_basis(mesh, element, phi, r, value);
      for (int f = 0; f < e->n_function; f++)
        u += value[f] * d[e->first + f];
      sum += w[i] * w[j] * half_s * half_t * u * slope * r *
             rad_angle_dt(patch->angle, rad_angle_t(patch->angle, phi));
    }
  return sum * patch->a1 * patch->b2;
}

/* A wave with the sign and size of each element's own; one of eleven elements is dark. */
static void set_d(const struct rad_mesh *mesh, double *d, double *integral) {
  for (int i = 0; i < mesh->n_element; i++) {
    double own = i % 11 == 4 ? 0 : sin(7.0 * i) / (1 + i % 3);
    for (int f = 0; f < mesh->element[i].n_function; f++) {
      double x[3];
      int at = mesh->element[i].first + f;
      rad_point_position(mesh, at, x);
      d[at] = own * (1.5 + cos(2 * x[0] + x[1] - x[2]));
    }
    integral[i] = integrate(mesh, i, d);
    for (int f = 0; f < mesh->element[i].n_function; f++) {
      int at = mesh->element[i].first + f;
      d[mesh->n_point + at] = integral[i] < 0 ? -d[at] : d[at];
    }
  }
}

/* The exact numbers of all points. */
struct exact {
  const struct rad_mesh *mesh;
  const unsigned char *sees;
  const struct rad_point_list *points;
  const unsigned char *limit;
  const double *d;
  double *total, *sum, *largest, *part; /* [n]; part [threads, n_element] */
};

static void add_exact(void *context, int thread, int first, int m, const double *row) {
  struct exact *x = context;
  int n = x->mesh->scene->n_triangle;
  for (int i = 0; i < m; i++)
    for (int e = 0; e < x->mesh->n_element; e++) {
      const struct rad_element *el = &x->mesh->element[e];
      double one = 0, *part = &x->part[thread * x->mesh->n_element + e];
      if (!x->sees[x->points->triangle[first] * n + rad_element_triangle(x->mesh, e)])
        continue;
      for (int f = el->first; f < el->first + el->n_function; f++)
        one += row[(size_t)f * (size_t)m + (size_t)i] * x->d[f];
      x->total[first + i] += one;
      x->sum[first + i] += fabs(one);
      x->largest[first + i] = fmax(x->largest[first + i], fabs(one));
      if (!x->limit[first + i])
        *part = fmax(*part, fabs(one));
    }
}

static double most_of(const double *part, int n_element, int e) {
  double most = 0;
  for (int t = 0; t < omp_get_max_threads(); t++)
    most = fmax(most, part[t * n_element + e]);
  return most;
}

/* How the numbers of both kinds compare: least and largest ratio where they matter. */
static void compare(const struct problem *p, const char *what, int n, const double *is,
                    const double *exact, double low, double high) {
  double least = INFINITY, most = 0, scale = 0;
  for (int i = 0; i < n; i++)
    scale = fmax(scale, exact[i]);
  for (int i = 0; i < n; i++)
    if (exact[i] > 1e-3 * scale) {
      least = fmin(least, is[i] / exact[i]);
      most = fmax(most, is[i] / exact[i]);
    }
  if (getenv("POLYRAD_TEST_VERBOSE"))
    printf("%-22s %-8s %.3f .. %.3f of the exact\n", p->name, what, least, most);
  ck_assert_msg(least >= low && most <= high, "%s, %s: %g .. %g of the exact", p->name, what, least,
                most);
}

START_TEST(parts) {
  const struct problem *p = &problems[_i];
  struct deck_text *text = malloc(sizeof *text);
  struct rad_case c;
  struct rad_error e;
  if (p->scene == BLOCKER)
    blocker_scene(text);
  else
    adaptive_scene(p->scene, text);
  deck_add(text, "method: {%s, matrix: dense}\n", p->mesh);
  ck_assert_msg(deck_prepare(text, &c, &e) == RAD_OK, "%s", e.text);
  ck_assert_int_eq(rad_rules_build(c.mesh, 0.1 * TOLERANCE, &c.rules, &e), RAD_OK);
  int n_element = c.mesh->n_element, n_thread = omp_get_max_threads();
  double *d = malloc(2 * sizeof *d * (size_t)c.mesh->n_point);
  double *integral = malloc(sizeof *d * (size_t)n_element);
  double *weight = malloc(sizeof *d * (size_t)c.scene.n_triangle);
  unsigned char *checked = malloc((size_t)c.scene.n_triangle);
  for (int t = 0; t < c.scene.n_triangle; t++)
    weight[t] = checked[t] = 1;
  set_d(c.mesh, d, integral);

  struct rad_once o;
  struct rad_checks checks;
  const double *in[2] = {d, d + c.mesh->n_point};
  ck_assert_int_eq(rad_once_begin(c.mesh, &c.rules, 64, TOLERANCE, &o, &e), RAD_OK);
  ck_assert_int_eq(rad_once_gather(&o, 2, in, &e), RAD_OK);
  ck_assert_int_eq(rad_checks_set(c.mesh, checked, 0, &checks, &e), RAD_OK);
  ck_assert_int_eq(rad_checks_run(&o, integral, weight, &checks, &e), RAD_OK);
  ck_assert_int_eq(o.blocks.far.first[o.tree.n_cluster] == 0, p->all_near);

  int *triangle = malloc(sizeof(int) * (size_t)checks.n);
  for (int i = 0; i < n_element; i++)
    for (int q = checks.first[i]; q < checks.first[i] + checks.count[i]; q++)
      triangle[q] = rad_element_triangle(c.mesh, i);
  struct rad_point_list list = {checks.n, triangle, checks.base, (const double(*)[2])checks.mu};
  double *value = calloc(3 * (size_t)checks.n, sizeof(double)), worst = 0;
  struct exact x = {c.mesh,
                    c.visibility.sight,
                    &list,
                    checks.limit,
                    d,
                    value,
                    value + checks.n,
                    value + 2 * checks.n,
                    calloc((size_t)(n_thread * n_element), sizeof(double))};
  ck_assert_int_eq(rad_visit_rows(c.mesh, &c.rules, c.visibility.sight, &list, add_exact, &x, &e),
                   RAD_OK);
  for (int q = 0; q < checks.n; q++)
    worst = fmax(worst, fabs(checks.total[q] - x.total[q]));
  ck_assert_msg(worst <= 2.5 * TOLERANCE, "%s: K d is off by %g", p->name, worst); /* |d| <= 2.5 */
  double *part = malloc(2 * sizeof *part * (size_t)n_element);
  for (int i = 0; i < n_element; i++) {
    part[i] = most_of(checks.part, n_element, i);
    part[n_element + i] = most_of(x.part, n_element, i);
  }
  /* what is far: the sum is exact, since the signs agree; the largest part is right up to the
   * change of the kernel over a block, whose clusters are 0.7 diameters apart or more; and an
   * element's own part is found at nodes, which may be nearer than the points or farther */
  int near = p->all_near;
  compare(p, "sum", checks.n, checks.sum, x.sum, near ? 1 - 1e-12 : 0.99, near ? 1 + 1e-12 : 1.01);
  compare(p, "largest", checks.n, checks.largest, x.largest, near ? 1 - 1e-12 : 0.4,
          near ? 1 + 1e-12 : 2.5);
  compare(p, "part", n_element, part, part + n_element, near ? 1 - 1e-12 : 0.5,
          near ? 1 + 1e-12 : 4);
  for (int i = 0; i < n_element; i++)
    ck_assert(i % 11 != 4 || part[i] == 0);
  free(part);
  free(x.part);
  free(value);
  free(triangle);
  rad_checks_free(&checks);
  rad_once_free(&o);
  free(checked);
  free(weight);
  free(integral);
  free(d);
  rad_case_free(&c);
  free(text);
}
END_TEST

int main(void) {
  Suite *s = suite_create("checks");
  TCase *c = tcase_create("checks");
  tcase_set_timeout(c, 600);
  tcase_add_loop_test(c, parts, 0, N_PROBLEM);
  suite_add_tcase(s, c);
  return run_suite(s);
}
