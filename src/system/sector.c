#include "system/sector.h"

#include <string.h>

#include "base/vec.h"

/* Lines shorter than this, over the size of the scene, are lost in the rounding of coordinates. */
#define SHORTEST 1e-12

void rad_sector_set(const struct rad_tree *tree, const struct rad_cluster *c,
                    struct rad_sector *s) {
  const struct rad_mesh *mesh = tree->mesh;
  const struct rad_element *first = &mesh->element[tree->element[c->element]];
  double sigma[2] = {INFINITY, -INFINITY}, phi;
  for (int i = c->element; i < c->element + c->n_element; i++) {
    const struct rad_element *e = &mesh->element[tree->element[i]];
    sigma[0] = fmin(sigma[0], e->sigma[0]);
    sigma[1] = fmax(sigma[1], e->sigma[1]);
  }
  s->patch = &mesh->patch[first->patch];
  for (int i = 0; i < 2; i++)
    s->t[i] = rad_angle_t(s->patch->angle, rad_graded(sigma[i], first->p_phi));
  s->n_radius = first->k_r;
  for (int j = 0; j < s->n_radius; j++)
    rad_element_point(mesh, first, first->k_phi * j, &phi, &s->radius[j]);
}

double rad_sector_distance(const struct rad_tree *tree, const struct rad_sector *s,
                           const struct rad_cluster *source) {
  const struct rad_patch *p = s->patch;
  struct rad_box line = {.plane = &tree->plane[p->triangle]}, box;
  double least = INFINITY, t = 0.5 * (s->t[0] + s->t[1]), half = 0.5 * (s->t[1] - s->t[0]);
  rad_cluster_box(tree, source, &box);
  for (int j = 0; j < s->n_radius; j++) {
    for (int d = 0; d < 3; d++) {
      line.center[d] = p->v[d] + s->radius[j] * (p->a[d] + t * p->b[d]);
      line.half[0][d] = s->radius[j] * half * p->b[d];
    }
    double length = 2 * rad_norm(line.half[0]);
    if (length < SHORTEST * tree->mesh->scene->size)
      return 0;
    least = fmin(least, rad_box_distance(&line, &box) / length);
  }
  return least;
}

void rad_sector_place(const struct rad_interpolation *p, const struct rad_sector *s, int place,
                      double mu[2]) {
  double t = 0.5 * (s->t[0] + s->t[1] + (s->t[1] - s->t[0]) * p->node[place % p->q]);
  rad_patch_mu(s->patch, rad_angle_phi(s->patch->angle, t), s->radius[place / p->q], mu);
}

void rad_sector_spread(const struct rad_interpolation *p, const struct rad_tree *tree,
                       const struct rad_cluster *c, const struct rad_sector *s, double *spread) {
  const struct rad_mesh *mesh = tree->mesh;
  size_t n = (size_t)c->n, at = 0;
  memset(spread, 0, sizeof(double) * n * (size_t)(p->q * s->n_radius));
  for (int i = c->element; i < c->element + c->n_element; i++) {
    const struct rad_element *e = &mesh->element[tree->element[i]];
    for (int b = 0; b < e->n_function; b++, at++) {
      double phi, r, value[RAD_MAX_INTERPOLATION];
      rad_element_point(mesh, e, b, &phi, &r);
      double t = rad_angle_t(s->patch->angle, phi);
      rad_interpolation_at(p, (2 * t - s->t[0] - s->t[1]) / (s->t[1] - s->t[0]), value);
      for (int l = 0; l < p->q; l++)
        spread[at + n * (size_t)(l + p->q * (b / e->k_phi))] = value[l];
    }
  }
}
