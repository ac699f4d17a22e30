#include "integrate/classes.h"

enum { MOST = 400 }; /* points: with more the near integrator is cheaper */

/* Distances at which the rules of an element suffice (theory 3.5): its longest segments of each
 * direction, and how far their middles lie from the element's. */
void rad_classes_set(const struct rad_patch *patch, const struct rad_element *e,
                     const struct rad_panel *angular, const struct rad_panel *radial,
                     struct rad_classes *c) {
  double t0 = rad_angle_t(patch->angle, rad_graded(e->sigma[0], e->p_phi));
  double t1 = rad_angle_t(patch->angle, rad_graded(e->sigma[1], e->p_phi));
  double r0 = rad_graded(e->tau[0], e->p_r), r1 = rad_graded(e->tau[1], e->p_r);
  double t = 0.5 * (t0 + t1), r = 0.5 * (r0 + r1), b = hypot(patch->b1, patch->b2);
  double ray0 = hypot(patch->a1 + t0 * patch->b1, t0 * patch->b2);
  double ray1 = hypot(patch->a1 + t1 * patch->b1, t1 * patch->b2);
  double half_t = 0.5 * r1 * b * (t1 - t0), half_r = 0.5 * (r1 - r0) * fmax(ray0, ray1);
  double off_t = half_r, off_r = 0.5 * r * b * (t1 - t0);
  c->center[0] = r * (patch->a1 + t * patch->b1);
  c->center[1] = r * t * patch->b2;
  c->width[0] = 0.5 * r0 * b * (t1 - t0);
  c->width[1] = 0.5 * r1 * b * (t1 - t0);
  c->length = 2 * half_r;
  c->half_t = half_t;
  c->reach_t = angular->reach;
  c->reach_r = radial->reach;
  for (int i = 0; i < 2; i++) {
    double at = i ? r1 : r0;
    c->end[i][0] = at * (patch->a1 + t * patch->b1);
    c->end[i][1] = at * t * patch->b2;
  }
  c->n = 0;
  int ot = 0, orr = 0;
  double from_t = off_t + half_t * angular->reach[0], from_r = off_r + half_r * radial->reach[0];
  while (1) {
    double from = fmax(from_t, from_r);
    if (rad_order[ot] * rad_order[orr] > MOST)
      break;
    if (isfinite(from)) {
      c->d2[c->n] = from * from;
      c->rule[c->n][0] = ot;
      c->rule[c->n++][1] = orr;
    }
    if (from_t >= from_r ? ++ot == RAD_N_ORDER : ++orr == RAD_N_ORDER)
      break;
    from_t = off_t + half_t * angular->reach[ot];
    from_r = off_r + half_r * radial->reach[orr];
  }
}

/* The first rule that reaches as near as `from`, or RAD_N_ORDER. */
static int first_rule(const double reach[RAD_N_ORDER], double from) {
  int o = 0;
  while (o < RAD_N_ORDER && from < reach[o])
    o++;
  return o;
}

int rad_class_close(const struct rad_classes *c, const double x[3], int rule[2]) {
  const double *from = c->end[0], *to = c->end[1];
  double along[2] = {to[0] - from[0], to[1] - from[1]}, dx[2] = {x[0] - from[0], x[1] - from[1]};
  double at = (dx[0] * along[0] + dx[1] * along[1]) / (along[0] * along[0] + along[1] * along[1]);
  at = fmin(fmax(at, 0), 1);
  double ends = 0, aside = hypot(hypot(dx[0] - at * along[0], dx[1] - at * along[1]), x[2]);
  for (int i = 0; i < 2; i++)
    ends += hypot(hypot(x[0] - c->end[i][0], x[1] - c->end[i][1]), x[2]) - c->width[i];
  rule[0] = first_rule(c->reach_t, aside / c->half_t);
  rule[1] = first_rule(c->reach_r, ends / c->length);
  return rule[0] < RAD_N_ORDER && rule[1] < RAD_N_ORDER &&
         rad_order[rule[0]] * rad_order[rule[1]] <= MOST;
}
