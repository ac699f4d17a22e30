#include "output/result.h"

#include <math.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/memory.h"
#include "output/hdf.h"
#include "output/stamp.h"
#include "output/thermal.h"
#include "output/vtkhdf.h"

void rad_result_free(struct rad_result *result) {
  free(result->picture.point);
  free(result->picture.connectivity);
  free(result->picture.offset);
  free(result->picture.type);
  free(result->picture.triangle);
  free(result->picture.radiosity);
  free(result->picture.irradiance);
  free(result->picture.indicator);
  free(result->picture.bound);
  free(result->point);
  free(result->point_triangle);
  free(result->value);
  free(result->probe_position);
  free(result->probe_normal);
  free(result->probe_radiosity);
  free(result->probe_irradiance);
  free(result->probe_error_irradiance);
  free(result->probe_flux);
  free(result->probe_temperature);
  rad_view_factors_free(&result->view_factors);
  *result = (struct rad_result){0};
}

/* Means and their errors, of triangles or surfaces; NULL: not computed. */
static void write_means(struct rad_hdf *h, hid_t group, hsize_t n, hsize_t n_band,
                        const struct rad_means *m) {
  const struct rad_hdf_array column[] = {
      {"mean_radiosity",
       "W/m2",
       "mean radiosity u",
       RAD_HDF_REAL,
       2,
       {n, n_band},
       m ? m->radiosity : NULL},
      {"mean_irradiance",
       "W/m2",
       "mean irradiance h",
       RAD_HDF_REAL,
       2,
       {n, n_band},
       m ? m->irradiance : NULL},
      {"error_radiosity",
       "W/m2",
       "bound of the error of mean_radiosity; nan: not estimated",
       RAD_HDF_REAL,
       2,
       {n, n_band},
       m ? m->error_radiosity : NULL},
      {"error_irradiance",
       "W/m2",
       "bound of the error of mean_irradiance; nan: not estimated",
       RAD_HDF_REAL,
       2,
       {n, n_band},
       m ? m->error_irradiance : NULL},
  };
  for (size_t k = 0; k < sizeof column / sizeof *column; k++)
    rad_hdf_array(h, group, &column[k]);
}

static void write_surfaces(struct rad_hdf *h, hid_t root, const struct rad_result *r,
                           const struct rad_thermal *thermal) {
  const struct rad_scene *const scene = r->scene;
  const hsize_t n = (hsize_t)scene->n_surface, n_band = (hsize_t)scene->n_band;
  double *const area = rad_calloc(n, sizeof *area);
  struct rad_means mean = {0};
  struct rad_error e;
  if (area && (!r->means || !rad_means_of_surfaces(scene, r->means, &mean, &e))) {
    for (int j = 0; j < scene->n_triangle; j++)
      area[scene->triangle[j].surface] += scene->triangle[j].area;
    const struct rad_hdf_array column = {
        "area", "m2", "radiating area; `side: both` counts twice", RAD_HDF_REAL, 1, {n}, area};
    const hid_t group = rad_hdf_group(h, root, "surfaces");
    rad_hdf_texts(h, group, "name", n, (const char *const *)scene->surface_name, "surface name");
    rad_hdf_array(h, group, &column);
    write_means(h, group, n, n_band, r->means ? &mean : NULL);
    rad_thermal_write(h, group, &thermal->surface);
    rad_hdf_group_close(h, group);
  } else {
    rad_hdf_fail(h, "out of memory for %d surfaces", scene->n_surface);
  }
  rad_means_free(&mean);
  free(area);
}

/* Columns of /triangles that the scene keeps in another form. */
struct geometry {
  double *vertices;   /* owned [n, 3, 3] */
  double *normal;     /* owned [n, 3] */
  double *emission;   /* owned [n, n_band] means */
  double *emissivity; /* owned [n], of thermal scenes */
  double *area;       /* owned [n] */
  int *surface;       /* owned [n] */
};

static void geometry_free(struct geometry *g) {
  free(g->vertices);
  free(g->normal);
  free(g->emission);
  free(g->emissivity);
  free(g->area);
  free(g->surface);
}

static int geometry_make(const struct rad_scene *scene, struct geometry *g) {
  const size_t n = (size_t)scene->n_triangle, n_band = (size_t)scene->n_band;
  *g = (struct geometry){.vertices = rad_alloc(9 * n, sizeof(double)),
                         .normal = rad_alloc(3 * n, sizeof(double)),
                         .emission = rad_alloc(n * n_band, sizeof(double)),
                         .emissivity = rad_alloc(n, sizeof(double)),
                         .area = rad_alloc(n, sizeof(double)),
                         .surface = rad_alloc(n, sizeof(int))};
  if (!g->vertices || !g->normal || !g->emission || !g->emissivity || !g->area || !g->surface)
    return 0;
  for (size_t j = 0; j < n; j++) {
    const struct rad_triangle *const t = &scene->triangle[j];
    for (size_t k = 0; k < 9; k++)
      g->vertices[9 * j + k] = t->v[k / 3][k % 3];
    for (size_t k = 0; k < 3; k++)
      g->normal[3 * j + k] = t->normal[k];
    for (size_t k = 0; k < n_band; k++) {
      const double *const E = scene->emission + 3 * j * n_band + k;
      g->emission[j * n_band + k] = E[0] + (E[n_band] - E[0] + E[2 * n_band] - E[0]) / 3;
    }
    g->surface[j] = t->surface;
    g->area[j] = t->area;
    g->emissivity[j] =
        scene->heat && scene->heat[j].kind != RAD_HEAT_NONE ? scene->heat[j].emissivity : NAN;
  }
  return 1;
}

static void write_triangles(struct rad_hdf *h, hid_t root, const struct rad_result *r,
                            const struct rad_thermal *thermal) {
  const struct rad_scene *const scene = r->scene;
  const hsize_t n = (hsize_t)scene->n_triangle, n_band = (hsize_t)scene->n_band;
  struct geometry g;
  if (!geometry_make(scene, &g)) {
    rad_hdf_fail(h, "out of memory for %d triangles", scene->n_triangle);
    geometry_free(&g);
    return;
  }
  const struct rad_hdf_array column[] = {
      {"vertices", "m", "vertices", RAD_HDF_REAL, 3, {n, 3, 3}, g.vertices},
      {"normal", "1", "unit normal of the radiating side", RAD_HDF_REAL, 2, {n, 3}, g.normal},
      {"surface", "1", "surface, as a row of /polyrad/surfaces", RAD_HDF_INT32, 1, {n}, g.surface},
      {"rho", "1", "reflectivity", RAD_HDF_REAL, 2, {n, n_band}, scene->rho},
      {"emission", "W/m2", "mean emitted radiosity E", RAD_HDF_REAL, 2, {n, n_band}, g.emission},
      {"area", "m2", "area", RAD_HDF_REAL, 1, {n}, g.area},
  };
  const hid_t group = rad_hdf_group(h, root, "triangles");
  for (size_t k = 0; k < sizeof column / sizeof *column; k++)
    rad_hdf_array(h, group, &column[k]);
  write_means(h, group, n, n_band, r->means);
  const struct rad_hdf_array exponent[] = {{"edge_exponent",
                                            "1",
                                            "beta of edges v0v1, v1v2, v2v0; inf: not singular",
                                            RAD_HDF_REAL,
                                            2,
                                            {n, 3},
                                            r->edge_exponent},
                                           {"vertex_exponent",
                                            "1",
                                            "alpha of vertices v0, v1, v2; inf: not singular",
                                            RAD_HDF_REAL,
                                            2,
                                            {n, 3},
                                            r->vertex_exponent}};
  for (size_t k = 0; k < 2 && r->edge_exponent && r->vertex_exponent; k++)
    rad_hdf_array(h, group, &exponent[k]);
  const struct rad_hdf_array emissivity = {
      "emissivity", "1", "emissivity; NaN where rho was given", RAD_HDF_REAL, 1, {n}, g.emissivity};
  if (scene->heat)
    rad_hdf_array(h, group, &emissivity);
  rad_thermal_write(h, group, &thermal->triangle);
  rad_hdf_group_close(h, group);
  geometry_free(&g);
}

static void write_solution(struct rad_hdf *h, hid_t root, const struct rad_result *r) {
  const hsize_t n = (hsize_t)r->n_point, n_band = (hsize_t)r->scene->n_band;
  const struct rad_hdf_array column[] = {
      {"point", "m", "collocation points", RAD_HDF_REAL, 2, {n, 3}, r->point},
      {"triangle",
       "1",
       "triangle of the point, as a row of /polyrad/triangles",
       RAD_HDF_INT32,
       1,
       {n},
       r->point_triangle},
      {"value",
       "W/m2",
       "radiosity u_h at the collocation points",
       RAD_HDF_REAL,
       2,
       {n, n_band},
       r->value},
  };
  const hid_t group = rad_hdf_group(h, root, "solution");
  for (size_t k = 0; k < sizeof column / sizeof *column; k++)
    rad_hdf_array(h, group, &column[k]);
  rad_hdf_group_close(h, group);
}

static void write_probes(struct rad_hdf *h, hid_t root, const struct rad_result *r) {
  const hsize_t n = (hsize_t)r->deck->n_probe, n_band = (hsize_t)r->scene->n_band;
  const char **const name = rad_alloc(n, sizeof *name);
  if (!name) {
    rad_hdf_fail(h, "out of memory for %d probes", r->deck->n_probe);
    return;
  }
  for (hsize_t i = 0; i < n; i++)
    name[i] = r->deck->probe[i].name;
  const struct rad_hdf_array column[] = {
      {"position", "m", "position", RAD_HDF_REAL, 2, {n, 3}, r->probe_position},
      {"normal", "1", "unit normal", RAD_HDF_REAL, 2, {n, 3}, r->probe_normal},
      {"radiosity",
       "W/m2",
       "radiosity u* at the probe",
       RAD_HDF_REAL,
       2,
       {n, n_band},
       r->probe_radiosity},
      {"irradiance",
       "W/m2",
       "irradiance at the probe",
       RAD_HDF_REAL,
       2,
       {n, n_band},
       r->probe_irradiance},
      {"error_irradiance",
       "W/m2",
       "at most so far from the irradiance of u; NaN: not known",
       RAD_HDF_REAL,
       2,
       {n, n_band},
       r->probe_error_irradiance},
      {"net_flux",
       "W/m2",
       "net heat flux u* - h at the probe",
       RAD_HDF_REAL,
       1,
       {n},
       r->probe_flux},
      {"temperature",
       "K",
       "temperature at the probe; NaN: rho was given, or flux allows none",
       RAD_HDF_REAL,
       1,
       {n},
       r->probe_temperature},
  };
  const hid_t group = rad_hdf_group(h, root, "probes");
  const size_t n_column = sizeof column / sizeof *column - (r->scene->heat ? 0 : 2);
  rad_hdf_texts(h, group, "name", n, name, "probe name");
  for (size_t k = 0; k < n_column; k++)
    rad_hdf_array(h, group, &column[k]);
  rad_hdf_group_close(h, group);
  free(name);
}

static void write_view_factors(struct rad_hdf *h, hid_t root, const struct rad_view_factors *f) {
  const hsize_t n = (hsize_t)f->n;
  if (!f->matrix)
    return;
  const struct rad_hdf_array column[] = {
      {"matrix",
       "1",
       "view factors F_st, area-weighted means over surface s; rows s and columns t as in "
       "/polyrad/surfaces",
       RAD_HDF_REAL,
       2,
       {n, n},
       f->matrix},
      {"row_sum", "1", "sum of F_st over t; 1 in a closed scene", RAD_HDF_REAL, 1, {n}, f->row_sum},
      {"error", "1", "estimated error of F_st", RAD_HDF_REAL, 2, {n, n}, f->error},
      {"reciprocity",
       "1",
       "|A_s F_st - A_t F_ts| over the larger of A_s, A_t",
       RAD_HDF_REAL,
       2,
       {n, n},
       f->reciprocity},
  };
  const hid_t group = rad_hdf_group(h, root, "view_factors");
  for (size_t k = 0; k < sizeof column / sizeof *column; k++)
    rad_hdf_array(h, group, &column[k]);
  rad_hdf_set_integer(h, group, "converged", f->converged != 0);
  rad_hdf_set_text(h, group, "reason", f->reason);
  rad_hdf_set_real(h, group, "tolerance", f->tolerance);
  rad_hdf_set_real(h, group, "worst_error", f->worst_error);
  rad_hdf_set_real(h, group, "worst_reciprocity", f->worst_reciprocity);
  rad_hdf_set_integer(h, group, "points", f->points);
  rad_hdf_set_real(h, group, "seconds_view_factors", f->seconds);
  rad_hdf_group_close(h, group);
}

/* Where the light goes, one number a band. */
static void write_balance(struct rad_hdf *h, hid_t root, const struct rad_balance *b) {
  if (!b)
    return;
  const hsize_t n = (hsize_t)b->n_band;
  const struct rad_hdf_array column[] = {
      {"emitted", "W", "int E dS", RAD_HDF_REAL, 1, {n}, b->emitted},
      {"absorbed", "W", "int (1 - rho) h dS", RAD_HDF_REAL, 1, {n}, b->absorbed},
      {"rest",
       "W",
       "emitted less absorbed: escaped, and lost on backs",
       RAD_HDF_REAL,
       1,
       {n},
       b->rest},
      {"error", "W", "bound of the errors of absorbed and rest", RAD_HDF_REAL, 1, {n}, b->error},
      {"lost_on_backs",
       "W",
       "light that meets backs of faces; nan: not told from what escapes",
       RAD_HDF_REAL,
       1,
       {n},
       b->on_backs},
      {"error_on_backs", "W", "of its integration", RAD_HDF_REAL, 1, {n}, b->backs_error},
      {"imbalance",
       "W",
       "int of E + rho h less int of the u that h is made from",
       RAD_HDF_REAL,
       1,
       {n},
       b->imbalance}};
  const hid_t group = rad_hdf_group(h, root, "balance");
  for (size_t k = 0; k < sizeof column / sizeof *column; k++)
    rad_hdf_array(h, group, &column[k]);
  rad_hdf_set_integer(h, group, "enclosed", b->is_enclosed);
  rad_hdf_group_close(h, group);
}

static void set_integers(struct rad_hdf *h, hid_t group, const struct rad_diagnostics *d) {
  const struct {
    const char *name;
    int64_t value;
  } list[] = {
      {"unknowns", d->unknowns},
      {"elements", d->elements},
      {"iterations", d->iterations},
      {"converged", d->converged != 0},
      {"kernel_values", d->kernel_values},
      {"pairs_near", d->pairs_near},
      {"pairs_far", d->pairs_far},
      {"pairs_skipped", d->pairs_skipped},
      {"means_converged", d->means_converged},
  };
  for (size_t k = 0; k < sizeof list / sizeof *list; k++)
    rad_hdf_set_integer(h, group, list[k].name, list[k].value);
}

static void set_reals(struct rad_hdf *h, hid_t group, const struct rad_diagnostics *d) {
  const struct {
    const char *name;
    double value;
  } list[] = {
      {"kappa", d->kappa},
      {"error_indicator", d->error_indicator},
      {"error_bound", d->error_bound},
      {"error_bound_limit", d->error_bound_limit},
      {"means_error", d->means_error},
      {"compression_error", d->compression_error},
      {"residual", d->residual},
      {"condition_estimate", d->condition_estimate},
      {"matrix_bytes", d->matrix_bytes},
      {"peak_memory_bytes", d->peak_memory_bytes},
      {"seconds_scene", d->seconds_scene},
      {"seconds_mesh", d->seconds_mesh},
      {"seconds_assemble", d->seconds_assemble},
      {"seconds_factor", d->seconds_factor},
      {"seconds_solve", d->seconds_solve},
      {"seconds_estimate", d->seconds_estimate},
      {"seconds_levels", d->seconds_levels},
      {"seconds_output", d->seconds_output},
      {"seconds_total", d->seconds_total},
  };
  for (size_t k = 0; k < sizeof list / sizeof *list; k++)
    rad_hdf_set_real(h, group, list[k].name, list[k].value);
}

/* Only if the deck says anything of it. */
static void write_camera(struct rad_hdf *h, hid_t root, const struct rad_deck_camera *c) {
  const double all[] = {c->from[0], c->from[1], c->from[2], c->to[0], c->to[1],
                        c->to[2],   c->up[0],   c->up[1],   c->up[2], c->angle};
  enum { N = sizeof all / sizeof *all };
  static const char *const what =
      "from, to, up [m], angle [degree] for tools/render; NaN: not said";
  if (c->given)
    rad_hdf_array(h, root, &(struct rad_hdf_array){"camera", "1", what, RAD_HDF_REAL, 1, {N}, all});
}

enum rad_code rad_result_write(const char *path, struct rad_result *result, double started,
                               struct rad_error *e) {
  const double begin = rad_seconds();
  struct rad_thermal thermal;
  const enum rad_code code = rad_thermal_make(result->scene, result->means, &thermal, e);
  if (code) {
    rad_thermal_free(&thermal);
    return code;
  }
  struct rad_hdf h;
  rad_hdf_begin(&h);
  rad_vtkhdf_write(&h, result);
  const hid_t root = rad_stamp(&h, result->deck, result->command, result->threads, started);
  rad_hdf_set_text(&h, root, "matrix", result->matrix);
  rad_hdf_set_text(&h, root, "solver", result->solver);
  write_surfaces(&h, root, result, &thermal);
  write_triangles(&h, root, result, &thermal);
  write_balance(&h, root, result->balance);
  rad_thermal_free(&thermal);
  write_solution(&h, root, result);
  write_probes(&h, root, result);
  write_view_factors(&h, root, &result->view_factors);
  write_camera(&h, root, &result->deck->output.camera);
  if (result->task)
    rad_task_put(&h, root, result->task);

  struct rad_diagnostics *const d = &result->diagnostics;
  d->seconds_output = rad_seconds() - begin;
  d->seconds_total =
      fmax(rad_stamp_now() - started, d->seconds_output); /* clocks may be set back */
  const hid_t group = rad_hdf_group(&h, root, "diagnostics");
  set_integers(&h, group, d);
  set_reals(&h, group, d);
  rad_hdf_group_close(&h, group);
  rad_hdf_group_close(&h, root);
  return rad_hdf_end(&h, path, e);
}
