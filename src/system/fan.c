#include "system/fan.h"

#include <stdlib.h>

#include "base/memory.h"

/* An element while its patch is sorted. */
struct ring {
  double tau[2];
  int k_r, element;
};

static int by_ring(const void *left, const void *right) {
  const struct ring *a = left, *b = right;
  for (int i = 0; i < 2; i++)
    if (a->tau[i] != b->tau[i])
      return a->tau[i] < b->tau[i] ? -1 : 1;
  return a->k_r != b->k_r ? a->k_r - b->k_r : a->element - b->element;
}

static int same_ring(const struct ring *a, const struct ring *b) {
  return a->tau[0] == b->tau[0] && a->tau[1] == b->tau[1] && a->k_r == b->k_r;
}

/* Width at its outer side, and length of its shorter ray, over the unknowns of a leaf of them. */
static int is_thin(const struct rad_mesh *mesh, const struct rad_element *e, int leaf) {
  const struct rad_patch *p = &mesh->patch[e->patch];
  double t[2], least = INFINITY, r0 = rad_graded(e->tau[0], e->p_r);
  double r1 = rad_graded(e->tau[1], e->p_r);
  for (int i = 0; i < 2; i++) {
    t[i] = rad_angle_t(p->angle, rad_graded(e->sigma[i], e->p_phi));
    least = fmin(least, hypot(p->a1 + t[i] * p->b1, t[i] * p->b2));
  }
  double width = r1 * hypot(p->b1, p->b2) * (t[1] - t[0]);
  return width * leaf <= (r1 - r0) * least * e->n_function;
}

/* Elements from .. to of the sorted list lie between the same values of tau. */
static int is_fan(const struct rad_mesh *mesh, const struct ring *from, const struct ring *to,
                  int leaf) {
  int n = 0, thin = 1;
  for (const struct ring *at = from; at < to && thin; at++) {
    const struct rad_element *e = &mesh->element[at->element];
    n += e->n_function;
    thin = !e->fold && is_thin(mesh, e, leaf);
  }
  return thin && n > leaf;
}

int rad_fans_find(const struct rad_mesh *mesh, int leaf, int *fan) {
  struct ring *ring = rad_alloc((size_t)mesh->n_element, sizeof *ring);
  int n_fan = 0;
  for (int p = 0; p < mesh->n_patch && ring; p++) {
    int first = mesh->element_first[p], n = mesh->element_first[p + 1] - first;
    for (int i = 0; i < n; i++) {
      const struct rad_element *e = &mesh->element[first + i];
      ring[i] = (struct ring){{e->tau[0], e->tau[1]}, e->k_r, first + i};
    }
    qsort(ring, (size_t)n, sizeof *ring, by_ring);
    for (int from = 0, to; from < n; from = to) {
      for (to = from + 1; to < n && same_ring(&ring[from], &ring[to]);)
        to++;
      int number = is_fan(mesh, ring + from, ring + to, leaf) ? n_fan++ : -1;
      for (int i = from; i < to; i++)
        fan[ring[i].element] = number;
    }
  }
  free(ring);
  return ring != NULL;
}
