/* Disjoint sets of numbers: parent [n], at first parent[i] == i. */
#ifndef RAD_BASE_UNION_FIND_H
#define RAD_BASE_UNION_FIND_H

/* The number that stands for the set of i; paths become shorter on the way. */
static inline int rad_find_root(int *parent, int i) {
  while (parent[i] != i)
    i = parent[i] = parent[parent[i]];
  return i;
}

/* Join the sets of i and j; the least number stands for both. */
static inline void rad_unite(int *parent, int i, int j) {
  int a = rad_find_root(parent, i), b = rad_find_root(parent, j);
  parent[a > b ? a : b] = a > b ? b : a;
}

#endif
