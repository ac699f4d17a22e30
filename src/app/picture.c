/* The picture of a solved case: points and cells of its elements, with the values there. */
#include "app/picture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum { VTK_TRIANGLE = 5, VTK_QUAD = 9, VTK_LAGRANGE_QUADRILATERAL = 70 };

/* Append a cell whose points are in the list; `bound` is the largest of them and the element's. */
static void add_cell(const struct rad_canvas *canvas, struct rad_picture *p, int element, int type,
                     int64_t n) {
  const struct rad_case *c = canvas->c;
  const int64_t *list = p->connectivity + p->offset[p->n_cell];
  p->type[p->n_cell] = (unsigned char)type;
  p->triangle[p->n_cell] = rad_element_triangle(c->mesh, element);
  if (p->bound) {
    double unit = rad_indicator_scale(&c->adaptive.indicator, c->scene.n_band);
    double bound = c->adaptive.element_bound[element] * unit;
    for (int64_t k = 0; k < n; k++)
      bound = fmax(bound, canvas->value[(list[k] + 1) * canvas->width - 1]);
    p->bound[p->n_cell] = bound;
    p->indicator[p->n_cell] = c->adaptive.indicator.local[element] * unit;
  }
  p->n_cell++;
  p->offset[p->n_cell] = p->offset[p->n_cell - 1] + n;
}

/* A linear cell; at r = 0 a triangle. */
static void add_linear(const struct rad_canvas *canvas, const struct rad_tile *tile,
                       struct rad_picture *p) {
  int64_t *list = p->connectivity + p->offset[p->n_cell];
  int tip = tile->j == 0 && canvas->c->mesh->element[tile->element].tau[0] == 0, n = 0;
  for (int k = 0; k < 4; k++)
    if (!tip || k != 1)
      list[n++] = tile->corner[k];
  add_cell(canvas, p, tile->element, tip ? VTK_TRIANGLE : VTK_QUAD, n);
}

/* Place of node (i, j), 0..s, in VTK's order: corners round the cell, then sides (both pairs in the
 * same direction), then the inside row by row. */
static int lagrange_place(int i, int j, int s) {
  int side_i = i == 0 || i == s, side_j = j == 0 || j == s, m = s - 1;
  if (side_i && side_j)
    return i ? (j ? 2 : 1) : (j ? 3 : 0);
  if (side_j)
    return 4 + i - 1 + (j ? 2 * m : 0);
  if (side_i)
    return 4 + j - 1 + (i ? m : 3 * m);
  return 4 + 4 * m + (i - 1) + m * (j - 1);
}

/* One cell of order s. At r = 0 its side has the length 0, but a value for each direction. */
static void add_lagrange(const struct rad_canvas *canvas, int element, int64_t first,
                         struct rad_picture *p) {
  int s = rad_picture_steps(canvas->c, element);
  int64_t *list = p->connectivity + p->offset[p->n_cell];
  for (int j = 0; j <= s; j++)
    for (int i = 0; i <= s; i++)
      list[lagrange_place(i, j, s)] = first + j * (s + 1) + i;
  add_cell(canvas, p, element, VTK_LAGRANGE_QUADRILATERAL, (int64_t)(s + 1) * (s + 1));
}

/* Cells of all elements, with dots as their points. */
static void add_cells(const struct rad_canvas *canvas, const int64_t *first,
                      struct rad_picture *p) {
  int64_t t = 0;
  for (int i = 0; i < canvas->c->mesh->n_element; i++)
    if (rad_picture_is_lagrange(canvas->c, i))
      add_lagrange(canvas, i, first[i], p);
    else
      for (; t < canvas->n_tile && canvas->tile[t].element == i; t++)
        add_linear(canvas, &canvas->tile[t], p);
}

/* Position and values of a dot. */
static void set_point(const struct rad_canvas *canvas, int64_t dot, int64_t at,
                      struct rad_picture *p) {
  const struct rad_case *c = canvas->c;
  const struct rad_dot *d = &canvas->dot[dot];
  const struct rad_element *el = &c->mesh->element[d->element];
  const struct rad_patch *patch = &c->mesh->patch[el->patch];
  size_t nb = (size_t)c->scene.n_band;
  const double *value = canvas->value + dot * canvas->width;
  double mu[2];
  rad_patch_mu(patch, pow(d->sigma, el->p_phi), pow(d->tau, el->p_r), mu);
  rad_triangle_point(&c->scene.triangle[patch->triangle], patch->base, mu, p->point + 3 * at);
  memcpy(p->irradiance + (size_t)at * nb, value, nb * sizeof *value);
  memcpy(p->radiosity + (size_t)at * nb, value + nb, nb * sizeof *value);
}

/* Points are the dots that cells use, in their order; connectivity is renumbered. */
static void keep_used(const struct rad_canvas *canvas, int64_t *number, struct rad_picture *p) {
  for (int64_t i = 0; i < canvas->n_dot; i++)
    number[i] = -1;
  for (int64_t k = 0; k < p->offset[p->n_cell]; k++)
    number[p->connectivity[k]] = 0;
  for (int64_t i = 0; i < canvas->n_dot; i++)
    if (number[i] == 0) {
      number[i] = p->n_point++;
      set_point(canvas, i, number[i], p);
    }
  for (int64_t k = 0; k < p->offset[p->n_cell]; k++)
    p->connectivity[k] = number[p->connectivity[k]];
}

static enum rad_code collect(const struct rad_canvas *canvas, const int64_t *first,
                             struct rad_picture *p, struct rad_error *e) {
  const struct rad_case *c = canvas->c;
  size_t points = (size_t)canvas->n_dot, cells = (size_t)canvas->n_tile,
         nb = (size_t)c->scene.n_band;
  size_t corners = 4 * cells;
  for (int i = 0; i < c->mesh->n_element; i++)
    if (rad_picture_is_lagrange(c, i)) {
      size_t side = (size_t)rad_picture_steps(c, i) + 1;
      cells++;
      corners += side * side;
    }
  *p = (struct rad_picture){.point = rad_alloc(points, 3 * sizeof(double)),
                            .connectivity = rad_alloc(corners, sizeof(int64_t)),
                            .offset = rad_calloc(cells + 1, sizeof(int64_t)),
                            .type = rad_alloc(cells, 1),
                            .triangle = rad_alloc(cells, sizeof(int)),
                            .radiosity = rad_alloc(points * nb, sizeof(double)),
                            .irradiance = rad_alloc(points * nb, sizeof(double)),
                            .indicator = c->has_bound ? rad_alloc(cells, sizeof(double)) : NULL,
                            .bound = c->has_bound ? rad_alloc(cells, sizeof(double)) : NULL};
  int64_t *number = rad_alloc(points, sizeof *number);
  enum rad_code code = RAD_OK;
  if (!number || !p->point || !p->connectivity || !p->offset || !p->type || !p->triangle ||
      !p->radiosity || !p->irradiance || (c->has_bound && (!p->indicator || !p->bound))) {
    code = rad_fail_memory(e, "the picture (output.sampling)",
                           (double)points * (56 + 16.0 * (double)nb));
  } else {
    add_cells(canvas, first, p);
    keep_used(canvas, number, p);
  }
  free(number);
  return code;
}

enum rad_code rad_case_picture(const struct rad_case *c, struct rad_picture *p,
                               struct rad_error *e) {
  struct rad_canvas canvas;
  int64_t *first = rad_alloc((size_t)c->mesh->n_element, sizeof *first);
  enum rad_code code = rad_canvas_begin(c, &canvas, e);
  if (!code && !first)
    code = rad_fail_memory(e, "the picture (output.sampling)", 8.0 * c->mesh->n_element);
  if (!code)
    code = rad_canvas_fill(&canvas, first, e);
  if (!code)
    code = collect(&canvas, first, p, e);
  rad_canvas_free(&canvas);
  free(first);
  return code;
}
