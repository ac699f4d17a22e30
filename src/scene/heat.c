#include "scene/heat.h"

#include <math.h>

double rad_heat_emission(const struct rad_heat *heat) {
  double t2 = heat->temperature * heat->temperature;
  return heat->kind == RAD_HEAT_FLUX ? heat->flux
                                     : heat->emissivity * RAD_STEFAN_BOLTZMANN * t2 * t2;
}

double rad_heat_rho(const struct rad_heat *heat) {
  return heat->kind == RAD_HEAT_FLUX ? 1 : 1 - heat->emissivity;
}

double rad_heat_fourth_power(const struct rad_heat *heat, double irradiance) {
  double t2 = heat->temperature * heat->temperature;
  return heat->kind == RAD_HEAT_NONE ? NAN
         : heat->kind == RAD_HEAT_TEMPERATURE
             ? t2 * t2
             : (irradiance + heat->flux / heat->emissivity) / RAD_STEFAN_BOLTZMANN;
}

double rad_heat_temperature(double fourth_power) {
  return fourth_power < 0 ? NAN : sqrt(sqrt(fourth_power));
}
