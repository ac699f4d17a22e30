#include "scene_help.h"

#include <check.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"

static uint64_t state;

unsigned long long seed(void) {
  const char *given = getenv("RAD_TEST_SEED");
  return given ? strtoull(given, NULL, 10) : 2003;
}

double uniform(double low, double high) {
  state += 0x9E3779B97F4A7C15u; /* splitmix64 */
  uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return low + (high - low) * (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

void start_random(void) {
  state = seed();
}

void random_direction(double d[3]) {
  double length;
  do {
    for (int m = 0; m < 3; m++)
      d[m] = uniform(-1, 1);
    length = rad_norm(d);
  } while (length > 1 || length < 0.1);
  for (int m = 0; m < 3; m++)
    d[m] /= length;
}

struct motion random_motion(double decades) {
  struct motion m;
  double other[3];
  random_direction(m.axis[0]);
  do {
    random_direction(other);
    rad_cross(m.axis[0], other, m.axis[1]);
  } while (rad_norm(m.axis[1]) < 0.1);
  double length = rad_norm(m.axis[1]);
  for (int d = 0; d < 3; d++)
    m.axis[1][d] /= length;
  rad_cross(m.axis[0], m.axis[1], m.axis[2]);
  m.scale = pow(10, uniform(-decades, decades));
  for (int d = 0; d < 3; d++)
    m.shift[d] = m.scale * uniform(-3, 3);
  return m;
}

void move(const struct motion *m, const double x[3], double y[3]) {
  for (int d = 0; d < 3; d++)
    y[d] = m->scale * rad_dot(m->axis[d], x) + m->shift[d];
}

const double UNIT[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
const double ELL[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
const int ELL_CAP[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}};
const double SQUARE[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
const int SQUARE_CAP[2][3] = {{0, 1, 2}, {0, 2, 3}};

/* --- decks --- */

struct rad_deck_triangle *add(struct rad_deck *deck, const char *name, const double v[3][3]) {
  deck->path = "room.yml";
  deck->n_band = 1;
  deck->band[0] = "all";
  size_t n = (size_t)deck->n_triangle + 1;
  if (n == 1 || (n & (n - 1)) == 0)
    deck->triangle = realloc(deck->triangle, 2 * n * sizeof *deck->triangle);
  ck_assert_ptr_nonnull(deck->triangle);
  struct rad_deck_triangle *t = &deck->triangle[deck->n_triangle++];
  *t = (struct rad_deck_triangle){.name = (char *)name, .line = 9 + deck->n_triangle};
  memcpy(t->vertex, v, sizeof t->vertex);
  t->optics.has_rho = t->optics.has_emission = true;
  t->optics.rho[0] = 0.5;
  for (int m = 0; m < 3; m++)
    t->optics.emission[m][0] = 1;
  return t;
}

void add_moved(struct rad_deck *deck, const struct motion *motion, const double v[3][3],
               enum rad_side side) {
  double moved[3][3];
  for (int m = 0; m < 3; m++)
    move(motion, v[m], moved[m]);
  add(deck, "wall", moved)->optics.side = side;
}

void add_prism(struct rad_deck *deck, const struct motion *motion, int n,
               const double (*polygon)[2], int n_cap, const int (*cap)[3], double low, double high,
               enum rad_side side) {
  for (int k = 0; k < n; k++) {
    const double *p = polygon[k], *q = polygon[(k + 1) % n];
    const double c[4][3] = {
        {p[0], p[1], low}, {q[0], q[1], low}, {q[0], q[1], high}, {p[0], p[1], high}};
    const int half[2][2][3] = {{{0, 1, 2}, {0, 2, 3}}, {{0, 1, 3}, {1, 2, 3}}};
    for (int h = 0; h < 2; h++) {
      double v[3][3];
      for (int m = 0; m < 3; m++)
        memcpy(v[m], c[half[k % 2][h][m]], sizeof v[m]);
      add_moved(deck, motion, v, side);
    }
  }
  for (int k = 0; k < 2 * n_cap; k++) {
    double v[3][3];
    for (int m = 0; m < 3; m++) {
      const double *p = polygon[cap[k / 2][k % 2 ? m : 2 - m]];
      v[m][0] = p[0];
      v[m][1] = p[1];
      v[m][2] = k % 2 ? high : low;
    }
    add_moved(deck, motion, v, side);
  }
}

void add_cube(struct rad_deck *deck, const struct motion *motion, enum rad_side side) {
  add_prism(deck, motion, 4, SQUARE, 2, SQUARE_CAP, 0, 1, side);
}

struct built build(struct rad_deck *deck) {
  struct built b = {0};
  b.code = rad_scene_build(deck, &b.scene, &b.notes, &b.error);
  return b;
}

struct built build_well(struct rad_deck *deck) {
  struct built b = build(deck);
  ck_assert_msg(b.code == RAD_OK, "refused: %s", b.error.text);
  return b;
}

void drop(struct built *b, struct rad_deck *deck) {
  rad_scene_free(&b->scene);
  rad_scene_free(&b->scene);
  rad_notes_free(&b->notes);
  free(deck->triangle);
  *deck = (struct rad_deck){0};
}

struct rad_scene build_scene(struct rad_deck *deck) {
  struct built b = build_well(deck);
  rad_notes_free(&b.notes);
  free(deck->triangle);
  *deck = (struct rad_deck){0};
  return b.scene;
}

void measure_triangle(struct rad_triangle *t) {
  double u[3], v[3], n[3];
  rad_sub(t->v[1], t->v[0], u);
  rad_sub(t->v[2], t->v[0], v);
  rad_cross(u, v, n);
  t->area = rad_norm(n) / 2;
  for (int d = 0; d < 3; d++)
    t->normal[d] = n[d] / rad_norm(n);
}
