/* The checkpoint reader. An input changes a checkpoint that is written here, because only the same
 * program reads one: byte 0 chooses the checkpoint (low bits), whether it is sealed again (bit 7),
 * so that the change gets beyond the seal, and whether it is cut (bit 6); then five bytes a change:
 * where, and the new value of that byte. */
#include <fcntl.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "app/checkpoint.h"
#include "output/checkpoint.h"
#include "output/seal.h"
#include "target.h"

static const char scene_text[] =
    "scene:\n"
    "  triangles:\n"
    "    - {vertices: [[0,0,0],[1,0,0],[0,1,0]], side: front, rho: 0.5, emission: 1}\n"
    "    - {vertices: [[0,0,0],[0,1,0],[0,0,1]], side: front, rho: 0.5, emission: 0}\n";
static const char by_hand_text[] =
    "method: {mesh: paper, elements: 1, quadrature_tolerance: 1e-4, solver: gmres, matrix: ";
static const char adaptive_text[] = "accuracy: {tolerance: 1e-2}\nmethod: {matrix: ";

enum { BEGUN, WHOLE, DENSE, ADAPTIVE, N_BASE };

static struct {
  struct rad_case c[N_BASE];
  uint8_t *bytes[N_BASE];
  size_t n[N_BASE];
  size_t *array[N_BASE], n_array[N_BASE]; /* places of the arrays' bytes */
} base;

static herr_t note_array(hid_t at, const char *name, const H5O_info_t *info, void *context) {
  int k = *(int *)context;
  if (info->type != H5O_TYPE_DATASET)
    return 0;
  hid_t dataset = H5Dopen2(at, name, H5P_DEFAULT);
  haddr_t start = H5Dget_offset(dataset);
  hsize_t size = H5Dget_storage_size(dataset);
  H5Dclose(dataset);
  if (size == 0)
    return 0;
  base.array[k] = realloc(base.array[k], (base.n_array[k] + size) * sizeof *base.array[k]);
  REQUIRE(base.array[k] && start + size <= base.n[k]);
  for (hsize_t i = 0; i < size; i++)
    base.array[k][base.n_array[k]++] = start + i;
  return 0;
}

static void find_arrays(int k, const char *path) {
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  REQUIRE(file >= 0 && H5Ovisit(file, H5_INDEX_NAME, H5_ITER_INC, note_array, &k) >= 0);
  REQUIRE(base.n_array[k] > 0);
  H5Fclose(file);
}

/* What a run has when it begins to look for its checkpoint. */
static void begin(int k, struct rad_dense *dense, struct rad_h2 *h2) {
  struct rad_case *c = &base.c[k];
  struct rad_error e;
  *dense = (struct rad_dense){0};
  *h2 = (struct rad_h2){0};
  REQUIRE((k == DENSE ? rad_dense_begin(c->mesh, NULL, dense, &e)
                      : rad_h2_begin(c->mesh, c->rules.tolerance, h2, &e)) == RAD_OK);
}

static void make_base(int k) {
  struct rad_case *c = &base.c[k];
  struct rad_error e;
  char text[1024], file[] = "/tmp/polyrad_fuzz_XXXXXX";
  snprintf(text, sizeof text, "%s%s%s}\n", scene_text, k == ADAPTIVE ? adaptive_text : by_hand_text,
           k < DENSE ? "hierarchical" : "dense");
  REQUIRE(rad_case_prepare(fuzz_file(text, strlen(text)), 0, NULL, NULL, c, &e) == RAD_OK);
  REQUIRE(rad_case_solve(c, &e) == RAD_OK);
  if (k == BEGUN) {
    rad_h2_free(&c->h2);
    begin(k, &c->dense, &c->h2);
    rad_iterate_free(&c->iterate);
  }
  int fd = mkstemp(file);
  REQUIRE(fd >= 0 && rad_case_save(c, file, "fuzz", 0, &e) == RAD_OK);
  close(fd);
  REQUIRE((fd = open(file, O_RDONLY)) >= 0);
  base.n[k] = (size_t)lseek(fd, 0, SEEK_END);
  base.bytes[k] = malloc(base.n[k]);
  REQUIRE(base.bytes[k] && pread(fd, base.bytes[k], base.n[k], 0) == (ssize_t)base.n[k]);
  close(fd);
  find_arrays(k, file);
  unlink(file);
}

static const char *change(int k, const uint8_t *bytes, size_t n) {
  size_t size = base.n[k];
  uint8_t *copy = malloc(size);
  REQUIRE(copy);
  memcpy(copy, base.bytes[k], size);
  for (size_t i = 1; i + 5 <= n; i += 5) {
    uint32_t at;
    memcpy(&at, bytes + i, 4);
    if (i == 1 && bytes[0] & 64)
      size = 1 + at % size;
    else if (bytes[0] & 128)
      copy[base.array[k][at % base.n_array[k]]] = bytes[i + 4];
    else
      copy[at % size] = bytes[i + 4];
  }
  const char *path = fuzz_file(copy, size);
  free(copy);
  if (bytes[0] & 128) {
    int fd = open(path, O_RDWR);
    REQUIRE(fd >= 0 && rad_seal_write(fd, "checkpoint") == 0);
    close(fd);
  }
  return path;
}

static enum rad_code read_matrix(int k, const char *path, const struct rad_origin *origin,
                                 struct rad_error *e) {
  enum rad_matrix form;
  struct rad_dense dense;
  struct rad_h2 h2;
  struct rad_iterate iterate = {0};
  enum rad_code code = rad_checkpoint_look(path, origin, &form, e);
  if (code)
    return code;
  begin(k, &dense, &h2);
  const struct rad_checkpoint into = {
      .dense = k == DENSE ? &dense : NULL, .h2 = k == DENSE ? NULL : &h2, .iterate = &iterate};
  code = rad_checkpoint_read(path, origin, &into, e);
  double n_point = origin->mesh->n_point; /* no file makes a matrix larger than a dense one */
  REQUIRE((double)h2.n_far <= n_point * n_point);
  rad_dense_free(&dense);
  rad_h2_free(&h2);
  rad_iterate_free(&iterate);
  return code;
}

/* What is read is a mesh of the scene, or refused. */
static enum rad_code read_stage(struct rad_case *c, const char *path,
                                const struct rad_origin *origin, struct rad_error *e) {
  struct rad_stage stage;
  struct rad_mesh mesh;
  enum rad_code code = rad_checkpoint_read_stage(path, origin, &stage, e);
  if (!code && stage.leaf)
    code = rad_stage_restore(&stage, &c->adaptive.layout, e);
  rad_stage_free(&stage);
  if (code)
    return code;
  code = rad_layout_mesh(&c->adaptive.layout, &mesh, e);
  REQUIRE(code || mesh.n_element == c->adaptive.layout.n_leaf);
  rad_mesh_free(&mesh);
  return code;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n) {
  omp_set_num_threads(1);
  for (int k = 0; k < N_BASE && !base.bytes[k]; k++)
    make_base(k);
  if (n < 1)
    return 0;
  int k = (bytes[0] & 63) % N_BASE;
  struct rad_case *c = &base.c[k];
  const struct rad_origin origin = {
      .deck = &c->deck, .scene = &c->scene, .mesh = k == ADAPTIVE ? NULL : c->mesh, .threads = 1};
  struct rad_error e = {0};
  const char *path = change(k, bytes, n);
  enum rad_code code =
      k == ADAPTIVE ? read_stage(c, path, &origin, &e) : read_matrix(k, path, &origin, &e);
  fuzz_check_error(code, &e);
  REQUIRE(H5Fget_obj_count((hid_t)H5F_OBJ_ALL, H5F_OBJ_ALL) == 0);
  REQUIRE(!code || n > 1 || bytes[0] & 64); /* unchanged, it is read */
  return 0;
}
