/* Three faces of a cube, cut at its corner: two reflect, one is a lamp that is brighter on one
 * side.
 *
 *   cc cube_corner.c $(pkg-config --cflags --libs polyrad) -o cube_corner && ./cube_corner
 */
#include <polyrad.h>
#include <stdio.h>

/* E(x) of the lamp, triangle 1, in W/m2; the other triangles emit nothing. */
static double lamp(const double x[3], int triangle, const double weight[3], int band, void *user) {
  const double *power = user;
  (void)weight;
  (void)band;
  return triangle == 1 ? *power * (1 - x[1] * x[1]) : 0;
}

int main(void) {
  static const double vertex[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}; /* [m] */
  static const int triangle[3][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}};
  static const int surface[3] = {0, 1, 2};
  static const char *const name[3] = {"floor", "lamp", "wall"};
  static const double rho[3] = {0.5, 0.1, 0.8};
  double power = 100;

  struct polyrad_scene scene = {0};
  scene.n_vertex = 4;
  scene.vertex = vertex[0];
  scene.n_triangle = 3;
  scene.triangle = triangle[0];
  scene.n_surface = 3;
  scene.surface = surface;
  scene.surface_name = name;
  scene.rho = rho;
  scene.emission_at = lamp;
  scene.user = &power;

  struct polyrad_options options = {0};
  options.tolerance = 1e-4; /* of the largest radiosity */

  const int on[2] = {0, 0};
  const double position[2][3] = {{0.25, 0.25, 0}, {0.001, 0.001, 0}};
  double radiosity[2], irradiance[2], mean[3];
  struct polyrad_summary summary;

  polyrad *p;
  int failed = polyrad_create(&scene, &p) || polyrad_solve(p, &options) ||
               polyrad_get_summary(p, &summary) ||
               polyrad_evaluate_at(p, 2, on, position[0], radiosity, irradiance) ||
               polyrad_surface_means(p, mean, NULL);
  if (failed) {
    fprintf(stderr, "cube_corner: %s\n", polyrad_error_text(p));
  } else {
    printf("%lld unknowns, error at most %.1e W/m2\n", summary.unknowns, summary.error_bound);
    for (int i = 0; i < 2; i++)
      printf("floor at (%g, %g): radiosity %.2f, irradiance %.2f W/m2\n", position[i][0],
             position[i][1], radiosity[i], irradiance[i]);
    for (int s = 0; s < 3; s++)
      printf("mean radiosity of %s: %.2f W/m2\n", name[s], mean[s]);
  }
  polyrad_free(p);
  return failed;
}
