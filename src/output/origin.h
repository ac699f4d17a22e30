/* Files that only the same program may go on from, with the same deck: what they came from. */
#ifndef RAD_OUTPUT_ORIGIN_H
#define RAD_OUTPUT_ORIGIN_H

#include "mesh/mesh.h"
#include "output/hdf.h"
#include "scene/deck.h"

struct rad_origin {
  const struct rad_deck *deck;
  int n_set; /* overrides of the deck */
  const char *const *set;
  const struct rad_scene *scene; /* NULL: not built yet */
  const struct rad_mesh *mesh;   /* NULL: not built yet */
  const char *command;
  int threads;
  double started; /* see rad_stamp */
};

/* /polyrad, with attributes `kind`, `set` and, as far as they are known, `scene_checksum`
 * (vertices, normals, rho, E), `elements`, `unknowns`. To be closed with rad_hdf_group_close. */
hid_t rad_origin_write(struct rad_hdf *h, const char *kind, const struct rad_origin *origin);

/**
 * Open a file of this kind for reading, sealed and of the same origin: program version, revision,
 * compiler, deck, overrides, scene and mesh.
 *
 * @param[out] file, root  the file and its /polyrad, to be closed with H5Fclose, H5Gclose
 * @return RAD_ESYSTEM for a file that cannot be read or is damaged, RAD_EINPUT for another origin
 */
enum rad_code rad_origin_open(const char *path, const char *kind, const struct rad_origin *origin,
                              hid_t *file, hid_t *root, struct rad_error *e);

#endif
