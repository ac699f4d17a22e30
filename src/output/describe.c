/* What a result file holds, in words. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "output/hdf.h"
#include "output/report.h"
#include "output/result.h"
#include "output/seal.h"

enum { MAX_SHOWN = 50, MAX_DEPTH = 8 }; /* rows of a list; nesting of groups */

static void say_text(FILE *out, hid_t at, const char *label, const char *attribute) {
  char *text = rad_hdf_get_text(at, attribute);
  if (text && *text)
    fprintf(out, "  %-22s %s\n", label, text);
  free(text);
}

static void say_number(FILE *out, hid_t at, const char *label, const char *attribute,
                       const char *unit) {
  const double value = rad_hdf_get_number(at, attribute);
  if (isnan(value))
    fprintf(out, "  %-22s not computed\n", label);
  else
    fprintf(out, "  %-22s %.10g%s%s\n", label, value, *unit ? " " : "", unit);
}

static void say_origin(FILE *out, hid_t root) {
  char *version = rad_hdf_get_text(root, "version");
  char *revision = rad_hdf_get_text(root, "git_revision");
  say_text(out, root, "title", "title");
  fprintf(out, "  %-22s polyrad %s, revision %s\n", "program", version ? version : "?",
          revision ? revision : "?");
  say_text(out, root, "compiler", "compiler");
  say_text(out, root, "flags", "flags");
  say_text(out, root, "BLAS", "blas");
  say_text(out, root, "HDF5", "hdf5");
  say_text(out, root, "started", "started");
  say_number(out, root, "threads", "threads", "");
  say_text(out, root, "command", "command");
  say_text(out, root, "bands", "bands");
  say_text(out, root, "matrix", "matrix");
  say_text(out, root, "solver", "solver");
  free(revision);
  free(version);
}

/* A named list with numbers, such as /surfaces: one row a name, one column a quantity and band. */
static void say_list(FILE *out, hid_t root, const char *name, int n_column,
                     const char *const column[]) {
  if (!rad_hdf_has(root, name))
    return;
  const hid_t group = H5Gopen2(root, name, H5P_DEFAULT);
  if (group < 0)
    return;
  struct rad_report report = {0};
  rad_report_names(&report, group, "name");
  if (report.n_row > 0) {
    fprintf(out, "\n%s (%d):\n", name, report.n_row);
    for (int k = 0; k < n_column; k++)
      rad_report_numbers(&report, group, column[k]);
    rad_report_print(&report, MAX_SHOWN, out);
  }
  rad_report_free(&report);
  H5Gclose(group);
}

static void say_diagnostics(FILE *out, hid_t root) {
  static const char *const phase[] = {"scene", "mesh",     "levels", "assemble", "factor",
                                      "solve", "estimate", "output", "total"};
  if (!rad_hdf_has(root, "diagnostics"))
    return;
  const hid_t at = H5Gopen2(root, "diagnostics", H5P_DEFAULT);
  if (at < 0)
    return;
  fprintf(out, "\nsolution:\n");
  fprintf(out, "  %-22s %s\n", "converged", rad_hdf_get_number(at, "converged") > 0 ? "yes" : "NO");
  say_number(out, at, "unknowns", "unknowns", "");
  say_number(out, at, "elements", "elements", "");
  say_number(out, at, "iterations", "iterations", "");
  say_number(out, at, "kappa", "kappa", "");
  say_number(out, at, "residual", "residual", "W/m2");
  say_number(out, at, "error indicator", "error_indicator", "W/m2");
  say_number(out, at, "error bound", "error_bound", "W/m2");
  say_number(out, at, "compression error", "compression_error", "");
  say_number(out, at, "condition estimate", "condition_estimate", "");
  say_number(out, at, "matrix", "matrix_bytes", "bytes");
  say_number(out, at, "peak memory", "peak_memory_bytes", "bytes");
  fprintf(out, "\ntimes:\n");
  for (size_t k = 0; k < sizeof phase / sizeof *phase; k++) {
    char name[32];
    snprintf(name, sizeof name, "seconds_%s", phase[k]);
    if (H5Aexists(at, name) > 0) /* files of older versions */
      fprintf(out, "  %-10s %10.3f s\n", phase[k], rad_hdf_get_number(at, name));
  }
  H5Gclose(at);
}

/* Row sums and, if they fit on a screen, the view factors. */
static void say_matrix(FILE *out, hid_t root, hid_t at) {
  enum { READABLE = 10 };
  const hid_t surfaces = H5Gopen2(root, "surfaces", H5P_DEFAULT);
  if (surfaces < 0)
    return;
  struct rad_report report = {0};
  rad_report_names(&report, surfaces, "name");
  if (report.n_row <= READABLE)
    rad_report_numbers(&report, at, "matrix");
  rad_report_numbers(&report, at, "row_sum");
  rad_report_print(&report, MAX_SHOWN, out);
  rad_report_free(&report);
  H5Gclose(surfaces);
}

static void say_view_factors(FILE *out, hid_t root) {
  if (!rad_hdf_has(root, "view_factors"))
    return;
  const hid_t at = H5Gopen2(root, "view_factors", H5P_DEFAULT);
  if (at < 0)
    return;
  fprintf(out, "\nview factors:\n");
  fprintf(out, "  %-22s %s\n", "converged", rad_hdf_get_number(at, "converged") > 0 ? "yes" : "NO");
  say_text(out, at, "reason", "reason");
  say_number(out, at, "tolerance", "tolerance", "");
  say_number(out, at, "error estimate", "worst_error", "");
  say_number(out, at, "reciprocity error", "worst_reciprocity", "");
  say_number(out, at, "time", "seconds_view_factors", "s");
  say_matrix(out, root, at);
  H5Gclose(at);
}

/* task 2 of 5: method.elements = 4 */
static void say_task(FILE *out, hid_t root) {
  const hid_t at = rad_hdf_has(root, "task") ? H5Gopen2(root, "task", H5P_DEFAULT) : -1;
  if (at < 0)
    return;
  int n_key = 0, n_set = 0;
  char **key = rad_hdf_read_texts(at, "key", &n_key), **set = rad_hdf_read_texts(at, "set", &n_set);
  fprintf(out, "\ntask %.0f of %.0f of a study%s:\n", rad_hdf_get_number(at, "number"),
          rad_hdf_get_number(at, "tasks"), rad_hdf_has(at, "value") ? "" : ", without a solution");
  for (int k = 0; key && set && k < n_key && k < n_set; k++)
    fprintf(out, "  %-22s %s\n", key[k], set[k]);
  rad_hdf_texts_free(key, n_key);
  rad_hdf_texts_free(set, n_set);
  H5Gclose(at);
}

static void say_study(FILE *out, hid_t root) {
  if (!rad_hdf_has(root, "study"))
    return;
  const hid_t group = H5Gopen2(root, "study", H5P_DEFAULT);
  if (group < 0)
    return;
  struct rad_report report = {0};
  rad_report_group(&report, group);
  fprintf(out, "\nstudy (%d runs):\n", report.n_row);
  rad_report_print(&report, report.n_row, out);
  rad_report_free(&report);
  H5Gclose(group);
}

static void say_dataset(FILE *out, hid_t dataset, const char *path) {
  const hid_t space = H5Dget_space(dataset);
  hsize_t shape[H5S_MAX_RANK] = {0};
  const int rank = H5Sget_simple_extent_dims(space, shape, NULL);
  char text[80] = "", *unit = rad_hdf_get_text(dataset, "unit");
  for (int k = 0; k < rank && k < RAD_HDF_MAX_RANK; k++) {
    const size_t used = strlen(text);
    snprintf(text + used, sizeof text - used, "%s%llu", k ? ", " : "",
             (unsigned long long)shape[k]);
  }
  char *description = rad_hdf_get_text(dataset, "description");
  fprintf(out, "  %-35s [%s] %s: %s\n", path, text, unit ? unit : "",
          description ? description : "");
  free(description);
  free(unit);
  H5Sclose(space);
}

/* All datasets below an open group; path is what leads to it. */
static void say_datasets(FILE *out, hid_t group, const char *path, int depth) {
  H5G_info_t is;
  if (depth > MAX_DEPTH || H5Gget_info(group, &is) < 0)
    return;
  for (hsize_t k = 0; k < is.nlinks; k++) {
    char name[256], below[1024];
    if (H5Lget_name_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, k, name, sizeof name,
                           H5P_DEFAULT) < 0)
      continue;
    const hid_t member = rad_hdf_has(group, name) ? H5Oopen(group, name, H5P_DEFAULT) : -1;
    if (member < 0)
      continue;
    snprintf(below, sizeof below, "%s/%s", path, name);
    if (H5Iget_type(member) == H5I_DATASET)
      say_dataset(out, member, below);
    else if (H5Iget_type(member) == H5I_GROUP)
      say_datasets(out, member, below, depth + 1);
    H5Oclose(member);
  }
}

static void say_members(FILE *out, hid_t file) {
  static const char *const top[] = {"VTKHDF", "polyrad"};
  fprintf(out, "\ndatasets:\n");
  for (int k = 0; k < 2; k++) {
    char path[16];
    const hid_t group = rad_hdf_has(file, top[k]) ? H5Gopen2(file, top[k], H5P_DEFAULT) : -1;
    if (group < 0)
      continue;
    snprintf(path, sizeof path, "/%s", top[k]);
    say_datasets(out, group, path, 0);
    H5Gclose(group);
  }
}

static void say_all(FILE *out, const char *path, hid_t file, hid_t root) {
  static const char *const surface[] = {
      "area",          "mean_radiosity", "mean_irradiance", "error_radiosity", "error_irradiance",
      "mean_net_flux", "net_power",      "error_net_power", "temperature"};
  static const char *const probe[] = {"position",         "radiosity", "irradiance",
                                      "error_irradiance", "net_flux",  "temperature"};
  char *kind = rad_hdf_get_text(root, "kind");
  fprintf(out, "%s: polyrad %s\n", path,
          kind                         ? kind
          : rad_hdf_has(root, "study") ? "study"
          : rad_hdf_has(root, "task")  ? "result, task of a study"
                                       : "result");
  free(kind);
  say_origin(out, root);
  say_text(out, root, "overrides", "set");
  say_list(out, root, "surfaces", 9, surface);
  say_list(out, root, "probes", 6, probe);
  say_view_factors(out, root);
  say_diagnostics(out, root);
  say_task(out, root);
  say_study(out, root);
  say_members(out, file);
}

static enum rad_code describe(const char *path, hid_t file, hid_t root, char **text,
                              struct rad_error *e) {
  char *kind = rad_hdf_get_text(root, "kind");
  const enum rad_code broken = kind ? rad_seal_check(path, kind, e) : RAD_OK;
  free(kind);
  if (broken)
    return broken;
  size_t size = 0;
  FILE *out = open_memstream(text, &size);
  if (out)
    say_all(out, path, file, root);
  if (out && fclose(out) == 0)
    return RAD_OK;
  free(*text);
  *text = NULL;
  return rad_fail_memory(e, "the description of a file", (double)size);
}

enum rad_code rad_result_describe(const char *path, char **text, struct rad_error *e) {
  struct rad_hdf_silence silence;
  hid_t file, root;
  *text = NULL;
  rad_hdf_silence_begin(&silence);
  enum rad_code code = rad_hdf_open(path, &file, &root, e);
  if (!code) {
    code = describe(path, file, root, text, e);
    rad_hdf_close(file, root);
  }
  rad_hdf_silence_end(&silence);
  return code;
}
