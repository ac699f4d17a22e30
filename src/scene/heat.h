/* Heat radiation of grey faces: from temperature and emissivity to E and rho, and back. */
#ifndef RAD_SCENE_HEAT_H
#define RAD_SCENE_HEAT_H

#include "scene/scene.h"

/* sigma = 2 pi^5 k^4 / (15 h^3 c^2) [W/(m2 K4)] of the exact constants of the SI (CODATA 2018). */
#define RAD_STEFAN_BOLTZMANN 5.670374419184429e-8

/* E and rho of the equation (theory 15.1): E = eps sigma T^4, rho = 1 - eps; where the net flux q
 * is given, u = q + h, so E = q, rho = 1. */
double rad_heat_emission(const struct rad_heat *heat); /* [W/m2] */
double rad_heat_rho(const struct rad_heat *heat);

/**
 * T^4 of a face [K4]: as given, or (h + q/eps)/sigma (theory 15.2), which is negative where more
 * flux is drawn than arrives; NaN for RAD_HEAT_NONE.
 *
 * @param[in] irradiance  h [W/m2] at a point, or a mean
 */
double rad_heat_fourth_power(const struct rad_heat *heat, double irradiance);

/* Fourth root; NaN of a negative number. */
double rad_heat_temperature(double fourth_power);

#endif
