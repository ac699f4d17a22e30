#include "estimate/view_cell.h"

#include <math.h>
#include <string.h>

struct rad_view_cell rad_view_cell_whole(int triangle) {
  return (struct rad_view_cell){.triangle = triangle, .corner = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
}

static int is_vertex(const double corner[3]) {
  return corner[0] == 1 || corner[1] == 1 || corner[2] == 1;
}

static struct rad_view_cell child_of(const struct rad_view_cell *parent, const double a[3],
                                     const double b[3], const double c[3]) {
  struct rad_view_cell cell = {
      .triangle = parent->triangle, .depth = parent->depth + 1, .at_vertex = is_vertex(a)};
  memcpy(cell.corner[0], a, sizeof cell.corner[0]);
  memcpy(cell.corner[1], b, sizeof cell.corner[1]);
  memcpy(cell.corner[2], c, sizeof cell.corner[2]);
  return cell;
}

static void middle(const double a[3], const double b[3], double m[3]) {
  for (int d = 0; d < 3; d++)
    m[d] = 0.5 * (a[d] + b[d]);
}

int rad_view_cell_split(const struct rad_view_cell *cell, struct rad_view_cell *child) {
  const double(*v)[3] = cell->corner;
  double m[3][3]; /* m[k] lies opposite to v[k] */
  for (int k = 0; k < 3; k++)
    middle(v[(k + 1) % 3], v[(k + 2) % 3], m[k]);
  int n = 0;
  child[n++] = child_of(cell, m[0], m[1], m[2]);
  child[n++] = child_of(cell, v[1], m[0], m[2]);
  child[n++] = child_of(cell, v[2], m[1], m[0]);
  if (!cell->at_vertex) {
    child[n++] = child_of(cell, v[0], m[2], m[1]);
    return n;
  }
  double between[3];
  middle(m[1], m[2], between);
  child[n++] = child_of(cell, v[0], m[2], between);
  child[n++] = child_of(cell, v[0], between, m[1]);
  return n;
}

double rad_view_cell_share(const struct rad_view_cell *cell) {
  const double(*c)[3] = cell->corner;
  double u[2] = {c[1][1] - c[0][1], c[1][2] - c[0][2]};
  double w[2] = {c[2][1] - c[0][1], c[2][2] - c[0][2]};
  return fabs(u[0] * w[1] - u[1] * w[0]);
}

int rad_view_cell_points(const struct rad_gauss *g, const struct rad_view_cell *cell, int n,
                         double (*mu)[2], double *weight) {
  const double(*c)[3] = cell->corner;
  const double *x = rad_gauss_node(g, n), *w = rad_gauss_weight(g, n);
  double sum[3];
  int base = 0;
  for (int d = 0; d < 3; d++) {
    sum[d] = c[0][d] + c[1][d] + c[2][d];
    base = sum[d] > sum[base] ? d : base;
  }
  for (int q = 0; q < n * n; q++) {
    double r = 0.5 * (1 + x[q / n]), t = 0.5 * (1 + x[q % n]);
    weight[q] = 0.5 * w[q / n] * w[q % n] * r;
    for (int k = 0; k < 2; k++) {
      int d = (base + 1 + k) % 3;
      mu[q][k] = (1 - r) * c[0][d] + r * ((1 - t) * c[1][d] + t * c[2][d]);
    }
  }
  return base;
}
