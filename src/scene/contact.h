/* Triangles that touch other than in a vertex or a whole edge. */
#ifndef RAD_SCENE_CONTACT_H
#define RAD_SCENE_CONTACT_H

#include "scene/scene.h"

enum { RAD_MAX_CONTACT_NOTES = 20 };

/* The first pairs in deck order, of all those that were found. */
struct rad_contacts {
  long n;
  int first[RAD_MAX_CONTACT_NOTES][2];
};

double rad_longest_edge(const struct rad_triangle *t);

/**
 * True if triangles a and b come closer than `tolerance` away from the vertices and the edge they
 * share.
 *
 * Shared vertices are those with equal numbers. With none shared: their distance. With one: the
 * distance of either's opposite edge from the other, because two triangles with a common vertex
 * that meet anywhere else meet there too. With two: whether one is folded onto the other. With
 * three: never.
 *
 * @param[in] tolerance  [m]; lowered to 1e-3 of the smaller triangle's height, so that small
 *                       triangles do not touch their neighbours' neighbours
 */
int rad_triangles_touch(const struct rad_triangle *a, const struct rad_triangle *b,
                        double tolerance);

/**
 * Find the triangles that touch other than in a vertex or a whole edge.
 *
 * Cost n log n, and the number of triangles whose bounding boxes overlap (box_pairs.h).
 *
 * @param[in]  number    [n_triangle] deck numbers; of neighbours with the same one only the first
 *                       is looked at
 * @param[out] contacts  pairs of scene triangles, the lower number first
 * @return RAD_OK, or RAD_ESYSTEM when out of memory
 */
enum rad_code rad_find_contacts(const struct rad_scene *scene, const int *number,
                                struct rad_contacts *contacts, struct rad_error *e);

#endif
