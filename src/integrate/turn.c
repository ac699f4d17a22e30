#include "integrate/turn.h"

/* Place of a scene vertex in a triangle, or -1. */
static int place_of(const struct rad_triangle *t, int vertex) {
  for (int c = 0; c < 3; c++)
    if (t->vertex[c] == vertex)
      return c;
  return -1;
}

int rad_turn_wanted(const struct rad_mesh *mesh, int target, int patch) {
  const struct rad_patch *p = &mesh->patch[patch];
  const int first = mesh->element_first[patch];
  const struct rad_element *el = &mesh->element[first];
  const struct rad_triangle *t = &mesh->scene->triangle[target];
  const struct rad_triangle *source = &mesh->scene->triangle[p->triangle];
  if (p->corner < 0 || p->mu_a[0] != 1 || mesh->element_first[patch + 1] != first + 1 || el->fold ||
      el->k_phi > 2 || el->k_r > 2)
    return 0;
  return place_of(source, t->vertex[0]) >= 0 || place_of(source, t->vertex[1]) >= 0 ||
         place_of(source, t->vertex[2]) >= 0;
}

/* The element's functions at the points of the turned one. */
static void set_values(const struct rad_mesh *mesh, int element, struct rad_turn *turn) {
  const struct rad_element *el = &turn->element;
  for (int g = 0; g < el->k_phi * el->k_r; g++) {
    double phi, r, mu[2], weight[3];
    rad_element_point(mesh, el, g, &phi, &r);
    rad_patch_mu(&turn->patch, phi, r, mu);
    weight[turn->patch.base] = 1 - mu[0] - mu[1];
    weight[(turn->patch.base + 1) % 3] = mu[0];
    weight[(turn->patch.base + 2) % 3] = mu[1];
    r = weight[1] + weight[2];
    rad_element_basis(mesh, element, weight[2] / r, r, turn->value[g]);
  }
}

int rad_turn_set(const struct rad_mesh *mesh, const struct rad_rules *rules, int target, int base,
                 int patch, struct rad_turn *turn) {
  const struct rad_triangle *t = &mesh->scene->triangle[target];
  const struct rad_patch *whole = &mesh->patch[patch];
  const struct rad_triangle *source = &mesh->scene->triangle[whole->triangle];
  const int element = mesh->element_first[patch], corner = place_of(source, t->vertex[base]);
  if (corner < 0)
    return 0;
  int toward = (corner + 1) % 3;
  for (int c = 1; c < 3; c++) {
    const int shared = place_of(source, t->vertex[(base + c) % 3]);
    toward = shared >= 0 ? shared : toward;
  }
  rad_patch_from(mesh->scene, whole->triangle, corner, toward, &turn->patch);
  turn->element = mesh->element[element];
  turn->element.patch = turn->element.first = 0;
  turn->first[0] = turn->zero[0] = 0;
  turn->first[1] = 1;
  turn->angular[0] = rules->angular[element];
  turn->radial[0] = rules->radial[element];
  turn->mesh = *mesh;
  turn->mesh.n_patch = turn->mesh.n_element = 1;
  turn->mesh.patch = &turn->patch;
  turn->mesh.element = &turn->element;
  turn->mesh.element_first = turn->first;
  turn->rules = *rules;
  turn->rules.angular = turn->angular;
  turn->rules.radial = turn->radial;
  set_values(mesh, element, turn);
  return 1;
}
