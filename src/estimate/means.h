/* Means over triangles of radiosity and irradiance, with the errors that are left in them. */
#ifndef RAD_ESTIMATE_MEANS_H
#define RAD_ESTIMATE_MEANS_H

#include "estimate/indicator.h"
#include "estimate/received.h"

/* Of n triangles, or of n surfaces. Arrays [n, n_band], owned. */
struct rad_means {
  int n, n_band;
  double *radiosity, *irradiance;             /* of u* and K u [W/m2] */
  double *error_radiosity, *error_irradiance; /* at most so far from those of u; NAN: not known */
  double *integration; /* the part of error_irradiance that integrals make, always known */
  double worst;        /* largest error over the largest radiosity of its band; NAN: not known */
  int worst_triangle;
  int is_enclosed;                  /* by topology (enclosure.h) */
  double sent[RAD_MAX_BAND];        /* int dS of the u that irradiance is made from [W] */
  double on_backs[RAD_MAX_BAND];    /* what backs of faces receive of it [W]; NAN: not known */
  double backs_error[RAD_MAX_BAND]; /* of on_backs [W] */
  double seconds;
};

/* What a solution on a mesh is known for. */
struct rad_estimate {
  const struct rad_indicator *indicator;
  const double *element_bound; /* [n_element] z + e~ over max |u|    (theory 17.2) */
};

/**
 * Means of a solution with an estimate: h = K u~ with u~ the interpolant of u* on the finer mesh,
 *
 *   |mean h(u) - mean K u~| <= mean |K (d - d~)| + mean K (z + e~)               (theory 17.2)
 *
 * with e~ what integrals, compression and the interpolant leave in u~.
 *
 * @param[in]  tolerance  of the bound over max |u|: integrals are made to a part of it
 * @param[out] m  to be freed with rad_means_free, also after an error
 */
enum rad_code rad_means_estimated(const struct rad_estimate *x, double tolerance,
                                  struct rad_means *m, struct rad_error *e);

/* Means of u_h [n_band, n_point] without an estimate: errors are NAN, but for the integrals'. */
enum rad_code rad_means_plain(const struct rad_mesh *mesh, const double *u, double tolerance,
                              struct rad_means *m, struct rad_error *e);

/* Area-weighted means over the scene's surfaces, of those over its triangles; errors add up. */
enum rad_code rad_means_of_surfaces(const struct rad_scene *scene, const struct rad_means *triangle,
                                    struct rad_means *surface, struct rad_error *e);

void rad_means_free(struct rad_means *m); /* safe twice */

#endif
