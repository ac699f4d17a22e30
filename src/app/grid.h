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

/* Of study.values, as an end of the grid's name in the file of a task; none for auto. */
extern const char *const rad_values_name[];

/* Number of values: triangles x 6 sub-triangles x points x bands. */
size_t rad_grid_size(const struct rad_scene *scene, enum rad_grid grid);

/* Values of one band. */
size_t rad_grid_points(enum rad_grid grid, int n_triangle);

/* The solution of a case on the grid, in the polar (phi, r) of every sub-triangle. */
enum rad_code rad_grid_evaluate(const struct rad_case *c, enum rad_grid grid, int star,
                                double *value, struct rad_error *e);

/* How far two solutions on the grid are apart, the worst band. */
struct rad_difference {
  double largest;     /* max |a - b| */
  double mean_square; /* root of the mean of (a - b)^2 over the surface, by the trapezoidal rule */
};

/* @param[in] area  [n_triangle];  a, b: values on the grid, as rad_grid_evaluate gives them */
struct rad_difference rad_grid_difference(enum rad_grid grid, int n_triangle, int n_band,
                                          const double *area, const double *a, const double *b);

/**
 * Estimated order alpha when errors behave like c |N^-alpha - N_ref^-alpha| [H, (4.2)]:
 * the reference is itself approximate (theory 7.1). N_ref = INFINITY: an exact reference.
 *
 * @param[in] ratio  error with n0 over error with n1
 * @return NAN if an argument is, or if no alpha in (0, 40) fits
 */
double rad_eoc(double n0, double n1, double n_reference, double ratio);

#endif
