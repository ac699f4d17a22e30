/* Cluster trees: the elements of each triangle, with their points, halved again and again. */
#ifndef RAD_SYSTEM_CLUSTER_H
#define RAD_SYSTEM_CLUSTER_H

#include <stddef.h>

#include "mesh/mesh.h"
#include "visibility/clip.h"

enum { RAD_LEAF = 64 }; /* unknowns of a leaf of the hierarchical matrix */

/* A triangle's frame: y = origin + y0 axis[0] + y1 axis[1], axis[2] the radiating normal. */
struct rad_plane {
  double origin[3], axis[3][3];
};

struct rad_cluster {
  int triangle, level;
  int parent;             /* -1: a triangle's root */
  int child;              /* first of two consecutive ones, or -1 */
  int first, n;           /* unknowns, in the tree's order */
  int element, n_element; /* in the tree's order */
  double low[2], high[2]; /* rectangle around its elements, in the triangle's frame [m] */
  double area;            /* of its elements [m2] */
  int sector;             /* its elements are of one fan (fan.h) */
};

/**
 * Clusters by level, roots first, children of a parent together. Unknowns of a cluster follow one
 * another in the tree's order, element by element.
 */
struct rad_tree {
  const struct rad_mesh *mesh; /* borrowed */
  int n_cluster, n_level, leaf;
  struct rad_cluster *cluster; /* owned [n_cluster]; the root of triangle t is number t */
  int *level_first;            /* owned [n_level + 1] */
  int *element;                /* owned [n_element] elements in the tree's order */
  int *unknown;                /* owned [n_point] unknowns in the tree's order */
  struct rad_plane *plane;     /* owned [n_triangle] */
};

/**
 * @param[in]  leaf  most unknowns of a leaf, or one element if that has more
 * @param[out] tree  to be freed with rad_tree_free, also after an error
 * Cost n_element log n_element.
 */
enum rad_code rad_tree_build(const struct rad_mesh *mesh, int leaf, struct rad_tree *tree,
                             struct rad_error *e);
void rad_tree_free(struct rad_tree *tree); /* safe twice */

/* Unknowns of the largest leaf; *element: k_phi k_r + k_r of the largest element. */
size_t rad_tree_most(const struct rad_tree *tree, size_t *element);

/* The part of a cluster's triangle in its rectangle, in the triangle's frame; n = 0 is none. */
void rad_cluster_polygon(const struct rad_tree *tree, int cluster, struct rad_polygon *polygon);

/* Length of the rectangle's diagonal [m]. */
static inline double rad_cluster_diameter(const struct rad_cluster *c) {
  return hypot(c->high[0] - c->low[0], c->high[1] - c->low[1]);
}

/* A rectangle in space, or a line: center and half axes in the plane of a triangle [m]. */
struct rad_box {
  double center[3], half[2][3];
  const struct rad_plane *plane; /* borrowed */
};

/* The rectangle of a cluster. */
void rad_cluster_box(const struct rad_tree *tree, const struct rad_cluster *c, struct rad_box *box);

/* A lower bound of the distance of two rectangles, mostly sharp [m]; the same of two clusters'. */
double rad_box_distance(const struct rad_box *a, const struct rad_box *b);
double rad_cluster_distance(const struct rad_tree *tree, const struct rad_cluster *a,
                            const struct rad_cluster *b);

/* Rectangle around an element, in its triangle's frame [m]; its area [m2]. */
void rad_element_box(const struct rad_tree *tree, int element, double low[2], double high[2]);
double rad_element_area(const struct rad_mesh *mesh, int element);

#endif
