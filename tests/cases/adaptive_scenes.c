#include "adaptive_scenes.h"

#include <math.h>
#include <string.h>

const double face_s1[3][3][3] = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                                 {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                 {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}}};
static const double s2[3][3][3] = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                                   {{0, 0, 0}, {0, 1, 0}, {1, 1, 1}},
                                   {{0, 0, 0}, {1, 1, 1}, {1, 0, 0}}};

void three_faces(struct deck_text *d, const double face[3][3][3], const double rho[3],
                 const double e[3]) {
  static const char *const name[] = {"one", "two", "three"};
  for (int t = 0; t < 3; t++)
    deck_polygon(d, name[t], 3, face[t], rho[t], e[t]);
}

static void angle(struct deck_text *d, double degrees) {
  double c = degrees == 90 ? 0 : cos(degrees * M_PI / 180), s = sin(degrees * M_PI / 180);
  double low[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  double high[4][3] = {{0, 0, 0}, {0, 1, 0}, {c, 1, s}, {c, 0, s}};
  deck_polygon(d, "low", 4, (const double(*)[3])low, 0.9, 1);
  deck_polygon(d, "high", 4, (const double(*)[3])high, 0.9, 0);
}

static void tetrahedron(struct deck_text *d) {
  static const double v[4][3] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  static const int face[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  static const double rho[4] = {0.2, 0.9, 0.5, 0.6}, e[4] = {1, 0, 0.3, 0.2};
  for (int f = 0; f < 4; f++) {
    double corner[3][3];
    char name[2] = {(char)('a' + f), 0};
    for (int i = 0; i < 3; i++)
      memcpy(corner[i], v[face[f][i]], sizeof corner[i]);
    deck_polygon(d, name, 3, (const double(*)[3])corner, rho[f], e[f]);
  }
}

static void box30(struct deck_text *d) {
  static const double a = 30, rho = 0.5;
  const double face[6][4][3] = {
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 0, a}, {0, 1, a}, {1, 1, a}, {1, 0, a}},
      {{0, 0, 0}, {0, 1, 0}, {0, 1, a}, {0, 0, a}}, {{1, 0, 0}, {1, 0, a}, {1, 1, a}, {1, 1, 0}},
      {{0, 0, 0}, {0, 0, a}, {1, 0, a}, {1, 0, 0}}, {{0, 1, 0}, {1, 1, 0}, {1, 1, a}, {0, 1, a}}};
  static const char *const name[] = {"floor", "ceiling", "x0", "x1", "y0", "y1"};
  static const double e[6] = {0, 1, 0.2, 0, 0.3, 0.5};
  for (int f = 0; f < 6; f++)
    deck_polygon(d, name[f], 4, face[f], rho, e[f]);
}

const char *adaptive_scene(int i, struct deck_text *d) {
  static const double half[3] = {0.5, 0.5, 0.5}, e1[3] = {0.5, 1, 0.3};
  static const double rho2[3] = {0.5, 1, 0.25}, e2[3] = {1, 0.2, 0.2}, e2x[3] = {0.2, 1, 0.2};
  static const double rho6[6] = {0.1, 0.9, 0.3, 0.5, 0.7, 0.2}, e6[6] = {0, 1, 0.2, 0, 3, 0.5};
  static const double degrees[4] = {10, 45, 90, 150};
  static const char *const name[N_ADAPTIVE_SCENE] = {
      "S1",       "S2",        "S2 exchanged", "angle 10", "angle 45",
      "angle 90", "angle 150", "tetrahedron",  "cube",     "box 1:1:30"};
  deck_begin(d);
  if (i == 0)
    three_faces(d, face_s1, half, e1);
  else if (i <= 2)
    three_faces(d, s2, rho2, i == 1 ? e2 : e2x);
  else if (i <= 6)
    angle(d, degrees[i - 3]);
  else if (i == 7)
    tetrahedron(d);
  else if (i == 8)
    deck_cube(d, rho6, e6);
  else
    box30(d);
  return name[i];
}

void blocker_scene(struct deck_text *d) {
  static const double low[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                      high[4][3] = {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}},
                      block[3][3] = {{.2, .3, .5}, {.75, .25, .45}, {.45, .8, .6}};
  deck_begin(d);
  deck_polygon(d, "low", 4, low, 0.7, 1);
  deck_polygon(d, "high", 4, high, 0.7, 0.2);
  deck_polygon(d, "block", 3, block, 0.5, 0);
}
