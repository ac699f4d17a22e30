/* Hulls of two triangles that a third one touches or enters: only the latter is a shadow. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/vec.h"
#include "scene_help.h"
#include "suite.h"
#include "visibility/occluder.h"

/* --- hulls that a third triangle touches or enters --- */

/* Corners of t's part in front of a plane through `at`. */
static int cut_front(const struct rad_triangle *t, const double at[3], const double normal[3],
                     double (*corner)[3]) {
  int n = 0;
  double h[3];
  for (int m = 0; m < 3; m++) {
    double r[3];
    rad_sub(t->v[m], at, r);
    h[m] = rad_dot(normal, r);
    if (h[m] >= 0)
      memcpy(corner[n++], t->v[m], sizeof *corner);
  }
  for (int m = 0; m < 3; m++) {
    int o = (m + 1) % 3;
    if (h[m] * h[o] < 0) {
      for (int d = 0; d < 3; d++)
        corner[n][d] = (t->v[m][d] * h[o] - t->v[o][d] * h[m]) / (h[o] - h[m]);
      n++;
    }
  }
  return n;
}

/* Two random triangles that face each other well, as the first two of a scene of three. */
struct pair {
  struct rad_triangle t[3];
  double corner[2][4][3]; /* of the cut triangles */
  int n[2];
};

static void set_triangle(struct rad_triangle *t, int number) {
  measure_triangle(t);
  for (int d = 0; d < 3; d++)
    t->vertex[d] = 3 * number + d;
}

static double depth(const double (*corner)[3], int n, const struct rad_triangle *t) {
  double most = 0;
  for (int c = 0; c < n; c++) {
    double r[3];
    rad_sub(corner[c], t->v[0], r);
    most = fmax(most, rad_dot(r, t->normal));
  }
  return most;
}

static void random_pair(struct pair *p) {
  do {
    *p = (struct pair){0};
    for (int i = 0; i < 2; i++) {
      do {
        for (int m = 0; m < 9; m++)
          p->t[i].v[m / 3][m % 3] = uniform(0, 1);
        set_triangle(&p->t[i], i);
      } while (p->t[i].area < 0.02);
    }
    for (int i = 0; i < 2; i++)
      p->n[i] = cut_front(&p->t[i], p->t[1 - i].v[0], p->t[1 - i].normal, p->corner[i]);
  } while (!p->n[0] || !p->n[1] || depth(p->corner[0], p->n[0], &p->t[1]) < 0.05 ||
           depth(p->corner[1], p->n[1], &p->t[0]) < 0.05);
}

/* Whether t[2] may keep t[0] and t[1] from seeing something of one another. */
static int third_shadows(struct pair *p) {
  double vertex[9][3];
  for (int m = 0; m < 9; m++)
    memcpy(vertex[m], p->t[m / 3].v[m % 3], sizeof vertex[m]);
  struct rad_scene scene = {.n_triangle = 3, .n_vertex = 9, .triangle = p->t, .size = 1.7};
  scene.vertex = vertex;
  struct rad_occluders o;
  struct rad_error e;
  int list[3], n;
  ck_assert_int_eq(rad_occluders_build(&scene, &o, &e), RAD_OK);
  enum rad_sight sight = rad_sight_between(&o, 0, 1, list, &n);
  ck_assert(sight != RAD_PARTLY || (n == 1 && o.occluder[list[0]].plane == o.plane[2]));
  rad_occluders_free(&o);
  return sight != RAD_FREE;
}

/* The greatest value of direction . x on the hull, and where. */
static double support(const struct pair *p, const double direction[3], const double **at) {
  double most = -INFINITY;
  for (int i = 0; i < 2; i++)
    for (int c = 0; c < p->n[i]; c++)
      if (rad_dot(direction, p->corner[i][c]) > most) {
        most = rad_dot(direction, p->corner[i][c]);
        *at = p->corner[i][c];
      }
  return most;
}

/* Make t[2] a triangle around `at` beyond the plane through it with this normal, touching the
 * plane with 1, 2 or 3 vertices, shifted along the normal. */
static void lean(struct pair *p, const double at[3], const double normal[3], int n_touching,
                 double shift) {
  double u[3], w[3];
  rad_cross(normal, fabs(normal[0]) < 0.6 ? (double[3]){1, 0, 0} : (double[3]){0, 1, 0}, u);
  double length = rad_norm(u), start = uniform(0, 6.3);
  for (int d = 0; d < 3; d++)
    u[d] /= length;
  rad_cross(normal, u, w);
  for (int m = 0; m < 3; m++) {
    double angle = start + 2.1 * m, reach = uniform(0.1, 1);
    double up = shift + (m < n_touching ? 0 : uniform(0.05, 1));
    int at_point = m == 0 && n_touching == 1;
    for (int d = 0; d < 3; d++)
      p->t[2].v[m][d] =
          at[d] + up * normal[d] + (at_point ? 0 : reach * (cos(angle) * u[d] + sin(angle) * w[d]));
  }
  set_triangle(&p->t[2], 2);
}

/* A vertex, an edge or the face of the third triangle on a corner of the hull, in any direction: no
 * shadow, and one as soon as it is pushed 1e-4 inwards by its vertex or its face. */
START_TEST(touching_the_hull_is_no_shadow) {
  start_random();
  for (int k = 0; k < 5000; k++) {
    struct pair p;
    random_pair(&p);
    double direction[3];
    const double *at = NULL;
    random_direction(direction);
    support(&p, direction, &at);
    lean(&p, at, direction, 1 + k % 3, 0);
    ck_assert_msg(!third_shadows(&p), "step %d, seed %llu", k, seed());
    lean(&p, at, direction, 3, -1e-4); /* at is well inside the triangle: it cuts the corner off */
    ck_assert_msg(third_shadows(&p), "step %d pushed in, seed %llu", k, seed());
  }
}
END_TEST

/* The same on the faces of the hull, spanned by three of its corners. */
START_TEST(lying_on_the_hull_is_no_shadow) {
  start_random();
  int n_face = 0;
  for (int k = 0; k < 3000; k++) {
    struct pair p;
    random_pair(&p);
    int i = k % 2, first = k % p.n[i], second = (k + 1) % p.n[i], third = k % p.n[1 - i];
    const double *a = p.corner[i][first], *b = p.corner[i][second], *c = p.corner[1 - i][third],
                 *at;
    double u[3], v[3], normal[3], center[3];
    rad_sub(b, a, u);
    rad_sub(c, a, v);
    rad_cross(u, v, normal);
    double length = rad_norm(normal);
    if (length < 0.05)
      continue;
    for (int flip = 0; flip < 2; flip++) {
      for (int d = 0; d < 3; d++) {
        normal[d] *= (flip ? -1 : 1 / length);
        center[d] = (a[d] + b[d] + c[d]) / 3;
      }
      if (support(&p, normal, &at) > rad_dot(normal, a) + 1e-12)
        continue; /* not a face */
      n_face++;
      for (int n = 1; n <= 3; n++) {
        lean(&p, center, normal, n, 0);
        ck_assert_msg(!third_shadows(&p), "step %d, seed %llu", k, seed());
        lean(&p, center, normal, n, -1e-7);
        ck_assert_msg(n == 2 || third_shadows(&p), "step %d pushed in, seed %llu", k, seed());
      }
    }
  }
  ck_assert_int_gt(n_face, 300);
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", seed());
  Suite *suite = suite_create("hull");
  TCase *tests = tcase_create("hull");
  tcase_add_test(tests, touching_the_hull_is_no_shadow);
  tcase_add_test(tests, lying_on_the_hull_is_no_shadow);
  tcase_set_timeout(tests, 120);
  suite_add_tcase(suite, tests);
  return run_suite(suite);
}
