#include "visibility/bvh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum { LEAF = 2 }; /* items at most */

static double center(const struct rad_box *box, int axis) {
  return box->low[axis] + box->high[axis]; /* twice */
}

/* Order item[0..n) such that no center of the first n_first is greater than one of the rest
 * (Hoare 1961). */
static void select_first(int *item, int n, int n_first, const struct rad_box *box, int axis) {
  int low = 0, high = n - 1;
  while (low < high) {
    double pivot = center(&box[item[low + (high - low) / 2]], axis);
    int a = low, b = high;
    while (a <= b) {
      while (center(&box[item[a]], axis) < pivot)
        a++;
      while (center(&box[item[b]], axis) > pivot)
        b--;
      if (a <= b) {
        int kept = item[a];
        item[a++] = item[b];
        item[b--] = kept;
      }
    }
    if (n_first <= b)
      high = b;
    else if (n_first >= a)
      low = a;
    else
      return;
  }
}

/* The node's box, and the axis along which its items' centers spread most. */
static int bound(struct rad_bvh_node *node, const int *item, int n, const struct rad_box *box) {
  int widest = 0;
  double width = -1;
  for (int d = 0; d < 3; d++) {
    double low = INFINITY, high = -INFINITY, first = INFINITY, last = -INFINITY;
    for (int k = 0; k < n; k++) {
      low = fmin(low, box[item[k]].low[d]);
      high = fmax(high, box[item[k]].high[d]);
      first = fmin(first, center(&box[item[k]], d));
      last = fmax(last, center(&box[item[k]], d));
    }
    node->box.low[d] = low;
    node->box.high[d] = high;
    if (last - first > width) {
      width = last - first;
      widest = d;
    }
  }
  return widest;
}

static void split(struct rad_bvh *bvh, int at, int first, int n, const struct rad_box *box) {
  struct rad_bvh_node *node = &bvh->node[at];
  int axis = bound(node, bvh->item + first, n, box);
  node->first = first;
  node->n = n;
  if (n <= LEAF)
    return;
  int half = n / 2;
  select_first(bvh->item + first, n, half, box, axis);
  node->n = 0;
  int child = node->first = bvh->n_node;
  bvh->n_node += 2;
  split(bvh, child, first, half, box);
  split(bvh, child + 1, first + half, n - half, box);
}

struct rad_bvh *rad_bvh_build(int n_item, const int *item, const struct rad_box *box) {
  struct rad_bvh *bvh = rad_calloc(1, sizeof *bvh);
  if (!bvh)
    return NULL;
  bvh->node = rad_alloc(2 * (size_t)n_item + 1, sizeof *bvh->node);
  bvh->item = rad_alloc((size_t)n_item, sizeof *bvh->item);
  if (!bvh->node || !bvh->item) {
    rad_bvh_free(bvh);
    return NULL;
  }
  if (n_item > 0) {
    memcpy(bvh->item, item, (size_t)n_item * sizeof *item);
    bvh->n_node = 1;
    split(bvh, 0, 0, n_item, box);
  }
  return bvh;
}

void rad_bvh_free(struct rad_bvh *bvh) {
  if (!bvh)
    return;
  free(bvh->node);
  free(bvh->item);
  free(bvh);
}
