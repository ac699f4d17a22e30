#include "scene/enclosure.h"

#include <math.h>

#include "base/vec.h"
#include "scene/shell.h"

/* Signed solid angle of a triangle seen from x (van Oosterom and Strackee), by its normal. */
static double solid_angle(const struct rad_triangle *t, const double x[3]) {
  double a[3], b[3], c[3], turn[3], side1[3], side2[3], flat[3];
  rad_sub(t->v[0], x, a);
  rad_sub(t->v[1], x, b);
  rad_sub(t->v[2], x, c);
  rad_cross(b, c, turn);
  rad_sub(t->v[1], t->v[0], side1);
  rad_sub(t->v[2], t->v[0], side2);
  rad_cross(side1, side2, flat);
  double la = rad_norm(a), lb = rad_norm(b), lc = rad_norm(c);
  double omega = 2 * atan2(rad_dot(a, turn), la * lb * lc + rad_dot(a, b) * lc +
                                                 rad_dot(a, c) * lb + rad_dot(b, c) * la);
  return rad_dot(flat, t->normal) > 0 ? omega : -omega;
}

/* Seen from inside, a closed shell fills 4 pi. */
static int is_inside(const struct rad_scene *s, const struct rad_shells *shells, int shell,
                     const double x[3]) {
  double sum = 0;
  for (int t = 0; t < s->n_triangle; t++)
    if (shells->shell[t] == shell)
      sum += solid_angle(&s->triangle[t], x);
  return fabs(sum) > 2 * M_PI;
}

static int is_held(const struct rad_scene *s, const struct rad_shells *shells, int shell) {
  double x[3] = {0, 0, 0};
  int first = 0;
  if (shells->volume[shell] < 0)
    return 1;
  while (shells->shell[first] != shell)
    first++;
  for (int c = 0; c < 9; c++)
    x[c % 3] += s->triangle[first].v[c / 3][c % 3] / 3;
  for (int room = 0; room < shells->n; room++)
    if (shells->volume[room] < 0 && is_inside(s, shells, room, x))
      return 1;
  return 0;
}

enum rad_code rad_find_enclosure(const struct rad_scene *scene, int *is_enclosed,
                                 struct rad_error *e) {
  struct rad_shells shells;
  enum rad_code code = rad_shells_find(scene, &shells, e);
  *is_enclosed = !code;
  for (int i = 0; i < shells.n && !code && *is_enclosed; i++)
    *is_enclosed = shells.closed[i] && is_held(scene, &shells, i);
  rad_shells_free(&shells);
  return code;
}
