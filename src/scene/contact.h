/* How two triangles meet, if not in a vertex or a whole edge. */
#ifndef RAD_SCENE_CONTACT_H
#define RAD_SCENE_CONTACT_H

#include "scene/scene.h"

enum rad_contact {
  RAD_APART,        /* or no more than a vertex or a whole edge in common */
  RAD_BACK_TO_BACK, /* one plane, overlapping, facing opposite ways: a slit, or a wall */
  RAD_TOUCHING,     /* one ends in, or stands on, the other, or on its edge */
  RAD_CROSSING,     /* one goes through the other */
  RAD_OVERLAPPING   /* one plane, facing the same way: the common area would count twice */
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
 * How triangles a and b meet: by intersect.h, then rad_triangles_touch.
 *
 * Faces of one plane that face opposite ways are back to back unless one is in front of the other
 * by more than 1e-12 of the larger and more than rounding: then they see each other through a gap,
 * and touch.
 *
 * @param[in] two_sided  1: one of them radiates on both sides
 * @param[in] tolerance  [m]; lowered as above, but not below the rounding of the coordinates
 */
enum rad_contact rad_contact_of(const struct rad_triangle *a, const struct rad_triangle *b,
                                int two_sided, double tolerance);

/**
 * Find all pairs of triangles that meet other than in a vertex or a whole edge.
 *
 * Closer than 1e-9 of the scene's size, or than the rounding of its coordinates, is meeting. Cost
 * n log n, and the number of triangles whose bounding boxes overlap (box_pairs.h).
 *
 * @param[in] number  [n_triangle] deck numbers; neighbours with the same one are one triangle that
 *                    radiates on both sides, the first of which is handed on
 * @param[in] found   called for every pair but RAD_APART, low < high, once and in no order
 * @return RAD_OK, or RAD_ESYSTEM when out of memory
 */
enum rad_code rad_find_contacts(const struct rad_scene *scene, const int *number,
                                void (*found)(void *context, int low, int high,
                                              enum rad_contact kind),
                                void *context, struct rad_error *e);

#endif
