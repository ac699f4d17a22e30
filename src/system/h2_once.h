/* Products with K that are needed once: nothing of the matrix is kept. */
#ifndef RAD_SYSTEM_H2_ONCE_H
#define RAD_SYSTEM_H2_ONCE_H

#include "integrate/element.h"
#include "system/blocks.h"
#include "system/interpolate.h"

/* Points by element of a mesh, positions as in rad_patch. */
struct rad_element_points {
  const int *first, *count; /* [n_element] the first of each element, and how many */
  const int *base;          /* [n] */
  const double (*mu)[2];    /* [n] */
};

/**
 * (K u_v)(x) at any points of the elements that carry u_v (theory 14.9): clusters and blocks as for
 * the hierarchical matrix, but moments go up, values come down, and kernel values and near
 * integrals are made on the way and thrown away.
 */
struct rad_once {
  const struct rad_mesh *mesh;   /* borrowed */
  const struct rad_rules *rules; /* borrowed: of near integrals */
  struct rad_tree tree;
  struct rad_blocks blocks;
  struct rad_interpolation p; /* of far blocks */
  double tolerance;           /* of far blocks */
  int n_vector;
  const double *u[2 * RAD_MAX_BAND]; /* [n_vector] borrowed [n_point]: as last gathered */
  unsigned char
      *is_source; /* owned [n_cluster] it, or one above it, is the source of a far block */
  unsigned char *has_light; /* owned [n_element] some u_v is not 0 there */
  unsigned char *is_lit;    /* owned [n_cluster] an element of it has light */
  double *moment;           /* owned [n_cluster, n_vector, p.n], pages; of sources */
  int *n_target;            /* owned [n_cluster] points of the last product */
  double *mean; /* owned [far blocks] mean of G between the nodes; 0 without points or light, or
                   where the last product took a block's elements one by one */
};

/* A cluster's moments [n_vector, p.n]; bytes of so much for all clusters. */
static inline double *rad_once_moments(const struct rad_once *o, int cluster) {
  return o->moment + (size_t)cluster * (size_t)o->n_vector * (size_t)o->p.n;
}

static inline size_t rad_once_bytes(const struct rad_once *o) {
  return sizeof(double) * (size_t)o->tree.n_cluster * (size_t)o->n_vector * (size_t)o->p.n;
}

/**
 * @param[in]  leaf       unknowns of a leaf: more means more exact work and less by interpolation
 * @param[in]  tolerance  of the far blocks, relative to a row sum of 1
 * @param[out] o          to be freed with rad_once_free, also after an error
 */
enum rad_code rad_once_begin(const struct rad_mesh *mesh, const struct rad_rules *rules, int leaf,
                             double tolerance, struct rad_once *o, struct rad_error *e);
void rad_once_free(struct rad_once *o); /* safe twice */

/* Moments of functions with coefficients u [n_vector] of [n_point], which stay the caller's. Again
 * for others. */
enum rad_code rad_once_gather(struct rad_once *o, int n_vector, const double *const *u,
                              struct rad_error *e);

/**
 * What one element near a leaf's points, or cheaper one by one, sends to them: value [n_near, n],
 * of points point [n], all on triangle `target`. Called by the thread that owns the points,
 * elements in ascending order.
 */
typedef void rad_once_visitor(void *context, int thread, int element, int target, int n,
                              const int *point, const double *value);

/**
 * y_v = K u_v at points, for the vectors that were gathered.
 *
 * @param[in]  n_near  near blocks are added to the first so many vectors only
 * @param[out] y       [n_vector] of [n], all written
 * @param      visit   of near elements, or NULL
 * @return RAD_ESTOPPED once rad_stop_asked(); y is then not whole
 * Every value has one owner and a fixed order of summation: the same bits for any number of
 * threads. Error: o->tolerance of far blocks and rules->tolerance of near ones, times max |u_v|.
 */
enum rad_code rad_once_at(struct rad_once *o, const struct rad_element_points *points, int n_near,
                          double *const *y, rad_once_visitor *visit, void *context,
                          struct rad_error *e);

#endif
