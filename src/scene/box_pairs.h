/* Boxes that overlap. */
#ifndef RAD_SCENE_BOX_PAIRS_H
#define RAD_SCENE_BOX_PAIRS_H

#include "base/error.h"

struct rad_box {
  double low[3], high[3];
  int item; /* the caller's */
};

/**
 * Call `found` for every two boxes that overlap or touch, once and in no particular order.
 *
 * A balanced tree over the boxes in Morton order, against itself: n log n, and the number of pairs.
 *
 * @param[in] box      [n] finite
 * @param[in] found    called with the boxes' items
 * @param[in] context  handed on
 * @return RAD_OK, or RAD_ESYSTEM when out of memory
 */
enum rad_code rad_box_pairs(int n, const struct rad_box *box,
                            void (*found)(void *context, int item, int other), void *context,
                            struct rad_error *e);

#endif
