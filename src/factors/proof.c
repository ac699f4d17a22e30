#include "factors/proof.h"

#include <math.h>

#include "factors/exchange.h"
#include "factors/hull2.h"

#define COVERED 1e-11 /* share of a crossing that rounding may leave open */
#define LITTLE 0.5    /* share left open below which it is worth a bound */
#define ROUGH 1e-2    /* goal of what only bounds */
enum { MOST_BLOCKERS = 3 /* that are taken away one by one */ };

/* The plane of some blockers, with coordinates. */
struct crossing {
  double origin[3], u[3], v[3];
  struct rad_polygon hull;
};

static void set_plane(const struct rad_pair *p, const struct rad_occluder *k, struct crossing *x) {
  const struct rad_occluders *o = &p->g->visibility->occluders;
  memcpy(x->origin, o->scene->vertex[o->corner[k->first]], sizeof x->origin);
  memcpy(x->u, o->inward[k->first], sizeof x->u);
  rad_cross(k->normal, x->u, x->v);
}

/* The crossing; 0 if the plane does not part cell and target, -1: it does, the other way round. */
static int cross(const struct rad_pair *p, const struct rad_flat *cell,
                 const struct rad_occluder *k, struct crossing *x) {
  const struct rad_flat *t = &p->face;
  double of_cell[3], of_target[4], r[3], at[3 * 4][2];
  double zero = 1e-12 * p->size, sign = 0;
  set_plane(p, k, x);
  for (int c = 0; c < 3; c++) {
    rad_sub(cell->corner[c], x->origin, r);
    of_cell[c] = rad_dot(k->normal, r);
    sign = fabs(of_cell[c]) > fabs(sign) ? of_cell[c] : sign;
  }
  for (int c = 0; c < t->n; c++) {
    rad_sub(t->corner[c], x->origin, r);
    of_target[c] = rad_dot(k->normal, r);
    if (of_target[c] * sign > zero * fabs(sign))
      return 0;
  }
  int n = 0;
  for (int c = 0; c < 3; c++)
    for (int m = 0; m < t->n; m++) {
      if (of_cell[c] * sign < -zero * fabs(sign))
        return 0;
      double a = fmax(0, of_cell[c] * (sign > 0 ? 1 : -1));
      double b = fmax(0, of_target[m] * (sign > 0 ? -1 : 1));
      if (!(a + b > zero))
        continue; /* along the plane: seen from a line only */
      double y[3];
      rad_between(cell->corner[c], t->corner[m], a / (a + b), y);
      rad_sub(y, x->origin, r);
      at[n][0] = rad_dot(x->u, r);
      at[n++][1] = rad_dot(x->v, r);
    }
  if (n < 3)
    return 0;
  rad_hull2(n, at, &x->hull);
  return sign > 0 ? 1 : -1;
}

/* The inside of a blocker in the plane's coordinates. */
static void inside(const struct rad_pair *p, const struct rad_occluder *k, const struct crossing *x,
                   struct rad_half_planes *h) {
  const struct rad_occluders *o = &p->g->visibility->occluders;
  h->n = k->n;
  for (int s = 0; s < k->n; s++) {
    const double *in = o->inward[k->first + s];
    double r[3];
    rad_sub(x->origin, o->scene->vertex[o->corner[k->first + s]], r);
    h->c[s][0] = rad_dot(in, r);
    h->c[s][1] = rad_dot(in, x->u);
    h->c[s][2] = rad_dot(in, x->v);
  }
}

/* What the cell sends through the open parts of a crossing, at most. */
static double through(const struct rad_pair *p, const struct rad_flat *cell,
                      const struct crossing *x, const double normal[3], double sign) {
  double sum = 0;
  for (int k = 0; k < p->parts.n; k++) {
    const struct rad_polygon *part = &p->parts.part[k];
    struct rad_flat f = {.n = part->n};
    double error;
    for (int d = 0; d < 3; d++)
      f.normal[d] = sign * normal[d];
    for (int c = 0; c < f.n; c++)
      for (int d = 0; d < 3; d++)
        f.corner[c][d] = x->origin[d] + part->corner[c][0] * x->u[d] + part->corner[c][1] * x->v[d];
    rad_flat_orient(&f);
    sum += rad_exchange(&p->g->gauss, cell, &f, ROUGH, &error);
    sum += error;
  }
  return sum;
}

/* One plane of blockers, that of list[first]; see rad_proof_range. */
static int by_plane(struct rad_pair *p, const struct rad_flat *cell, int n, const int *list,
                    int first, struct rad_range *range) {
  const struct rad_occluder *all = p->g->visibility->occluders.occluder;
  const struct rad_occluder *k = &all[p->blocker[list[first]]];
  struct crossing x;
  int sign = cross(p, cell, k, &x), m = 0;
  double area = sign ? rad_polygon_area(&x.hull) : 0;
  if (!(area > 0))
    return 0;
  for (int i = first; i < n; i++)
    if (all[p->blocker[list[i]]].plane == k->plane)
      inside(p, &all[p->blocker[list[i]]], &x, &p->shadow[m++]);
  switch ((int)rad_visible(&x.hull, m, p->shadow, &p->parts)) {
  case -1:
    return -1;
  case RAD_HIDDEN:
    return 1;
  case RAD_FREE:
    return 0;
  default:;
  }
  double open = rad_parts_area(&p->parts) / area;
  if (open <= COVERED)
    return 1;
  if (open < LITTLE)
    range->high = fmin(range->high, through(p, cell, &x, k->normal, sign));
  return 0;
}

/* What the cell sends to a blocker, at most; INFINITY if it is on both sides of its plane. */
static double taken(const struct rad_pair *p, const struct rad_flat *cell,
                    const struct rad_occluder *k) {
  const struct rad_occluders *o = &p->g->visibility->occluders;
  struct rad_flat f = {.n = k->n};
  double above = 0, below = 0, error, r[3];
  for (int c = 0; c < k->n; c++)
    memcpy(f.corner[c], o->scene->vertex[o->corner[k->first + c]], sizeof f.corner[c]);
  for (int c = 0; c < 3; c++) {
    rad_sub(cell->corner[c], f.corner[0], r);
    double h = rad_dot(k->normal, r);
    above = fmax(above, h);
    below = fmax(below, -h);
  }
  if (above > 1e-12 * p->size && below > 1e-12 * p->size)
    return INFINITY;
  for (int d = 0; d < 3; d++)
    f.normal[d] = above > below ? k->normal[d] : -k->normal[d];
  rad_flat_orient(&f);
  rad_flat_clip(&f, cell->corner[0], cell->normal, 1e-12 * p->size);
  if (f.n < 3)
    return 0;
  double value = rad_exchange(&p->g->gauss, cell, &f, ROUGH, &error);
  return value + error;
}

int rad_proof_range(struct rad_pair *p, const struct rad_flat *cell, int n, const int *list,
                    const double all[2], struct rad_range *range) {
  const struct rad_occluder *occluder = p->g->visibility->occluders.occluder;
  *range = (struct rad_range){0, all[0] + all[1]};
  for (int i = 0; i < n; i++) {
    int before = 0;
    while (before < i &&
           occluder[p->blocker[list[before]]].plane != occluder[p->blocker[list[i]]].plane)
      before++;
    if (before < i)
      continue;
    int hidden = by_plane(p, cell, n, list, i, range);
    if (hidden)
      return hidden;
  }
  if (n > MOST_BLOCKERS)
    return 0;
  double low = all[0] - all[1];
  for (int i = 0; i < n; i++)
    low -= taken(p, cell, &occluder[p->blocker[list[i]]]);
  range->low = fmax(0, low);
  return 0;
}
