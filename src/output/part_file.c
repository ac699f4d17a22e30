#include "output/part_file.h"

#include <stdlib.h>

#include "base/memory.h"
#include "output/operator_file.h"

enum rad_code rad_part_write(const char *path, const struct rad_origin *origin,
                             struct rad_part_number part, const struct rad_part_matrix *m,
                             struct rad_error *e) {
  struct rad_hdf h;
  rad_hdf_begin_large(&h);
  const hid_t root = rad_origin_write(&h, "part", origin);
  rad_hdf_set_integer(&h, root, "part", part.number);
  rad_hdf_set_integer(&h, root, "parts", part.n);
  if (m->dense)
    rad_operator_write_dense_part(&h, root, m->dense, part);
  else
    rad_operator_write_h2_part(&h, root, m->h2, part);
  rad_hdf_group_close(&h, root);
  return rad_hdf_end_large(&h, path, "part", e);
}

static struct rad_part_number number_of(hid_t root) {
  const double number = rad_hdf_get_number(root, "part"), n = rad_hdf_get_number(root, "parts");
  return number >= 1 && number <= n && n < 1e9 ? (struct rad_part_number){(int)number, (int)n}
                                               : (struct rad_part_number){0};
}

/* The number and form of one file. */
static enum rad_code look(const char *path, const struct rad_origin *origin,
                          struct rad_part_number *part, enum rad_matrix *form,
                          struct rad_error *e) {
  hid_t file, root;
  enum rad_code code = rad_origin_open(path, "part", origin, &file, &root, e);
  if (code)
    return code;
  *part = number_of(root);
  *form = rad_operator_form(root);
  H5Gclose(root);
  H5Fclose(file);
  if (!part->n || *form == RAD_MATRIX_AUTO)
    return rad_fail(e, RAD_ESYSTEM, "%.400s has no part of a matrix; assemble it again", path);
  return RAD_OK;
}

/* Each of the parts once: owner[i] is the file of part i + 1, or -1. */
static enum rad_code check_all(int n_file, const char *const *file,
                               const struct rad_part_number *part, const enum rad_matrix *form,
                               int *owner, struct rad_error *e) {
  int n = part[0].n;
  for (int f = 0; f < n_file; f++) {
    if (part[f].n != n || form[f] != form[0])
      return rad_fail(e, RAD_EINPUT,
                      "%.300s is one of %d parts of a %s matrix, but %.300s one of %d of a %s one; "
                      "give the parts of one assembly",
                      file[0], n, form[0] == RAD_MATRIX_DENSE ? "dense" : "hierarchical", file[f],
                      part[f].n, form[f] == RAD_MATRIX_DENSE ? "dense" : "hierarchical");
    int *own = &owner[part[f].number - 1];
    if (*own >= 0)
      return rad_fail(e, RAD_EINPUT,
                      "%.300s and %.300s are both part %d of %d; give each part once", file[*own],
                      file[f], part[f].number, n);
    *own = f;
  }
  for (int i = 0; i < n; i++)
    if (owner[i] < 0)
      return rad_fail(e, RAD_EINPUT,
                      "part %d of %d is missing; polyrad assemble DECK --part %d/%d makes it",
                      i + 1, n, i + 1, n);
  return RAD_OK;
}

enum rad_code rad_parts_look(int n_file, const char *const *file, const struct rad_origin *origin,
                             enum rad_matrix *form, struct rad_error *e) {
  struct rad_part_number *part = rad_alloc((size_t)n_file, sizeof *part);
  enum rad_matrix *own_form = rad_alloc((size_t)n_file, sizeof *own_form);
  enum rad_code code =
      part && own_form ? RAD_OK : rad_fail_memory(e, "the list of parts", 12.0 * n_file);
  for (int f = 0; f < n_file && !code; f++)
    code = look(file[f], origin, &part[f], &own_form[f], e);
  if (!code) {
    int *owner = rad_alloc((size_t)part[0].n, sizeof *owner);
    for (int i = 0; owner && i < part[0].n; i++)
      owner[i] = -1;
    code = owner ? check_all(n_file, file, part, own_form, owner, e)
                 : rad_fail_memory(e, "the list of parts", 4.0 * part[0].n);
    *form = own_form[0];
    free(owner);
  }
  free(part);
  free(own_form);
  return code;
}

enum rad_code rad_parts_read(int n_file, const char *const *file, const struct rad_origin *origin,
                             const struct rad_part_matrix *m, struct rad_error *e) {
  for (int f = 0; f < n_file; f++) {
    hid_t open, root;
    enum rad_code code = rad_origin_open(file[f], "part", origin, &open, &root, e);
    if (code)
      return code;
    struct rad_hdf_silence silence;
    rad_hdf_silence_begin(&silence);
    struct rad_part_number part = number_of(root);
    bool done = part.n && (m->dense ? rad_operator_read_dense_part(root, m->dense, part)
                                    : rad_operator_read_h2_part(root, m->h2, part));
    H5Gclose(root);
    H5Fclose(open);
    rad_hdf_silence_end(&silence);
    if (!done)
      return rad_fail(e, RAD_ESYSTEM,
                      "%.400s does not fit into this run, or into memory; assemble it again",
                      file[f]);
  }
  return RAD_OK;
}
