#include "system/parts.h"

#include <stddef.h>

#include "base/union_find.h"

int rad_find_parts(const struct rad_operator *k, int *part) {
  int n = k->mesh->scene->n_triangle, count = 0;
  for (int i = 0; i < n; i++)
    part[i] = i;
  for (int i = 0; i < n; i++)
    for (int j = 0; j < i; j++)
      if (k->sees[(size_t)i * n + j])
        rad_unite(part, i, j);
  for (int i = 0; i < n; i++)
    part[i] = rad_find_root(part, i);
  for (int i = 0; i < n; i++)
    part[i] = part[i] == i ? count++ : part[part[i]];
  return count;
}
