#include "output/operator_file.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "system/interpolate.h"

/* --- what is in a file: the same lists for writing and reading --- */

enum { MOST_ARRAYS = 8 };

struct list {
  int n;
  struct rad_hdf_array array[MOST_ARRAYS];
};

static void add(struct list *l, const char *name, const char *description, enum rad_hdf_type type,
                size_t n, void *data) {
  l->array[l->n++] = (struct rad_hdf_array){name, "1", description, type, 1, {(hsize_t)n}, data};
}

static void list_columns(struct rad_dense *d, struct rad_part_range columns, struct list *l) {
  size_t n = (size_t)d->n;
  add(l, "matrix", "K, column by column", RAD_HDF_REAL, n * (size_t)(columns.end - columns.first),
      d->k + n * (size_t)columns.first);
}

static void list_dense(struct rad_dense *d, struct list *l) {
  add(l, "task_done", "parts of the assembly: 1 done", RAD_HDF_UINT8, (size_t)d->n_task, d->done);
  list_columns(d, (struct rad_part_range){0, d->n}, l);
}

/* The blocks of some target clusters, which follow one another. */
static void add_blocks(struct list *l, const char *name, const char *description,
                       const struct rad_block_list *blocks, struct rad_part_range clusters,
                       struct rad_h2_dense *d) {
  size_t at = d->at[blocks->first[clusters.first]], n = d->at[blocks->first[clusters.end]] - at;
  if (d->narrow)
    add(l, name, description, RAD_HDF_REAL32, n, d->narrow + at);
  else
    add(l, name, description, RAD_HDF_REAL, n, d->wide + at);
}

static void list_blocks(struct rad_h2 *h, struct rad_part_range clusters, struct list *l) {
  add_blocks(l, "near", "near blocks", &h->blocks.near, clusters, &h->near);
  add_blocks(l, "sector", "near blocks of sectors", &h->blocks.sector, clusters, &h->sector);
}

static void list_near(struct rad_h2 *h, struct list *l) {
  add(l, "near_done", "near blocks of each cluster: 1 done", RAD_HDF_UINT8,
      (size_t)h->tree.n_cluster, h->near_done);
  list_blocks(h, (struct rad_part_range){0, h->tree.n_cluster}, l);
}

static void list_ranks(struct rad_h2 *h, struct list *l) {
  size_t n = (size_t)h->tree.n_cluster;
  add(l, "row_rank", "ranks of row clusters", RAD_HDF_INT32, n, h->row.rank);
  add(l, "column_rank", "ranks of column clusters", RAD_HDF_INT32, n, h->column.rank);
}

static void list_far(struct rad_h2 *h, struct list *l) {
  add(l, "row", "bases of row clusters", RAD_HDF_REAL, h->row.n_data, h->row.data);
  add(l, "column", "bases of column clusters", RAD_HDF_REAL, h->column.n_data, h->column.data);
  add(l, "far", "far blocks", RAD_HDF_REAL, h->n_far, h->far);
}

static void list_basis(struct rad_basis *b, struct list *l) {
  size_t n = (size_t)b->tree->n_cluster;
  add(l, "state", "1 done, 2 done and its change not kept", RAD_HDF_UINT8, n, b->state);
  add(l, "rank", "rank of each cluster", RAD_HDF_INT32, n, b->rank);
}

static const char *const basis_name[2] = {"row_basis", "column_basis"};

/* --- both directions --- */

static void write_list(struct rad_hdf *h, hid_t group, const struct list *l) {
  for (int i = 0; i < l->n; i++)
    rad_hdf_array(h, group, &l->array[i]);
}

static bool read_list(hid_t group, const struct list *l) {
  bool done = true;
  for (int i = 0; i < l->n && done; i++) {
    const struct rad_hdf_array *a = &l->array[i];
    done = rad_hdf_read_into(group, a->name, a->type, a->shape[0], (void *)a->data);
  }
  return done;
}

static void write_counters(struct rad_hdf *h, hid_t group, const struct rad_counters *c) {
  rad_hdf_set_integer(h, group, "kernel_values", c->kernel_values);
  rad_hdf_set_integer(h, group, "pairs_near", c->near);
  rad_hdf_set_integer(h, group, "pairs_far", c->far);
}

static void add_counters(hid_t group, struct rad_counters *c) { /* exact up to 2^53 */
  c->kernel_values += (int64_t)rad_hdf_get_number(group, "kernel_values");
  c->near += (int64_t)rad_hdf_get_number(group, "pairs_near");
  c->far += (int64_t)rad_hdf_get_number(group, "pairs_far");
}

static hid_t begin(struct rad_hdf *h, hid_t root, const char *form, const struct rad_counters *c) {
  const hid_t group = rad_hdf_group(h, root, "operator");
  rad_hdf_set_text(h, group, "form", form);
  write_counters(h, group, c);
  return group;
}

/* A group that may be there, or negative. */
static hid_t open_group(hid_t at, const char *name) {
  return rad_hdf_has(at, name) ? H5Gopen2(at, name, H5P_DEFAULT) : H5I_INVALID_HID;
}

enum rad_matrix rad_operator_form(hid_t root) {
  const hid_t group = open_group(root, "operator");
  if (group < 0)
    return RAD_MATRIX_AUTO;
  char *text = rad_hdf_get_text(group, "form");
  enum rad_matrix form =
      text && !strcmp(text, "dense") ? RAD_MATRIX_DENSE : RAD_MATRIX_HIERARCHICAL;
  free(text);
  H5Gclose(group);
  return form;
}

/* The operator, if it has this form, its counters added; negative if not. */
static hid_t open_form(hid_t root, enum rad_matrix form, struct rad_counters *c) {
  const hid_t group =
      rad_operator_form(root) == form ? open_group(root, "operator") : H5I_INVALID_HID;
  if (group >= 0)
    add_counters(group, c);
  return group;
}

/* --- dense --- */

void rad_operator_write_dense(struct rad_hdf *h, hid_t root, struct rad_dense *dense) {
  struct list l = {0};
  list_dense(dense, &l);
  const hid_t group = begin(h, root, "dense", &dense->counters);
  write_list(h, group, &l);
  rad_hdf_group_close(h, group);
}

bool rad_operator_read_dense(hid_t root, struct rad_dense *dense) {
  struct list l = {0};
  list_dense(dense, &l);
  const hid_t group = open_form(root, RAD_MATRIX_DENSE, &dense->counters);
  const bool done = group >= 0 && read_list(group, &l);
  if (group >= 0)
    H5Gclose(group);
  return done;
}

/* --- bases on their way --- */

static int is_there(const struct rad_basis *b, int cluster) {
  return b->state[cluster] == RAD_BASIS_DONE || b->state[cluster] == RAD_BASIS_SPENT;
}

/* Numbers of each cluster's matrix and change, as far as they are there. */
static void set_counts(const struct rad_basis *b, size_t n_node, size_t *matrix, size_t *change) {
  for (int c = 0; c < b->tree->n_cluster; c++) {
    size_t rank = (size_t)b->rank[c];
    matrix[c] = is_there(b, c) ? rank * (size_t)rad_basis_rows(b->tree, b->rank, c) : 0;
    change[c] = b->state[c] == RAD_BASIS_DONE ? rank * n_node : 0;
  }
}

static size_t nodes_of(const struct rad_h2 *h) {
  struct rad_interpolation p;
  rad_interpolation_init(&p, h->tolerance);
  return (size_t)p.n;
}

static void write_basis(struct rad_hdf *h, hid_t parent, const char *name, size_t n_node,
                        struct rad_basis *b) {
  static const struct rad_hdf_array matrix = {
      .name = "matrix", .unit = "1", .description = "bases, [rows, rank] column-major"};
  static const struct rad_hdf_array change = {
      .name = "change", .unit = "1", .description = "polynomials in the bases, [n_node, rank]"};
  size_t n = (size_t)b->tree->n_cluster, *count = rad_alloc(2 * n, sizeof *count);
  struct list l = {0};
  list_basis(b, &l);
  const hid_t group = rad_hdf_group(h, parent, name);
  write_list(h, group, &l);
  if (count) {
    set_counts(b, n_node, count, count + n);
    rad_hdf_lists(h, group, &matrix, n, count, (const double *const *)b->matrix);
    rad_hdf_lists(h, group, &change, n, count + n, (const double *const *)b->change);
  } else {
    rad_hdf_fail(h, "out of memory for %zu bases", n);
  }
  rad_hdf_group_close(h, group);
  free(count);
}

/* No basis has more columns than its cluster unknowns, whatever a file says. */
static bool ranks_fit(const struct rad_tree *tree, const int *rank) {
  for (int c = 0; c < tree->n_cluster; c++)
    if (rank[c] < 0 || rank[c] > tree->cluster[c].n)
      return false;
  return true;
}

/* One array of all clusters, cut into theirs. */
static bool read_pieces(hid_t group, const char *name, const struct rad_basis *b,
                        const size_t *count, double **piece) {
  size_t total = 0;
  for (int c = 0; c < b->tree->n_cluster; c++)
    total += count[c];
  double *all = rad_alloc(total, sizeof(double)), *at = all;
  bool done = all && rad_hdf_read_into(group, name, RAD_HDF_REAL, total, all);
  for (int c = 0; c < b->tree->n_cluster && done; c++) {
    if (!is_there(b, c))
      continue;
    done = (piece[c] = rad_alloc(count[c], sizeof(double))) != NULL;
    if (done)
      memcpy(piece[c], at, sizeof(double) * count[c]);
    at += count[c];
  }
  free(all);
  return done;
}

/* What another basis has of the same clusters moves over. */
static void merge_basis(struct rad_basis *from, struct rad_basis *to) {
  for (int c = 0; c < to->tree->n_cluster; c++)
    if (is_there(from, c)) {
      free(to->matrix[c]);
      free(to->change[c]);
      to->state[c] = from->state[c];
      to->rank[c] = from->rank[c];
      to->matrix[c] = from->matrix[c];
      to->change[c] = from->change[c];
      from->matrix[c] = from->change[c] = NULL;
    }
}

static bool read_basis(hid_t parent, const char *name, size_t n_node, struct rad_basis *to) {
  size_t n = (size_t)to->tree->n_cluster, *count = rad_alloc(2 * n, sizeof *count);
  struct rad_basis b;
  struct rad_error e;
  struct list l = {0};
  bool done = !rad_basis_begin(to->tree, &b, &e) && count;
  list_basis(&b, &l);
  const hid_t group = open_group(parent, name);
  done = done && group >= 0 && read_list(group, &l) && ranks_fit(b.tree, b.rank);
  if (done) {
    set_counts(&b, n_node, count, count + n);
    done = read_pieces(group, "matrix", &b, count, b.matrix) &&
           read_pieces(group, "change", &b, count + n, b.change);
  }
  if (done)
    merge_basis(&b, to);
  if (group >= 0)
    H5Gclose(group);
  rad_basis_free(&b);
  free(count);
  return done;
}

static void write_bases(struct rad_hdf *h, hid_t group, struct rad_h2 *h2) {
  for (int s = 0; s < 2; s++)
    write_basis(h, group, basis_name[s], nodes_of(h2), &h2->basis[s]);
}

static bool read_bases(hid_t group, struct rad_h2 *h2) {
  bool done = true;
  for (int s = 0; s < 2 && done; s++)
    done = read_basis(group, basis_name[s], nodes_of(h2), &h2->basis[s]);
  return done;
}

/* --- hierarchical --- */

void rad_operator_write_h2(struct rad_hdf *h, hid_t root, struct rad_h2 *h2) {
  const hid_t group = begin(h, root, "hierarchical", &h2->counters);
  struct list l = {0};
  rad_hdf_set_integer(h, group, "far_done", h2->far_done);
  if (h2->far_done) {
    list_ranks(h2, &l);
    list_far(h2, &l);
  }
  list_near(h2, &l);
  write_list(h, group, &l);
  if (!h2->far_done)
    write_bases(h, group, h2);
  rad_hdf_group_close(h, group);
}

/* Finished bases and far blocks. */
static bool read_far(hid_t group, struct rad_h2 *h2) {
  struct list ranks = {0}, l = {0};
  struct rad_error e;
  h2->row.rank = rad_alloc((size_t)h2->tree.n_cluster, sizeof(int));
  h2->column.rank = rad_alloc((size_t)h2->tree.n_cluster, sizeof(int));
  list_ranks(h2, &ranks);
  if (!h2->row.rank || !h2->column.rank || !read_list(group, &ranks) ||
      !ranks_fit(&h2->tree, h2->row.rank) || !ranks_fit(&h2->tree, h2->column.rank) ||
      rad_h2_far_begin(h2, &e))
    return false;
  for (int s = 0; s < 2; s++)
    rad_basis_free(&h2->basis[s]);
  list_far(h2, &l);
  return read_list(group, &l);
}

bool rad_operator_read_h2(hid_t root, struct rad_h2 *h2) {
  const hid_t group = open_form(root, RAD_MATRIX_HIERARCHICAL, &h2->counters);
  if (group < 0)
    return false;
  struct list near = {0};
  list_near(h2, &near);
  h2->far_done = rad_hdf_get_number(group, "far_done") == 1;
  bool done = h2->far_done ? read_far(group, h2) : read_bases(group, h2);
  done = done && read_list(group, &near);
  H5Gclose(group);
  return done;
}

/* --- parts --- */

void rad_operator_write_dense_part(struct rad_hdf *h, hid_t root, struct rad_dense *dense,
                                   struct rad_part_number part) {
  struct list l = {0};
  list_columns(dense, rad_part_columns(dense, part), &l);
  const hid_t group = begin(h, root, "dense", &dense->counters);
  write_list(h, group, &l);
  rad_hdf_group_close(h, group);
}

bool rad_operator_read_dense_part(hid_t root, struct rad_dense *dense,
                                  struct rad_part_number part) {
  struct rad_part_range own = rad_part_columns(dense, part);
  struct rad_error e;
  struct list l = {0};
  list_columns(dense, own, &l);
  const hid_t group = open_form(root, RAD_MATRIX_DENSE, &dense->counters);
  const bool done =
      group >= 0 && read_list(group, &l) && !rad_dense_set_done(dense, own.first, own.end, 0, &e);
  if (group >= 0)
    H5Gclose(group);
  return done;
}

void rad_operator_write_h2_part(struct rad_hdf *h, hid_t root, struct rad_h2 *h2,
                                struct rad_part_number part) {
  struct list l = {0};
  list_blocks(h2, rad_part_clusters(h2, part), &l);
  const hid_t group = begin(h, root, "hierarchical", &h2->counters);
  write_list(h, group, &l);
  write_bases(h, group, h2);
  rad_hdf_group_close(h, group);
}

bool rad_operator_read_h2_part(hid_t root, struct rad_h2 *h2, struct rad_part_number part) {
  struct rad_part_range own = rad_part_clusters(h2, part);
  struct list l = {0};
  list_blocks(h2, own, &l);
  const hid_t group = open_form(root, RAD_MATRIX_HIERARCHICAL, &h2->counters);
  const bool done = group >= 0 && read_bases(group, h2) && read_list(group, &l);
  if (done)
    memset(h2->near_done + own.first, 1, (size_t)(own.end - own.first));
  if (group >= 0)
    H5Gclose(group);
  return done;
}
