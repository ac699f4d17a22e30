/* Net heat and temperatures of a result whose scene was given by temperatures or fluxes. */
#ifndef RAD_OUTPUT_THERMAL_H
#define RAD_OUTPUT_THERMAL_H

#include "output/hdf.h"
#include "output/result.h"

/* Of n faces: triangles or surfaces. */
struct rad_thermal_list {
  int n;
  double *flux;        /* owned [n] mean of u - h [W/m2] */
  double *power;       /* owned [n] flux times area [W] */
  double *temperature; /* owned [n] fourth root of the mean of T^4 [K]; NaN: none (theory 15.3) */
};

struct rad_thermal {
  struct rad_thermal_list triangle, surface;
  double sum;   /* of the powers [W]: 0 in a closed scene, else what leaves */
  double given; /* of those that are positive [W] */
  int cold;     /* first triangle whose flux leaves it no temperature, or -1 */
};

/* From the means of r->triangle_radiosity, triangle_irradiance. Nothing (n = 0) if the scene is not
 * thermal. To be freed with rad_thermal_free, also after an error. */
enum rad_code rad_thermal_make(const struct rad_result *r, struct rad_thermal *thermal,
                               struct rad_error *e);
void rad_thermal_free(struct rad_thermal *thermal); /* safe twice */

/* Datasets mean_net_flux, net_power and temperature of an open group; none if n = 0. */
void rad_thermal_write(struct rad_hdf *h, hid_t group, const struct rad_thermal_list *list);

#endif
