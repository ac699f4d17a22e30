#include "system/h2_leaf.h"

#include <string.h>

#include "base/simd_math.h"
#include "base/vec.h"

/* Polynomials at a point of the triangle, given as an offset from its origin: c[i + q j]. */
static inline void at_point(const struct rad_interpolation *p, const struct rad_plane *plane,
                            const struct rad_cluster *leaf, const double offset[3],
                            double *restrict c) {
  double one[2][RAD_MAX_INTERPOLATION];
  for (int d = 0; d < 2; d++) {
    double y = rad_dot(offset, plane->axis[d]);
    double z = (2 * y - leaf->low[d] - leaf->high[d]) / (leaf->high[d] - leaf->low[d]);
    rad_interpolation_at(p, z, one[d]);
  }
  for (int j = 0; j < p->q; j++)
    for (int i = 0; i < p->q; i++)
      c[i + p->q * j] = one[0][i] * one[1][j];
}

void rad_leaf_polynomials(const struct rad_interpolation *p, const struct rad_tree *tree,
                          const struct rad_cluster *leaf, const double x[3], double *c) {
  double offset[3];
  rad_sub(x, tree->plane[leaf->triangle].origin, offset);
  at_point(p, &tree->plane[leaf->triangle], leaf, offset, c);
}

void rad_leaf_values(const struct rad_interpolation *p, const struct rad_tree *tree,
                     const struct rad_cluster *leaf, double *v) {
  for (int l = 0; l < leaf->n; l++) {
    double x[3];
    rad_point_position(tree->mesh, tree->unknown[leaf->first + l], x);
    rad_leaf_polynomials(p, tree, leaf, x, v + (size_t)l * (size_t)p->n);
  }
}

/* A Gauss rule on an interval of sigma or tau: places t or r, weights with each trial function. */
struct rule {
  int n;
  double at[RAD_GAUSS_MAX], weight[RAD_GAUSS_MAX][RAD_GAUSS_MAX]; /* [point][function] */
};

static void set_rule(const struct rad_mesh *mesh, int n, const double range[2], double p, int k,
                     int radial, enum rad_angle angle, struct rule *rule) {
  const double *z = rad_gauss_node(&mesh->gauss, n), *w = rad_gauss_weight(&mesh->gauss, n);
  double half = 0.5 * (range[1] - range[0]);
  rule->n = n;
  for (int i = 0; i < n; i++) {
    double graded = range[0] + (1 + z[i]) * half, value = rad_graded(graded, p);
    double slope = p == 1 ? 1 : p * pow(graded, p - 1);
    rule->at[i] = radial ? value : rad_angle_t(angle, value);
    rad_lagrange(&mesh->nodes, k, z[i], rule->weight[i]);
    double factor = w[i] * half * slope * (radial ? value : rad_angle_dt(angle, rule->at[i]));
    for (int a = 0; a < k; a++)
      rule->weight[i][a] *= factor;
  }
}

/* Points that suffice in one direction: exact for polynomials; on ungraded elements also what the
 * kernel needs whose poles are a diameter of the leaf away (Bernstein ellipse, theory 3.12). */
static int points_for(const struct rad_interpolation *p, double grading, int k, double diameter,
                      double leaf_diameter, double tolerance) {
  int exact = (int)ceil(grading * p->q + 0.5 * k) + 1, most = exact;
  if (grading == 1) {
    double d = 2 * leaf_diameter / diameter, rho = d + sqrt(d * d + 1);
    most = (int)ceil(0.5 * (log(100 / tolerance) / log(rho) + k + 3));
  }
  most = most < exact ? most : exact;
  return most < RAD_GAUSS_MAX ? most : RAD_GAUSS_MAX;
}

/* One element of a leaf. */
struct source {
  const struct rad_interpolation *p;
  const struct rad_plane *plane;
  const struct rad_cluster *leaf;
  const struct rad_patch *patch;
  const struct rad_element *element;
  struct rule angular, radial;
};

/* Moments of all tensor functions: m[node + n_node (a + k_phi c)]; row [k_r, n_node] is scratch. */
static void element_moments(const struct source *e, double *restrict m, double *restrict row) {
  enum { MOST = RAD_MAX_INTERPOLATION * RAD_MAX_INTERPOLATION };
  const struct rad_patch *patch = e->patch;
  size_t n = (size_t)e->p->n, k_phi = (size_t)e->element->k_phi, k_r = (size_t)e->element->k_r;
  double c[MOST], start[3], scale = patch->a1 * patch->b2;
  rad_sub(patch->v, e->plane->origin, start);
  memset(m, 0, sizeof(double) * n * k_phi * k_r);
  for (int i = 0; i < e->angular.n; i++) {
    memset(row, 0, sizeof(double) * n * k_r);
    for (int j = 0; j < e->radial.n; j++) {
      double offset[3];
      for (int d = 0; d < 3; d++)
        offset[d] = start[d] + e->radial.at[j] * (patch->a[d] + e->angular.at[i] * patch->b[d]);
      at_point(e->p, e->plane, e->leaf, offset, c);
      for (size_t f = 0; f < k_r; f++) {
        double w = scale * e->radial.weight[j][f];
#pragma omp simd
        for (size_t s = 0; s < n; s++)
          row[n * f + s] += w * c[s];
      }
    }
    for (size_t b = 0; b < k_phi * k_r; b++) {
      double w = e->angular.weight[i][b % k_phi];
      const double *from = row + n * (b / k_phi);
#pragma omp simd
      for (size_t s = 0; s < n; s++)
        m[n * b + s] += w * from[s];
    }
  }
}

/* v = fold m, scaled. */
static void store(const struct rad_element *e, size_t n, const double *m, double scale, double *v) {
  int k = e->k_phi * e->k_r;
  memset(v, 0, sizeof(double) * n * (size_t)e->n_function);
  for (int f = 0; f < e->n_function; f++)
    for (int b = e->fold ? 0 : f; b < (e->fold ? k : f + 1); b++) {
      double w = scale * (e->fold ? e->fold[f * k + b] : 1);
      for (size_t s = 0; s < n; s++)
        v[n * (size_t)f + s] += w * m[n * (size_t)b + s];
    }
}

static double share(const struct rad_mesh *mesh, int element) {
  return rad_element_area(mesh, element) / mesh->element[element].n_function;
}

RAD_CLONES void rad_leaf_moments(const struct rad_interpolation *p, const struct rad_tree *tree,
                                 const struct rad_cluster *leaf, double tolerance, double *v,
                                 double *scratch) {
  const struct rad_mesh *mesh = tree->mesh;
  struct source source = {.p = p, .plane = &tree->plane[leaf->triangle], .leaf = leaf};
  for (int i = leaf->element; i < leaf->element + leaf->n_element; i++) {
    const struct rad_element *e = source.element = &mesh->element[tree->element[i]];
    source.patch = &mesh->patch[e->patch];
    double low[2], high[2], wide = rad_cluster_diameter(leaf);
    rad_element_box(tree, tree->element[i], low, high);
    double own = hypot(high[0] - low[0], high[1] - low[1]);
    set_rule(mesh, points_for(p, e->p_phi, e->k_phi, own, wide, tolerance), e->sigma, e->p_phi,
             e->k_phi, 0, source.patch->angle, &source.angular);
    set_rule(mesh, points_for(p, e->p_r, e->k_r, own, wide, tolerance), e->tau, e->p_r, e->k_r, 1,
             source.patch->angle, &source.radial);
    size_t k = (size_t)(e->k_phi * e->k_r);
    element_moments(&source, scratch, scratch + k * (size_t)p->n);
    store(e, (size_t)p->n, scratch, 1 / sqrt(share(mesh, tree->element[i])), v);
    v += (size_t)p->n * (size_t)e->n_function;
  }
}

void rad_leaf_shares(const struct rad_tree *tree, const struct rad_cluster *leaf, double *d) {
  for (int i = leaf->element; i < leaf->element + leaf->n_element; i++) {
    int element = tree->element[i];
    double one = share(tree->mesh, element);
    for (int f = 0; f < tree->mesh->element[element].n_function; f++)
      *d++ = one;
  }
}
