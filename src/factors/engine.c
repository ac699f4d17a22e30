#include "factors/engine.h"

#include <stdlib.h>

#include "base/memory.h"
#include "factors/body.h"
#include "scene/edge.h"

/* Sides with the same two vertices, in a ring: one that three polygons share has three twins. */
static void find_twins(int n, const struct rad_edge *side, int *twin) {
  for (int first = 0, last; first < n; first = last) {
    last = rad_edges_end(n, side, first);
    for (int k = first; k < last; k++)
      twin[side[k].number] = last - first == 1 ? -1 : side[k + 1 < last ? k + 1 : first].number;
  }
}

enum rad_code rad_pair_engine_init(const struct rad_scene *scene, struct rad_pair_engine *g,
                                   struct rad_error *e) {
  const struct rad_occluders *o = &scene->visibility->occluders;
  int n = o->n ? o->occluder[o->n - 1].first + o->occluder[o->n - 1].n : 0;
  *g = (struct rad_pair_engine){.scene = scene, .visibility = scene->visibility};
  enum rad_code code = rad_gauss_init(&g->gauss, e);
  if (code)
    return code;
  struct rad_edge *side = rad_alloc((size_t)n, sizeof *side);
  g->twin = rad_alloc((size_t)n, sizeof *g->twin);
  g->owner = rad_alloc((size_t)n, sizeof *g->owner);
  g->body = rad_alloc((size_t)o->n, sizeof *g->body);
  if (!side || !g->twin || !g->owner || !g->body)
    code = rad_fail_memory(e, "the edges of what casts shadows", 20.0 * n);
  for (int k = 0; k < o->n && !code; k++)
    for (int c = 0; c < o->occluder[k].n; c++) {
      int at = o->occluder[k].first + c;
      int p = o->corner[at], q = o->corner[o->occluder[k].first + (c + 1) % o->occluder[k].n];
      g->owner[at] = k;
      side[at] = rad_edge_of(p, q, at);
    }
  if (!code) {
    rad_edges_sort(n, side);
    find_twins(n, side, g->twin);
    if (rad_bodies_find(o, g->twin, g->owner, g->body))
      code = rad_fail_memory(e, "the edges of what casts shadows", 8.0 * o->n);
  }
  free(side);
  return code;
}

void rad_pair_engine_free(struct rad_pair_engine *g) {
  rad_gauss_free(&g->gauss);
  free(g->twin);
  free(g->owner);
  free(g->body);
  *g = (struct rad_pair_engine){0};
}
