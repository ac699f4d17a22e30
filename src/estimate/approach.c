#include "estimate/approach.h"

#include <stdlib.h>

#include "base/memory.h"

enum { MOST_PASSES = 60 }; /* each halves an element, or cuts a graded one to a fifth */

/* Parts of features whose feet matter, walked again in another mesh. */
static int walk_again(const struct rad_feet *feet, double least, const struct rad_mesh *mesh,
                      struct rad_feet *now) {
  int done = 1;
  now->n_foot = 0;
  for (int i = 0; i < feet->n_foot && done; i++)
    if (feet->foot[i].effect > least)
      done = rad_feet_walk(mesh, feet->foot[i].feature, feet->foot[i].from, feet->foot[i].to, now);
  return done;
}

/* What the feet want of the leaves; returns whether there is any. */
static int ask(const struct rad_mesh *mesh, const struct rad_feet *feet,
               struct rad_refinement *what) {
  int any = 0;
  for (int i = 0; i < feet->n_foot; i++) {
    const struct rad_foot *f = &feet->foot[i];
    int in_phi, in_r;
    rad_unresolved(mesh, f->element, f->phi, f->r, f->width, feet->feature[f->feature].across,
                   &in_phi, &in_r);
    what[f->element].split_phi |= in_phi;
    what[f->element].split_r |= in_r;
    any = 1;
  }
  return any;
}

/* One split of the leaves with feet; origins stay those of the mesh before. */
static enum rad_code split(const struct rad_mesh *mesh, const struct rad_feet *feet,
                           struct rad_layout *l, int *any, struct rad_error *e) {
  size_t n = (size_t)l->n_leaf;
  struct rad_refinement *what = rad_calloc(n, sizeof *what);
  int *origin = rad_alloc(n, sizeof(int));
  enum rad_code code = RAD_OK;
  if (!what || !origin)
    code = rad_fail_memory(e, "the refinement", 20.0 * (double)n);
  for (size_t i = 0; i < n && !code; i++) {
    what[i] = (struct rad_refinement){.k_phi = l->leaf[i].k_phi, .k_r = l->leaf[i].k_r};
    origin[i] = l->leaf[i].origin;
  }
  if (!code && (*any = ask(mesh, feet, what))) {
    code = rad_layout_refine(l, what, e);
    for (int i = 0; i < l->n_leaf && !code; i++)
      if (l->leaf[i].origin >= 0)
        l->leaf[i].origin = origin[l->leaf[i].origin];
  }
  free(what);
  free(origin);
  return code;
}

enum rad_code rad_approach(const struct rad_feet *feet, double least, struct rad_layout *l,
                           struct rad_error *e) {
  struct rad_feet now = {
      .feature = feet->feature, .n_feature = feet->n_feature, .room_feature = feet->room_feature};
  enum rad_code code = RAD_OK;
  int any = 1;
  for (int i = 0; i < MOST_PASSES && any && !code; i++) {
    struct rad_mesh mesh;
    code = rad_layout_mesh(l, &mesh, e);
    if (!code && !walk_again(feet, least, &mesh, &now))
      code = rad_fail_memory(e, "the refinement", 200.0 * now.n_foot);
    if (!code)
      code = split(&mesh, &now, l, &any, e);
    rad_mesh_free(&mesh);
  }
  free(now.foot);
  return code;
}
