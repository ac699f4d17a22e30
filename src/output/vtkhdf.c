#include "output/vtkhdf.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/vec.h"
#include "scene/heat.h"

/* What the scene says about every point. */
struct scenery {
  double *rho;                /* owned [n_point, n_band] */
  double *emission;           /* owned [n_point, n_band] */
  double *flux, *temperature; /* owned [n_point], of thermal scenes */
  int *surface;               /* owned [n_point] */
};

static void scenery_free(struct scenery *s) {
  free(s->rho);
  free(s->emission);
  free(s->flux);
  free(s->temperature);
  free(s->surface);
}

/* Weights of vertices 1 and 2 at point x of a triangle; vertex 0 has the rest. */
static void barycentric(const struct rad_triangle *t, const double x[3], double weight[2]) {
  double a[3], b[3], d[3];
  rad_sub(t->v[1], t->v[0], a);
  rad_sub(t->v[2], t->v[0], b);
  rad_sub(x, t->v[0], d);
  const double aa = rad_dot(a, a), ab = rad_dot(a, b), bb = rad_dot(b, b);
  const double da = rad_dot(d, a), db = rad_dot(d, b);
  const double determinant = aa * bb - ab * ab;
  weight[0] = (bb * da - ab * db) / determinant;
  weight[1] = (aa * db - ab * da) / determinant;
}

/* Net flux and temperature of triangle j at point i of the picture. */
static void look_up_heat(const struct rad_scene *scene, const struct rad_picture *p, int j,
                         int64_t i, struct scenery *s) {
  if (!scene->heat || !p->radiosity || !p->irradiance)
    return;
  s->flux[i] = p->radiosity[i] - p->irradiance[i];
  s->temperature[i] =
      rad_heat_temperature(rad_heat_fourth_power(&scene->heat[j], p->irradiance[i]));
}

/* Properties of triangle j at point i of the picture. Differences keep a constant emission exact.
 */
static void look_up(const struct rad_scene *scene, int j, const double x[3], int64_t i,
                    struct scenery *s) {
  const int n_band = scene->n_band;
  const double *const E = scene->emission + (size_t)j * 3 * (size_t)n_band;
  double weight[2];
  barycentric(&scene->triangle[j], x, weight);
  s->surface[i] = scene->triangle[j].surface;
  for (int k = 0; k < n_band; k++) {
    const double E0 = E[k], E1 = E[n_band + k], E2 = E[2 * n_band + k];
    s->rho[i * n_band + k] = scene->rho[j * n_band + k];
    s->emission[i * n_band + k] = E0 + weight[0] * (E1 - E0) + weight[1] * (E2 - E0);
  }
}

static int scenery_make(const struct rad_scene *scene, const struct rad_picture *p,
                        struct scenery *s) {
  const size_t n = (size_t)p->n_point, n_band = (size_t)scene->n_band;
  *s = (struct scenery){.rho = rad_alloc(n * n_band, sizeof(double)),
                        .emission = rad_alloc(n * n_band, sizeof(double)),
                        .flux = rad_alloc(n, sizeof(double)),
                        .temperature = rad_alloc(n, sizeof(double)),
                        .surface = rad_alloc(n, sizeof(int))};
  if (!s->rho || !s->emission || !s->flux || !s->temperature || !s->surface)
    return 0;
  for (size_t i = 0; i < n; i++) {
    s->surface[i] = -1;
    s->flux[i] = s->temperature[i] = NAN;
  }
  for (size_t i = 0; i < n * n_band; i++)
    s->rho[i] = s->emission[i] = NAN;
  for (int64_t c = 0; c < p->n_cell; c++)
    for (int64_t k = p->offset[c]; k < p->offset[c + 1]; k++) {
      const int64_t i = p->connectivity[k];
      assert(i >= 0 && i < p->n_point);
      assert(p->triangle[c] >= 0 && p->triangle[c] < scene->n_triangle);
      look_up(scene, p->triangle[c], p->point + 3 * i, i, s);
      look_up_heat(scene, p, p->triangle[c], i, s);
    }
  return 1;
}

/* mean: [n_cell, n_band] of point values over the points of each cell */
static void average(const struct rad_picture *p, int n_band, const double *value, double *mean) {
  for (int64_t c = 0; c < p->n_cell; c++)
    for (int k = 0; k < n_band; k++) {
      double sum = 0;
      for (int64_t m = p->offset[c]; m < p->offset[c + 1]; m++)
        sum += value[p->connectivity[m] * n_band + k];
      mean[c * n_band + k] = sum / (double)(p->offset[c + 1] - p->offset[c]);
    }
}

static void write_field(struct rad_hdf *h, hid_t group, const char *name, const char *unit,
                        const char *description, int64_t n, int n_band, const double *value) {
  rad_hdf_array(h, group,
                &(struct rad_hdf_array){.name = name,
                                        .unit = unit,
                                        .description = description,
                                        .type = RAD_HDF_REAL,
                                        .rank = n_band > 1 ? 2 : 1,
                                        .shape = {(hsize_t)n, (hsize_t)n_band},
                                        .data = value});
}

static void write_number(struct rad_hdf *h, hid_t group, const char *name, const char *description,
                         int64_t n, const int *number) {
  rad_hdf_array(h, group,
                &(struct rad_hdf_array){.name = name,
                                        .unit = "1",
                                        .description = description,
                                        .type = RAD_HDF_INT32,
                                        .rank = 1,
                                        .shape = {(hsize_t)n},
                                        .data = number});
}

static void write_surface(struct rad_hdf *h, hid_t group, int64_t n, const int *surface) {
  write_number(h, group, "surface", "surface, as a row of /polyrad/surfaces", n, surface);
}

/* Fields that are shown: as the deck asks, and as far as they were computed. */
static const double *shown(const struct rad_result *r, unsigned field, const double *value) {
  const unsigned fields = r->deck->output.fields;
  return !fields || fields & field ? value : NULL;
}

/* The same of a field of thermal scenes. */
static const double *shown_heat(const struct rad_result *r, unsigned field, const double *value) {
  return r->scene->heat && r->picture.radiosity && r->picture.irradiance ? shown(r, field, value)
                                                                         : NULL;
}

static void write_point_data(struct rad_hdf *h, hid_t root, const struct rad_result *r,
                             const struct scenery *s) {
  const int64_t n = r->picture.n_point;
  const int n_band = r->scene->n_band;
  const double *const u = shown(r, RAD_FIELD_RADIOSITY, r->picture.radiosity);
  const double *const g = shown(r, RAD_FIELD_IRRADIANCE, r->picture.irradiance);
  const double *const q = shown_heat(r, RAD_FIELD_NET_FLUX, s->flux);
  const double *const t = shown_heat(r, RAD_FIELD_TEMPERATURE, s->temperature);
  const hid_t group = rad_hdf_group(h, root, "PointData");
  if (u)
    write_field(h, group, "radiosity", "W/m2", "radiosity u", n, n_band, u);
  if (g)
    write_field(h, group, "irradiance", "W/m2", "irradiance", n, n_band, g);
  if (q)
    write_field(h, group, "net_flux", "W/m2", "net heat flux u - h", n, 1, q);
  if (t)
    write_field(h, group, "temperature", "K", "temperature; NaN: rho was given, or none", n, 1, t);
  write_field(h, group, "rho", "1", "reflectivity of the point's triangle", n, n_band, s->rho);
  write_field(h, group, "emission", "W/m2", "emitted radiosity E", n, n_band, s->emission);
  write_surface(h, group, n, s->surface);
  rad_hdf_group_close(h, group);
}

/* Cell values that belong to the whole triangle. */
static void write_constants(struct rad_hdf *h, hid_t group, const struct rad_result *r,
                            double *rho) {
  const struct rad_picture *const p = &r->picture;
  const int n_band = r->scene->n_band;
  int *const surface = rad_alloc((size_t)p->n_cell, sizeof *surface);
  if (!surface) {
    rad_hdf_fail(h, "out of memory for the pictures");
    return;
  }
  for (int64_t c = 0; c < p->n_cell; c++) {
    const int j = p->triangle[c];
    surface[c] = r->scene->triangle[j].surface;
    for (int k = 0; k < n_band; k++)
      rho[c * n_band + k] = r->scene->rho[j * n_band + k];
  }
  write_field(h, group, "rho", "1", "reflectivity", p->n_cell, n_band, rho);
  write_surface(h, group, p->n_cell, surface);
  write_number(h, group, "triangle", "scene triangle, as a row of /polyrad/triangles", p->n_cell,
               p->triangle);
  free(surface);
}

static void write_cell_data(struct rad_hdf *h, hid_t root, const struct rad_result *r,
                            const struct scenery *s) {
  const struct rad_picture *const p = &r->picture;
  const int n_band = r->scene->n_band;
  const struct {
    const char *name, *unit, *description;
    const double *value;
  } field[] = {
      {"radiosity", "W/m2", "radiosity u, mean over the points",
       shown(r, RAD_FIELD_RADIOSITY, p->radiosity)},
      {"irradiance", "W/m2", "irradiance, mean over the points",
       shown(r, RAD_FIELD_IRRADIANCE, p->irradiance)},
      {"emission", "W/m2", "emitted radiosity E, mean over the points", s->emission},
      {"net_flux", "W/m2", "net heat flux u - h, mean over the points",
       shown_heat(r, RAD_FIELD_NET_FLUX, s->flux)},
      {"temperature", "K", "temperature, mean over the points",
       shown_heat(r, RAD_FIELD_TEMPERATURE, s->temperature)},
  };
  double *const cell = rad_alloc((size_t)p->n_cell * (size_t)n_band, sizeof *cell);
  if (!cell) {
    rad_hdf_fail(h, "out of memory for the pictures");
    return;
  }
  const hid_t group = rad_hdf_group(h, root, "CellData");
  for (size_t k = 0; k < sizeof field / sizeof *field; k++)
    if (field[k].value) {
      average(p, n_band, field[k].value, cell);
      write_field(h, group, field[k].name, field[k].unit, field[k].description, p->n_cell, n_band,
                  cell);
    }
  if (p->indicator)
    write_field(h, group, "error_indicator", "W/m2", "largest |rho K (u* - u_h)| of the element",
                p->n_cell, 1, p->indicator);
  if (p->bound)
    write_field(h, group, "error_bound", "W/m2", "bound z of |u - u*|, largest of the element",
                p->n_cell, 1, p->bound);
  write_constants(h, group, r, cell);
  rad_hdf_group_close(h, group);
  free(cell);
}

static void write_count(struct rad_hdf *h, hid_t root, const char *name, const char *description,
                        int64_t n) {
  rad_hdf_array(h, root,
                &(struct rad_hdf_array){name, "1", description, RAD_HDF_INT64, 1, {1}, &n});
}

static void write_grid(struct rad_hdf *h, hid_t root, const struct rad_picture *p) {
  static const int64_t no_cell[1] = {0};
  const int64_t *const offset = p->n_cell > 0 ? p->offset : no_cell;
  const hsize_t n_point = (hsize_t)p->n_point, n_cell = (hsize_t)p->n_cell;
  const hsize_t n_corner = (hsize_t)offset[n_cell];
  const struct rad_hdf_array grid[] = {
      {"Points", "m", "points of the cells", RAD_HDF_REAL, 2, {n_point, 3}, p->point},
      {"Connectivity",
       "1",
       "points of each cell, in VTK's order",
       RAD_HDF_INT64,
       1,
       {n_corner},
       p->connectivity},
      {"Offsets",
       "1",
       "where each cell starts in Connectivity, and its end",
       RAD_HDF_INT64,
       1,
       {n_cell + 1},
       offset},
      {"Types",
       "1",
       "VTK cell types: 5 triangle, 9 quadrilateral, 70 Lagrange quadrilateral",
       RAD_HDF_UINT8,
       1,
       {n_cell},
       p->type},
  };
  write_count(h, root, "NumberOfPoints", "points of the grid", p->n_point);
  write_count(h, root, "NumberOfCells", "cells of the grid", p->n_cell);
  write_count(h, root, "NumberOfConnectivityIds", "length of Connectivity", offset[n_cell]);
  for (size_t k = 0; k < sizeof grid / sizeof *grid; k++)
    rad_hdf_array(h, root, &grid[k]);
}

void rad_vtkhdf_write(struct rad_hdf *h, const struct rad_result *result) {
  static const int64_t version[2] = {2, 0};
  struct scenery scenery;
  const hid_t root = rad_hdf_group(h, h->file, "VTKHDF");
  rad_hdf_set_integers(h, root, "Version", 2, version);
  rad_hdf_set_ascii(h, root, "Type", "UnstructuredGrid");
  write_grid(h, root, &result->picture);
  if (scenery_make(result->scene, &result->picture, &scenery)) {
    write_point_data(h, root, result, &scenery);
    write_cell_data(h, root, result, &scenery);
  } else {
    rad_hdf_fail(h, "out of memory for the pictures");
  }
  scenery_free(&scenery);
  rad_hdf_group_close(h, root);
}
