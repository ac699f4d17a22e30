/* What one element sends to one triangle, with an error: the kernels of received.c. */
#ifndef RAD_ESTIMATE_TRANSFER_H
#define RAD_ESTIMATE_TRANSFER_H

#include <stdint.h>

#include "estimate/light_cell.h"
#include "estimate/smooth.h"

/* Elements whose light meets a receiver with shadows, or cut by its plane: how many; int |w| F of
 * theirs without the shadows [W]. */
struct rad_open {
  int n;
  double sum[RAD_MAX_WEIGHT];
};

/* Everything that the pairs of elements and receivers share. */
struct rad_transfer {
  const struct rad_weights *w; /* borrowed, as what follows */
  const struct rad_scene *to;  /* the receivers are to->triangle[first] .. */
  const double *tolerance;     /* [w->n] of the mean over each receiver [W/m2] */
  int first;
  int as_it_comes;       /* tolerance is INFINITY: the points that are exact for w */
  double accuracy;       /* of the factors, relative */
  struct rad_open *open; /* owned [n_receiver]; set by the caller */
  struct rad_receivers receivers;
  struct rad_pair_engine engine; /* of pairs that something may stand between */
};

/* To be freed with rad_transfer_free, also after an error. */
enum rad_code rad_transfer_begin(const struct rad_weights *w, const struct rad_scene *to, int first,
                                 const double *tolerance, struct rad_transfer *t,
                                 struct rad_error *e);
void rad_transfer_free(struct rad_transfer *t); /* safe twice */

/* What a cell sends, by rule; made when it is asked for. */
enum { RAD_N_RULE = 4 }; /* the least; two to compare; one more, if these differ */
struct rad_lights {
  struct rad_light_cell cell;
  struct rad_cell_shape shape;
  double axis[2]; /* of rad_smoothness, once it was asked for */
  int points;     /* per direction of the first two rules to compare */
  unsigned n;     /* rules that are set */
  struct rad_light rule[RAD_N_RULE];
};

/* Memory of one thread. */
struct rad_transfer_scratch {
  struct rad_scratch patch;
  struct rad_cell_scratch *cells; /* owned */
  enum rad_code code;             /* the first error, and its text */
  struct rad_error error;
  struct rad_light scattered[RAD_SCATTERED];
  unsigned char is_scattered[RAD_SCATTERED]; /* those that are set */
  struct rad_lights whole, part;             /* of the element at hand, of a cell of it */
  int64_t factors;                           /* made, from points to triangles */
};

enum rad_code rad_transfer_scratch_init(const struct rad_transfer *t,
                                        struct rad_transfer_scratch *w, struct rad_error *e);
void rad_transfer_scratch_free(struct rad_transfer_scratch *w); /* safe twice */

/* Points per direction that integrate w exactly, and F where it is nearly constant. */
int rad_transfer_rule(const struct rad_element *e);

/* True if F(y -> to) has kinks on triangle `from`: shadows, or the receiver's plane. */
int rad_transfer_is_broken(const struct rad_transfer *t, int from, int to);

/* The element whose light the next calls send. */
void rad_transfer_element(const struct rad_transfer *t, int element,
                          struct rad_transfer_scratch *w);

/* int |w_k| F dS [w->n] of the element at hand to a triangle, without shadows [W]. rounding: as in
 * rad_receiver. */
void rad_transfer_open(const struct rad_transfer *t, int triangle, double rounding, double *most,
                       struct rad_transfer_scratch *w);

/* Sums over elements [w->n]: int w_k F dS [W], errors that add up, variances of those by chance. */
struct rad_transfer_sums {
  double *value, *error, *variance;
};

/* How many standard errors a stated error has, with Student's t of RAD_REPLICATES in mind. */
#define RAD_SIGMAS 5.5

/**
 * Add what the element at hand sends to a triangle that it sees.                   (theory 17.1)
 *
 * @param[in]  portion  of the tolerance that the element may use up
 * Errors other than the receivers' accuracy times the value, which is the caller's. On an error
 * w->code is set.
 */
void rad_transfer_to(const struct rad_transfer *t, int triangle, double portion,
                     const struct rad_transfer_sums *sums, struct rad_transfer_scratch *w);

#endif
