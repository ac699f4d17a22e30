/* polyrad: radiosity of scenes of triangles with a stated error bound.
 *
 *   u(x) = E(x) + rho h(x),   h(x) = int V(x,y) cos cos / (pi |x-y|^2) u(y) dS(y)
 *
 * u is the radiosity, h the irradiance, E the emission [W/m2]; rho the reflectivity [-]. Each band
 * is a problem of its own. Lengths are in metres, or any unit as long as it is the same everywhere.
 *
 *   struct polyrad_scene scene = {0};          fill it in
 *   polyrad *p;
 *   if (polyrad_create(&scene, &p) || polyrad_solve(p, NULL))
 *     fprintf(stderr, "%s\n", polyrad_error_text(p));
 *   else
 *     polyrad_evaluate_at(p, n, triangle, position, radiosity, NULL);
 *   polyrad_free(p);
 *
 * Arrays are row-major: [n, m] has m numbers in a row. Indices count from 0 in calls; the sentences
 * of polyrad_error_text count triangles and vertices from 1. Whatever is passed in is copied or no
 * longer needed when the call returns, except `user`; arrays for results are the caller's.
 *
 * Errors. A call that can fail returns a status and leaves one sentence for polyrad_error_text; its
 * results are then undefined. No call prints or ends the program.
 *
 * Threads. Different handles may be used at the same time, one handle by one thread at a time. Work
 * is spread by OpenMP over polyrad_options.threads; the results do not depend on their number.
 */
#ifndef POLYRAD_H
#define POLYRAD_H

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define POLYRAD_API __attribute__((visibility("default")))
#else
#define POLYRAD_API
#endif

enum { POLYRAD_MAX_BAND = 16 };

typedef enum polyrad_status {
  POLYRAD_OK = 0,
  POLYRAD_NUMERIC = 1, /* closed white scene, no convergence, tolerance not reached */
  POLYRAD_INPUT = 2,   /* an argument; or a call out of turn */
  POLYRAD_SYSTEM = 3   /* memory */
} polyrad_status;

/* One scene and, once solved, its solution. */
typedef struct polyrad polyrad;

/**
 * Emission as a function. It must be continuous on each triangle, seen from each vertex in polar
 * coordinates: at a vertex it may depend on the direction. Details much smaller than a triangle can
 * be missed; divide the triangle there.
 *
 * @param[in] x         [3] the point
 * @param[in] triangle  that it is on, from 0
 * @param[in] weight    [3] its barycentric coordinates; exact, however near to a vertex it is
 * @param[in] band      from 0
 * @param[in] user      that of the scene
 * @return E [W/m2], finite; the same for the same arguments. Called many times, from within calls
 * of polyrad by the thread that made the call; it may not call polyrad for this handle
 */
typedef double polyrad_emission(const double x[3], int triangle, const double weight[3], int band,
                                void *user);

/* A scene; set everything to zero first. Given are rho and exactly one of the three emissions; or,
 * for heat radiation, emissivity and temperature or flux, with one band. */
struct polyrad_scene {
  int n_vertex;
  const double *vertex; /* [n_vertex, 3]; closer than 1e-10 of the scene's size: the same vertex */
  int n_triangle;
  const int *triangle; /* [n_triangle, 3] vertices, anticlockwise seen from the side that
                          radiates; two triangles, back to back, make a sheet */
  int n_surface;       /* 0: one surface */
  const int *surface;  /* [n_triangle] or NULL if n_surface is 0 */
  const char *const *surface_name; /* [n_surface] different names, or NULL: surface_1, ... */
  int n_band;                      /* at most POLYRAD_MAX_BAND; 0: one band */
  const double *rho;               /* [n_triangle, n_band] 0..1 */
  const double *emission;          /* [n_triangle, n_band] constant on each triangle, or NULL */
  const double *vertex_emission;   /* [n_triangle, 3, n_band] linear between these, or NULL */
  polyrad_emission *emission_at;   /* any function, or NULL */
  void *user;                      /* passed to emission_at; to live as long as the handle */
  const double *emissivity;        /* [n_triangle] 0..1, in place of rho and emission */
  const double *temperature;       /* [n_triangle] [K]; NaN where flux is given; or NULL */
  const double *flux; /* [n_triangle] u - h [W/m2]; NaN where temperature is; or NULL */
};

/* How to solve; 0 in any field is its default. */
struct polyrad_options {
  double tolerance;    /* of the largest error of u over the largest u; default 1e-3. With
                          emission_at also of h over the largest u */
  double memory_limit; /* [bytes] for the matrix and what belongs to it; default: what there is. The
                          tables of polyrad_create, about n_triangle^2 bytes, come before it */
  int threads;         /* default: what OpenMP has; also used by later calls */
};

/* What a solution says of itself. */
struct polyrad_summary {
  long long unknowns;       /* collocation points */
  int elements, levels;     /* levels: solutions on finer and finer meshes */
  double error_bound;       /* of max |u - u*| from 1e-7 of edges and vertices on [W/m2] */
  double error_bound_limit; /* the same right up to edges and vertices [W/m2] */
  double relative_bound;    /* error bound over the largest u, worst band: what tolerance is for */
  double residual;          /* of the linear system, max norm [W/m2] */
  int converged;            /* 1: relative_bound <= tolerance */
};

/**
 * Copy and check a scene, and find out which triangles see each other.
 *
 * @param[in]  scene  is copied
 * @param[out] p      to be freed with polyrad_free, also after an error; NULL without memory for it
 * @return POLYRAD_INPUT for NULL where an array is needed, an index out of range, a number that is
 *         not finite, rho outside 0..1, a degenerate or duplicate triangle, triangles of one plane
 * that face the same way and overlap, a flux below 0 on a face that sees no other, a surface
 *         without triangles. Cost and memory n_triangle^2
 */
POLYRAD_API polyrad_status polyrad_create(const struct polyrad_scene *scene, polyrad **p);

/* Warnings about the scene: sentence i, from 0; NULL when there are no more. Owned by p. */
POLYRAD_API const char *polyrad_warning(const polyrad *p, int i);

/**
 * Solve to a tolerance. A handle may be solved again, with other options.
 *
 * @param[in] options  NULL: all defaults
 * @return POLYRAD_NUMERIC also if the tolerance was not reached: then there is a solution with
 *         summary.converged 0 and its bound, and it may be evaluated
 */
POLYRAD_API polyrad_status polyrad_solve(polyrad *p, const struct polyrad_options *options);

POLYRAD_API polyrad_status polyrad_get_summary(polyrad *p, struct polyrad_summary *summary);

/**
 * u* and h at points given by triangle and barycentric coordinates. Points of one triangle that
 * follow each other are worked on together, which is faster.
 *
 * @param[in]  triangle    [n] from 0
 * @param[in]  weight      [n, 3] sum 1, none below 0 (to 1e-6); on an edge or vertex the limit from
 *                         inside the triangle is meant
 * @param[out] radiosity   [n, n_band] [W/m2], or NULL
 * @param[out] irradiance  [n, n_band] [W/m2], or NULL
 */
POLYRAD_API polyrad_status polyrad_evaluate(polyrad *p, int n, const int *triangle,
                                            const double *weight, double *radiosity,
                                            double *irradiance);

/* The same at positions [n, 3] that lie on their triangles, to 1e-6 of the triangle's size. */
POLYRAD_API polyrad_status polyrad_evaluate_at(polyrad *p, int n, const int *triangle,
                                               const double *position, double *radiosity,
                                               double *irradiance);

/* Means over surfaces, each [n_surface, n_band] [W/m2], or NULL. */
POLYRAD_API polyrad_status polyrad_surface_means(polyrad *p, double *radiosity, double *irradiance);

/* Bounds of the errors of those means, each [n_surface, n_band] [W/m2], or NULL; NaN in a scene
 * that was solved without a tolerance. */
POLYRAD_API polyrad_status polyrad_surface_errors(polyrad *p, double *radiosity,
                                                  double *irradiance);

/**
 * Of a scene with emissivities, each [n_surface], or NULL.
 *
 * @param[out] net_flux     mean of u - h, what the surface gives off [W/m2]
 * @param[out] temperature  fourth root of the mean of T^4 [K]; NaN where more flux is drawn than
 * arrives
 */
POLYRAD_API polyrad_status polyrad_surface_heat(polyrad *p, double *net_flux, double *temperature);

/**
 * View factors between surfaces: the share of what leaves s evenly that arrives at t. Needs no
 * solution.
 *
 * @param[in]  tolerance  absolute, of each factor and each row sum; 0: 1e-6
 * @param[out] factor     [n_surface, n_surface] row s, column t; with POLYRAD_NUMERIC the best
 * there is: polyrad_error_text says how wrong it may be
 */
POLYRAD_API polyrad_status polyrad_view_factors(polyrad *p, double tolerance, double *factor);

/* What went wrong in the last call with p, or "". For NULL: that p is missing. Owned by p. */
POLYRAD_API const char *polyrad_error_text(const polyrad *p);

POLYRAD_API void polyrad_free(polyrad *p); /* NULL is fine */

POLYRAD_API const char *polyrad_version(void); /* "0.1.0" */

#ifdef __cplusplus
}
#endif

#endif
