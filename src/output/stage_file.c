#include "output/stage_file.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "output/operator_file.h"

enum { IN_LEAF = 3, IN_PLACE = 4, MOST_LEVELS = 1000 };

/* More leaves than this are not read: their unknowns would not fit into any matrix. */
#define MOST_LEAVES 1e8 /* times IN_PLACE fits an int */

static void list_arrays(const struct rad_stage_arrays *x, hsize_t n, struct rad_hdf_array a[2]) {
  a[0] = (struct rad_hdf_array){
      "leaf", "1", "patch, points in phi, points in r", RAD_HDF_INT32, 2, {n, IN_LEAF}, x->leaf};
  a[1] = (struct rad_hdf_array){"place",       "1",     "range of phi, range of r", RAD_HDF_REAL, 2,
                                {n, IN_PLACE}, x->place};
}

static bool allocate(size_t n, struct rad_stage_arrays *x) {
  x->leaf = rad_alloc(IN_LEAF * n, sizeof *x->leaf);
  x->place = rad_alloc(IN_PLACE * n, sizeof *x->place);
  return x->leaf && x->place;
}

void rad_stage_arrays_free(struct rad_stage_arrays *x) {
  free(x->leaf);
  free(x->place);
  *x = (struct rad_stage_arrays){0};
}

static void write_numbers(struct rad_hdf *h, hid_t group, const struct rad_stage *s) {
  rad_hdf_set_integer(h, group, "levels", s->levels);
  rad_hdf_set_integer(h, group, "leaves", s->n_leaf);
  rad_hdf_set_integer(h, group, "stuck", s->stuck);
  rad_hdf_set_integer(h, group, "weights", s->least_weight ? s->n_weight : 0);
  rad_hdf_set_real(h, group, "least_bound", s->least);
  rad_hdf_set_real(h, group, "target", s->target);
  rad_hdf_set_real(h, group, "quadrature_tolerance", s->quadrature);
}

void rad_stage_write(struct rad_hdf *h, hid_t root, const struct rad_stage *s,
                     struct rad_stage_arrays *x) {
  struct rad_hdf_array a[2];
  if (!allocate((size_t)s->n_leaf, x)) {
    rad_hdf_fail(h, "out of memory");
    return;
  }
  for (int i = 0; i < s->n_leaf; i++) {
    const struct rad_leaf *f = &s->leaf[i];
    x->leaf[IN_LEAF * i] = f->patch;
    x->leaf[IN_LEAF * i + 1] = f->k_phi;
    x->leaf[IN_LEAF * i + 2] = f->k_r;
    for (int d = 0; d < 2; d++) {
      x->place[IN_PLACE * i + d] = f->phi[d];
      x->place[IN_PLACE * i + 2 + d] = f->r[d];
    }
  }
  list_arrays(x, (hsize_t)s->n_leaf, a);
  const hid_t group = rad_hdf_group(h, root, "stage");
  write_numbers(h, group, s);
  rad_hdf_array(h, group, &a[0]);
  rad_hdf_array(h, group, &a[1]);
  const struct rad_hdf_array weight = {"least_weight", "1", "of K d, where means asked for more",
                                       RAD_HDF_REAL,   1,   {(hsize_t)s->n_weight},
                                       s->least_weight};
  if (s->least_weight)
    rad_hdf_array(h, group, &weight);
  rad_hdf_group_close(h, group);
}

/* A whole number of an attribute, from 0 to most. */
static bool read_whole(hid_t group, const char *name, double most, int64_t *value) {
  const double x = rad_hdf_get_number(group, name);
  const bool is_whole = x >= 0 && x <= most && x == floor(x);
  *value = is_whole ? (int64_t)x : 0;
  return is_whole;
}

static bool read_numbers(hid_t group, struct rad_stage *s) {
  int64_t levels, leaves, stuck, weights;
  if (!read_whole(group, "levels", MOST_LEVELS, &levels) ||
      !read_whole(group, "leaves", MOST_LEAVES, &leaves) ||
      !read_whole(group, "stuck", MOST_LEVELS, &stuck) ||
      !read_whole(group, "weights", MOST_LEAVES, &weights))
    return false;
  *s = (struct rad_stage){.levels = (int)levels,
                          .stuck = (int)stuck,
                          .n_leaf = (int)leaves,
                          .n_weight = (int)weights,
                          .least = rad_hdf_get_number(group, "least_bound"),
                          .target = rad_hdf_get_number(group, "target"),
                          .quadrature = rad_hdf_get_number(group, "quadrature_tolerance")};
  return s->least > 0 && s->target > 0 && s->quadrature > 0 && s->quadrature < 1;
}

/* True if a dataset holds so many numbers: one in a damaged file asks for no memory. */
static bool are_there(hid_t group, const char *name, int n) {
  const hid_t dataset = H5Dopen2(group, name, H5P_DEFAULT);
  if (dataset < 0)
    return false;
  const hid_t space = H5Dget_space(dataset);
  const bool same = H5Sget_simple_extent_npoints(space) == (hssize_t)n &&
                    H5Dget_storage_size(dataset) == sizeof(double) * (hsize_t)n;
  H5Sclose(space);
  H5Dclose(dataset);
  return same;
}

static bool read_leaves(hid_t group, struct rad_stage *s) {
  struct rad_stage_arrays x = {0};
  const size_t n = (size_t)s->n_leaf;
  s->leaf = rad_alloc(n, sizeof *s->leaf);
  bool done = s->leaf && allocate(n, &x);
  done = done && rad_hdf_read_into(group, "leaf", RAD_HDF_INT32, IN_LEAF * n, x.leaf) &&
         rad_hdf_read_into(group, "place", RAD_HDF_REAL, IN_PLACE * n, x.place);
  for (size_t i = 0; i < n && done; i++) {
    const int32_t *leaf = &x.leaf[IN_LEAF * i];
    const double *place = &x.place[IN_PLACE * i];
    s->leaf[i] = (struct rad_leaf){.patch = leaf[0],
                                   .k_phi = leaf[1],
                                   .k_r = leaf[2],
                                   .phi = {place[0], place[1]},
                                   .r = {place[2], place[3]},
                                   .origin = -1};
  }
  rad_stage_arrays_free(&x);
  return done;
}

static bool read_weights(hid_t group, struct rad_stage *s) {
  if (!s->n_weight)
    return true;
  if (!are_there(group, "least_weight", s->n_weight) ||
      !(s->least_weight = rad_alloc((size_t)s->n_weight, sizeof(double))) ||
      !rad_hdf_read_into(group, "least_weight", RAD_HDF_REAL, (size_t)s->n_weight, s->least_weight))
    return false;
  for (int i = 0; i < s->n_weight; i++)
    if (s->least_weight[i] != 0 && s->least_weight[i] != 1)
      return false;
  return true;
}

bool rad_stage_read(hid_t root, struct rad_stage *s) {
  const hid_t group = H5Gopen2(root, "stage", H5P_DEFAULT);
  if (group < 0)
    return false;
  const bool done = read_numbers(group, s) && s->n_leaf > 0 &&
                    are_there(group, "place", IN_PLACE * s->n_leaf) && read_leaves(group, s) &&
                    read_weights(group, s);
  H5Gclose(group);
  s->matrix = rad_operator_form(root);
  if (done && s->matrix != RAD_MATRIX_AUTO)
    return true;
  rad_stage_free(s);
  return false;
}
