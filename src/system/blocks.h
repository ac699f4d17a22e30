/* The matrix as blocks of clusters: far ones to be interpolated, near ones to be integrated. */
#ifndef RAD_SYSTEM_BLOCKS_H
#define RAD_SYSTEM_BLOCKS_H

#include <stddef.h>

#include "system/cluster.h"

/* Sources of each target cluster: those of cluster t are source[first[t]] .. source[first[t + 1]].
 */
struct rad_block_list {
  size_t *first; /* owned [n_cluster + 2], the last unused */
  int *source;   /* owned; ascending for each target */
};

/**
 * Every pair of points and elements that exchange light is in exactly one block.
 *
 * far: two clusters that see all of one another and whose rectangles are 0.7 of the wider one
 * apart (theory 14.1); sector: what a cluster of one fan receives from a leaf that is 0.7 of the
 * length of its lines away from each (theory 14.10); near: all other pairs of leaves. Hidden pairs
 * are in none.
 */
struct rad_blocks {
  struct rad_block_list far, near, sector;
  double near_entries, sector_entries; /* of all these blocks together */
};

/**
 * @param[in]  places on a line of a sector; 0: no sector blocks
 * @param[in]  least  distance below which nothing is far, for the sake of rounding [m]
 * @param[out] blocks to be freed with rad_blocks_free, also after an error
 * In parallel over triangles; the same for any number of threads.
 */
enum rad_code rad_blocks_build(const struct rad_tree *tree, int places, double least,
                               struct rad_blocks *blocks, struct rad_error *e);
void rad_blocks_free(struct rad_blocks *blocks); /* safe twice */

#endif
