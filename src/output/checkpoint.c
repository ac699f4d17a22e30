#include "output/checkpoint.h"

#include "output/operator_file.h"
#include "output/stage_file.h"

static struct rad_hdf_array array_of(const char *name, const char *unit, const char *description,
                                     enum rad_hdf_type type, hsize_t n, const void *data) {
  return (struct rad_hdf_array){name, unit, description, type, 1, {n}, data};
}

enum { N_ARRAY = 3 };

/* The arrays of an iterate of n unknowns. */
static void list_iterate(const struct rad_iterate *x, size_t n, struct rad_hdf_array a[N_ARRAY]) {
  hsize_t m = (hsize_t)x->n_system;
  a[0] = array_of("u", "W/m2", "iterates of the systems, one after another", RAD_HDF_REAL, m * n,
                  x->u);
  a[1] = array_of("steps", "1", "steps that led there", RAD_HDF_INT64, m, x->steps);
  a[2] =
      array_of("before", "W/m2", "residual where the last cycle began", RAD_HDF_REAL, m, x->before);
}

static void write_iterate(struct rad_hdf *h, hid_t root, const struct rad_iterate *x, size_t n) {
  struct rad_hdf_array a[N_ARRAY];
  list_iterate(x, n, a);
  const hid_t group = rad_hdf_group(h, root, "iterate");
  rad_hdf_set_integer(h, group, "systems", x->n_system);
  for (int i = 0; i < N_ARRAY; i++)
    rad_hdf_array(h, group, &a[i]);
  rad_hdf_group_close(h, group);
}

static bool read_iterate(hid_t root, struct rad_iterate *x, int n, struct rad_error *e) {
  const hid_t group = H5Gopen2(root, "iterate", H5P_DEFAULT);
  const double systems = group < 0 ? 0 : rad_hdf_get_number(group, "systems");
  bool done =
      systems >= 1 && systems <= 2 * RAD_MAX_BAND && !rad_iterate_init((int)systems, n, x, e);
  if (done) {
    struct rad_hdf_array a[N_ARRAY];
    list_iterate(x, (size_t)n, a);
    for (int i = 0; i < N_ARRAY && done; i++)
      done = rad_hdf_read_into(group, a[i].name, a[i].type, a[i].shape[0], (void *)a[i].data);
  }
  if (group >= 0)
    H5Gclose(group);
  return done;
}

enum rad_code rad_checkpoint_write(const char *path, const struct rad_origin *origin,
                                   const struct rad_checkpoint *c, struct rad_error *e) {
  struct rad_hdf h;
  rad_hdf_begin_large(&h);
  const hid_t root = rad_origin_write(&h, "checkpoint", origin);
  if (c->dense)
    rad_operator_write_dense(&h, root, c->dense);
  if (c->h2)
    rad_operator_write_h2(&h, root, c->h2);
  struct rad_stage_arrays arrays = {0};
  if (c->stage)
    rad_stage_write(&h, root, c->stage, &arrays);
  if (c->iterate && c->iterate->n_system)
    write_iterate(&h, root, c->iterate, (size_t)origin->mesh->n_point);
  rad_hdf_group_close(&h, root);
  enum rad_code code = rad_hdf_end_large(&h, path, "checkpoint", e);
  rad_stage_arrays_free(&arrays);
  return code;
}

/* A checkpoint being read, without HDF5's own messages. */
struct reading {
  hid_t file, root;
  struct rad_hdf_silence silence;
};

static enum rad_code begin(const char *path, const struct rad_origin *origin, struct reading *r,
                           struct rad_error *e) {
  enum rad_code code = rad_origin_open(path, "checkpoint", origin, &r->file, &r->root, e);
  if (!code)
    rad_hdf_silence_begin(&r->silence);
  return code;
}

static enum rad_code end(const char *path, struct reading *r, bool done, struct rad_error *e) {
  H5Gclose(r->root);
  H5Fclose(r->file);
  rad_hdf_silence_end(&r->silence);
  if (done)
    return RAD_OK;
  return rad_fail(e, RAD_ESYSTEM,
                  "%.400s does not fit into this run, or into memory; begin without --restart",
                  path);
}

enum rad_code rad_checkpoint_look(const char *path, const struct rad_origin *origin,
                                  enum rad_matrix *form, struct rad_error *e) {
  struct reading r;
  enum rad_code code = begin(path, origin, &r, e);
  if (code)
    return code;
  *form = rad_operator_form(r.root);
  return end(path, &r, true, e);
}

enum rad_code rad_checkpoint_read(const char *path, const struct rad_origin *origin,
                                  const struct rad_checkpoint *c, struct rad_error *e) {
  struct reading r;
  bool done = true;
  enum rad_code code = begin(path, origin, &r, e);
  if (code)
    return code;
  if (c->dense && rad_hdf_has(r.root, "operator"))
    done = rad_operator_read_dense(r.root, c->dense);
  if (c->h2 && rad_hdf_has(r.root, "operator"))
    done = rad_operator_read_h2(r.root, c->h2);
  if (done && c->iterate && rad_hdf_has(r.root, "iterate"))
    done = read_iterate(r.root, c->iterate, origin->mesh->n_point, e);
  return end(path, &r, done, e);
}

enum rad_code rad_checkpoint_read_stage(const char *path, const struct rad_origin *origin,
                                        struct rad_stage *stage, struct rad_error *e) {
  struct reading r;
  *stage = (struct rad_stage){0};
  enum rad_code code = begin(path, origin, &r, e);
  if (code)
    return code;
  return end(path, &r, !rad_hdf_has(r.root, "stage") || rad_stage_read(r.root, stage), e);
}
