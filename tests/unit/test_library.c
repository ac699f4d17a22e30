/* include/polyrad.h as its callers meet it. */
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "cases/scene_text.h"
#include "polyrad.h"
#include "suite.h"

/* Surface S1: three faces of a cube, cut at its corner; as inputs/cube_corner.yml. */
static const double vertex[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
static const int triangle[] = {0, 1, 2, 0, 2, 3, 0, 3, 1};
static const int surface[] = {0, 1, 2};
static const char *const name[] = {"floor", "wall_x0", "wall_y0"};
static const double rho[] = {0.5, 0.5, 0.5}, emission[] = {0.5, 1, 0.3};

static struct polyrad_scene corner(void) {
  return (struct polyrad_scene){.n_vertex = 4,
                                .vertex = vertex,
                                .n_triangle = 3,
                                .triangle = triangle,
                                .n_surface = 3,
                                .surface = surface,
                                .surface_name = name,
                                .rho = rho,
                                .emission = emission};
}

static polyrad *create(const struct polyrad_scene *scene) {
  polyrad *p;
  polyrad_status status = polyrad_create(scene, &p);
  ck_assert_msg(status == POLYRAD_OK, "%s", polyrad_error_text(p));
  return p;
}

static polyrad *solve(const struct polyrad_scene *scene, double tolerance) {
  polyrad *p = create(scene);
  struct polyrad_options o = {.tolerance = tolerance, .threads = 1};
  polyrad_status status = polyrad_solve(p, &o);
  ck_assert_msg(status == POLYRAD_OK, "%s", polyrad_error_text(p));
  ck_assert_str_eq(polyrad_error_text(p), "");
  return p;
}

enum { N = 5 };
static const int place[N] = {0, 0, 0, 1, 2};
static const double weight[N][3] = {{0.5, 0.25, 0.25},
                                    {0.998, 0.001, 0.001},
                                    {0.1, 0.9, 0}, /* on an edge */
                                    {0.3, 0.3, 0.4},
                                    {0, 0, 1}}; /* at a vertex */

/* The same triangles in the same order, so the same numbers as the program's. */
START_TEST(same_as_the_program) {
  struct deck_text d;
  struct rad_case c;
  struct rad_error e;
  struct polyrad_scene scene = corner();
  deck_begin(&d);
  for (int t = 0; t < 3; t++) {
    double v[3][3];
    for (int m = 0; m < 3; m++)
      memcpy(v[m], vertex + 3 * triangle[3 * t + m], sizeof v[m]);
    deck_polygon(&d, name[t], 3, v, rho[t], emission[t]);
  }
  deck_add(&d,
           "accuracy: {tolerance: 1e-4}\n"
           "probes: [{at: [0.25, 0.25, 0]}, {at: [0.001, 0.001, 0]}]\n");
  ck_assert_msg(!deck_solve(&d, &c, &e), "%s", e.text);
  struct rad_result r;
  ck_assert_int_eq(rad_case_result(&c, "", &r, &e), RAD_OK);
  polyrad *p = solve(&scene, 1e-4);
  double u[N], h[N], mean[3], at[2][3] = {{0.25, 0.25, 0}, {0.001, 0.001, 0}}, v[2];
  ck_assert_int_eq(polyrad_evaluate(p, N, place, weight[0], u, h), POLYRAD_OK);
  ck_assert_int_eq(polyrad_evaluate_at(p, 2, place, at[0], v, NULL), POLYRAD_OK);
  ck_assert_int_eq(polyrad_surface_means(p, mean, NULL), POLYRAD_OK);
  for (int i = 0; i < 2; i++) { /* places differ by roundings */
    ck_assert_double_eq_tol(u[i], r.probe_radiosity[i], 1e-12);
    ck_assert_double_eq_tol(h[i], r.probe_irradiance[i], 1e-12);
    ck_assert_double_eq_tol(v[i], r.probe_radiosity[i], 1e-12);
  }
  for (int i = 0; i < 3; i++)
    ck_assert_double_eq(mean[i], r.means->radiosity[i]);
  struct polyrad_summary s;
  ck_assert_int_eq(polyrad_get_summary(p, &s), POLYRAD_OK);
  ck_assert_int_eq(s.unknowns, r.diagnostics.unknowns);
  ck_assert_double_eq(s.error_bound, r.diagnostics.error_bound);
  ck_assert_double_eq(s.residual, r.diagnostics.residual);
  ck_assert(s.converged && s.relative_bound <= 1e-4);
  rad_result_free(&r);
  rad_case_free(&c);
  polyrad_free(p);
}
END_TEST

/* Tolerances of a finer and a coarser run: values differ by no more than the bounds. */
START_TEST(bound_holds) {
  struct polyrad_scene scene = corner();
  polyrad *p = solve(&scene, 1e-5);
  double fine[N], u[N];
  struct polyrad_summary s;
  polyrad_evaluate(p, N, place, weight[0], fine, NULL);
  struct polyrad_options o = {.tolerance = 1e-3};
  ck_assert_int_eq(polyrad_solve(p, &o), POLYRAD_OK); /* again, with the same handle */
  polyrad_get_summary(p, &s);
  polyrad_evaluate(p, N, place, weight[0], u, NULL);
  for (int i = 0; i < N; i++)
    ck_assert_double_le(fabs(u[i] - fine[i]), s.error_bound_limit + 1.2e-5);
  polyrad_free(p);
}
END_TEST

/* Each band is a problem of its own; surfaces keep the caller's numbers. */
START_TEST(bands_and_numbers) {
  static const int other[] = {2, 0, 1};
  static const double both[] = {0.5, 0.9, 0.5, 0.1, 0.5, 0}, light[] = {0.5, 0, 1, 2, 0.3, 0};
  struct polyrad_scene scene = corner(), two = corner();
  two.n_band = 2;
  two.rho = both;
  two.emission = light;
  two.surface = other;
  two.surface_name = NULL;
  polyrad *p = solve(&scene, 1e-4), *q = solve(&two, 1e-4);
  double u[3], u2[3][2], h2[3][2], f[9], f2[9];
  polyrad_surface_means(p, u, NULL);
  polyrad_surface_means(q, u2[0], h2[0]);
  ck_assert_int_eq(polyrad_view_factors(p, 1e-5, f), POLYRAD_OK);
  ck_assert_int_eq(polyrad_view_factors(q, 1e-5, f2), POLYRAD_OK);
  for (int t = 0; t < 3; t++) {
    ck_assert_double_eq_tol(u[t], u2[other[t]][0], 3e-4);
    ck_assert_double_eq_tol(u2[other[t]][1], light[2 * t + 1] + both[2 * t + 1] * h2[other[t]][1],
                            4e-4); /* twice the bound, largest u 2 */
    for (int s = 0; s < 3; s++)
      ck_assert_double_eq_tol(f[3 * t + s], f2[3 * other[t] + other[s]], 1e-12);
  }
  polyrad_free(p);
  polyrad_free(q);
}
END_TEST

/* A black sheet between a lamp and a floor: what is behind its middle sees no lamp. */
START_TEST(shadow) {
  static const double v[] = {0, 0, 0, 1, 0,  0,  0,   1, 0,  0,   0,  1, 0,  1,
                             1, 1, 0, 1, -2, -2, 0.5, 4, -2, 0.5, -2, 4, 0.5};
  static const int t[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 6, 8, 7};
  static const int s[] = {0, 1, 2, 2};
  static const double r[] = {0.5, 0, 0, 0}, e[] = {0, 1, 0, 0};
  struct polyrad_scene scene = {.n_vertex = 9,
                                .vertex = v,
                                .n_triangle = 2,
                                .triangle = t,
                                .n_surface = 2,
                                .surface = s,
                                .rho = r,
                                .emission = e};
  double open[1], shut[1], f[4];
  static const int at[] = {0};
  static const double middle[] = {1. / 3, 1. / 3, 1. / 3};
  polyrad *p = solve(&scene, 1e-4);
  polyrad_evaluate(p, 1, at, middle, NULL, open);
  ck_assert_int_eq(polyrad_view_factors(p, 0, f), POLYRAD_OK);
  ck_assert(f[1] > 0.1 && fabs(f[1] - f[2]) < 2e-6 && f[0] == 0);
  double best[4] = {-1, -1, -1, -1}; /* beyond rounding: the best there is, and a sentence */
  ck_assert_int_eq(polyrad_view_factors(p, 1e-17, best), POLYRAD_NUMERIC);
  ck_assert(strstr(polyrad_error_text(p), "have an error of"));
  ck_assert(fabs(best[1] - f[1]) < 2e-6 && best[0] == 0);
  polyrad_free(p);
  scene.n_triangle = 4;
  scene.n_surface = 3;
  p = solve(&scene, 1e-4);
  polyrad_evaluate(p, 1, at, middle, NULL, shut);
  ck_assert_double_gt(open[0], 0.1);
  ck_assert_double_eq(shut[0], 0);
  polyrad_free(p);
}
END_TEST

/* ---- emission as a function ------------------------------------------------------------------ */

static double linear_e(const double x[3], int t, const double w[3], int band, void *user) {
  (void)w;
  ck_assert(band == 0 && t >= 0 && t < 3);
  return ((const double *)user)[0] + x[0] + 2 * x[1] + 3 * x[2];
}

static void assert_close(polyrad *p, polyrad *q, double tolerance) {
  double u[2][N], h[2][N], m[2][3];
  ck_assert_int_eq(polyrad_evaluate(p, N, place, weight[0], u[0], h[0]), POLYRAD_OK);
  ck_assert_int_eq(polyrad_evaluate(q, N, place, weight[0], u[1], h[1]), POLYRAD_OK);
  ck_assert_int_eq(polyrad_surface_means(p, m[0], NULL), POLYRAD_OK);
  ck_assert_int_eq(polyrad_surface_means(q, m[1], NULL), POLYRAD_OK);
  for (int i = 0; i < N; i++) {
    ck_assert_double_eq_tol(u[0][i], u[1][i], tolerance);
    ck_assert_double_eq_tol(h[0][i], h[1][i], tolerance);
  }
  for (int i = 0; i < 3; i++)
    ck_assert_double_eq_tol(m[0][i], m[1][i], tolerance);
}

/* E(x) = 1 + x + 2 y + 3 z as a function and by its vertex values; the largest u is below 6. */
START_TEST(linear_function) {
  static const double black[] = {0.5, 0, 0.5}, one = 1;
  double at[9];
  for (int i = 0; i < 9; i++) {
    const double *x = vertex + 3 * triangle[i];
    at[i] = 1 + x[0] + 2 * x[1] + 3 * x[2];
  }
  struct polyrad_scene numbers = corner(), function = corner();
  numbers.emission = function.emission = NULL;
  numbers.rho = function.rho = black; /* one face has no unknowns with numbers */
  numbers.vertex_emission = at;
  function.emission_at = linear_e;
  function.user = (void *)&one;
  polyrad *p = solve(&numbers, 1e-4), *q = solve(&function, 1e-4);
  assert_close(p, q, 2 * 6e-4);
  polyrad_free(p);
  polyrad_free(q);
}
END_TEST

static double quadratic_e(const double x[3], int t, const double w[3], int band, void *user) {
  (void)x;
  (void)user;
  (void)band;
  return t ? 0 : w[1] * w[1];
}

/* sum over an n x n grid of cells of E cos cos / pi r^2 from the triangle z = 0 to a point on
 * x = 0: the midpoint rule, whose error is O(1/n^2). */
static double brute(const double y[3], int n) {
  double sum = 0;
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      double r = (i + 0.5) / n, s = (j + 0.5) / n, w1 = r * (1 - s), w2 = r * s;
      double d[3] = {w1 - y[0], w2 - y[1], -y[2]};
      double d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
      sum += w1 * w1 * d[0] * y[2] / (M_PI * d2 * d2) * r / ((double)n * n);
    }
  return sum;
}

/* Black faces: h of a known E, whose u no equation has to be solved for. */
START_TEST(black_function) {
  static const double black[] = {0, 0, 0};
  struct polyrad_scene scene = corner();
  scene.rho = black;
  scene.emission = NULL;
  scene.emission_at = quadratic_e;
  polyrad *p = solve(&scene, 1e-5);
  double h, u[2], mean[3];
  static const int at[] = {1}, on[] = {0, 0};
  static const double w[] = {0.25, 0.25, 0.5}, on_floor[] = {0.2, 0.6, 0.2, 1, 0, 0};
  const double y[] = {0, 0.25, 0.5};
  ck_assert_int_eq(polyrad_evaluate(p, 1, at, w, NULL, &h), POLYRAD_OK);
  ck_assert_double_eq_tol(h, (4 * brute(y, 800) - brute(y, 400)) / 3, 1e-5 + 1e-8);
  ck_assert_int_eq(polyrad_evaluate(p, 2, on, on_floor, u, NULL), POLYRAD_OK);
  ck_assert_double_eq_tol(u[0], 0.36, 1e-14);
  ck_assert_double_eq_tol(u[1], 0, 1e-14);
  polyrad_surface_means(p, mean, NULL);
  ck_assert_double_eq_tol(mean[0], 1. / 6, 1e-5); /* 2 int w1^2 dw = 2 * 2!/4! */
  ck_assert_double_eq(mean[1], 0);
  polyrad_free(p);
}
END_TEST

/* E = angle at a vertex, discontinuous there but continuous in polar coordinates. */
static double polar_e(const double x[3], int t, const double w[3], int band, void *user) {
  (void)x;
  (void)user;
  (void)band;
  return t ? 0.5 : w[2] / (w[1] + w[2]);
}

START_TEST(polar_function) {
  struct polyrad_scene scene = corner();
  scene.emission = NULL;
  scene.emission_at = polar_e;
  polyrad *p = solve(&scene, 1e-4), *q = solve(&scene, 1e-3);
  assert_close(p, q, 1.1e-3 * 2);
  double u[3], h[3];
  static const int at[] = {0, 0, 0};
  static const double w[3][3] = {{1 - 4e-9, 1e-9, 3e-9}, {1 - 4e-9, 3e-9, 1e-9}, {0.2, 0.2, 0.6}};
  ck_assert_int_eq(polyrad_evaluate(p, 3, at, w[0], u, h), POLYRAD_OK);
  for (int i = 0; i < 3; i++)
    ck_assert_double_eq_tol(u[i] - 0.5 * h[i], i == 1 ? 0.25 : 0.75, 1e-14);
  polyrad_free(p);
  polyrad_free(q);
}
END_TEST

static double broken_e(const double x[3], int t, const double w[3], int band, void *user) {
  (void)w;
  (void)user;
  (void)band;
  return t == 1 && x[1] > 0.4 ? NAN : 1;
}

START_TEST(function_that_fails) {
  struct polyrad_scene scene = corner();
  scene.emission = NULL;
  scene.emission_at = broken_e;
  polyrad *p = create(&scene);
  ck_assert_int_eq(polyrad_solve(p, NULL), POLYRAD_INPUT);
  ck_assert_str_eq(polyrad_error_text(p),
                   "emission_at is not finite on triangle 2 (wall_x0) in band 1; correct it");
  double u;
  ck_assert_int_eq(polyrad_evaluate(p, 1, place, weight[0], &u, NULL), POLYRAD_INPUT);
  polyrad_free(p);
}
END_TEST

/* ---- warnings -------------------------------------------------------------------------------- */

/* A tetrahedron by itself, and a sheet with a flux on both sides: what it is told. */
START_TEST(warnings) {
  static const double corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  static const int outwards[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}, sheet[] = {0, 1, 2, 0, 2, 1};
  static const double half[] = {0.5, 0.5, 0.5, 0.5}, one[] = {1, 1};
  struct polyrad_scene s = {.n_vertex = 4,
                            .vertex = corners,
                            .n_triangle = 4,
                            .triangle = outwards,
                            .rho = half,
                            .emission = half};
  polyrad *p = create(&s);
  ck_assert_ptr_nonnull(strstr(polyrad_warning(p, 0), "closed shell of 4 triangles"));
  ck_assert_ptr_nonnull(strstr(polyrad_warning(p, 1), "no face of the scene sees another"));
  ck_assert_ptr_null(polyrad_warning(p, 2));
  polyrad_free(p);
  s = (struct polyrad_scene){.n_vertex = 4,
                             .vertex = corners,
                             .n_triangle = 2,
                             .triangle = sheet,
                             .emissivity = half,
                             .flux = one};
  p = create(&s);
  ck_assert_ptr_nonnull(strstr(polyrad_warning(p, 0), "has a flux and two sides"));
  ck_assert_ptr_nonnull(strstr(polyrad_warning(p, 1), "no face of the scene sees another"));
  ck_assert_ptr_nonnull(strstr(polyrad_warning(p, 2), "2 of its 2 triangles see no other face"));
  ck_assert_ptr_null(polyrad_warning(p, 3));
  polyrad_free(p);
}
END_TEST

/* ---- errors ---------------------------------------------------------------------------------- */

static void refuse(const struct polyrad_scene *scene, const char *part) {
  polyrad *p;
  ck_assert_int_eq(polyrad_create(scene, &p), POLYRAD_INPUT);
  ck_assert_msg(strstr(polyrad_error_text(p), part) != NULL, "%s", polyrad_error_text(p));
  ck_assert(!strchr(polyrad_error_text(p), '\n'));
  ck_assert_int_eq(polyrad_solve(p, NULL), POLYRAD_INPUT);
  ck_assert_int_eq(polyrad_surface_means(p, NULL, NULL), POLYRAD_INPUT);
  double f[9];
  ck_assert_int_eq(polyrad_view_factors(p, 0, f), POLYRAD_INPUT);
  polyrad_free(p);
}

START_TEST(bad_scenes) {
  static const int far[] = {0, 1, 2, 0, 2, 4, 0, 3, 1}, flat[] = {0, 1, 2, 0, 2, 2, 0, 3, 1};
  static const int twice[] = {0, 1, 2, 0, 1, 2, 0, 3, 1}, below[] = {0, -1, 1}, few[] = {0, 0, 0};
  static const int least[] = {0, 1, INT_MIN, 0, 2, 3, 0, 3, 1},
                   most[] = {INT_MAX, 1, 2, 0, 2, 3, 0, 3, INT_MAX};
  static const double more[] = {0.5, 1.1, 0}, not [] = {0, NAN, 0}, many[] = {0, INFINITY, 1};
  static const char *const same[] = {"a", "b", "a"}, *const none[] = {"a", NULL, "b"};
  static const double off[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, NAN, 1};
  static const double rug[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0.9, 0.9, 0};
  static const int on_floor[] = {0, 1, 2, 0, 1, 3, 1, 2, 3};
  refuse(NULL, "scene is NULL");
#define REFUSE(field, value, part)                                                                 \
  do {                                                                                             \
    struct polyrad_scene s = corner();                                                             \
    s.field = value;                                                                               \
    refuse(&s, part);                                                                              \
  } while (0)
  REFUSE(vertex, NULL, "0 vertices");
  REFUSE(triangle, NULL, "0 triangles");
  REFUSE(n_triangle, -1, "-1 triangles");
  REFUSE(rho, NULL, "rho is NULL");
  REFUSE(emission, NULL, "0 of emission");
  REFUSE(vertex_emission, emission, "2 of emission");
  REFUSE(emission_at, linear_e, "2 of emission");
  REFUSE(emissivity, emission, "emissivity is given, and so are rho, an emission or several bands");
  REFUSE(temperature, emission, "temperature or flux is given; give emissivity with them");
  REFUSE(flux, emission, "temperature or flux is given; give emissivity with them");
  struct polyrad_scene both = corner();
  both.vertex_emission = emission;
  both.emission_at = linear_e;
  refuse(&both, "3 of emission, vertex_emission and emission_at are given");
  both = corner();
  both.rho = both.emission = NULL;
  both.emissivity = emission;
  both.emission_at = linear_e;
  refuse(&both, "emissivity is given, and so are");
  both.emission_at = NULL;
  both.n_band = 2;
  refuse(&both, "several bands");
  REFUSE(n_triangle, 0, "0 triangles");
  REFUSE(n_triangle, INT_MAX, "2147483647 triangles");
  REFUSE(n_triangle, INT_MIN, "-2147483648 triangles");
  REFUSE(n_vertex, 0, "0 vertices");
  REFUSE(n_vertex, -1, "-1 vertices");
  REFUSE(n_vertex, INT_MIN, "-2147483648 vertices");
  REFUSE(n_vertex, 3, "triangle 2 has the vertex index 3; give one of 0 to 2");
  REFUSE(n_band, 17, "n_band is 17");
  REFUSE(n_band, -1, "n_band is -1");
  REFUSE(n_band, INT_MIN, "n_band is -2147483648");
  REFUSE(n_band, INT_MAX, "n_band is 2147483647");
  REFUSE(n_surface, -1, "n_surface is -1");
  REFUSE(n_surface, INT_MAX, "n_surface is 2147483647");
  REFUSE(triangle, least, "triangle 1 has the vertex index -2147483648; give one of 0 to 3");
  REFUSE(triangle, most, "triangle 1 has the vertex index 2147483647; give one of 0 to 3");
  REFUSE(surface, most, "triangle 1 has the surface index 2147483647; give one of 0 to 2");
  REFUSE(n_surface, 0, "n_surface is 0 and surface is given");
  REFUSE(n_surface, 4, "n_surface is 4");
  REFUSE(surface, NULL, "surface is NULL");
  REFUSE(surface, below, "triangle 2 has the surface index -1; give one of 0 to 2");
  REFUSE(surface, few, "2 of the 3 surfaces have no triangles");
  REFUSE(surface_name, same, "surfaces 1 and 3 have the same name, 'a'");
  REFUSE(surface_name, none, "surface_name[1] is NULL");
  struct polyrad_scene nameless = corner();
  nameless.n_surface = 0;
  nameless.surface = NULL;
  refuse(&nameless, "surface_name is given, but no surface");
  REFUSE(triangle, far, "triangle 2 has the vertex index 4; give one of 0 to 3");
  REFUSE(triangle, flat, "triangle 2 (wall_x0): degenerate");
  REFUSE(triangle, twice, "same vertices and same normal as triangle 1");
  REFUSE(vertex, off, "coordinate that is not finite");
  struct polyrad_scene covered = corner();
  covered.vertex = rug;
  covered.triangle = on_floor;
  refuse(&covered, "triangle 2 (wall_x0): overlaps triangle 1 (");
  REFUSE(rho, more, "triangle 2 (wall_x0): rho is 1.1");
  REFUSE(rho, not, "rho is nan");
  REFUSE(emission, many, "emission is not finite");
  ck_assert_int_eq(polyrad_create(NULL, NULL), POLYRAD_INPUT);
}
END_TEST

START_TEST(bad_calls) {
  struct polyrad_scene scene = corner();
  polyrad *p = create(&scene);
  double u[3] = {0}, w[3] = {0.5, 0.25, 0.25};
  int t = 0, out = 3;
  struct polyrad_summary s;
  static const int extreme[] = {0, -1, INT_MAX, INT_MIN};
  for (int i = 0; i < 4; i++)
    ck_assert_ptr_null(polyrad_warning(p, extreme[i]));
  ck_assert_ptr_null(polyrad_warning(NULL, 0));
  ck_assert_int_eq(polyrad_evaluate(p, 1, &t, w, u, NULL), POLYRAD_INPUT);
  ck_assert_str_eq(polyrad_error_text(p), "there is no solution yet; call polyrad_solve first");
  ck_assert_int_eq(polyrad_get_summary(p, &s), POLYRAD_INPUT);
  static const struct polyrad_options bad[] = {{.tolerance = -1}, {.tolerance = NAN},
                                               {.tolerance = 2},  {.memory_limit = -1},
                                               {.threads = -1},   {.threads = 5000}};
  for (int i = 0; i < 6; i++)
    ck_assert_int_eq(polyrad_solve(p, &bad[i]), POLYRAD_INPUT);
  ck_assert_int_eq(polyrad_solve(p, NULL), POLYRAD_OK);
  ck_assert_int_eq(polyrad_evaluate(p, 1, &out, w, u, NULL), POLYRAD_INPUT);
  ck_assert_str_eq(polyrad_error_text(p), "point 1 has the triangle index 3; give one of 0 to 2");
  for (int i = 1; i < 4; i++) {
    ck_assert_int_eq(polyrad_evaluate(p, 1, &extreme[i], w, u, NULL), POLYRAD_INPUT);
    ck_assert_ptr_nonnull(strstr(polyrad_error_text(p), "give one of 0 to 2"));
    ck_assert_int_eq(polyrad_evaluate_at(p, 1, &extreme[i], w, u, NULL), POLYRAD_INPUT);
    ck_assert_int_eq(polyrad_evaluate(p, extreme[i], &t, w, u, NULL), POLYRAD_INPUT);
    ck_assert_ptr_nonnull(strstr(polyrad_error_text(p), "give 0 to"));
    ck_assert_int_eq(polyrad_evaluate_at(p, extreme[i], &t, w, u, NULL), POLYRAD_INPUT);
  }
  ck_assert_int_eq(polyrad_evaluate(p, 1, NULL, w, u, NULL), POLYRAD_INPUT);
  ck_assert_int_eq(polyrad_evaluate(p, -1, &t, w, u, NULL), POLYRAD_INPUT);
  ck_assert_int_eq(polyrad_evaluate(p, 0, NULL, NULL, NULL, NULL), POLYRAD_OK);
  ck_assert_int_eq(polyrad_evaluate_at(p, 1, &t, (double[]){0.2, 0.2, 1e-3}, u, NULL),
                   POLYRAD_INPUT);
  ck_assert_str_eq(polyrad_error_text(p), "point 1 does not lie on triangle 1; correct it");
  for (int m = 0; m < 3; m++) {
    static const double wrong[3][3] = {{0.5, 0.5, 0.5}, {-0.5, 1, 0.5}, {NAN, 0, 1}};
    ck_assert_int_eq(polyrad_evaluate(p, 1, &t, wrong[m], u, NULL), POLYRAD_INPUT);
  }
  ck_assert_int_eq(polyrad_view_factors(p, 0, NULL), POLYRAD_INPUT);
  ck_assert_int_eq(polyrad_view_factors(p, NAN, u), POLYRAD_INPUT);
  ck_assert_int_eq(polyrad_get_summary(p, NULL), POLYRAD_INPUT);
  polyrad_free(p);
  polyrad_free(NULL);
  ck_assert_int_eq(polyrad_solve(NULL, NULL), POLYRAD_INPUT);
  ck_assert_int_eq(polyrad_surface_means(NULL, u, u), POLYRAD_INPUT);
  ck_assert(strstr(polyrad_error_text(NULL), "NULL") && strlen(polyrad_version()) > 2);
}
END_TEST

/* What polyrad_create refused is still a handle, which holds nothing. */
START_TEST(calls_after_a_refusal) {
  struct polyrad_scene scene = corner();
  struct polyrad_summary summary;
  double x[9] = {0.5, 0.25, 0.25};
  const int t = 0;
  polyrad *p;
  scene.n_vertex = 3;
  ck_assert_int_eq(polyrad_create(&scene, &p), POLYRAD_INPUT);
  ck_assert_ptr_nonnull(p);
  ck_assert_ptr_null(polyrad_warning(p, 0));
  ck_assert_int_eq(polyrad_solve(p, NULL), POLYRAD_INPUT);
  ck_assert_int_eq(polyrad_get_summary(p, &summary), POLYRAD_INPUT);
  ck_assert_int_eq(polyrad_evaluate(p, 1, &t, x, x, x), POLYRAD_INPUT);
  ck_assert_int_eq(polyrad_evaluate_at(p, 1, &t, x, x, x), POLYRAD_INPUT);
  ck_assert_int_eq(polyrad_surface_means(p, x, x), POLYRAD_INPUT);
  ck_assert_int_eq(polyrad_surface_heat(p, x, x), POLYRAD_INPUT);
  ck_assert_int_eq(polyrad_view_factors(p, 0, x), POLYRAD_INPUT);
  ck_assert_int_gt((int)strlen(polyrad_error_text(p)), 10);
  polyrad_free(p);
}
END_TEST

/* A closed tetrahedron seen from inside, all white: no light is ever lost. */
START_TEST(closed_and_white) {
  static const int inside[] = {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2};
  static const double white[] = {1, 1, 1, 1}, e[] = {1, 0, 0, 0};
  struct polyrad_scene scene = {.n_vertex = 4,
                                .vertex = vertex,
                                .n_triangle = 4,
                                .triangle = inside,
                                .rho = white,
                                .emission = e};
  polyrad *p = create(&scene);
  ck_assert_int_eq(polyrad_solve(p, NULL), POLYRAD_NUMERIC);
  ck_assert(strlen(polyrad_error_text(p)) > 20);
  double u;
  ck_assert_int_eq(polyrad_evaluate(p, 1, place, weight[0], &u, NULL), POLYRAD_INPUT);
  polyrad_free(p);
}
END_TEST

START_TEST(memory_limit) {
  struct polyrad_scene scene = corner();
  polyrad *p = create(&scene);
  struct polyrad_options o = {.tolerance = 1e-9, .memory_limit = 1e4, .threads = 1};
  ck_assert_int_eq(polyrad_solve(p, &o), POLYRAD_SYSTEM);
  ck_assert_msg(strstr(polyrad_error_text(p), "coarsest mesh") != NULL, "%s",
                polyrad_error_text(p));
  o.memory_limit = 3e6; /* the first levels fit, the last does not: a solution with its bound */
  ck_assert_int_eq(polyrad_solve(p, &o), POLYRAD_NUMERIC);
  ck_assert_msg(strstr(polyrad_error_text(p), "was not reached") != NULL, "%s",
                polyrad_error_text(p));
  struct polyrad_summary s;
  double u;
  ck_assert_int_eq(polyrad_get_summary(p, &s), POLYRAD_OK);
  ck_assert(!s.converged && s.relative_bound > 1e-9 && s.relative_bound < 1);
  ck_assert_int_eq(polyrad_evaluate(p, 1, place, weight[0], &u, NULL), POLYRAD_OK);
  polyrad_free(p);
}
END_TEST

/* ---- threads --------------------------------------------------------------------------------- */

static void *solve_alone(void *result) {
  struct polyrad_scene scene = corner();
  polyrad *p;
  struct polyrad_options o = {.tolerance = 1e-3, .threads = 1};
  if (!polyrad_create(&scene, &p) && !polyrad_solve(p, &o))
    polyrad_evaluate(p, N, place, weight[0], result, NULL);
  polyrad_free(p);
  return NULL;
}

/* Handles in threads of the caller's: the same bits. */
START_TEST(two_at_a_time) {
  double u[3][N] = {{0}};
  pthread_t thread[2];
  solve_alone(u[2]);
  for (int i = 0; i < 2; i++)
    ck_assert_int_eq(pthread_create(&thread[i], NULL, solve_alone, u[i]), 0);
  for (int i = 0; i < 2; i++)
    pthread_join(thread[i], NULL);
  ck_assert_double_gt(u[2][0], 0.5);
  ck_assert(!memcmp(u[0], u[2], sizeof u[0]) && !memcmp(u[1], u[2], sizeof u[0]));
}
END_TEST

int main(void) {
  Suite *s = suite_create("library");
  TCase *t = tcase_create("library");
  tcase_set_timeout(t, 200);
  tcase_add_test(t, same_as_the_program);
  tcase_add_test(t, bound_holds);
  tcase_add_test(t, bands_and_numbers);
  tcase_add_test(t, shadow);
  tcase_add_test(t, linear_function);
  tcase_add_test(t, black_function);
  tcase_add_test(t, polar_function);
  tcase_add_test(t, function_that_fails);
  tcase_add_test(t, warnings);
  tcase_add_test(t, bad_scenes);
  tcase_add_test(t, bad_calls);
  tcase_add_test(t, calls_after_a_refusal);
  tcase_add_test(t, closed_and_white);
  tcase_add_test(t, memory_limit);
  tcase_add_test(t, two_at_a_time);
  suite_add_tcase(s, t);
  return run_suite(s);
}
