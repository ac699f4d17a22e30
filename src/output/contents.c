#define _GNU_SOURCE /* asprintf */
#include "output/contents.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/checksum.h"
#include "base/memory.h"

enum { PIECE = 1 << 20 }; /* bytes read at once */

/* ---- sums: the same while it is written and while it is read ------------------------------- */

/* Of what kind and shape values are. */
static uint64_t sum_kind(hid_t memory, int rank, const hsize_t *shape) {
  const bool varies = H5Tis_variable_str(memory) > 0;
  uint64_t head[3 + RAD_HDF_MAX_RANK] = {(uint64_t)H5Tget_class(memory),
                                         varies ? 0 : H5Tget_size(memory), (uint64_t)rank};
  for (int k = 0; k < rank; k++)
    head[3 + k] = shape[k];
  return rad_checksum(0, head, sizeof head);
}

static uint64_t sum_text(uint64_t sum, const char *text) {
  return rad_checksum(sum, text ? text : "", text ? strlen(text) : 0);
}

/* n values of a type as it is in memory. */
static uint64_t sum_values(uint64_t sum, hid_t memory, size_t n, const void *data) {
  if (H5Tis_variable_str(memory) <= 0)
    return rad_checksum(sum, data, n * H5Tget_size(memory));
  for (size_t i = 0; i < n; i++)
    sum = sum_text(sum, ((const char *const *)data)[i]);
  return sum;
}

/* A dataset is summed up by pieces of whole rows: bytes of a row, and rows of a piece. */
struct pieces {
  size_t row, rows;
};

static struct pieces pieces_of(hid_t memory, int rank, const hsize_t *shape) {
  size_t row = H5Tget_size(memory);
  for (int k = 1; k < rank; k++)
    row *= shape[k];
  return (struct pieces){row, row && row < PIECE ? PIECE / row : 1};
}

/* ---- writing ------------------------------------------------------------------------------- */

/* A line of the list; of a dataset, attribute is NULL. */
static void remember(struct rad_hdf *h, hid_t group, const char *attribute, const char *dataset,
                     uint64_t sum) {
  char path[128], *line = NULL;
  if (H5Iget_name(group, path, sizeof path) <= 0)
    rad_hdf_fail(h, "HDF5 does not know the name of a group");
  const int n = attribute
                    ? asprintf(&line, "%016" PRIx64 " attribute %s of %s", sum, attribute, path)
                    : asprintf(&line, "%016" PRIx64 " dataset %s/%s", sum, path, dataset);
  if (n >= 0 &&
      rad_reserve((void **)&h->content, h->n_content + 1, &h->content_room, sizeof line)) {
    h->content[h->n_content++] = line;
  } else {
    rad_hdf_fail(h, "out of memory for checksums");
    if (n >= 0)
      free(line);
  }
}

/* Sum over the rows of a; over fill values where it has no data. */
static uint64_t sum_rows(struct rad_hdf *h, uint64_t sum, const struct rad_hdf_array *a,
                         hid_t memory) {
  const struct pieces p = pieces_of(memory, a->rank, a->shape);
  const size_t n = a->shape[0], most = p.rows < n ? p.rows : n;
  double *fill = NULL;
  if (!p.row)
    return sum;
  if (!a->data && !(fill = rad_alloc(most * p.row, 1)))
    rad_hdf_fail(h, "out of memory for the checksum of '%.80s'", a->name);
  if (fill)
    memset(fill, 0, most * p.row);
  for (size_t i = 0; fill && a->type == RAD_HDF_REAL && i < most * p.row / sizeof *fill; i++)
    fill[i] = NAN;
  for (size_t i = 0; i < n && (a->data || fill); i += p.rows) {
    const size_t rows = n - i < p.rows ? n - i : p.rows;
    const void *at = fill ? (const void *)fill : (const char *)a->data + i * p.row;
    sum = sum_values(sum, memory, rows * (p.row / H5Tget_size(memory)), at);
  }
  free(fill);
  return sum;
}

void rad_contents_dataset(struct rad_hdf *h, hid_t parent, const struct rad_hdf_array *a,
                          hid_t memory) {
  if (h->failed || h->memory >= 0)
    return;
  uint64_t sum = sum_rows(h, sum_kind(memory, a->rank, a->shape), a, memory);
  sum = sum_text(sum_text(sum, a->unit), a->description);
  remember(h, parent, NULL, a->name, sum);
}

void rad_contents_attribute(struct rad_hdf *h, hid_t object, const char *name, hid_t memory,
                            size_t n, const void *data) {
  const hsize_t shape = n;
  if (h->failed || h->memory >= 0 || H5Iget_type(object) != H5I_GROUP)
    return;
  const uint64_t sum = sum_values(sum_kind(memory, n ? 1 : 0, &shape), memory, n ? n : 1, data);
  remember(h, object, name, NULL, sum);
}

static const char about_list[] = "checksum and name of every dataset and group attribute";

static uint64_t sum_list(size_t n, char *const *line, const char *about) {
  uint64_t sum = sum_text(n, about);
  for (size_t i = 0; i < n; i++)
    sum = sum_text(sum, line[i]);
  return sum;
}

void rad_contents_write(struct rad_hdf *h) {
  const size_t n = h->n_content; /* what is written here is not on the list */
  char **const line = h->content, sum[24];
  h->content = NULL;
  h->n_content = h->content_room = 0;
  if (!h->failed && n > 0) {
    snprintf(sum, sizeof sum, "%016" PRIx64, sum_list(n, line, about_list));
    const hid_t root = rad_hdf_check(h, H5Gopen2(h->file, "polyrad", H5P_DEFAULT), "polyrad");
    rad_hdf_set_text(h, root, "checksum", sum);
    rad_hdf_texts(h, root, "checksums", n, (const char *const *)line, about_list);
    rad_hdf_group_close(h, root);
  }
  rad_hdf_texts_free(line, (int)n);
  rad_hdf_texts_free(h->content, (int)h->n_content);
  h->content = NULL;
  h->n_content = h->content_room = 0;
}

/* ---- reading ------------------------------------------------------------------------------- */

/* A type in memory for one in the file; to be closed. */
static hid_t memory_type(hid_t type) {
  return H5Tget_class(type) == H5T_STRING ? H5Tcopy(type)
                                          : H5Tget_native_type(type, H5T_DIR_ASCEND);
}

/* Read n values by pieces into a buffer, and go on with the sum; false if HDF5 cannot. */
static bool sum_dataset(hid_t dataset, hid_t space, hid_t memory, int rank, const hsize_t *shape,
                        uint64_t *sum) {
  const struct pieces p = pieces_of(memory, rank, shape);
  const bool varies = H5Tis_variable_str(memory) > 0;
  hsize_t start[RAD_HDF_MAX_RANK] = {0}, count[RAD_HDF_MAX_RANK];
  memcpy(count, shape, sizeof count);
  char *piece = p.row ? rad_alloc(p.rows < shape[0] ? p.rows : shape[0], p.row) : NULL;
  bool done = piece || !p.row;
  for (; piece && done && start[0] < shape[0]; start[0] += p.rows) {
    count[0] = shape[0] - start[0] < p.rows ? shape[0] - start[0] : p.rows;
    const hid_t block = H5Screate_simple(rank, count, NULL);
    done = block >= 0 &&
           H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) >= 0 &&
           H5Dread(dataset, memory, block, space, H5P_DEFAULT, piece) >= 0;
    if (done)
      *sum = sum_values(*sum, memory, (size_t)count[0] * (p.row / H5Tget_size(memory)), piece);
    if (done && varies)
      H5Dvlen_reclaim(memory, block, H5P_DEFAULT, piece);
    H5Sclose(block);
  }
  free(piece);
  return done;
}

static bool read_dataset(hid_t root, const char *path, uint64_t *sum) {
  hsize_t shape[RAD_HDF_MAX_RANK] = {0};
  const hid_t dataset = H5Dopen2(root, path, H5P_DEFAULT);
  if (dataset < 0)
    return false;
  const hid_t type = H5Dget_type(dataset), space = H5Dget_space(dataset);
  const hid_t memory = type >= 0 ? memory_type(type) : type;
  const int rank = space >= 0 ? H5Sget_simple_extent_ndims(space) : 0;
  bool done = memory >= 0 && rank >= 1 && rank <= RAD_HDF_MAX_RANK &&
              H5Sget_simple_extent_dims(space, shape, NULL) == rank;
  if (done) {
    *sum = sum_kind(memory, rank, shape);
    done = sum_dataset(dataset, space, memory, rank, shape, sum);
  }
  char *unit = rad_hdf_get_text(dataset, "unit");
  char *description = rad_hdf_get_text(dataset, "description");
  *sum = sum_text(sum_text(*sum, unit), description);
  done = done && unit && description;
  free(unit);
  free(description);
  H5Tclose(memory);
  H5Tclose(type);
  H5Sclose(space);
  H5Dclose(dataset);
  return done;
}

static bool read_attribute(hid_t root, const char *path, const char *name, uint64_t *sum) {
  const hid_t at = H5Aopen_by_name(root, path, name, H5P_DEFAULT, H5P_DEFAULT);
  if (at < 0)
    return false;
  const hid_t type = H5Aget_type(at), space = H5Aget_space(at);
  const hid_t memory = type >= 0 ? memory_type(type) : type;
  const hssize_t n = space >= 0 ? H5Sget_simple_extent_npoints(space) : -1;
  const int rank = space >= 0 ? H5Sget_simple_extent_ndims(space) : -1;
  const hsize_t shape = n > 0 ? (hsize_t)n : 0;
  void *data = memory >= 0 && n > 0 && n < PIECE && (rank == 0 || rank == 1)
                   ? rad_calloc((size_t)n, H5Tget_size(memory))
                   : NULL;
  const bool done = data && H5Aread(at, memory, data) >= 0;
  if (done)
    *sum = sum_values(sum_kind(memory, rank, &shape), memory, (size_t)n, data);
  if (done && H5Tis_variable_str(memory) > 0)
    H5Dvlen_reclaim(memory, space, H5P_DEFAULT, data);
  free(data);
  H5Tclose(memory);
  H5Tclose(type);
  H5Sclose(space);
  H5Aclose(at);
  return done;
}

static char *text_of(hid_t root, const char *object, const char *attribute) {
  const hid_t at = H5Oopen(root, object, H5P_DEFAULT);
  char *text = at < 0 ? NULL : rad_hdf_get_text(at, attribute);
  if (at >= 0)
    H5Oclose(at);
  return text;
}

/* What a line of the list says, compared with what is there. */
static bool is_as_written(hid_t root, const char *line) {
  static const char dataset[] = " dataset ", attribute[] = " attribute ";
  char *name = NULL;
  uint64_t sum = 0;
  bool done = false;
  const uint64_t expected = strtoull(line, &name, 16);
  if (!strncmp(name, dataset, strlen(dataset))) {
    done = read_dataset(root, name + strlen(dataset), &sum);
  } else if (!strncmp(name, attribute, strlen(attribute))) {
    char *of = strstr(name += strlen(attribute), " of ");
    if (of)
      *of = '\0';
    done = of && read_attribute(root, of + 4, name, &sum);
    if (of)
      *of = ' ';
  }
  return done && sum == expected;
}

/* Whether a group still knows the order of its members, if it ever did: that of a table's columns.
 */
static bool is_in_order(hid_t root, const char *name) {
  const hid_t group = H5Gopen2(root, name, H5P_DEFAULT);
  const hid_t how = group < 0 ? group : H5Gget_create_plist(group);
  unsigned order = 0;
  H5G_info_t is;
  bool good =
      how >= 0 && H5Pget_link_creation_order(how, &order) >= 0 && H5Gget_info(group, &is) >= 0;
  for (hsize_t k = 0; good && order & H5P_CRT_ORDER_INDEXED && k < is.nlinks; k++)
    good = H5Lget_name_by_idx(group, ".", H5_INDEX_CRT_ORDER, H5_ITER_INC, k, NULL, 0,
                              H5P_DEFAULT) >= 0;
  H5Pclose(how);
  H5Gclose(group);
  return good;
}

static enum rad_code fail(const char *path, const char *name, struct rad_error *e) {
  return rad_fail(e, RAD_ESYSTEM,
                  "%.400s is damaged: %.300s is not as it was written; make it again", path, name);
}

enum rad_code rad_contents_check(const char *path, hid_t root, struct rad_error *e) {
  const htri_t has_sum = H5Aexists(root, "checksum"),
               has_list = H5Lexists(root, "checksums", H5P_DEFAULT);
  if (has_sum == 0 && has_list == 0)
    return RAD_OK; /* an older version wrote it */
  int n = 0;
  char right[24] = "", *sum = rad_hdf_get_text(root, "checksum");
  char **line = rad_hdf_read_texts(root, "checksums", &n),
       *about = text_of(root, "checksums", "description");
  if (line)
    snprintf(right, sizeof right, "%016" PRIx64, sum_list((size_t)n, line, about));
  enum rad_code code =
      sum && line && !strcmp(sum, right) ? RAD_OK : fail(path, "the list of its checksums", e);
  for (int i = 0; i < n && !code; i++)
    if (!is_as_written(root, line[i]))
      code = fail(path, line[i] + strcspn(line[i], " ") + 1, e);
  if (!code && H5Lexists(root, "study", H5P_DEFAULT) > 0 && !is_in_order(root, "study"))
    code = fail(path, "the order of columns in /polyrad/study", e);
  rad_hdf_texts_free(line, n);
  free(about);
  free(sum);
  return code;
}
