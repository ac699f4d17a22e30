#include "integrate/view.h"

#include <stdbool.h>

#include "base/vec.h"

static bool has_vertex(const struct rad_triangle *t, int vertex) {
  return t->vertex[0] == vertex || t->vertex[1] == vertex || t->vertex[2] == vertex;
}

/* Which coordinates of a scene vertex vanish in the patch's frame, known from topology alone. */
static void known_zeros(const struct rad_triangle *source, const struct rad_patch *p, int vertex,
                        bool zero[3]) {
  bool corner = p->corner >= 0 && vertex == p->corner;
  bool on_side = corner || (p->toward >= 0 && vertex == p->toward);
  zero[0] = corner;
  zero[1] = on_side;
  zero[2] = has_vertex(source, vertex);
}

void rad_view_set(const struct rad_triangle *target, const struct rad_triangle *source,
                  const struct rad_patch *p, struct rad_view *view) {
  const double *axis[3] = {p->e1, p->e2, source->normal};
  bool zero[3][3];
  for (int c = 0; c < 3; c++)
    known_zeros(source, p, target->vertex[c], zero[c]);
  for (int c = 0; c < 3; c++) {
    double offset[3];
    rad_sub(target->v[c], p->v, offset);
    for (int d = 0; d < 3; d++)
      view->origin[c][d] = zero[c][d] ? 0 : rad_dot(offset, axis[d]);
    for (int m = 0; m < 2; m++) {
      int other = (c + 1 + m) % 3;
      double f[3];
      rad_sub(target->v[other], target->v[c], f);
      for (int d = 0; d < 3; d++)
        view->along[c][m][d] = zero[c][d] && zero[other][d] ? 0 : rad_dot(f, axis[d]);
    }
  }
  bool corner_in = p->corner >= 0 && has_vertex(target, p->corner);
  bool side_in = corner_in && p->toward >= 0 && has_vertex(target, p->toward);
  double offset[3];
  rad_sub(p->v, target->v[0], offset);
  view->n0 = corner_in ? 0 : rad_dot(target->normal, offset);
  view->na = side_in ? 0 : rad_dot(target->normal, p->a);
  view->nb = rad_dot(target->normal, p->b);
}
