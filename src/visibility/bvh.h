/* Bounding volume hierarchy: boxes of boxes. */
#ifndef RAD_VISIBILITY_BVH_H
#define RAD_VISIBILITY_BVH_H

struct rad_box {
  double low[3], high[3];
};

/* A leaf holds items first .. first + n - 1 of rad_bvh.item; an inner node has n = 0 and the
 * children first and first + 1. */
struct rad_bvh_node {
  struct rad_box box;
  int first, n;
};

enum { RAD_BVH_DEPTH = 64 }; /* room for the nodes that a walk has put off: one a level */

struct rad_bvh {
  int n_node;                /* 0: empty; the root is node 0 */
  struct rad_bvh_node *node; /* owned [n_node] */
  int *item;                 /* owned [n_item] */
};

/**
 * Split at the median along the longest axis of the centers, down to a few items.
 *
 * @param[in] item  [n_item] numbers in box, any order
 * @param[in] box   boxes by item number
 * @return owned, to be freed with rad_bvh_free; NULL without memory. Cost n log n.
 */
struct rad_bvh *rad_bvh_build(int n_item, const int *item, const struct rad_box *box);
void rad_bvh_free(struct rad_bvh *bvh); /* NULL is fine */

#endif
