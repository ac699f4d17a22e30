#include "estimate/stage.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum rad_code rad_stage_take(const struct rad_layout *l, struct rad_stage *s, struct rad_error *e) {
  size_t n = (size_t)l->n_leaf;
  s->n_leaf = l->n_leaf;
  s->n_weight = l->scene->n_triangle * l->scene->n_band;
  s->leaf = rad_alloc(n, sizeof *s->leaf);
  if (!s->leaf)
    return rad_fail_memory(e, "the adaptive mesh", (double)n * sizeof *s->leaf);
  memcpy(s->leaf, l->leaf, n * sizeof *s->leaf);
  return RAD_OK;
}

void rad_stage_free(struct rad_stage *s) {
  free(s->leaf);
  free(s->least_weight);
  *s = (struct rad_stage){0};
}

static int is_range(const double x[2]) {
  return x[0] >= 0 && x[0] < x[1] && x[1] <= 1;
}

static int is_leaf(const struct rad_leaf *f, int n_patch) {
  return f->patch >= 0 && f->patch < n_patch && is_range(f->phi) && is_range(f->r) &&
         f->k_phi >= 1 && f->k_phi <= RAD_MAX_POINTS_1D && f->k_r >= 1 &&
         f->k_r <= RAD_MAX_POINTS_1D;
}

/* Each patch has its leaves one after another, and they have the area of the patch. */
static int cover(const struct rad_stage *s, int n_patch) {
  int i = 0;
  for (int p = 0; p < n_patch; p++) {
    double area = 0;
    for (; i < s->n_leaf && is_leaf(&s->leaf[i], n_patch) && s->leaf[i].patch == p; i++)
      area += (s->leaf[i].phi[1] - s->leaf[i].phi[0]) * (s->leaf[i].r[1] - s->leaf[i].r[0]);
    if (!(fabs(area - 1) < 1e-9))
      return 0;
  }
  return i == s->n_leaf;
}

enum rad_code rad_stage_restore(const struct rad_stage *s, struct rad_layout *l,
                                struct rad_error *e) {
  if (!cover(s, l->n_patch) ||
      (s->least_weight && s->n_weight != l->scene->n_triangle * l->scene->n_band))
    return rad_fail(e, RAD_EINPUT,
                    "the mesh in the checkpoint is not one of this scene; begin without --restart");
  struct rad_leaf *leaf = rad_alloc((size_t)s->n_leaf, sizeof *leaf);
  if (!leaf)
    return rad_fail_memory(e, "the adaptive mesh", (double)s->n_leaf * sizeof *leaf);
  for (int i = 0; i < s->n_leaf; i++) {
    leaf[i] = s->leaf[i];
    leaf[i].origin = -1;
  }
  free(l->leaf);
  l->leaf = leaf;
  l->n_leaf = l->room = s->n_leaf;
  return RAD_OK;
}
