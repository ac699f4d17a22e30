/* Exponents at edges and vertices: values computed elsewhere, limits, cones turned and split, and
 * brute force: M by the double exponential rule, and the cone operator by a trapezoidal rule in
 * logarithmic angle and distance, that is, by direct integration over the faces. */
#include <check.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "mesh/exponents.h"

static const double pi = 3.14159265358979323846;
#define DEGREES (pi / 180)
enum { MAX_FACE = 64 };

static struct rad_gauss gauss;

/* --- random numbers; RAD_TEST_SEED in the environment changes the seed --- */

static uint64_t state;

static uint64_t seed(void) {
  const char *given = getenv("RAD_TEST_SEED");
  return given ? strtoull(given, NULL, 10) : 2003;
}

static double uniform(double low, double high) {
  state += 0x9E3779B97F4A7C15u; /* splitmix64 */
  uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return low + (high - low) * (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static void start(void) {
  struct rad_error e;
  state = seed();
  ck_assert_int_eq(rad_gauss_init(&gauss, &e), RAD_OK);
}

static void stop(void) {
  rad_gauss_free(&gauss);
}

__attribute__((format(printf, 4, 5))) static void
close_to(double got, double expected, double tolerance, const char *format, ...) {
  char what[256];
  va_list list;
  va_start(list, format);
  vsnprintf(what, sizeof what, format, list);
  va_end(list);
  ck_assert_msg(fabs(got - expected) <= tolerance, "%s: %.12g, expected %.12g, seed %llu", what,
                got, expected, (unsigned long long)seed());
}

/* --- edges --- */

/* "edge" of reference/exponents.json: an independent program, confirmed by a 1-D wedge model;
 * digits is the number of decimals it gives. */
START_TEST(edges_of_the_reference) {
  static const struct {
    double gamma, rho1, rho2, beta;
    int digits;
  } known[] = {{90, 0.5, 0.5, 0.7633620752, 10},  {45, 0.5, 1.0, 0.6527530252, 10},
               {45, 0.5, 0.25, 0.8783542069, 10}, {120, 1.0, 0.25, 0.8383887764, 10},
               {30, 0.9, 0.9, 0.490443, 6},       {45, 0.9, 0.9, 0.457745, 6},
               {60, 0.9, 0.9, 0.478374, 6},       {90, 0.9, 0.9, 0.581993, 6},
               {120, 0.9, 0.9, 0.730968, 6}};
  for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
    double gamma = known[i].gamma * DEGREES, half_digit = 0.51 * pow(10, -known[i].digits);
    close_to(rad_edge_exponent(known[i].rho1, known[i].rho2, gamma), known[i].beta, half_digit,
             "edge %zu", i);
    close_to(rad_edge_exponent(known[i].rho2, known[i].rho1, gamma), known[i].beta, half_digit,
             "edge %zu, exchanged", i);
  }
}
END_TEST

/* M(beta), with t = e^x, x = sinh(y): the trapezoidal rule in y, in steps of gamma/10. */
static double brute_m(double beta, double gamma) {
  double h = fmin(0.1 * gamma, 0.02), sum = 0, s = sin(gamma / 2);
  double reach = asinh(50 / (1 - beta));
  for (double y = -reach; y < reach; y += h) {
    double x = sinh(y), half = sinh(0.5 * x), term = (beta + 0.5) * x;
    if (fabs(x) > 500) /* half^2 would overflow: (2 cosh x)^(-3/2) */
      sum += cosh(y) * exp(term - 1.5 * fabs(x));
    else
      sum += cosh(y) * exp(term - 1.5 * log(4 * (half * half + s * s)));
  }
  return 0.5 * sin(gamma) * sin(gamma) * h * sum;
}

START_TEST(edges_by_brute_force) {
  static const double angle[] = {1, 2, 5, 10, 30, 60, 89.999, 90, 90.001, 120, 150, 175, 179};
  static const double rho[] = {0.01, 0.3, 0.9, 0.999, 1};
  for (size_t i = 0; i < sizeof angle / sizeof *angle; i++)
    for (size_t j = 0; j < sizeof rho / sizeof *rho; j++) {
      double gamma = angle[i] * DEGREES, beta = rad_edge_exponent(rho[j], rho[j], gamma);
      ck_assert_msg(beta > 0 && beta < 1, "%g degrees, rho %g: %g", angle[i], rho[j], beta);
      double h = 1e-4 * fmin(beta, 1 - beta), m = brute_m(beta, gamma);
      double slope = (brute_m(beta + h, gamma) - brute_m(beta - h, gamma)) / (2 * h);
      close_to(beta + (1 / rho[j] - m) / slope, beta, 1e-10 * beta, "%g degrees, rho %g", angle[i],
               rho[j]);
    }
}
END_TEST

START_TEST(edges_without_singularity) {
  ck_assert(isinf(rad_edge_exponent(0, 1, 1)));
  ck_assert(isinf(rad_edge_exponent(1, 0, 1)));
  ck_assert(isinf(rad_edge_exponent(1, 1, pi)));
  ck_assert(isinf(rad_edge_exponent(1, 1, 1.5 * pi)));
  ck_assert(isinf(rad_edge_exponent(1, 1, 0)));
  ck_assert(isinf(rad_edge_exponent(1e-300, 1e-300, 1)));
}
END_TEST

/* Near 1, M has the pole sin^2 gamma / (2 (1 - beta)); near 180 degrees nothing else is left. */
START_TEST(edges_in_the_limit) {
  for (double rho = 1e-4; rho > 1e-9; rho /= 10)
    for (double gamma = 0.1; gamma < pi; gamma += 0.3) {
      double pole = rho * sin(gamma) * sin(gamma) / 2;
      close_to(1 - rad_edge_exponent(rho, rho, gamma), pole, 20 * pole * rho + 1e-15,
               "rho %g, gamma %g", rho, gamma);
    }
  for (double turn = 1e-2; turn > 1e-5; turn /= 10) {
    double pole = sin(turn) * sin(turn) / 2;
    close_to(1 - rad_edge_exponent(1, 1, pi - turn), pole, 10 * pole * turn * turn + 1e-15,
             "turn %g", turn);
  }
}
END_TEST

/* --- cones --- */

static void direction(double x, double y, double z, double d[3]) {
  double length = sqrt(x * x + y * y + z * z);
  d[0] = x / length;
  d[1] = y / length;
  d[2] = z / length;
}

/* From edge a to edge b; front is the side from which this is anticlockwise. */
static struct rad_cone_face face_of(const double a[3], const double b[3], double rho) {
  struct rad_cone_face f = {.rho = rho};
  double n[3];
  direction(a[0], a[1], a[2], f.edge[0]);
  direction(b[0], b[1], b[2], f.edge[1]);
  rad_cross(f.edge[0], f.edge[1], n);
  direction(n[0], n[1], n[2], f.normal);
  return f;
}

static double alpha_of(int n, const struct rad_cone_face *face) {
  double alpha;
  struct rad_error e;
  ck_assert_int_eq(rad_vertex_exponent(&gauss, n, face, &alpha, &e), RAD_OK);
  return alpha;
}

static const double X[3] = {1, 0, 0}, Y[3] = {0, 1, 0}, Z[3] = {0, 0, 1}, D[3] = {1, 1, 1};

static int cube_corner(double rho, struct rad_cone_face *face) {
  face[0] = face_of(X, Y, rho);
  face[1] = face_of(Y, Z, rho);
  face[2] = face_of(Z, X, rho);
  return 3;
}

static int surface_s2(struct rad_cone_face *face) {
  face[0] = face_of(X, Y, 0.5);
  face[1] = face_of(Y, D, 1);
  face[2] = face_of(D, X, 0.25);
  return 3;
}

/* n equal faces, edges at this angle from the axis, seen from inside. */
static int pyramid(int n, double degrees, double rho, struct rad_cone_face *face) {
  for (int i = 0; i < n; i++) {
    double d[2][3], t = tan(degrees * DEGREES);
    for (int m = 0; m < 2; m++)
      direction(t * cos(2 * pi * (i + m) / n), t * sin(2 * pi * (i + m) / n), 1, d[m]);
    face[i] = face_of(d[0], d[1], rho);
  }
  return n;
}

/* Two sectors of this width on the z axis, at the dihedral angle gamma; `parts` faces each. */
static int book(double gamma, double width, int parts, const double rho[2],
                struct rad_cone_face *face) {
  for (int i = 0; i < 2 * parts; i++) {
    int page = i / parts;
    double d[2][3], turn = page * gamma;
    for (int m = 0; m < 2; m++) {
      double phi = width * (i % parts + m) / parts;
      direction(sin(phi) * cos(turn), sin(phi) * sin(turn), cos(phi), d[m]);
    }
    face[i] = page ? face_of(d[1], d[0], rho[1]) : face_of(d[0], d[1], rho[0]);
  }
  return 2 * parts;
}

/* Floor and two walls around the outer side of a square pillar: 270 degrees of floor, cut at this
 * angle, so that its parts reach behind the walls. */
static int reflex_corner(double cut_degrees, double rho, struct rad_cone_face *face) {
  double cut[3];
  direction(cos(cut_degrees * DEGREES), sin(cut_degrees * DEGREES), 0, cut);
  face[0] = face_of(Y, cut, rho);
  face[1] = face_of(cut, X, rho);
  face[2] = face_of(X, Z, rho);
  face[3] = face_of(Z, Y, rho);
  return 4;
}

/* The same, the floor in quadrants: none of them reaches behind a wall. */
static int reflex_quadrants(double rho, struct rad_cone_face *face) {
  static const double west[3] = {-1, 0, 0}, south[3] = {0, -1, 0};
  reflex_corner(225, rho, face);
  face[0] = face_of(Y, west, rho);
  face[1] = face_of(west, south, rho);
  face[4] = face_of(south, X, rho);
  return 5;
}

/* "vertex_cube_corner" of reference/exponents.json, 5 or 6 digits, and S2 of method.md 5. */
START_TEST(vertices_of_the_reference) {
  static const double known[][2] = {{0.1, 0.95718}, {0.3, 0.85961}, {0.5, 0.744986},
                                    {0.7, 0.61152}, {0.9, 0.45597}, {0.99, 0.37722}};
  struct rad_cone_face face[3];
  for (size_t i = 0; i < sizeof known / sizeof *known; i++)
    close_to(alpha_of(cube_corner(known[i][0], face), face), known[i][1], 5e-6, "rho %g",
             known[i][0]);
  close_to(alpha_of(surface_s2(face), face), 0.87498, 5e-6, "S2");
}
END_TEST

/* A point within an edge: v = sin^beta phi, alpha = beta. */
START_TEST(half_planes_have_the_exponent_of_their_edge) {
  static const double angle[] = {10, 30, 45, 90, 120, 170}, rho[][2] = {{0.5, 1}, {0.9, 0.9}};
  struct rad_cone_face face[MAX_FACE];
  for (size_t i = 0; i < sizeof angle / sizeof *angle; i++)
    for (size_t j = 0; j < 2; j++)
      for (int parts = 2; parts <= 4; parts++) {
        double gamma = angle[i] * DEGREES;
        double beta = rad_edge_exponent(rho[j][0], rho[j][1], gamma);
        close_to(alpha_of(book(gamma, pi, parts, rho[j], face), face), beta, 1e-6,
                 "%g degrees, %d parts", angle[i], parts);
      }
  for (int i = 2; i < 6; i++) {
    double gamma = angle[i] * DEGREES;
    close_to(alpha_of(book(gamma, pi, 2, rho[0], face), face), rad_edge_exponent(0.5, 1, gamma),
             1e-8, "%g degrees, in detail", angle[i]);
  }
}
END_TEST

/* Two sectors on one edge, open elsewhere: the wider, the closer to the edge's beta from above. */
START_TEST(open_ends) {
  static const double rho[2] = {0.9, 0.8};
  struct rad_cone_face face[2];
  for (double angle = 10; angle < 180; angle += 20) {
    double last = 1, beta = rad_edge_exponent(rho[0], rho[1], angle * DEGREES);
    for (double width = 10; width < 180; width += 24) {
      double alpha = alpha_of(book(angle * DEGREES, width * DEGREES, 1, rho, face), face);
      ck_assert_msg(alpha > beta && alpha < last, "%g, %g: %g", angle, width, alpha);
      last = alpha;
    }
  }
}
END_TEST

START_TEST(cones_without_singularity) {
  struct rad_cone_face face[6];
  cube_corner(0.9, face);
  ck_assert(isinf(alpha_of(0, face)));
  ck_assert(isinf(alpha_of(1, face)));
  for (int i = 0; i < 3; i++) /* the corner from outside */
    for (int m = 0; m < 3; m++)
      face[i].normal[m] *= -1;
  ck_assert(isinf(alpha_of(3, face)));
  cube_corner(0.9, face);
  face[1].rho = face[2].rho = 0;
  ck_assert(isinf(alpha_of(3, face)));
  cube_corner(0.9, face);
  for (int m = 0; m < 3; m++) /* a slit, and a face in its plane */
    face[1].normal[m] = -face[0].normal[m];
  memcpy(face[1].edge, face[0].edge, sizeof face[1].edge);
  face[2] = face_of(Y, (double[3]){-1, 0, 0}, 0.9);
  ck_assert(isinf(alpha_of(3, face)));
}
END_TEST

START_TEST(cones_in_the_limit) {
  struct rad_cone_face face[MAX_FACE];
  double small = 1 - alpha_of(cube_corner(1e-4, face), face);
  close_to((1 - alpha_of(cube_corner(1e-6, face), face)) / small, 0.01, 1e-5, "rho -> 0");
  ck_assert(isinf(alpha_of(cube_corner(1e-12, face), face)));
  ck_assert(alpha_of(pyramid(5, 89.9, 1, face), face) > 0.9999);
  for (int n = 3; n <= 12; n++) /* thin pyramids of mirrors hardly let anything out */
    for (double degrees = 1; degrees < 90; degrees += 8) {
      double full = alpha_of(pyramid(n, degrees, 1, face), face);
      double less = alpha_of(pyramid(n, degrees, 0.8, face), face);
      ck_assert_msg(0 < full && full < less && less < 1, "%d faces, %g degrees: %g, %g", n, degrees,
                    full, less);
    }
}
END_TEST

/* From 17 faces on the discretisation is another one: compared with fewer, extrapolated in 1/n^2.
 */
START_TEST(many_faces_continue_few) {
  static const int from[4] = {10, 12, 14, 16}, to[3] = {17, 18, 19};
  struct rad_cone_face face[MAX_FACE];
  for (double degrees = 5; degrees < 90; degrees += 20) {
    double known[4];
    for (int i = 0; i < 4; i++)
      known[i] = alpha_of(pyramid(from[i], degrees, 0.9, face), face);
    for (int k = 0; k < 3; k++) {
      double extrapolated = 0, x = 1. / (to[k] * to[k]);
      for (int i = 0; i < 4; i++) {
        double basis = 1, xi = 1. / (from[i] * from[i]);
        for (int j = 0; j < 4; j++)
          if (j != i)
            basis *= (x - 1. / (from[j] * from[j])) / (xi - 1. / (from[j] * from[j]));
        extrapolated += basis * known[i];
      }
      close_to(alpha_of(pyramid(to[k], degrees, 0.9, face), face), extrapolated, 3e-6,
               "%d faces, %g degrees", to[k], degrees);
    }
  }
  ck_assert(alpha_of(pyramid(MAX_FACE, 45, 0.9, face), face) < 1);
}
END_TEST

static void random_rotation(double r[3][3]) {
  double a[3], b[3], c[3];
  do {
    for (int m = 0; m < 3; m++) {
      a[m] = uniform(-1, 1);
      b[m] = uniform(-1, 1);
    }
    rad_cross(a, b, c);
  } while (rad_norm(c) < 0.1);
  direction(a[0], a[1], a[2], r[0]);
  direction(c[0], c[1], c[2], r[1]);
  rad_cross(r[0], r[1], r[2]);
}

static void rotate(double r[3][3], double x[3]) {
  double y[3];
  for (int m = 0; m < 3; m++)
    y[m] = rad_dot(r[m], x);
  memcpy(x, y, sizeof y);
}

/* Turned, with the faces in another order and their edges exchanged. */
START_TEST(turning_changes_nothing) {
  struct rad_cone_face face[MAX_FACE];
  for (int trial = 0; trial < 60; trial++) {
    static const double rho[2] = {0.4, 0.9};
    int n = trial % 5 == 0   ? cube_corner(0.7, face)
            : trial % 5 == 1 ? surface_s2(face)
            : trial % 5 == 2 ? pyramid(3 + trial % 7, uniform(10, 80), 0.9, face)
            : trial % 5 == 3 ? book(uniform(0.2, 3), uniform(0.2, 3), 2, rho, face)
                             : reflex_corner(uniform(185, 265), 0.8, face);
    double alpha = alpha_of(n, face), r[3][3];
    random_rotation(r);
    for (int i = 0; i < n; i++) {
      int swap = (int)uniform(0, n), flip = uniform(0, 1) < 0.5;
      struct rad_cone_face other = face[swap];
      face[swap] = face[i];
      face[i] = other;
      if (flip) {
        memcpy(face[i].edge[0], other.edge[1], sizeof other.edge[0]);
        memcpy(face[i].edge[1], other.edge[0], sizeof other.edge[0]);
      }
    }
    for (int i = 0; i < n; i++) {
      rotate(r, face[i].edge[0]);
      rotate(r, face[i].edge[1]);
      rotate(r, face[i].normal);
    }
    close_to(alpha_of(n, face), alpha, 1e-9, "cone %d", trial);
  }
}
END_TEST

/* Where one face is cut in two makes no difference, also where parts reach behind others. */
START_TEST(cutting_a_face_changes_nothing) {
  struct rad_cone_face face[MAX_FACE];
  double alpha = alpha_of(reflex_quadrants(0.9, face), face);
  for (double cut = 185; cut < 270; cut += 10)
    close_to(alpha_of(reflex_corner(cut, 0.9, face), face), alpha, 1e-7, "cut at %g", cut);
  for (double part = 0.1; part < 1; part += 0.2) {
    double middle[3] = {cos(part * pi / 2), sin(part * pi / 2), 0};
    int n = cube_corner(0.5, face);
    alpha = alpha_of(n, face);
    face[n] = face_of(middle, Y, 0.5);
    face[0] = face_of(X, middle, 0.5);
    close_to(alpha_of(n + 1, face), alpha, 1e-7, "corner, floor cut at %g", part);
  }
}
END_TEST

/* --- the cone operator by brute force --- */

struct point {
  double x[3], weight;
  int face;
};

/* phi = angle / (1 + e^-s), |s| <= 16, in steps of h: the trapezoidal rule. */
static int spread(int n_face, const struct rad_cone_face *face, double h, struct point *out) {
  int n = 0, steps = (int)(16 / h);
  for (int i = 0; i < n_face; i++)
    for (int k = -steps; k <= steps; k++) {
      double angle = acos(rad_dot(face[i].edge[0], face[i].edge[1])), part = 1 / (1 + exp(-k * h));
      double rest = 1 / (1 + exp(k * h));
      struct point *p = &out[n++];
      p->face = i;
      p->weight = angle * part * rest * h;
      for (int m = 0; m < 3; m++)
        p->x[m] =
            (sin(rest * angle) * face[i].edge[0][m] + sin(part * angle) * face[i].edge[1][m]) /
            sin(angle);
    }
  return n;
}

/* int nu^(2+alpha) |x - nu y|^-4 dnu with nu = e^t, sinh(t/2) = |x-y|/2 sinh(y). */
static double radial(double alpha, const double x[3], const double y[3]) {
  double d[3], h = 0.3, sum = 0, half;
  rad_sub(x, y, d);
  half = 0.5 * rad_norm(d);
  double first = -14, last = 14 + 20 / (1 - alpha);
  for (double z = first; z < last; z += h) {
    double s = half * sinh(z);
    sum += exp(2 * (1 + alpha) * asinh(s) - 3 * log(cosh(z)) - 0.5 * log1p(s * s));
  }
  return h * sum / (8 * half * half * half);
}

/* Spectral radius of K_alpha by power iteration: 1 at the right alpha. */
static double brute_radius(int n_face, const struct rad_cone_face *face, double alpha, double h) {
  int n = n_face * (2 * (int)(16 / h) + 1);
  struct point *p = malloc((size_t)n * sizeof *p);
  double *k = malloc((size_t)n * (size_t)n * sizeof *k), *v = malloc(2 * (size_t)n * sizeof *v);
  ck_assert(p && k && v);
  spread(n_face, face, h, p);
  for (int i = 0; i < n; i++) {
    v[i] = 1;
    for (int j = 0; j <= i; j++) {
      double a = rad_dot(face[p[i].face].normal, p[j].x),
             b = rad_dot(face[p[j].face].normal, p[i].x);
      double both = 0;
      if (p[i].face != p[j].face && a > 0 && b > 0)
        both = a * b * radial(alpha, p[i].x, p[j].x) / pi;
      k[i * n + j] = face[p[i].face].rho * both * p[j].weight;
      k[j * n + i] = face[p[j].face].rho * both * p[i].weight;
    }
  }
  double growth = 0;
  for (int step = 0; step < 400; step++) {
    double *w = v + n, before = 0, after = 0;
    for (int i = 0; i < n; i++) {
      w[i] = 0;
      for (int j = 0; j < n; j++)
        w[i] += k[i * n + j] * v[j];
      before += p[i].weight / face[p[i].face].rho * v[i] * v[i];
      after += p[i].weight / face[p[i].face].rho * v[i] * w[i]; /* Rayleigh quotient */
    }
    growth = after / before;
    for (int i = 0; i < n; i++)
      v[i] = (w[i] + v[i]) / (1 + growth); /* + v: two faces have -growth too */
  }
  free(p);
  free(k);
  free(v);
  return growth;
}

static void expect_brute(int n, const struct rad_cone_face *face, double h, double tolerance,
                         const char *what) {
  double alpha = alpha_of(n, face);
  close_to(brute_radius(n, face, alpha, h), 1, tolerance, "%s, alpha %g", what, alpha);
}

START_TEST(the_operator_by_brute_force) {
  struct rad_cone_face face[6];
  expect_brute(cube_corner(0.5, face), face, 0.5, 2e-7, "cube corner, rho 0.5");
  expect_brute(cube_corner(1, face), face, 0.5, 2e-7, "cube corner, rho 1");
  expect_brute(surface_s2(face), face, 0.3, 1e-6, "S2");
  expect_brute(pyramid(3, 25, 0.7, face), face, 0.35, 1e-6, "pyramid");
  static const double rho[2] = {0.9, 0.3};
  expect_brute(book(1, 1.5, 1, rho, face), face, 0.3, 1e-6, "two faces");
  double skew[4][3] = {{1, 0.2, 0}, {0.1, 1, 0.3}, {-0.3, 0.4, 1}, {0.6, -0.5, 0.8}};
  for (int i = 0; i < 4; i++)
    face[i] = face_of(skew[i], skew[(i + 1) % 4], 0.4 + 0.2 * i);
  expect_brute(4, face, 0.4, 2e-6, "skew cone");
  expect_brute(reflex_quadrants(0.8, face), face, 0.4, 1e-6, "reflex corner");
}
END_TEST

/* --- scenes --- */

static struct rad_deck_triangle *add(struct rad_deck *deck, const double a[3], const double b[3],
                                     const double c[3], double rho) {
  static const int most = 64;
  if (!deck->triangle)
    deck->triangle = calloc((size_t)most, sizeof *deck->triangle);
  ck_assert(deck->triangle && deck->n_triangle < most);
  deck->path = "exponents.yml";
  deck->n_band = deck->n_band ? deck->n_band : 1;
  deck->band[0] = "all";
  deck->band[1] = "other";
  struct rad_deck_triangle *t = &deck->triangle[deck->n_triangle++];
  *t = (struct rad_deck_triangle){.name = "wall", .line = deck->n_triangle};
  memcpy(t->vertex[0], a, sizeof t->vertex[0]);
  memcpy(t->vertex[1], b, sizeof t->vertex[1]);
  memcpy(t->vertex[2], c, sizeof t->vertex[2]);
  t->optics.has_rho = t->optics.has_emission = true;
  t->optics.rho[0] = rho;
  return t;
}

static struct rad_exponents exponents_of(struct rad_deck *deck) {
  struct rad_scene scene;
  struct rad_notes notes = {0};
  struct rad_exponents x;
  struct rad_error e;
  ck_assert_msg(rad_scene_build(deck, &scene, &notes, &e) == RAD_OK, "%s", e.text);
  ck_assert_int_eq(rad_scene_exponents(&scene, &x, &e), RAD_OK);
  ck_assert_int_eq(x.n_triangle, scene.n_triangle);
  rad_scene_free(&scene);
  rad_notes_free(&notes);
  free(deck->triangle);
  *deck = (struct rad_deck){0};
  return x;
}

static void expect3(const double got[3], double a, double b, double c, const char *what) {
  const double expected[3] = {a, b, c};
  for (int m = 0; m < 3; m++)
    if (isinf(expected[m]))
      ck_assert_msg(isinf(got[m]) && got[m] > 0, "%s %d: %g, expected none", what, m, got[m]);
    else
      close_to(got[m], expected[m], 5e-6, "%s %d", what, m);
}

static const double O[3] = {0, 0, 0};

/* S2 of the paper; floor v0v1 is edge 1-3, v2v0 edge 1-2, and edge 2-3 leads to (1, 1, 1). */
START_TEST(scene_s2) {
  struct rad_deck deck = {0};
  add(&deck, O, X, Y, 0.5);
  add(&deck, O, Y, D, 1);
  add(&deck, O, D, X, 0.25);
  struct rad_exponents x = exponents_of(&deck);
  expect3(x.beta[0], 0.8783542069, INFINITY, 0.6527530252, "floor");
  expect3(x.beta[1], 0.6527530252, INFINITY, 0.8383887764, "white");
  expect3(x.beta[2], 0.8383887764, INFINITY, 0.8783542069, "grey");
  for (int t = 0; t < 3; t++) {
    close_to(x.alpha[t][0], 0.87498, 5e-6, "origin");
    for (int m = 1; m < 3; m++) /* two faces, open ends: above the beta of their edge */
      ck_assert(x.alpha[t][m] > x.beta[t][m == 1 ? 0 : 2] && x.alpha[t][m] < 1);
  }
  ck_assert(x.alpha[0][1] == x.alpha[2][2] && x.alpha[0][2] == x.alpha[1][1]);
  rad_exponents_free(&x);
  rad_exponents_free(&x);
  ck_assert(!x.beta && !x.alpha && x.n_triangle == 0);
}
END_TEST

/* The unit cube, two triangles a side, seen from inside; the first edges are the cube's. */
static void add_cube(struct rad_deck *deck, double rho) {
  for (int side = 0; side < 6; side++) {
    int axis = side / 2, one = side % 2;
    double c[4][3];
    for (int k = 0; k < 4; k++) {
      int u = k == 1 || k == 2, v = k > 1;
      c[k][axis] = one;
      c[k][(axis + 1) % 3] = one ? v : u;
      c[k][(axis + 2) % 3] = one ? u : v;
    }
    add(deck, c[0], c[1], c[2], rho);
    add(deck, c[2], c[3], c[0], rho);
  }
}

START_TEST(scene_of_a_cube) {
  struct rad_deck deck = {0};
  add_cube(&deck, 0.5);
  struct rad_exponents x = exponents_of(&deck);
  for (int t = 0; t < 12; t++) {
    expect3(x.beta[t], 0.7633620752, 0.7633620752, INFINITY, "beta");
    expect3(x.alpha[t], 0.744986, 0.744986, 0.744986, "alpha");
  }
  rad_exponents_free(&x);
}
END_TEST

START_TEST(the_worst_band_counts) {
  for (int second = 0; second < 2; second++) {
    struct rad_deck deck = {0};
    add_cube(&deck, 0.5);
    deck.n_band = 2;
    for (int t = 0; t < 12; t++) {
      struct rad_deck_optics *optics = &deck.triangle[t].optics;
      optics->rho[1] = t < 4 ? 0.9 : 0; /* the sides x = 0, x = 1; and y = 0, y = 1 by halves */
      if (t == 4 || t == 5)
        optics->rho[1] = 0.9;
      if (second) {
        optics->rho[0] = optics->rho[1];
        optics->rho[1] = 0.5;
      }
    }
    struct rad_exponents x = exponents_of(&deck);
    for (int t = 0; t < 12; t++)
      for (int m = 0; m < 2; m++) {
        double beta = x.beta[t][m];
        ck_assert_msg(fabs(beta - 0.7633620752) < 1e-9 || fabs(beta - 0.581993) < 1e-6, "%g", beta);
        ck_assert(x.alpha[t][m] < 0.744986 + 5e-6);
      }
    int worst = 0; /* edges of y = 0 with x = 0 and x = 1, from both sides */
    for (int t = 0; t < 12; t++)
      for (int m = 0; m < 2; m++)
        worst += fabs(x.beta[t][m] - 0.581993) < 1e-6;
    ck_assert_int_eq(worst, 4);
    rad_exponents_free(&x);
  }
}
END_TEST

START_TEST(scenes_without_singularity) {
  struct rad_deck deck = {0};
  add_cube(&deck, 0.9);
  for (int t = 0; t < 12; t++)
    deck.triangle[t].optics.side = RAD_SIDE_BACK;
  struct rad_exponents x = exponents_of(&deck);
  for (int t = 0; t < 12; t++) {
    expect3(x.beta[t], INFINITY, INFINITY, INFINITY, "box from outside, beta");
    expect3(x.alpha[t], INFINITY, INFINITY, INFINITY, "box from outside, alpha");
  }
  rad_exponents_free(&x);
  static const double west[3] = {-1, 0, 0}, south[3] = {0, -1, 0};
  add(&deck, O, X, Y, 0.9)->optics.side = RAD_SIDE_BOTH;
  add(&deck, O, Y, west, 0.5)->optics.side = RAD_SIDE_BOTH;
  add(&deck, O, west, south, 1);
  x = exponents_of(&deck);
  for (int t = 0; t < 5; t++) {
    expect3(x.beta[t], INFINITY, INFINITY, INFINITY, "plate, beta");
    expect3(x.alpha[t], INFINITY, INFINITY, INFINITY, "plate, alpha");
  }
  rad_exponents_free(&x);
}
END_TEST

START_TEST(black_faces_have_none) {
  struct rad_deck deck = {0};
  add(&deck, O, X, Y, 0.5);
  add(&deck, O, Y, Z, 0);
  add(&deck, O, Z, X, 0.5);
  struct rad_exponents x = exponents_of(&deck);
  expect3(x.beta[0], 0.7633620752, INFINITY, INFINITY, "floor");
  expect3(x.beta[1], INFINITY, INFINITY, INFINITY, "black, beta");
  expect3(x.alpha[1], INFINITY, INFINITY, INFINITY, "black, alpha");
  ck_assert(x.alpha[0][0] < 1 && x.alpha[0][0] == x.alpha[2][0] && isinf(x.alpha[0][2]));
  rad_exponents_free(&x);
}
END_TEST

/* Sheets at 0, 60 and 150 degrees on one edge: each side meets only the next sheet. */
START_TEST(sheets_on_one_edge) {
  for (int both = 0; both < 2; both++) {
    struct rad_deck deck = {0};
    const double angle[3] = {0, 60 * DEGREES, 150 * DEGREES}, rho[3] = {0.5, 0.9, 1};
    for (int i = 0; i < 3; i++) {
      double tip[3] = {cos(angle[i]), sin(angle[i]), 0};
      add(&deck, O, tip, Z, rho[i]);
    }
    deck.triangle[0].optics.side = RAD_SIDE_BACK; /* right-hand normal: clockwise */
    deck.triangle[1].optics.side = both ? RAD_SIDE_BOTH : RAD_SIDE_BACK;
    struct rad_exponents x = exponents_of(&deck);
    double narrow = rad_edge_exponent(0.5, 0.9, 60 * DEGREES);
    double wide = rad_edge_exponent(0.9, 1, 90 * DEGREES);
    int last = x.n_triangle - 1, back = both ? 2 : 1;
    expect3(x.beta[0], INFINITY, INFINITY, both ? narrow : INFINITY, "first");
    expect3(x.beta[back], INFINITY, INFINITY, wide, "middle, away from the first");
    if (both)
      expect3(x.beta[1], INFINITY, INFINITY, narrow, "middle, towards the first");
    expect3(x.beta[last], INFINITY, INFINITY, wide, "last");
    rad_exponents_free(&x);
  }
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", (unsigned long long)seed());
  Suite *suite = suite_create("exponents");
  TCase *tests = tcase_create("exponents");
  tcase_add_checked_fixture(tests, start, stop);
  tcase_add_test(tests, edges_of_the_reference);
  tcase_add_test(tests, edges_by_brute_force);
  tcase_add_test(tests, edges_without_singularity);
  tcase_add_test(tests, edges_in_the_limit);
  tcase_add_test(tests, vertices_of_the_reference);
  tcase_add_test(tests, half_planes_have_the_exponent_of_their_edge);
  tcase_add_test(tests, open_ends);
  tcase_add_test(tests, cones_without_singularity);
  tcase_add_test(tests, cones_in_the_limit);
  tcase_add_test(tests, many_faces_continue_few);
  tcase_add_test(tests, turning_changes_nothing);
  tcase_add_test(tests, cutting_a_face_changes_nothing);
  tcase_add_test(tests, the_operator_by_brute_force);
  tcase_add_test(tests, scene_s2);
  tcase_add_test(tests, scene_of_a_cube);
  tcase_add_test(tests, the_worst_band_counts);
  tcase_add_test(tests, scenes_without_singularity);
  tcase_add_test(tests, black_faces_have_none);
  tcase_add_test(tests, sheets_on_one_edge);
  tcase_set_timeout(tests, 120);
  suite_add_tcase(suite, tests);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed != 0;
}
