/* Points and tiles of the picture: a grid in each element, halved where it shows too little. */
#include <math.h>
#include <stdlib.h>

#include "app/picture.h"
#include "base/memory.h"

/* VTK's limit on the order of its Lagrange cells. */
enum { MOST_ORDER = 10 };

/* Corners, interpolated, show samples to this part of the face's largest irradiance; and what u_h
 * knows, which is everywhere, a little coarser, for the sake of time. */
#define SHOWN 0.02
#define SHOWN_KNOWN 0.05

/* A foot where the samples of the estimate miss less than this part is left to what u_h knows. */
#define MISSED 0.1

/* Halvings where nothing is near, as at vertices in which faces of different light meet, and beyond
 * what holds a foot: what happens there reaches a few times as far as it is wide. */
enum { HALVINGS = 3 };

/* Most tiles that halving makes of one element, and of all together over those of the grid. */
enum { MOST_OF_ELEMENT = 4096, MOST_OF_ALL = 4, LEAST_OF_ALL = 100000 };

static int larger(int a, int b) {
  return a > b ? a : b;
}

static int passive(const struct rad_case *c, int element) {
  const unsigned char *list = c->has_bound ? c->adaptive.layout.passive : NULL;
  return list ? list[rad_element_triangle(c->mesh, element)] : RAD_ACTIVE;
}

int rad_picture_is_lagrange(const struct rad_case *c, int element) {
  return c->deck.output.cells == RAD_CELLS_LAGRANGE && passive(c, element) != RAD_BLACK;
}

/* Linear cells: as asked, and in adaptive runs at least half the element's degree, or its shape is
 * lost. One Lagrange cell: its degree, and enough for its coordinates, which are polynomials of
 * degree p in a graded variable (times tan of one). */
int rad_picture_steps(const struct rad_case *c, int element) {
  const struct rad_element *e = &c->mesh->element[element];
  int s = c->deck.output.sampling, k = larger(e->k_phi, e->k_r);
  if (!rad_picture_is_lagrange(c, element))
    return c->is_adaptive ? larger(s, (k + 1) / 2) : s;
  s = larger(larger(s, k - 1), 2 * (int)ceil(fmax(e->p_phi, e->p_r)));
  return s < MOST_ORDER ? s : MOST_ORDER;
}

/* Number i of n equal parts of a range; its ends exactly. */
static double part_of(const double range[2], int i, int n) {
  return i == n ? range[1] : range[0] + (range[1] - range[0]) * i / n;
}

/* Lattice point (i, j) of n parts a direction. */
static int64_t add_at(struct rad_canvas *p, int element, int i, int j, int n) {
  const struct rad_element *e = &p->c->mesh->element[element];
  return rad_canvas_add(p, element, part_of(e->sigma, i, n), part_of(e->tau, j, n));
}

static struct rad_tile *add_tile(struct rad_canvas *p, struct rad_tile tile) {
  if (!rad_reserve((void **)&p->tile, (size_t)p->n_tile + 1, &p->room_tile, sizeof tile))
    return NULL;
  p->tile[p->n_tile] = tile;
  return &p->tile[p->n_tile++];
}

static int add_sample(struct rad_canvas *p, struct rad_tile *tile, int64_t dot) {
  if (dot < 0 || !rad_reserve((void **)&p->sample, (size_t)p->n_sample + 1, &p->room_sample,
                              sizeof *p->sample))
    return 0;
  p->sample[p->n_sample] = (struct rad_sample){dot, tile->sample};
  tile->sample = p->n_sample++;
  return 1;
}

/* The middle of a tile as a sample. */
static int add_middle(struct rad_canvas *p, struct rad_tile *tile) {
  int n = rad_picture_steps(p->c, tile->element) << (tile->level + 1);
  return add_sample(p, tile, add_at(p, tile->element, 2 * tile->i + 1, 2 * tile->j + 1, n));
}

/* ---- what is in a tile ----------------------------------------------------------------------- */

/* A dot's place in a tile, 0..1. */
static void inside(const struct rad_canvas *p, const struct rad_tile *t, const struct rad_dot *dot,
                   double at[2]) {
  const struct rad_element *e = &p->c->mesh->element[t->element];
  int n = rad_picture_steps(p->c, t->element) << t->level;
  double sigma = (dot->sigma - e->sigma[0]) / (e->sigma[1] - e->sigma[0]) * n - t->i;
  double tau = (dot->tau - e->tau[0]) / (e->tau[1] - e->tau[0]) * n - t->j;
  at[0] = fmin(fmax(sigma, 0), 1);
  at[1] = fmin(fmax(tau, 0), 1);
}

/* True if the corners do not show a sample. most: [n_triangle, n_band] largest |h| */
static int is_missed(const struct rad_canvas *p, const struct rad_tile *t, int64_t dot,
                     const double *most) {
  int nb = p->c->scene.n_band, triangle = rad_element_triangle(p->c->mesh, t->element);
  double at[2];
  inside(p, t, &p->dot[dot], at);
  const double weight[4] = {(1 - at[0]) * (1 - at[1]), at[0] * (1 - at[1]), at[0] * at[1],
                            (1 - at[0]) * at[1]};
  for (int b = 0; b < nb; b++) {
    double shown = 0;
    for (int k = 0; k < 4; k++)
      shown += weight[k] * p->value[t->corner[k] * p->width + b];
    if (fabs(p->value[dot * p->width + b] - shown) > SHOWN * most[triangle * nb + b])
      return 1;
  }
  return 0;
}

/* h of the collocation points in the middle of a tile and of its sides, less what its corners show
 * there, the largest, for one band. */
static double bend(const struct rad_canvas *p, const struct rad_tile *t, int band) {
  const struct rad_case *c = p->c;
  const struct rad_element *e = &c->mesh->element[t->element];
  const double *h = c->h + (size_t)band * (size_t)c->mesh->n_point + e->first;
  int n = 2 * rad_picture_steps(c, t->element) << t->level;
  double v[3][3], basis[RAD_GAUSS_MAX * RAD_GAUSS_MAX], most = 0;
  for (int k = 0; k < 9; k++) {
    int i = k % 3, j = k / 3;
    double sigma = part_of(e->sigma, 2 * t->i + i, n), tau = part_of(e->tau, 2 * t->j + j, n);
    rad_element_basis(c->mesh, t->element, pow(sigma, e->p_phi), pow(tau, e->p_r), basis);
    v[j][i] = 0;
    for (int f = 0; f < e->n_function; f++)
      v[j][i] += basis[f] * h[f];
  }
  for (int k = 0; k < 3; k += 2) {
    most = fmax(most, fabs(v[k][1] - 0.5 * (v[k][0] + v[k][2])));
    most = fmax(most, fabs(v[1][k] - 0.5 * (v[0][k] + v[2][k])));
  }
  return fmax(most, fabs(v[1][1] - 0.25 * (v[0][0] + v[0][2] + v[2][0] + v[2][2])));
}

/* True if the mesh knows of more in a tile than its corners show. */
static int is_bent(const struct rad_canvas *p, const struct rad_tile *t, const double *most) {
  int nb = p->c->scene.n_band, triangle = rad_element_triangle(p->c->mesh, t->element);
  for (int b = 0; b < nb; b++)
    if (bend(p, t, b) > SHOWN_KNOWN * most[triangle * nb + b])
      return 1;
  return 0;
}

static int misses_any(const struct rad_canvas *p, const struct rad_tile *t, const double *most) {
  for (int64_t s = t->sample; s >= 0; s = p->sample[s].next)
    if (is_missed(p, t, p->sample[s].dot, most))
      return 1;
  return passive(p->c, t->element) == RAD_ACTIVE && is_bent(p, t, most);
}

/* The largest |h| of each face among the dots from `from` on. */
static void see_largest(const struct rad_canvas *p, int64_t from, double *most) {
  int nb = p->c->scene.n_band;
  for (int64_t i = from; i < p->n_dot; i++) {
    double *of = most + rad_element_triangle(p->c->mesh, p->dot[i].element) * nb;
    for (int b = 0; b < nb; b++)
      of[b] = fmax(of[b], fabs(p->value[i * p->width + b]));
  }
}

/* ---- feet ------------------------------------------------------------------------------------ */

/* Places below what is near to a face, by element: those on black faces, which the mesh does not
 * look at, and those of the others at which the samples of its estimate miss something. */
struct feet {
  struct rad_feet black;        /* owned */
  int *head;                    /* owned [n_element] first foot, or -1 */
  int *next;                    /* owned [feet] next of the element, or -1 */
  const struct rad_foot **foot; /* owned [feet] */
};

static void feet_free(struct feet *f) {
  rad_feet_free(&f->black);
  free(f->head);
  free(f->next);
  free(f->foot);
}

/* The largest irradiance that the mesh knows of on an element's face. */
static double largest_known(const struct rad_case *c, int element) {
  int t = rad_element_triangle(c->mesh, element);
  double most = 0;
  for (int b = 0; b < c->scene.n_band; b++)
    for (int q = c->mesh->point_first[t]; q < c->mesh->point_first[t + 1]; q++)
      most = fmax(most, fabs(c->h[(size_t)b * (size_t)c->mesh->n_point + (size_t)q]));
  return most;
}

static enum rad_code feet_find(const struct rad_case *c, struct feet *f, struct rad_error *e) {
  *f = (struct feet){.head = NULL};
  int n_triangle = c->scene.n_triangle, n_element = c->mesh->n_element;
  const unsigned char *passive_of = c->has_bound ? c->adaptive.layout.passive : NULL;
  unsigned char *others = rad_alloc((size_t)n_triangle, 1);
  f->head = rad_alloc((size_t)n_element, sizeof(int));
  if (!others || !f->head) {
    free(others);
    return rad_fail_memory(e, "the picture", 4.0 * n_element);
  }
  for (int t = 0; t < n_triangle; t++)
    others[t] = !passive_of || passive_of[t] != RAD_BLACK;
  enum rad_code code = rad_feet_find(c->mesh, c->visibility.sight, others, &f->black, e);
  free(others);
  if (code)
    return code;
  const struct rad_feet *known = &c->adaptive.indicator.feet;
  int n_known = c->has_bound ? known->n_foot : 0, n = n_known + f->black.n_foot;
  f->next = rad_alloc((size_t)n, sizeof(int));
  f->foot = rad_alloc((size_t)n, sizeof *f->foot);
  if (!f->next || !f->foot)
    return rad_fail_memory(e, "the picture", 12.0 * n);
  for (int i = 0; i < n_element; i++)
    f->head[i] = -1;
  for (int i = 0; i < n; i++) {
    f->foot[i] = i < n_known ? &known->foot[i] : &f->black.foot[i - n_known];
    if (i < n_known && known->foot[i].missed <= MISSED * largest_known(c, known->foot[i].element))
      continue;
    f->next[i] = f->head[f->foot[i]->element];
    f->head[f->foot[i]->element] = i;
  }
  return RAD_OK;
}

/* ---- the grid -------------------------------------------------------------------------------- */

/* The grid of an element, with its tiles; 0 without memory. */
static int add_grid(struct rad_canvas *p, int element, int64_t *first) {
  int s = rad_picture_steps(p->c, element), done = 1;
  *first = p->n_dot;
  for (int j = 0; j <= s; j++)
    for (int i = 0; i <= s && done; i++)
      done = add_at(p, element, i, j, s) >= 0;
  for (int j = 0; j < s && done && !rad_picture_is_lagrange(p->c, element); j++)
    for (int i = 0; i < s && done; i++) {
      int64_t at = *first + j * (s + 1) + i;
      struct rad_tile tile = {element, 0, i, j, 0, HALVINGS, {at, at + 1, at + s + 2, at + s + 1},
                              -1};
      done = add_tile(p, tile) != NULL;
    }
  return done;
}

static int clamp(double x, int n) {
  return x < 0 ? 0 : x < n ? (int)x : n - 1;
}

/* A foot as a sample of its tile; the element's tiles begin at `tile`. */
static int add_foot(struct rad_canvas *p, int element, int64_t tile, const struct rad_foot *foot) {
  const struct rad_element *e = &p->c->mesh->element[element];
  int s = rad_picture_steps(p->c, element);
  double sigma = rad_ungraded(foot->phi, e->p_phi), tau = rad_ungraded(foot->r, e->p_r);
  int i = clamp((sigma - e->sigma[0]) / (e->sigma[1] - e->sigma[0]) * s, s);
  int j = clamp((tau - e->tau[0]) / (e->tau[1] - e->tau[0]) * s, s);
  struct rad_tile *t = &p->tile[tile + j * s + i];
  t->is_open = 1;
  return add_sample(p, t, rad_canvas_add(p, element, sigma, tau));
}

/* Samples of an element: its feet; and the middles of its tiles, on a black face or if there are
 * feet: then u_h, which only needs to be right where it matters for others, is no guide. */
static int add_samples(struct rad_canvas *p, int element, int64_t tile, const struct feet *feet) {
  int done = 1;
  for (int f = feet->head[element]; f >= 0 && done; f = feet->next[f])
    done = add_foot(p, element, tile, feet->foot[f]);
  for (int64_t t = tile; t < p->n_tile && done; t++) {
    if (passive(p->c, element) == RAD_BLACK || feet->head[element] >= 0)
      done = add_middle(p, &p->tile[t]);
    p->tile[t].is_open = 1;
  }
  return done;
}

/* ---- halving --------------------------------------------------------------------------------- */

/* True if a sample of a tile is not its middle. */
static int has_foot(const struct rad_canvas *p, const struct rad_tile *t) {
  return t->sample >= 0 && p->sample[t->sample].next >= 0;
}

/* The four tiles of one, in `four`; the samples go to them. 0 without memory. */
static int quarter(struct rad_canvas *p, const struct rad_tile *t, struct rad_tile four[4]) {
  int n = rad_picture_steps(p->c, t->element) << (t->level + 1), done = 1;
  int deepest = has_foot(p, t) ? larger(t->deepest, t->level + 1 + HALVINGS) : t->deepest;
  int64_t dot[3][3];
  for (int j = 0; j < 3; j++)
    for (int i = 0; i < 3; i++) {
      int is_corner = i != 1 && j != 1;
      dot[j][i] = is_corner ? t->corner[j == 0 ? (i == 0 ? 0 : 1) : (i == 0 ? 3 : 2)]
                            : add_at(p, t->element, 2 * t->i + i, 2 * t->j + j, n);
      done = done && dot[j][i] >= 0;
    }
  for (int k = 0; k < 4; k++) {
    int i = k % 2, j = k / 2;
    four[k] = (struct rad_tile){t->element,
                                t->level + 1,
                                2 * t->i + i,
                                2 * t->j + j,
                                1,
                                deepest,
                                {dot[j][i], dot[j][i + 1], dot[j + 1][i + 1], dot[j + 1][i]},
                                -1};
  }
  for (int64_t s = t->sample, next; s >= 0 && done; s = next) {
    double at[2];
    next = p->sample[s].next;
    inside(p, t, &p->dot[p->sample[s].dot], at);
    if (at[0] == 0.5 && at[1] == 0.5)
      continue; /* the old middle is a corner now */
    struct rad_tile *to = &four[(at[0] >= 0.5) + 2 * (at[1] >= 0.5)];
    p->sample[s].next = to->sample;
    to->sample = s;
  }
  for (int k = 0; k < 4 && done && t->sample >= 0; k++)
    done = add_middle(p, &four[k]);
  return done;
}

/* Halve the open tiles that show too little, as far as there is room; the list stays by element.
 * Returns how many were, or -1 without memory. */
static int64_t halve(struct rad_canvas *p, const double *most, int64_t room) {
  struct rad_tile *old = p->tile;
  int64_t n_old = p->n_tile, n = 0, of_element = 0;
  int done = 1;
  p->tile = NULL;
  p->n_tile = 0;
  p->room_tile = 0;
  for (int64_t t = 0; t < n_old && done; t++) {
    struct rad_tile four[4], one = old[t];
    of_element = t > 0 && old[t - 1].element == one.element ? of_element : 0;
    int splits = one.is_open && n < room && of_element < MOST_OF_ELEMENT &&
                 one.level < one.deepest && one.level < RAD_PICTURE_HALVINGS &&
                 misses_any(p, &one, most);
    of_element += splits ? 4 : 1;
    one.is_open = 0;
    if (splits) {
      n++;
      done = quarter(p, &one, four);
      for (int k = 0; k < 4 && done; k++)
        done = add_tile(p, four[k]) != NULL;
    } else {
      done = add_tile(p, one) != NULL;
    }
  }
  free(old);
  return done ? n : -1;
}

static enum rad_code fail_memory(const struct rad_canvas *p, struct rad_error *e) {
  return rad_fail_memory(e, "the picture (output.sampling)",
                         (double)p->n_dot * (24 + 8.0 * p->width));
}

static int64_t most_of_all(int64_t grids) {
  return grids > LEAST_OF_ALL / MOST_OF_ALL ? MOST_OF_ALL * grids : LEAST_OF_ALL;
}

enum rad_code rad_picture_halved(const struct rad_case *c, double *most, struct rad_error *e) {
  struct rad_feet feet;
  size_t n = (size_t)c->mesh->n_element;
  double s = c->deck.output.sampling, grids = (double)n * s * s, halved = 0;
  unsigned char *has_foot = rad_calloc(n, 1);
  enum rad_code code = rad_feet_find(c->mesh, c->visibility.sight, NULL, &feet, e);
  if (!code && !has_foot)
    code = rad_fail_memory(e, "the picture", (double)n);
  for (int i = 0; i < feet.n_foot && !code; i++)
    has_foot[feet.foot[i].element] = 1;
  for (size_t i = 0; i < n && !code; i++)
    halved += has_foot[i] ? MOST_OF_ELEMENT : 0;
  *most = fmin(halved, (double)most_of_all((int64_t)grids) - grids);
  rad_feet_free(&feet);
  free(has_foot);
  return code;
}

static enum rad_code refine(struct rad_canvas *p, struct rad_error *e) {
  size_t n = (size_t)p->c->scene.n_triangle * (size_t)p->c->scene.n_band;
  double *most = rad_calloc(n, sizeof(double));
  int64_t limit = most_of_all(p->n_tile), from = 0;
  enum rad_code code = most ? RAD_OK : fail_memory(p, e);
  while (!code && from < p->n_dot) {
    see_largest(p, from, most);
    from = p->n_dot;
    if (halve(p, most, (limit - p->n_tile) / 3) < 0)
      code = fail_memory(p, e);
    else if (p->n_dot > from)
      code = rad_canvas_evaluate(p, from, e);
  }
  free(most);
  return code;
}

enum rad_code rad_canvas_fill(struct rad_canvas *p, int64_t *first_dot, struct rad_error *e) {
  const struct rad_case *c = p->c;
  struct feet feet = {.head = NULL};
  enum rad_code code = c->has_bound ? feet_find(c, &feet, e) : RAD_OK;
  for (int i = 0; i < c->mesh->n_element && !code; i++) {
    int64_t tile = p->n_tile;
    int done = add_grid(p, i, &first_dot[i]);
    if (done && c->has_bound && !rad_picture_is_lagrange(c, i))
      done = add_samples(p, i, tile, &feet);
    if (!done)
      code = fail_memory(p, e);
  }
  feet_free(&feet);
  if (!code)
    code = rad_canvas_evaluate(p, 0, e);
  return code || !c->has_bound ? code : refine(p, e);
}
