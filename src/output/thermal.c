#include "output/thermal.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "scene/heat.h"

static void free_list(struct rad_thermal_list *list) {
  free(list->flux);
  free(list->power);
  free(list->temperature);
}

void rad_thermal_free(struct rad_thermal *thermal) {
  free_list(&thermal->triangle);
  free_list(&thermal->surface);
  *thermal = (struct rad_thermal){0};
}

static int make_list(int n, struct rad_thermal_list *list) {
  *list = (struct rad_thermal_list){n, rad_calloc((size_t)n, sizeof(double)),
                                    rad_calloc((size_t)n, sizeof(double)),
                                    rad_calloc((size_t)n, sizeof(double))};
  return list->flux && list->power && list->temperature;
}

/* Powers and areas of surfaces add up, and so do area times T^4. */
static void add_up(const struct rad_scene *scene, const struct rad_result *r,
                   struct rad_thermal *thermal) {
  struct rad_thermal_list *t = &thermal->triangle, *s = &thermal->surface;
  for (int j = 0; j < scene->n_triangle; j++) {
    const int to = scene->triangle[j].surface;
    const double area = scene->triangle[j].area;
    const double fourth = rad_heat_fourth_power(&scene->heat[j], r->triangle_irradiance[j]);
    t->flux[j] = r->triangle_radiosity[j] - r->triangle_irradiance[j];
    t->power[j] = area * t->flux[j];
    t->temperature[j] = rad_heat_temperature(fourth);
    s->power[to] += t->power[j];
    s->flux[to] += area; /* for now */
    s->temperature[to] += area * fourth;
    thermal->sum += t->power[j];
    thermal->given += fmax(t->power[j], 0);
    if (fourth < 0 && thermal->cold < 0)
      thermal->cold = j;
  }
  for (int i = 0; i < s->n; i++) {
    const double area = s->flux[i];
    s->flux[i] = s->power[i] / area;
    s->temperature[i] = rad_heat_temperature(s->temperature[i] / area);
  }
}

enum rad_code rad_thermal_make(const struct rad_result *r, struct rad_thermal *thermal,
                               struct rad_error *e) {
  const struct rad_scene *const scene = r->scene;
  *thermal = (struct rad_thermal){.cold = -1};
  if (!scene->heat)
    return RAD_OK;
  const int made = make_list(scene->n_triangle, &thermal->triangle) &
                   make_list(scene->n_surface, &thermal->surface);
  if (!made)
    return rad_fail_memory(e, "the net fluxes", 48.0 * scene->n_triangle);
  add_up(scene, r, thermal);
  return RAD_OK;
}

void rad_thermal_write(struct rad_hdf *h, hid_t group, const struct rad_thermal_list *list) {
  const hsize_t n = (hsize_t)list->n;
  const struct rad_hdf_array column[] = {
      {"mean_net_flux", "W/m2", "mean net heat flux u - h", RAD_HDF_REAL, 1, {n}, list->flux},
      {"net_power", "W", "net heat flux times area", RAD_HDF_REAL, 1, {n}, list->power},
      {"temperature",
       "K",
       "fourth root of the mean of T^4; NaN: rho was given, or flux allows none",
       RAD_HDF_REAL,
       1,
       {n},
       list->temperature}};
  for (size_t k = 0; k < sizeof column / sizeof *column && list->n > 0; k++)
    rad_hdf_array(h, group, &column[k]);
}
