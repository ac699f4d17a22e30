#include "output/thermal.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "scene/heat.h"

static void free_list(struct rad_thermal_list *list) {
  free(list->flux);
  free(list->error_flux);
  free(list->power);
  free(list->error_power);
  free(list->temperature);
  free(list->error_temperature);
}

void rad_thermal_free(struct rad_thermal *thermal) {
  free_list(&thermal->triangle);
  free_list(&thermal->surface);
  *thermal = (struct rad_thermal){0};
}

static int make_list(int n, struct rad_thermal_list *list) {
  double **column[] = {&list->flux,        &list->error_flux,  &list->power,
                       &list->error_power, &list->temperature, &list->error_temperature};
  *list = (struct rad_thermal_list){.n = n};
  for (int i = 0; i < 6; i++)
    if (!(*column[i] = rad_calloc((size_t)n, sizeof(double))))
      return 0;
  return 1;
}

/* T of T^4 +- error: the larger of the two ways to the ends, which do not go below 0 K. */
static double temperature_error(double fourth, double error) {
  double t = rad_heat_temperature(fourth);
  double up = rad_heat_temperature(fourth + error) - t;
  double down = t - rad_heat_temperature(fmax(fourth - error, 0));
  return isnan(error) ? NAN : fmax(up, down);
}

/* One triangle: u - h = E - (1 - rho) h, and its T^4 with error. */
static void set_triangle(const struct rad_scene *scene, const struct rad_means *m, int j,
                         struct rad_thermal_list *t, double *fourth, double *fourth_error) {
  const struct rad_heat *heat = &scene->heat[j];
  const double area = scene->triangle[j].area, rho = scene->rho[j];
  *fourth = rad_heat_fourth_power(heat, m->irradiance[j]);
  *fourth_error = heat->kind == RAD_HEAT_FLUX ? m->error_irradiance[j] / RAD_STEFAN_BOLTZMANN : 0;
  t->flux[j] = m->radiosity[j] - m->irradiance[j];
  t->error_flux[j] = rho < 1 ? (1 - rho) * m->error_irradiance[j] : 0;
  t->power[j] = area * t->flux[j];
  t->error_power[j] = area * t->error_flux[j];
  t->temperature[j] = rad_heat_temperature(*fourth);
  t->error_temperature[j] = temperature_error(*fourth, *fourth_error);
}

/* Powers and areas of surfaces add up, and so do area times T^4; errors as well. */
static void add_up(const struct rad_scene *scene, const struct rad_means *m,
                   struct rad_thermal *thermal) {
  struct rad_thermal_list *t = &thermal->triangle, *s = &thermal->surface;
  for (int j = 0; j < scene->n_triangle; j++) {
    const int to = scene->triangle[j].surface;
    const double area = scene->triangle[j].area;
    double fourth, error;
    set_triangle(scene, m, j, t, &fourth, &error);
    s->power[to] += t->power[j];
    s->error_power[to] += t->error_power[j];
    s->flux[to] += area; /* for now */
    s->temperature[to] += area * fourth;
    s->error_temperature[to] += area * error;
    thermal->sum += t->power[j];
    thermal->error_sum += t->error_power[j];
    thermal->given += fmax(t->power[j], 0);
    if (fourth < 0 && thermal->cold < 0)
      thermal->cold = j;
  }
  for (int i = 0; i < s->n; i++) {
    const double area = s->flux[i], fourth = s->temperature[i] / area;
    s->flux[i] = s->power[i] / area;
    s->error_flux[i] = s->error_power[i] / area;
    s->error_temperature[i] = temperature_error(fourth, s->error_temperature[i] / area);
    s->temperature[i] = rad_heat_temperature(fourth);
  }
}

enum rad_code rad_thermal_make(const struct rad_scene *scene, const struct rad_means *means,
                               struct rad_thermal *thermal, struct rad_error *e) {
  *thermal = (struct rad_thermal){.cold = -1};
  if (!scene->heat || !means)
    return RAD_OK;
  const int made = make_list(scene->n_triangle, &thermal->triangle) &
                   make_list(scene->n_surface, &thermal->surface);
  if (!made)
    return rad_fail_memory(e, "the net fluxes", 96.0 * scene->n_triangle);
  add_up(scene, means, thermal);
  return RAD_OK;
}

void rad_thermal_write(struct rad_hdf *h, hid_t group, const struct rad_thermal_list *list) {
  const hsize_t n = (hsize_t)list->n;
  const struct rad_hdf_array column[] = {
      {"mean_net_flux", "W/m2", "mean net heat flux u - h", RAD_HDF_REAL, 1, {n}, list->flux},
      {"error_net_flux", "W/m2", "bound of its error", RAD_HDF_REAL, 1, {n}, list->error_flux},
      {"net_power", "W", "net heat flux times area", RAD_HDF_REAL, 1, {n}, list->power},
      {"error_net_power", "W", "bound of its error", RAD_HDF_REAL, 1, {n}, list->error_power},
      {"temperature",
       "K",
       "fourth root of the mean of T^4; NaN: rho was given, or flux allows none",
       RAD_HDF_REAL,
       1,
       {n},
       list->temperature},
      {"error_temperature",
       "K",
       "bound of its error",
       RAD_HDF_REAL,
       1,
       {n},
       list->error_temperature}};
  for (size_t k = 0; k < sizeof column / sizeof *column && list->n > 0; k++)
    rad_hdf_array(h, group, &column[k]);
}
