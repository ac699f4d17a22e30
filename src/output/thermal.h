/* Net heat and temperatures of a result whose scene was given by temperatures or fluxes. */
#ifndef RAD_OUTPUT_THERMAL_H
#define RAD_OUTPUT_THERMAL_H

#include "output/hdf.h"
#include "output/result.h"

/* Of n faces: triangles or surfaces. Errors are bounds; NaN: not known. */
struct rad_thermal_list {
  int n;
  double *flux, *error_flux;   /* owned [n] mean of u - h [W/m2]; exact where it was given */
  double *power, *error_power; /* owned [n] flux times area [W] */
  double *temperature; /* owned [n] fourth root of the mean of T^4 [K]; NaN: none (theory 15.3) */
  double
      *error_temperature; /* owned [n] the larger way to the ends of T^4 +- error, 0 K at least */
};

struct rad_thermal {
  struct rad_thermal_list triangle, surface;
  double sum, error_sum; /* of the powers [W]: 0 in a closed scene, else what leaves */
  double given;          /* of those that are positive [W] */
  int cold;              /* first triangle whose flux leaves it no temperature, or -1 */
};

/* From the means of the triangles. Nothing (n = 0) if the scene is not thermal or there are no
 * means. To be freed with rad_thermal_free, also after an error. */
enum rad_code rad_thermal_make(const struct rad_scene *scene, const struct rad_means *means,
                               struct rad_thermal *thermal, struct rad_error *e);
void rad_thermal_free(struct rad_thermal *thermal); /* safe twice */

/* Datasets mean_net_flux, net_power, temperature and their errors of an open group; none if n = 0.
 */
void rad_thermal_write(struct rad_hdf *h, hid_t group, const struct rad_thermal_list *list);

#endif
