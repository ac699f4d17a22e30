/* What the picture of a solved case is made of, while it is made. */
#ifndef RAD_APP_PICTURE_H
#define RAD_APP_PICTURE_H

#include <stdint.h>

#include "app/case.h"

/* A point of an element, in its graded variables. */
struct rad_dot {
  int element;
  double sigma, tau;
};

/* A quadrilateral of an element: number (i, j) of the parts that its cells, `steps` a direction,
 * make when halved `level` times. */
struct rad_tile {
  int element, level, i, j;
  int is_open;       /* its samples have not been looked at */
  int deepest;       /* level down to which it and its parts may be halved */
  int64_t corner[4]; /* dots, round it from (i, j) towards (i + 1, j) */
  int64_t sample;    /* first of its list, or -1 */
};

/* A dot inside a tile that tells whether the corners show what is there. */
struct rad_sample {
  int64_t dot, next;
};

struct rad_canvas {
  const struct rad_case *c; /* borrowed */
  struct rad_once once;     /* K u_h, and K z of the bound; only if there is one */
  int is_dark;              /* nothing emits: all values are 0 */
  int width;                /* numbers of a dot: h and u of all bands, bound */
  int64_t n_dot, n_tile, n_sample;
  size_t room_dot, room_value, room_tile, room_sample;
  struct rad_dot *dot;       /* owned; by element, as far as they were made at a time */
  double *value;             /* owned [n_dot, width] [W/m2] */
  struct rad_tile *tile;     /* owned, by element; none where an element is one Lagrange cell */
  struct rad_sample *sample; /* owned */
};

/* Cells per direction of an element before any is halved; or the order of its Lagrange cell. */
int rad_picture_steps(const struct rad_case *c, int element);

/* True if an element is one Lagrange cell. Black faces never are: their light may be anything. */
int rad_picture_is_lagrange(const struct rad_case *c, int element);

/* Most tiles that halving may add where the mesh was made by hand: there it is for feet only. */
enum rad_code rad_picture_halved(const struct rad_case *c, double *most, struct rad_error *e);

enum rad_code rad_canvas_begin(const struct rad_case *c, struct rad_canvas *canvas,
                               struct rad_error *e);
void rad_canvas_free(struct rad_canvas *canvas); /* safe twice */

/* Append a dot; its number, or -1 without memory. */
int64_t rad_canvas_add(struct rad_canvas *canvas, int element, double sigma, double tau);

/* Values of the dots from `from` on, which are in the order of their elements: u* and h = K u_h
 * where there is a bound, at edges their limits from inside the face; else u_h and h interpolated.
 */
enum rad_code rad_canvas_evaluate(struct rad_canvas *canvas, int64_t from, struct rad_error *e);

/**
 * Dots and tiles of all elements, evaluated. Where u_h is no guide, on black faces and below what
 * the mesh does not resolve, tiles are halved until their corners, interpolated, show the
 * irradiance in their middles and below what is near to 0.02 of the face's largest: three times,
 * and three times more often than what holds such a place, at most RAD_PICTURE_HALVINGS times.
 *
 * @param[out] first_dot  [n_element] of each element's grid
 */
enum rad_code rad_canvas_fill(struct rad_canvas *canvas, int64_t *first_dot, struct rad_error *e);

enum { RAD_PICTURE_HALVINGS = 12 };

#endif
