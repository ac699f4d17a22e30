/* Comparing solutions: the paper's closed 100 x 100 grid on every sub-triangle, and its EOC. */
#ifndef RAD_APP_GRID_H
#define RAD_APP_GRID_H

#include <stddef.h>

#include "app/case.h"

enum { RAD_GRID = 100 };

/* Number of values: triangles x 6 sub-triangles x 100 x 100 x bands. */
size_t rad_grid_size(const struct rad_scene *scene);

/* u_h of a solved case at (i/99, j/99) of the polar (phi, r) of every sub-triangle. */
void rad_grid_evaluate(const struct rad_case *c, double *value);

/**
 * Estimated order alpha when errors behave like c |N^-alpha - N_ref^-alpha| [H, (4.2)]:
 * the reference is itself approximate (theory 7.1). N_ref = INFINITY: an exact reference.
 *
 * @param[in] ratio  error with n0 over error with n1
 * @return NAN if an argument is, or if no alpha in (0, 40) fits
 */
double rad_eoc(double n0, double n1, double n_reference, double ratio);

int rad_grid_threads(void);

#endif
