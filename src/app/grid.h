/* Comparing solutions: the paper's closed 100 x 100 grid on every sub-triangle, and its EOC. */
#ifndef RAD_APP_GRID_H
#define RAD_APP_GRID_H

#include <stddef.h>

#include "app/case.h"

enum { RAD_GRID = 100, RAD_CROWD = 24 };

/* Where solutions are compared: the paper's closed grid of u_h, or, as soon as adaptive runs take
 * part, a grid of phi, r = 1e-6 .. 1 in equal ratios, where adaptive runs report u*. */
enum rad_grid { RAD_GRID_CLOSED, RAD_GRID_CROWDED };
extern const char *const rad_grid_name[];

/* Number of values: triangles x 6 sub-triangles x points x bands. */
size_t rad_grid_size(const struct rad_scene *scene, enum rad_grid grid);

/* The solution of a case on the grid, in the polar (phi, r) of every sub-triangle. */
enum rad_code rad_grid_evaluate(const struct rad_case *c, enum rad_grid grid, double *value,
                                struct rad_error *e);

/**
 * Estimated order alpha when errors behave like c |N^-alpha - N_ref^-alpha| [H, (4.2)]:
 * the reference is itself approximate (theory 7.1). N_ref = INFINITY: an exact reference.
 *
 * @param[in] ratio  error with n0 over error with n1
 * @return NAN if an argument is, or if no alpha in (0, 40) fits
 */
double rad_eoc(double n0, double n1, double n_reference, double ratio);

#endif
