/* What is wrong, or merely doubtful, with a scene: called by rad_scene_build, in this order. */
#ifndef RAD_SCENE_CHECK_H
#define RAD_SCENE_CHECK_H

#include "scene/scene.h"

/* A scene and what its messages need. `side: both` gives two triangles with one number. */
struct rad_checked {
  const struct rad_scene *scene;
  const char *path;      /* of the deck */
  const char *mesh_path; /* where the triangles with numbers above n_deck come from */
  int n_deck;
  const int *number; /* [n_triangle] from 1: the deck's, then the mesh's; twins are neighbours */
};

/* Path of the file that triangle t comes from. */
const char *rad_checked_path(const struct rad_checked *c, int t);

/**
 * Refuse triangle t: "PATH:LINE: error: triangle 3 (floor): " and the formatted rest; the path is
 * that of the file the triangle comes from.
 *
 * @param[in] t  number in the scene, from 0
 * @return RAD_EINPUT
 */
enum rad_code rad_check_fail(const struct rad_checked *c, int t, struct rad_error *e,
                             const char *fmt, ...) __attribute__((format(printf, 4, 5)));

/* Coordinates, rho and emission are finite, and 0 <= rho <= 1. Needs v, line, surface, rho,
 * emission. */
enum rad_code rad_check_numbers(const struct rad_checked *c, struct rad_error *e);

/* No triangle has two equal vertices or an area below 1e-14 of its longest edge squared.
 * Needs vertex and area besides. */
enum rad_code rad_check_shapes(const struct rad_checked *c, struct rad_error *e);

/* No two triangles have the same vertices and the same normal; with opposite normals they are a
 * slit, which is allowed. Cost n log n. */
enum rad_code rad_check_duplicates(const struct rad_checked *c, struct rad_error *e);

enum { RAD_MAX_CONTACT_NOTES = 20 };

/**
 * Look at how triangles meet (contact.h).
 *
 * Refused: triangles of one plane that face the same way and overlap. Warned of: triangles that
 * cross, then triangles that touch other than in a vertex or a whole edge, RAD_MAX_CONTACT_NOTES
 * pairs in all in deck order, the rest counted; then surfaces with a flux on faces back to back.
 *
 * @param[out] notes  warnings are appended
 * @return RAD_OK, RAD_EINPUT, or RAD_ESYSTEM when out of memory
 */
enum rad_code rad_check_contacts(const struct rad_checked *c, struct rad_notes *notes,
                                 struct rad_error *e);

#endif
