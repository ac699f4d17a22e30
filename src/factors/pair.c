#include "factors/pair.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "visibility/facing.h"

static void set_face(struct rad_pair *p) {
  struct rad_flat *f = &p->face;
  f->n = p->front.n;
  memcpy(f->normal, p->t->normal, sizeof f->normal);
  for (int c = 0; c < f->n; c++) {
    const double *b = p->front.corner[c], lambda[3] = {1 - b[0] - b[1], b[0], b[1]};
    rad_at_lambda(p->t->v, lambda, f->corner[c]);
  }
  rad_flat_orient(f);
}

static void set_size(struct rad_pair *p) {
  double most = 0;
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      most = fmax(most, fmax(rad_distance2(p->s->v[a], p->t->v[b]),
                             fmax(rad_distance2(p->s->v[a], p->s->v[b]),
                                  rad_distance2(p->t->v[a], p->t->v[b]))));
  p->size = sqrt(most);
}

static int set_blockers(struct rad_pair *p) {
  const struct rad_visibility *v = p->g->visibility;
  if (!p->list && !(p->list = rad_alloc((size_t)v->occluders.n, sizeof *p->list)))
    return -1;
  p->blocker = rad_blockers(v, p->source, p->target, p->list, &p->n_blocker);
  size_t n = (size_t)p->n_blocker;
  if (!rad_reserve((void **)&p->frame, n, &p->frame_room, sizeof *p->frame) ||
      !rad_reserve((void **)&p->shadow, n, &p->shadow_room, sizeof *p->shadow))
    return -1;
  for (int k = 0; k < p->n_blocker; k++)
    rad_shadow_frame_set(&v->occluders, p->source, p->target, p->blocker[k], &p->frame[k]);
  return 0;
}

int rad_pair_set_unobstructed(const struct rad_pair_engine *g, int source, int target,
                              struct rad_pair *p) {
  double h[3];
  p->g = g;
  p->source = source;
  p->target = target;
  p->s = &g->scene->triangle[source];
  p->t = &g->scene->triangle[target];
  p->n_blocker = 0;
  rad_heights(p->s, p->t, h);
  p->front = (struct rad_polygon){.n = 3, .corner = {{0, 0}, {1, 0}, {0, 1}}};
  rad_clip(&p->front, h[0], h[1] - h[0], h[2] - h[0]);
  if (p->front.n < 3)
    return 0;
  set_face(p);
  set_size(p);
  return 1;
}

int rad_pair_set(const struct rad_pair_engine *g, int source, int target, struct rad_pair *p) {
  unsigned char sight =
      g->visibility->sight[(size_t)source * (size_t)g->scene->n_triangle + (size_t)target];
  if (sight == RAD_HIDDEN || !rad_pair_set_unobstructed(g, source, target, p))
    return 0;
  return sight == RAD_PARTLY && set_blockers(p) ? -1 : 1;
}

void rad_pair_free(struct rad_pair *p) {
  free(p->frame);
  free(p->list);
  free(p->shadow);
  rad_parts_free(&p->parts);
  *p = (struct rad_pair){0};
}

void rad_pair_front(const struct rad_pair *p, const double corner[3][3], struct rad_polygon *part) {
  double h[3];
  rad_heights(p->t, p->s, h);
  *part = (struct rad_polygon){.n = 3};
  for (int c = 0; c < 3; c++) {
    part->corner[c][0] = corner[c][1];
    part->corner[c][1] = corner[c][2];
  }
  rad_clip(part, h[0], h[1] - h[0], h[2] - h[0]);
}

/* Lambert's form of a part of the target. */
static double part_factor(const struct rad_pair *p, const struct rad_polygon *part,
                          const double y[3]) {
  struct rad_flat f = {.n = part->n};
  for (int c = 0; c < part->n; c++) {
    const double *b = part->corner[c], lambda[3] = {1 - b[0] - b[1], b[0], b[1]};
    rad_at_lambda(p->t->v, lambda, f.corner[c]);
  }
  return rad_flat_factor(y, p->s->normal, &f);
}

double rad_pair_seen(struct rad_pair *p, int n, const int *list, const double lambda[3]) {
  int base = lambda[1] > lambda[0] ? 1 : 0, m = 0;
  base = lambda[2] > lambda[base] ? 2 : base;
  const double mu[2] = {lambda[(base + 1) % 3], lambda[(base + 2) % 3]}, zero[2] = {0, 0};
  const double along_x[2] = {1, 0}, along_y[2] = {0, 1};
  double y[3], sum = 0;
  rad_at_lambda(p->s->v, lambda, y);
  for (int k = 0; k < n; k++) {
    struct rad_shadow shadow;
    rad_shadow_cast(&p->frame[list[k]], base, mu, &shadow);
    if (shadow.n)
      rad_half_planes_set(&shadow, 0, zero, along_x, along_y, &p->shadow[m++]);
  }
  if (m == 0)
    return rad_flat_factor(y, p->s->normal, &p->face);
  switch ((int)rad_visible(&p->front, m, p->shadow, &p->parts)) {
  case -1:
    return -1;
  case RAD_HIDDEN:
    return 0;
  case RAD_FREE:
    return rad_flat_factor(y, p->s->normal, &p->face);
  default:
    for (int k = 0; k < p->parts.n; k++)
      sum += part_factor(p, &p->parts.part[k], y);
    return sum;
  }
}
