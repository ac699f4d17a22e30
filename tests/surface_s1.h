/* Surface S1 of the paper, made without a deck. */
#ifndef POLYRAD_TEST_SURFACE_S1_H
#define POLYRAD_TEST_SURFACE_S1_H

#include <math.h>
#include <string.h>

#include "scene/scene.h"

/* Three sides of a cube's corner; the scene refers to tri, and has no optics. */
static inline void make_s1(struct rad_triangle tri[3], struct rad_scene *scene) {
  static double v[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  static const int corner[3][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}};
  memset(tri, 0, 3 * sizeof *tri);
  for (int t = 0; t < 3; t++) {
    for (int c = 0; c < 3; c++) {
      memcpy(tri[t].v[c], v[corner[t][c]], sizeof v[0]);
      tri[t].vertex[c] = corner[t][c];
    }
    tri[t].normal[t == 0 ? 2 : t - 1] = 1;
    tri[t].area = 0.5;
  }
  *scene = (struct rad_scene){
      .n_triangle = 3, .n_vertex = 4, .n_band = 1, .triangle = tri, .vertex = v, .size = sqrt(3)};
}

#endif
