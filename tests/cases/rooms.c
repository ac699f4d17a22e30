#include "rooms.h"

#include <check.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "estimate/iterate.h"
#include "system/dense.h"
#include "visibility/facing.h"

void room_make(struct rad_deck *deck, struct room *room) {
  struct rad_error e;
  room->scene = build_scene(deck);
  enum rad_code code = rad_visibility_build(&room->scene, &room->visibility, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
}

void room_free(struct room *room) {
  rad_visibility_free(&room->visibility);
  rad_scene_free(&room->scene);
}

void add_spot(struct spots *s, int triangle, int base, double mu1, double mu2) {
  ck_assert_int_lt(s->n, MOST_SPOT);
  s->triangle[s->n] = triangle;
  s->base[s->n] = base;
  s->mu[s->n][0] = mu1;
  s->mu[s->n++][1] = mu2;
}

void add_border_spots(struct spots *s, int triangle, double distance) {
  for (int base = 0; base < 3; base++) {
    add_spot(s, triangle, base, 0.37, distance);
    add_spot(s, triangle, base, distance, 0.24);
    add_spot(s, triangle, base, 0.6 * distance, 0.3 * distance);
  }
}

void spot_position(const struct room *room, const struct spots *s, int i, double x[3]) {
  rad_triangle_point(&room->scene.triangle[s->triangle[i]], s->base[i], s->mu[i], x);
}

const struct rad_deck_method
    method_constant = {.mesh = RAD_MESH_UNIFORM, .elements = 1, .degree = 0, .grading = 1},
    method_folded = {.mesh = RAD_MESH_UNIFORM, .elements = 2, .degree = 1, .grading = 1},
    method_paper = {.mesh = RAD_MESH_PAPER, .elements = 2, .degree = 1, .grading = 2},
    method_graded = {.mesh = RAD_MESH_GRADED, .elements = 1, .degree = 5, .grading = 3};

static void build_mesh(const struct room *room, const struct rad_deck_method *method,
                       double tolerance, struct rad_mesh *mesh, struct rad_rules *rules) {
  struct rad_error e;
  enum rad_code code = rad_mesh_build(&room->scene, method, mesh, &e);
  if (!code)
    code = rad_rules_build(mesh, tolerance, rules, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
}

struct sums {
  const struct rad_mesh *mesh;
  const unsigned char *sees;
  const struct spots *spots;
  double *value;
};

static void add_sums(void *context, int thread, int first, int m, const double *row) {
  const struct sums *s = context;
  int n = s->mesh->scene->n_triangle;
  (void)thread;
  for (int i = 0; i < m; i++)
    for (int j = 0; j < n; j++) {
      double sum = 0;
      if (s->sees[s->spots->triangle[first] * n + j])
        for (int q = s->mesh->point_first[j]; q < s->mesh->point_first[j + 1]; q++)
          sum += row[(size_t)q * (size_t)m + (size_t)i];
      s->value[(size_t)(first + i) * (size_t)n + (size_t)j] = sum;
    }
}

double *receive(struct room *room, const struct rad_deck_method *method, double tolerance,
                const struct spots *s, int visible) {
  struct rad_mesh mesh;
  struct rad_rules rules;
  struct rad_error e;
  size_t n = (size_t)room->scene.n_triangle;
  unsigned char *faces = malloc(n * n);
  double *value = calloc((size_t)s->n * n, sizeof *value);
  ck_assert(faces && value);
  for (size_t i = 0; i < n * n; i++)
    faces[i] =
        i / n != i % n && rad_faces(&room->scene.triangle[i / n], &room->scene.triangle[i % n]);
  if (!visible)
    room->scene.visibility = NULL;
  build_mesh(room, method, tolerance, &mesh, &rules);
  struct sums sums = {&mesh, visible ? room->visibility.sight : faces, s, value};
  struct rad_point_list list = {s->n, s->triangle, s->base, s->mu};
  ck_assert_int_eq(rad_visit_rows(&mesh, &rules, sums.sees, &list, add_sums, &sums, &e), RAD_OK);
  room->scene.visibility = &room->visibility;
  rad_rules_free(&rules);
  rad_mesh_free(&mesh);
  free(faces);
  return value;
}

void assemble(const struct room *room, const struct rad_deck_method *method, double tolerance,
              struct rad_mesh *mesh, struct rad_dense *dense) {
  struct rad_rules rules;
  struct rad_error e;
  build_mesh(room, method, tolerance, mesh, &rules);
  enum rad_code code = rad_dense_assemble(mesh, &rules, NULL, dense, &e);
  ck_assert_msg(code == RAD_OK, "%s", e.text);
  rad_rules_free(&rules);
}

void add_box(struct rad_deck *deck, const struct motion *motion, const double low[3],
             const double high[3], enum rad_side side) {
  double base[4][2];
  for (int c = 0; c < 4; c++)
    for (int d = 0; d < 2; d++)
      base[c][d] = SQUARE[c][d] > 0 ? high[d] : low[d];
  add_prism(deck, motion, 4, (const double(*)[2])base, 2, SQUARE_CAP, low[2], high[2], side);
}
