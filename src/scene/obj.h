/* Wavefront OBJ: polygons in double precision, triangulated, with the names of their surfaces. */
#ifndef RAD_SCENE_OBJ_H
#define RAD_SCENE_OBJ_H

#include "base/error.h"

enum { RAD_MAX_BENT_NOTES = 20 };

struct rad_obj_triangle {
  int vertex[3]; /* from 0; the right-hand rule gives the front */
  int part;
  int line; /* of its face */
};

struct rad_obj {
  int n_vertex, n_triangle, n_part;
  double (*vertex)[3];               /* owned [n_vertex] as in the file, not welded */
  struct rad_obj_triangle *triangle; /* owned [n_triangle] in the order of the faces */
  char *
      *part_name; /* owned [n_part] surface of each run of faces, by first face; names may repeat */
};

/**
 * Read an OBJ file.
 *
 * Statements v, f (corners v, v/vt, v//vn, v/vt/vn, numbers from 1 or negative), g, o, usemtl;
 * comments, continued lines, lines of any length. vt, vn, vp, s, mtllib, l, p and display
 * attributes are passed over; free-form surfaces and unknown statements are refused.
 *
 * One rule names the surfaces: by usemtl if the file has any, else by g, else by o. Faces without
 * such a name belong to a surface named after the file, without folder and extension. A name is the
 * rest of its line.
 *
 * Polygons are cut by rad_polygon_triangulate. Messages read `PATH:LINE: error: ...`.
 *
 * Cost proportional to the file's size (and to n^2 for a face of n corners, at most 10000).
 *
 * @param[out] obj    to be freed with rad_obj_free, also after an error
 * @param[out] notes  a warning for polygons that are not plane to 1e-6 of their diameter: the first
 *                    RAD_MAX_BENT_NOTES by line, the rest counted
 * @return RAD_OK, RAD_EINPUT for anything wrong with the text, RAD_ESYSTEM if it cannot be read
 */
enum rad_code rad_obj_read(const char *path, struct rad_obj *obj, struct rad_notes *notes,
                           struct rad_error *e);

void rad_obj_free(struct rad_obj *obj); /* safe twice */

#endif
