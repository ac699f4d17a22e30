/*
 * Trust in the oracle: Lambert's closed form, an exact radial antiderivative, symmetry, partition
 * of unity, and its own convergence. Random cases print their seed.
 */
#include "oracle.h"
#include "suite.h"

#include <check.h>
#include <math.h>
#include <quadmath.h>
#include <stdio.h>
#include <stdlib.h>

__extension__ typedef __float128 quad;
typedef long double ext;

enum { SEED = 20240611, MAX_K = 12 };
static const double TIGHT = 5e-18; /* of sum |I|: about fifty roundings of long double */
static const double NOISE = 1e-32; /* Lambert sums angles of order one in quadruple precision */

static double uniform(double low, double high) {
  return low + (high - low) * (rand() / (RAND_MAX + 1.0));
}

static ext total(int n, const ext *I, ext *absolute) {
  ext sum = 0;
  *absolute = 0;
  for (int i = 0; i < n; i++) {
    sum += I[i];
    *absolute += fabsl(I[i]);
  }
  return sum;
}

/* Sum over the basis = Lambert: the Lagrange polynomials add up to one. */
static void hold_to_lambert(const struct oracle_point *x, const struct oracle_element *e) {
  ext I[MAX_K * MAX_K], absolute;
  ck_assert_int_ge(oracle_integrate(x, e, I), 0);
  const ext sum = total(e->k_phi * e->k_r, I, &absolute);
  const ext error = fabsl(sum - oracle_lambert_element(x, e));
  ck_assert_msg(error <= TIGHT * absolute + NOISE, "off Lambert by %.1Le of %.3Le", error,
                absolute);
}

static void random_scene(struct oracle_point *x, struct oracle_element *e, double distance) {
  const double grading[5] = {1, 2, 3, 6, uniform(1.5, 4)};
  *e = (struct oracle_element){.polar = rand() % 2, .sigma = {0, 1}, .tau = {0, 1}};
  *x = (struct oracle_point){.mu1 = uniform(0, 1) * distance, .mu2 = uniform(0, 1) * distance};
  e->p_phi = grading[rand() % 5];
  e->p_r = grading[rand() % 5];
  e->sigma[rand() % 2] = uniform(0.3, 0.7);
  e->tau[rand() % 2] = uniform(0.3, 0.7);
  e->k_phi = 1 + rand() % MAX_K;
  e->k_r = 1 + rand() % MAX_K;
  const double phi = rand() % 2 ? 0 : uniform(0, 1), r = rand() % 3 ? uniform(0, 1.2) : 0;
  for (int i = 0; i < 3; i++) {
    e->v[i] = uniform(-1, 1);
    e->a[i] = uniform(-1, 1);
    e->b[i] = uniform(-1, 1);
    x->edge1[i] = uniform(-1, 1);
    x->edge2[i] = uniform(-1, 1);
    x->vertex[i] = e->v[i] + r * (e->a[i] + phi * e->b[i]) + distance * uniform(-1, 1);
  }
}

/* Turns both normals so that x and the patch's vertex see each other. */
static void face_each_other(struct oracle_point *x, struct oracle_element *e) {
  for (int i = 0; i < 3; i++) {
    const double y = e->v[i] + 0.5 * e->a[i] + 0.2 * e->b[i];
    x->normal[i] = y - x->vertex[i];
    e->normal[i] = -x->normal[i];
  }
}

START_TEST(test_gauss) {
  for (int n = 1; n <= 40; n++) {
    ext z[40], w[40];
    oracle_gauss(n, z, w);
    for (int power = 0; power < 2 * n; power++) {
      ext sum = 0;
      for (int q = 0; q < n; q++)
        sum += w[q] * powl(z[q], power);
      const ext exact = power % 2 ? 0 : 2.0L / (power + 1);
      ck_assert(fabsl(sum - exact) < 2e-18L);
    }
  }
}
END_TEST

/* Two Lambert values known in closed form without arctangents of vectors: Hottel's tables. */
START_TEST(test_lambert_known) {
  const struct oracle_point x = {.edge1 = {1, 0, 0}, .edge2 = {0, 1, 0}, .normal = {0, 0, 1}};
  const double front[4][3] = {{0, 0, 2}, {3, 0, 2}, {3, 1, 2}, {0, 1, 2}};
  const double wall[4][3] = {{-1, 1, 0}, {1, 1, 0}, {1, 1, 2}, {-1, 1, 2}};
  const double sunk[4][3] = {{-1, 1, -3}, {1, 1, -3}, {1, 1, 2}, {-1, 1, 2}};
  const double down[3] = {0, 0, -1}, up[3] = {0, 0, 1}, towards[3] = {0, -1, 0};
  const ext pi = acosl(-1), X = 1.5L, Y = 0.5L, u = sqrtl(1 + X * X), v = sqrtl(1 + Y * Y);
  const ext parallel = (X / u * atanl(Y / u) + Y / v * atanl(X / v)) / (2 * pi);
  const ext upright = (atanl(1) - atanl(1 / sqrtl(5)) / sqrtl(5)) / pi;
  ck_assert(fabsl(oracle_lambert(&x, 4, front, down) - parallel) < 1e-19L);
  ck_assert(fabsl(oracle_lambert(&x, 4, wall, towards) - upright) < 1e-19L);
  ck_assert(fabsl(oracle_lambert(&x, 4, sunk, towards) - upright) < 1e-19L);
  ck_assert(oracle_lambert(&x, 4, front, up) == 0);
}
END_TEST

START_TEST(test_lambert_random) {
  srand(SEED + (unsigned)_i);
  printf("test_lambert_random: seed %d\n", SEED + _i);
  for (int pass = 0; pass < 12; pass++) {
    struct oracle_point x;
    struct oracle_element e;
    random_scene(&x, &e, pow(10, -_i));
    face_each_other(&x, &e);
    hold_to_lambert(&x, &e);
  }
}
END_TEST

/* x at `distance` from the edge phi = 0, or the vertex, on a face that folds up from it. */
START_TEST(test_lambert_fold) {
  const double fold[3][2] = {{0.25, 1}, {0, 1}, {-2, 1}}; /* steps y, z: acute, right, obtuse */
  for (int i = 0; i < 9; i++) {
    const double near = i < 3 ? 1e-3 : 1e-10, along = i < 6 ? 0.25 : near;
    const double *step = fold[i % 3];
    const struct oracle_point x = {.edge1 = {1, 0, 0},
                                   .edge2 = {0, step[0], step[1]},
                                   .mu1 = along,
                                   .mu2 = near,
                                   .normal = {0, step[1], -step[0]}};
    struct oracle_element e = {.a = {0.5, 0, 0}, .b = {-0.125, 0.25, 0}, .normal = {0, 0, 1}};
    e.polar = i % 2;
    e.p_phi = 1 + i % 4;
    e.p_r = i == 4 ? 1.5 : 2; /* one broken power */
    e.sigma[1] = e.tau[1] = 1;
    e.k_phi = 2 + i;
    e.k_r = 3;
    hold_to_lambert(&x, &e);
  }
}
END_TEST

/* A broken power is singular at 0, outside the box but close to it. */
START_TEST(test_lambert_broken_power) {
  const struct oracle_point x = {
      .vertex = {0.5, 0.25, 1}, .edge1 = {1, 0, 0.25}, .edge2 = {0, 1, 0}, .normal = {0, 0, -1}};
  for (int i = 0; i < 6; i++) {
    const struct oracle_element e = {.a = {0.5, 0, 0},
                                     .b = {-0.125, 0.25, 0},
                                     .normal = {0, 0, 1},
                                     .polar = i % 2,
                                     .p_phi = i < 3 ? 2.25 : 1,
                                     .p_r = i < 3 ? 1 : 1.375,
                                     .sigma = {pow(10, -1 - i % 3), 0.5},
                                     .tau = {pow(10, -1 - i % 3), 1},
                                     .k_phi = 1 + 2 * i,
                                     .k_r = 3};
    hold_to_lambert(&x, &e);
  }
}
END_TEST

/* The horizon meets the patch anywhere: through v exactly, or past it at 1e-10, and elsewhere. */
START_TEST(test_lambert_horizon) {
  const double offset[5] = {0, 1e-10, -1e-10, 0.1, -0.3};
  for (int i = 0; i < 25; i++) {
    const double turn = 0.3 + 1.25 * (i / 5);
    const struct oracle_point x = {.vertex = {0, offset[i % 5], 1},
                                   .edge1 = {0, 0, i % 2 ? 1 : 0.001},
                                   .edge2 = {cos(turn), sin(turn), 0},
                                   .normal = {sin(turn), -cos(turn), 0}};
    const struct oracle_element e = {.a = {1, -0.5, 0},
                                     .b = {0.25, 1, 0},
                                     .normal = {0, 0, 1},
                                     .polar = i % 2,
                                     .p_phi = 1 + i % 3,
                                     .p_r = i == 7 ? 2.5 : 1 + i % 2,
                                     .sigma = {0, 1},
                                     .tau = {0, 1},
                                     .k_phi = 5,
                                     .k_r = 4};
    hold_to_lambert(&x, &e);
  }
}
END_TEST

/*
 * The whole triangle: six sub-triangles against the plain polygon, near an inner point and a
 * corner. Corner coordinates are multiples of 6/64, so that halves and thirds are exact.
 */
START_TEST(test_six_patches) {
  const double corner[3][3] = {{0, 0, 0}, {1.5, 0.375, 0}, {0.375, 1.125, 0.75}};
  const double centre[3] = {0.625, 0.5, 0.25}, normal[3] = {0.28125, -1.125, 1.546875};
  const double lift[3] = {1e-10, 1e-5, 0.5};
  for (int i = 0; i < 6; i++) {
    struct oracle_point x = {.edge1 = {1, 0.25, 0}, .edge2 = {0, 1, 0.75}, .normal = {0, 0, -1}};
    x.vertex[0] = i < 3 ? 0.5 : lift[i % 3] / 4;
    x.vertex[1] = i < 3 ? 0.375 : 0;
    x.vertex[2] = (i < 3 ? 0.1875 : 0) + lift[i % 3];
    ext sum = 0;
    for (int patch = 0; patch < 6; patch++) {
      const double *v = corner[patch / 2], *w = corner[(patch / 2 + 1 + patch % 2) % 3];
      struct oracle_element e = {.polar = 1, .p_phi = 2, .p_r = 3, .sigma = {0, 1}, .tau = {0, 1}};
      e.k_phi = e.k_r = 4;
      for (int k = 0; k < 3; k++) {
        e.v[k] = v[k];
        e.a[k] = (w[k] - v[k]) / 2;
        e.b[k] = centre[k] - (v[k] + w[k]) / 2;
        e.normal[k] = normal[k];
      }
      ext I[16], absolute;
      ck_assert_int_ge(oracle_integrate(&x, &e, I), 0);
      sum += total(16, I, &absolute);
    }
    const ext exact = oracle_lambert(&x, 3, corner, normal);
    ck_assert(exact > 0.01L && fabsl(sum - exact) < TIGHT * exact);
  }
}
END_TEST

/* ---- a second route for single basis functions: exact in r (p_r = 1), adaptive in sigma ---- */

struct moment {
  quad v[3], a[3], b[3], n_x[3]; /* v relative to x */
  int p, i, j;                   /* phi = sigma^p; weight sigma^i r^j */
  ext z[20], w[20];
};

static quad dot(const quad *p, const quad *q) {
  return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
}

/* int_lo^hi r^(j+1) (alpha r + beta) / |v + r d|^4 dr by the recurrences of N_m and M_m. */
static quad radial(int j, const quad *v, const quad *d, quad alpha, quad beta, quad lo, quad hi) {
  const quad dd = dot(d, d), r0 = -dot(v, d) / dd, s0 = lo - r0, s1 = hi - r0;
  quad square = 0, c[8] = {beta, alpha}, N[8], M[8], sum = 0;
  for (int k = 0; k < 3; k++) {
    const quad foot = v[k] + r0 * d[k];
    square += foot * foot / dd;
  }
  const quad delta = sqrtq(square), q0 = s0 * s0 + square, q1 = s1 * s1 + square;
  c[0] += alpha * r0; /* in powers of s = r - r0; then times r = s + r0, j + 1 times */
  for (int pass = 0; pass <= j; pass++)
    for (int m = 7; m >= 0; m--)
      c[m] = c[m] * r0 + (m > 0 ? c[m - 1] : 0);
  N[0] = atan2q(delta * (s1 - s0), square + s0 * s1) / delta;
  N[1] = logq(q1 / q0) / 2;
  M[0] = (N[0] + s1 / q1 - s0 / q0) / (2 * square);
  M[1] = (s1 - s0) * (s1 + s0) / (2 * q0 * q1);
  for (int m = 0; m + 2 < 8; m++) {
    N[m + 2] = (powq(s1, m + 1) - powq(s0, m + 1)) / (m + 1) - square * N[m];
    M[m + 2] = N[m] - square * M[m];
  }
  for (int m = 0; m < 8; m++)
    sum += c[m] * M[m];
  return sum / (dd * dd);
}

static quad ray(const struct moment *o, quad sigma) {
  const quad root3 = sqrtq(3), phi = powq(sigma, o->p), turn = atanq(1) * 4 / 6;
  const quad t = root3 * tanq(turn * phi), slope = turn * (root3 + t * t / root3);
  quad d[3], lo = 0, hi = 1;
  for (int k = 0; k < 3; k++)
    d[k] = o->a[k] + t * o->b[k];
  const quad alpha = dot(o->n_x, d), beta = dot(o->n_x, o->v), cut = -beta / alpha;
  if (beta <= 0 && alpha + beta <= 0)
    return 0;
  if (beta < 0)
    lo = cut;
  if (alpha + beta < 0)
    hi = cut;
  return radial(o->j, o->v, d, alpha, beta, lo, hi) * slope * o->p * powq(sigma, o->p - 1 + o->i);
}

static quad panel(const struct moment *o, quad lo, quad hi) {
  quad sum = 0;
  for (int q = 0; q < 20; q++)
    sum += o->w[q] * ray(o, (lo + hi) / 2 + (hi - lo) / 2 * o->z[q]);
  return sum * (hi - lo) / 2;
}

static quad adaptive(const struct moment *o, quad lo, quad hi, quad whole, quad tolerance) {
  const quad middle = (lo + hi) / 2, left = panel(o, lo, middle), right = panel(o, middle, hi);
  if (fabsq(left + right - whole) <= tolerance)
    return left + right;
  return adaptive(o, lo, middle, left, tolerance) + adaptive(o, middle, hi, right, tolerance);
}

/* sum_ac sigma_a^i tau_c^j I[a,c] = int K sigma^i tau^j, for i < k_phi, j < k_r. */
static void hold_to_moments(const struct oracle_point *x, struct oracle_element *e) {
  struct moment o = {.p = (int)e->p_phi};
  ext I[9], z[3], w[3], absolute;
  oracle_gauss(20, o.z, o.w);
  oracle_gauss(3, z, w);
  e->k_phi = e->k_r = 3;
  ck_assert_int_gt(oracle_integrate(x, e, I), 0);
  total(9, I, &absolute);
  for (int k = 0; k < 3; k++) {
    o.v[k] = (quad)e->v[k] - x->vertex[k] - (quad)x->mu1 * x->edge1[k] - (quad)x->mu2 * x->edge2[k];
    o.a[k] = e->a[k];
    o.b[k] = e->b[k];
    o.n_x[k] = x->normal[k]; /* its direction is exact in these cases */
  }
  const quad length = sqrtq(dot(o.n_x, o.n_x));
  for (int k = 0; k < 3; k++)
    o.n_x[k] /= length;
  /* the patches lie in z = 0 and face up; |a x b| = |a_x b_y - a_y b_x| */
  const quad area = fabsq(o.a[0] * o.b[1] - o.a[1] * o.b[0]);
  const quad front = -o.v[2] * area / (4 * atanq(1));
  for (int ij = 0; ij < 9; ij++) {
    o.i = ij % 3;
    o.j = ij / 3;
    const quad exact = front * adaptive(&o, 0, 1, panel(&o, 0, 1), 1e-20 * absolute / front);
    ext sum = 0;
    for (int ac = 0; ac < 9; ac++)
      sum += powl((1 + z[ac % 3]) / 2, o.i) * powl((1 + z[ac / 3]) / 2, o.j) * I[ac];
    const ext error = fabsl(sum - (ext)exact);
    ck_assert_msg(error <= TIGHT * absolute, "moment %d: %.1Le of %.1Le", ij, error, absolute);
  }
}

START_TEST(test_moments) {
  const double height[3] = {0.25, 1e-4, 1e-10};
  struct oracle_element e = {.a = {0.5, 0, 0}, .b = {-0.125, 0.25, 0}, .normal = {0, 0, 1}};
  e.polar = 1;
  e.p_r = 1;
  e.sigma[1] = e.tau[1] = 1;
  e.p_phi = 1 + _i % 3;
  const struct oracle_point above = {.vertex = {0.25, 0.0625, height[_i % 3]},
                                     .edge1 = {1, 0, 0},
                                     .edge2 = {0, 1, 0},
                                     .normal = {0, 0, -1}};
  const struct oracle_point wall = {.vertex = {0.125, 0, 0},
                                    .edge1 = {1, 0, 0},
                                    .edge2 = {0, 0, 1},
                                    .mu1 = 0.125,
                                    .mu2 = height[_i % 3],
                                    .normal = {0, 1, 0}};
  const struct oracle_point across = {.vertex = {0.25, 0.03125, 0}, /* horizon through the patch */
                                      .edge1 = {0, 0, 1},
                                      .edge2 = {0.6, 0.8, 0},
                                      .mu1 = height[_i % 3],
                                      .normal = {-0.8, 0.6, 0}};
  hold_to_moments(&above, &e);
  hold_to_moments(&wall, &e);
  hold_to_moments(&across, &e);
}
END_TEST

/* ---- invariants ---- */

/* The mirror image x -> -x, and a scale of 2^-20, change nothing; doubled effort changes nothing.
 */
START_TEST(test_symmetry) {
  srand(SEED);
  printf("test_symmetry: seed %d\n", SEED);
  for (int pass = 0; pass < 20; pass++) {
    struct oracle_point x;
    struct oracle_element e;
    ext I[MAX_K * MAX_K], J[MAX_K * MAX_K], absolute;
    random_scene(&x, &e, pow(10, -(pass % 6)));
    face_each_other(&x, &e);
    const int n = e.k_phi * e.k_r;
    ck_assert_int_ge(oracle_integrate(&x, &e, I), 0);
    total(n, I, &absolute);
    ck_assert_int_ge(oracle_integrate_with(&(struct oracle_rule){30, 0.7}, &x, &e, J), 0);
    for (int i = 0; i < n; i++)
      ck_assert(fabsl(I[i] - J[i]) <= 2 * TIGHT * absolute);
    double *vector[8] = {x.vertex, x.edge1, x.edge2, x.normal, e.v, e.a, e.b, e.normal};
    for (int k = 0; k < 8; k++) {
      vector[k][0] = -ldexp(vector[k][0], -20);
      vector[k][1] = ldexp(vector[k][1], -20);
      vector[k][2] = ldexp(vector[k][2], -20);
    }
    ck_assert_int_ge(oracle_integrate(&x, &e, J), 0);
    for (int i = 0; i < n; i++)
      ck_assert(fabsl(I[i] - J[i]) <= TIGHT * absolute);
  }
}
END_TEST

/* A parent's basis functions are polynomials on its halves: their integrals add up. */
START_TEST(test_halves) {
  const struct oracle_point x = {
      .edge1 = {1, 0, 0}, .edge2 = {0, 0, 1}, .normal = {0, 1, 0}, .mu1 = 0.2, .mu2 = 1e-6};
  struct oracle_element e = {.a = {0.5, 0, 0}, .b = {-0.125, 0.25, 0}, .normal = {0, 0, 1}};
  e.p_phi = e.p_r = 3;
  e.sigma[1] = e.tau[1] = 1;
  e.k_phi = e.k_r = 6;
  ext parent[36], child[36], sum[36] = {0}, z[6], w[6], absolute;
  oracle_gauss(6, z, w);
  ck_assert_int_gt(oracle_integrate(&x, &e, parent), 0);
  total(36, parent, &absolute);
  for (int quarter = 0; quarter < 4; quarter++) {
    const int half[2] = {quarter % 2, quarter / 2};
    for (int k = 0; k < 2; k++) {
      e.sigma[k] = (half[0] + k) / 2.0;
      e.tau[k] = (half[1] + k) / 2.0;
    }
    ck_assert_int_gt(oracle_integrate(&x, &e, child), 0);
    for (int ac = 0; ac < 36; ac++)
      for (int bd = 0; bd < 36; bd++) {
        ext value = 1;
        for (int m = 0; m < 6; m++) {
          const ext u = (z[bd % 6] - 1) / 2 + half[0], s = (z[bd / 6] - 1) / 2 + half[1];
          value *= m == ac % 6 ? 1 : (u - z[m]) / (z[ac % 6] - z[m]);
          value *= m == ac / 6 ? 1 : (s - z[m]) / (z[ac / 6] - z[m]);
        }
        sum[ac] += value * child[bd];
      }
  }
  for (int ac = 0; ac < 36; ac++)
    ck_assert(fabsl(sum[ac] - parent[ac]) <= 10 * TIGHT * absolute);
}
END_TEST

START_TEST(test_unseen_and_touching) {
  struct oracle_element e = {.a = {0.5, 0, 0}, .b = {0, 0.25, 0}, .normal = {0, 0, -1}};
  struct oracle_point x = {.vertex = {0.1, 0.01, 0.5}, .edge1 = {1, 0, 0}, .edge2 = {0, 1, 0}};
  ext I[4];
  e.p_phi = e.p_r = 1;
  e.sigma[1] = e.tau[1] = 1;
  e.k_phi = e.k_r = 2;
  x.normal[2] = -1;
  ck_assert_int_eq(oracle_integrate(&x, &e, I), 0); /* behind the source */
  ck_assert(I[0] == 0 && I[3] == 0);
  e.normal[2] = 1;
  ck_assert_int_gt(oracle_integrate(&x, &e, I), 0);
  x.vertex[2] = 1e-200;
  ck_assert_int_eq(oracle_integrate(&x, &e, I), -1); /* on the source */
  x.vertex[2] = 0.5;
  x.normal[2] = 1;
  ck_assert_int_eq(oracle_integrate(&x, &e, I), 0); /* behind x */
  ck_assert(I[0] == 0 && I[3] == 0);
}
END_TEST

int main(void) {
  Suite *suite = suite_create("oracle");
  TCase *group = tcase_create("all");
  tcase_set_timeout(group, 60);
  tcase_add_test(group, test_gauss);
  tcase_add_test(group, test_lambert_known);
  tcase_add_loop_test(group, test_lambert_random, 0, 11);
  tcase_add_test(group, test_lambert_fold);
  tcase_add_test(group, test_lambert_broken_power);
  tcase_add_test(group, test_lambert_horizon);
  tcase_add_test(group, test_six_patches);
  tcase_add_loop_test(group, test_moments, 0, 3);
  tcase_add_test(group, test_symmetry);
  tcase_add_test(group, test_halves);
  tcase_add_test(group, test_unseen_and_touching);
  suite_add_tcase(suite, group);
  return run_suite(suite);
}
