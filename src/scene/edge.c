#include "scene/edge.h"

#include <stdlib.h>

static int compare(const void *a, const void *b) {
  const struct rad_edge *x = a, *y = b;
  if (x->low != y->low)
    return x->low < y->low ? -1 : 1;
  if (x->high != y->high)
    return x->high < y->high ? -1 : 1;
  return (x->number > y->number) - (x->number < y->number);
}

void rad_edges_sort(int n, struct rad_edge *edge) {
  qsort(edge, (size_t)n, sizeof *edge, compare);
}

int rad_edges_end(int n, const struct rad_edge *edge, int first) {
  int last = first + 1;
  while (last < n && edge[last].low == edge[first].low && edge[last].high == edge[first].high)
    last++;
  return last;
}
