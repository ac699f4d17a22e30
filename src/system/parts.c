#include "system/parts.h"

#include <stddef.h>

static int find(int *parent, int i) {
  while (parent[i] != i)
    i = parent[i] = parent[parent[i]];
  return i;
}

int rad_find_parts(const struct rad_operator *k, int *part) {
  int n = k->mesh->scene->n_triangle, count = 0;
  for (int i = 0; i < n; i++)
    part[i] = i;
  for (int i = 0; i < n; i++)
    for (int j = 0; j < i; j++)
      if (k->sees[(size_t)i * n + j]) {
        int a = find(part, i), b = find(part, j);
        part[a > b ? a : b] = a > b ? b : a; /* roots are the least of their part */
      }
  for (int i = 0; i < n; i++)
    part[i] = find(part, i);
  for (int i = 0; i < n; i++)
    part[i] = part[i] == i ? count++ : part[part[i]];
  return count;
}
