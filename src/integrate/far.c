#include "integrate/far.h"

#include <math.h>

#include "base/simd_math.h"

enum { LANES = 16 }; /* targets at a time: the sums of a plain bilinear element stay in registers */

#define INLINE static inline __attribute__((always_inline))

/* Add one ray's source points to sum[c, lane]: sum_p w[c,p] n_x.(y-x) / |x-y|^4. */
INLINE void ray_sums(const int k_r, const double *restrict x, const double *restrict y,
                     const double *restrict z2, double d1, double d2, double n0, double slope,
                     int n_r, const double *restrict r, const double *restrict w,
                     double sum[][LANES]) {
  for (int p = 0; p < n_r; p++) {
    double y1 = r[p] * d1, y2 = r[p] * d2, height = n0 + r[p] * slope, g[LANES];
#pragma omp simd
    for (int i = 0; i < LANES; i++) {
      double e1 = y1 - x[i], e2 = y2 - y[i], q = e1 * e1 + (e2 * e2 + z2[i]);
      g[i] = height / (q * q);
    }
    for (int c = 0; c < k_r; c++)
#pragma omp simd
      for (int i = 0; i < LANES; i++)
        sum[c][i] += w[c * n_r + p] * g[i];
  }
}

/* All rays for LANES targets; k_r is a constant where this is called. */
INLINE void lanes(const int k_r, const struct rad_patch *patch, const struct rad_view *view,
                  const struct rad_panel *angular, int rule_t, const struct rad_panel *radial,
                  int rule_r, const struct rad_tile *tile, int at, double *restrict out) {
  int k_phi = angular->k, n_t = rad_order[rule_t], n_r = rad_order[rule_r];
  const double *t = angular->point[rule_t], *w_t = angular->weight[rule_t];
  double z2[LANES], factor[LANES], scale = patch->a1 * patch->b2 / M_PI;
  for (int i = 0; i < LANES; i++) {
    double z = tile->z[at + i];
    z2[i] = z * z;
    factor[i] = z > 0 ? scale * z : 0;
  }
  for (int q = 0; q < n_t; q++) {
    double sum[RAD_GAUSS_MAX][LANES];
    for (int c = 0; c < k_r; c++)
      for (int i = 0; i < LANES; i++)
        sum[c][i] = 0;
    ray_sums(k_r, tile->x + at, tile->y + at, z2, patch->a1 + t[q] * patch->b1, t[q] * patch->b2,
             view->n0, view->na + t[q] * view->nb, n_r, radial->point[rule_r],
             radial->weight[rule_r], sum);
    for (int c = 0; c < k_r; c++)
      for (int a = 0; a < k_phi; a++) {
        double *restrict o = out + (a + k_phi * c) * RAD_TILE + at, w = w_t[a * n_t + q];
#pragma omp simd
        for (int i = 0; i < LANES; i++)
          o[i] += w * factor[i] * sum[c][i];
      }
  }
}

RAD_CLONES void rad_far(const struct rad_patch *patch, const struct rad_view *view,
                        const struct rad_panel *angular, int angular_rule,
                        const struct rad_panel *radial, int radial_rule, struct rad_tile *tile,
                        int n, double *restrict out) {
  int k_r = radial->k, padded = (n + LANES - 1) / LANES * LANES;
  for (int i = n; i < padded; i++) {
    tile->x[i] = tile->x[n - 1];
    tile->y[i] = tile->y[n - 1];
    tile->z[i] = tile->z[n - 1];
  }
  for (int j = 0; j < angular->k * k_r; j++)
    for (int i = 0; i < padded; i++)
      out[j * RAD_TILE + i] = 0;
  for (int at = 0; at < n; at += LANES) {
    if (k_r == 1)
      lanes(1, patch, view, angular, angular_rule, radial, radial_rule, tile, at, out);
    else if (k_r == 2)
      lanes(2, patch, view, angular, angular_rule, radial, radial_rule, tile, at, out);
    else
      lanes(k_r, patch, view, angular, angular_rule, radial, radial_rule, tile, at, out);
  }
}
