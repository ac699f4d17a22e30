// Oracle of the survey: means and view factors of a scene of triangles, by means of its own. It
// shares nothing with src/: no code, no header, no format of files. Surfaces radiate on the side of
// their normals; both sides block; what reaches a back is lost.
#ifndef SURVEY_ORACLE_H
#define SURVEY_ORACLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { oracle_bands = 4, oracle_dimensions = 9, oracle_replicates = 64 };

struct vec {
  double x, y, z;
};
struct face {
  struct vec v[3], normal, side[3]; // side: in the plane, inwards from edge k
  double offset, reach[3];          // normal . p = offset in the plane; side . p > reach inside
  double area, size;
  int surface;
  double rho[oracle_bands], emission[oracle_bands];
};
struct blockers {
  int n, *face;
};
struct oracle_scene {
  int faces, surfaces, bands;
  struct face *face;
  double *area;              // of surfaces
  bool *coplanar;            // [faces, faces]
  struct blockers **between; // [faces, faces], made when first asked for
};

static inline struct vec sub(struct vec a, struct vec b) {
  return (struct vec){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline struct vec along(struct vec a, double t, struct vec d) {
  return (struct vec){a.x + t * d.x, a.y + t * d.y, a.z + t * d.z};
}
static inline double dot(struct vec a, struct vec b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline struct vec cross(struct vec a, struct vec b) {
  return (struct vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
// Height of p over the plane of f, on the radiating side positive.
static inline double height(const struct face *f, struct vec p) {
  return dot(f->normal, p) - f->offset;
}

// Read a scene; on an error a sentence goes to stderr and the program ends with 2.
struct oracle_scene *oracle_read(const char *path);
void oracle_free(struct oracle_scene *s);
_Noreturn void oracle_die(const char *format, ...) __attribute__((format(printf, 1, 2)));
void *oracle_new(size_t n, size_t size);

// May some point of a see some point of b?
bool oracle_facing(const struct oracle_scene *s, int a, int b);
// Faces that may stand between a and b.
const struct blockers *oracle_between(struct oracle_scene *s, int a, int b);
// First face that a ray from x on face a meets, or -1; where it meets it.
int oracle_hit(const struct oracle_scene *s, int a, struct vec x, struct vec direction,
               struct vec *at);
// View factor from the point x of face a to what it sees of face t.
double oracle_seen(struct oracle_scene *s, int a, struct vec x, int t);

// Coordinate of point `index` in an Owen-scrambled Sobol sequence.
double oracle_sobol(uint32_t index, int dimension, uint64_t seed);
uint64_t oracle_hash(uint64_t x);
double oracle_random(uint64_t *state);
struct vec oracle_point(const struct face *f, double a, double b);
struct vec oracle_cosine(struct vec normal, double a, double b);

struct oracle_settings {
  uint32_t first,
      most; // points a replicate on the faces of pairs: at least, at most (powers of two)
  uint32_t rays, paths; // the same for means: at least, at most
  int replicates;
  int closed;    // points of a path that see all faces in closed form
  double target; // standard error asked for: of a view factor, of a mean relative to it
  uint64_t seed;
};
// Mean and standard error of n independent values.
void oracle_mean(int n, const double *value, double *mean, double *error);
// Face of a surface, each with its share of the area.
int oracle_pick(const struct oracle_scene *s, int surface, double share);
// No point of a sends more than this share to t; 0: they do not face each other.
double oracle_most_seen(const struct oracle_scene *s, int a, int t);

// Pair integrals of all replicates, and what may have been missed of them.
struct oracle_sums {
  double *exchange;        // [replicates, surfaces, surfaces]: A_i F_ij
  double *seen;            // [faces, faces]: A F of pairs of faces, what may be missed added
  double *missed_exchange; // [surfaces, surfaces]
};
struct oracle_sums oracle_sum_factors(struct oracle_scene *s, const struct oracle_settings *o);
void oracle_free_sums(struct oracle_sums *q);
enum { oracle_few = 8 }; // fewer points that see something do not tell how much is seen
// "what i j mean error": the mean of the replicates' values, their standard error and what is
// missed.
void oracle_print(const char *what, int i, int j, int n, const double *value, double missed);

void oracle_factors(const struct oracle_scene *s, int replicates, const struct oracle_sums *q);
void oracle_rays(struct oracle_scene *s, const struct oracle_settings *o);
void oracle_means(struct oracle_scene *s, const struct oracle_settings *o,
                  const struct oracle_sums *f);

#endif
