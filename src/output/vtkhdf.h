/* The picture of a result as VTKHDF, which ParaView and pyvista open directly. */
#ifndef RAD_OUTPUT_VTKHDF_H
#define RAD_OUTPUT_VTKHDF_H

#include "output/hdf.h"
#include "output/result.h"

/**
 * Write group /VTKHDF, an UnstructuredGrid of version 2.0.
 *
 * Points and cells are those of result->picture. Point data: radiosity and irradiance as given;
 * rho, emission and surface of the triangle whose cell holds the point, emission varying linearly
 * over the triangle. Cell data: radiosity, irradiance and emission are means over its points.
 * Arrays are [n] for one band, else [n, n_band]. Radiosity and irradiance are left out when the
 * deck's output.fields does not name them, or when the picture has none. A point of no cell has
 * surface -1, rho and emission NaN.
 *
 * Needs 2 * n_band + 1 numbers a point, for as long as it writes. Errors are kept in h.
 */
void rad_vtkhdf_write(struct rad_hdf *h, const struct rad_result *result);

#endif
