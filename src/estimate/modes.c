#include "estimate/modes.h"

#include <math.h>

/* e^-rate per degree fitted to the last modes; modes at rounding level decay fast enough. */
static double decay(const double *mode, int n) {
  int from = n > 6 ? n - 6 : 1, count = 0;
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int m = from; m < n; m++) {
    double y = log(fmax(mode[m], 1e-16)), x = m;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
    count++;
  }
  double det = count * sxx - sx * sx;
  return det > 0 ? -(count * sxy - sx * sy) / det : 1;
}

void rad_modes(const struct rad_mesh *fine, int i, const struct rad_element *coarse, int n_band,
               const double *star, const double *scale, struct rad_modes out) {
  const struct rad_element *f = &fine->element[i];
  const double *xp = rad_gauss_node(&fine->gauss, f->k_phi),
               *wp = rad_gauss_weight(&fine->gauss, f->k_phi);
  const double *xr = rad_gauss_node(&fine->gauss, f->k_r),
               *wr = rad_gauss_weight(&fine->gauss, f->k_r);
  double pp[RAD_GAUSS_MAX][RAD_GAUSS_MAX], pr[RAD_GAUSS_MAX][RAD_GAUSS_MAX];
  double mode_phi[RAD_GAUSS_MAX] = {0}, mode_r[RAD_GAUSS_MAX] = {0};
  for (int q = 0; q < f->k_phi; q++)
    rad_legendre(f->k_phi, xp[q], pp[q]);
  for (int q = 0; q < f->k_r; q++)
    rad_legendre(f->k_r, xr[q], pr[q]);
  for (int b = 0; b < n_band; b++) {
    if (scale[b] == 0)
      continue;
    const double *u = star + (size_t)b * (size_t)fine->n_point + f->first;
    for (int n = 0; n < f->k_r; n++)
      for (int m = 0; m < f->k_phi; m++) {
        double a = 0;
        for (int r = 0; r < f->k_r; r++)
          for (int q = 0; q < f->k_phi; q++)
            a += wp[q] * wr[r] * pp[q][m] * pr[r][n] * u[q + f->k_phi * r];
        a = fabs(a) * (2 * m + 1) * (2 * n + 1) / (4 * scale[b]);
        mode_phi[m] += a;
        mode_r[n] += a;
      }
  }
  for (int m = coarse->k_phi; m < f->k_phi; m++)
    *out.tail_phi += mode_phi[m];
  for (int n = coarse->k_r; n < f->k_r; n++)
    *out.tail_r += mode_r[n];
  *out.rate_phi = decay(mode_phi, f->k_phi);
  *out.rate_r = decay(mode_r, f->k_r);
}
