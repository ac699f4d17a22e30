#include "output/origin.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/checksum.h"
#include "base/provenance.h"
#include "base/text.h"
#include "output/seal.h"
#include "output/stamp.h"

/* The scene, whatever files it came from: 52 bits, which a double holds. */
static int64_t scene_checksum(const struct rad_scene *s) {
  size_t n = (size_t)s->n_triangle, nb = (size_t)s->n_band;
  uint64_t sum = 0;
  for (size_t t = 0; t < n; t++) {
    sum = rad_checksum(sum, s->triangle[t].v, sizeof s->triangle[t].v);
    sum = rad_checksum(sum, s->triangle[t].normal, sizeof s->triangle[t].normal);
  }
  sum = rad_checksum(sum, s->rho, sizeof(double) * n * nb);
  sum = rad_checksum(sum, s->emission, sizeof(double) * 3 * n * nb);
  return (int64_t)(sum >> 12);
}

hid_t rad_origin_write(struct rad_hdf *h, const char *kind, const struct rad_origin *o) {
  const hid_t root = rad_stamp(h, o->deck, o->command, o->threads, o->started);
  char *set = rad_join_lines(o->n_set, o->set);
  if (!set)
    rad_hdf_fail(h, "out of memory for %d overrides", o->n_set);
  rad_hdf_set_text(h, root, "kind", kind);
  rad_hdf_set_text(h, root, "set", set);
  if (o->scene)
    rad_hdf_set_integer(h, root, "scene_checksum", scene_checksum(o->scene));
  if (o->mesh) {
    rad_hdf_set_integer(h, root, "elements", o->mesh->n_element);
    rad_hdf_set_integer(h, root, "unknowns", o->mesh->n_point);
  }
  free(set);
  return root;
}

static int is_text(hid_t root, const char *name, const char *expected) {
  char *text = rad_hdf_get_text(root, name);
  int same = text && expected && !strcmp(text, expected);
  free(text);
  return same;
}

/* What is absent was not known yet when the file was written. */
static int is_number(hid_t root, const char *name, double expected) {
  double value = rad_hdf_get_number(root, name);
  return isnan(value) || value == expected;
}

static enum rad_code compare(const char *path, hid_t root, const struct rad_origin *o,
                             struct rad_error *e) {
  struct rad_provenance p = {0};
  rad_provenance_get(&p);
  if (!is_text(root, "version", p.version) || !is_text(root, "git_revision", p.git_revision) ||
      !is_text(root, "compiler", p.compiler) || !is_text(root, "flags", p.flags)) {
    char *version = rad_hdf_get_text(root, "version");
    char *revision = rad_hdf_get_text(root, "git_revision");
    enum rad_code code = rad_fail(
        e, RAD_EINPUT,
        "%.400s was written by another build of polyrad: %.40s (%.60s), and this is %s (%s); use "
        "that one, or make the file again",
        path, version ? version : "?", revision ? revision : "?", p.version, p.git_revision);
    free(version);
    free(revision);
    return code;
  }
  if (!is_text(root, "deck", o->deck->text))
    return rad_fail(e, RAD_EINPUT,
                    "%.400s was made from another deck: the text of %.400s differs; give the deck "
                    "it was made from, or make it again",
                    path, o->deck->path);
  char *set = rad_join_lines(o->n_set, o->set), *theirs = rad_hdf_get_text(root, "set");
  enum rad_code code = RAD_OK;
  if (!set || !theirs || strcmp(set, theirs) != 0)
    code = rad_fail(e, RAD_EINPUT,
                    "%.400s was made with other --set options (%.200s); give the same, in that "
                    "order, or make it again",
                    path, theirs && *theirs ? theirs : "none");
  free(set);
  free(theirs);
  for (char *c = e->text; code && *c; c++)
    *c = *c == '\n' ? ' ' : *c;
  if (!code &&
      ((o->scene && !is_number(root, "scene_checksum", (double)scene_checksum(o->scene))) ||
       (o->mesh && (!is_number(root, "elements", o->mesh->n_element) ||
                    !is_number(root, "unknowns", o->mesh->n_point)))))
    code = rad_fail(e, RAD_EINPUT,
                    "%.400s was made from another scene: the mesh file of %.400s has changed; give "
                    "the one it was made from, or make it again",
                    path, o->deck->path);
  return code;
}

enum rad_code rad_origin_open(const char *path, const char *kind, const struct rad_origin *o,
                              hid_t *file, hid_t *root, struct rad_error *e) {
  struct rad_hdf_silence silence;
  *file = *root = H5I_INVALID_HID;
  enum rad_code code = rad_seal_check(path, kind, e);
  if (code)
    return code;
  rad_hdf_silence_begin(&silence);
  *file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  *root = *file < 0 ? *file : H5Gopen2(*file, "polyrad", H5P_DEFAULT);
  code = *root < 0 ? rad_fail(e, RAD_ESYSTEM, "cannot read %.400s: HDF5 does not open it", path)
                   : compare(path, *root, o, e);
  if (code && *root >= 0)
    H5Gclose(*root);
  if (code && *file >= 0)
    H5Fclose(*file);
  rad_hdf_silence_end(&silence);
  return code;
}
