/* Shared by the tests of scenes: random numbers and motions, decks made by hand, their scenes. */
#ifndef POLYRAD_TEST_SCENE_HELP_H
#define POLYRAD_TEST_SCENE_HELP_H

#include "scene/scene.h"

/* --- random numbers and motions --- */

unsigned long long seed(void); /* 2003, or RAD_TEST_SEED from the environment */
void start_random(void);
double uniform(double low, double high);
void random_direction(double d[3]);

struct motion {
  double axis[3][3], shift[3], scale;
};

/* Rotation, scale of 10^-decades..10^decades (0: rigid), and a shift of at most 3 scales. */
struct motion random_motion(double decades);
void move(const struct motion *m, const double x[3], double y[3]);

/* --- decks --- */

extern const double UNIT[3][3];   /* (0,0,0), (1,0,0), (0,1,0) */
extern const double SQUARE[4][2]; /* the unit square in x, y */
extern const int SQUARE_CAP[2][3];
extern const double ELL[6][2]; /* an L in x, y */
extern const int ELL_CAP[4][3];

/* Append a triangle with rho 0.5 and emission 1, in line 10, 11, ... */
struct rad_deck_triangle *add(struct rad_deck *deck, const char *name, const double v[3][3]);

/* Append a moved one, "wall". */
void add_moved(struct rad_deck *deck, const struct motion *motion, const double v[3][3],
               enum rad_side side);

/* A prism over a polygon in x, y, cut into triangles; its right-hand normals point outwards. */
void add_prism(struct rad_deck *deck, const struct motion *motion, int n,
               const double (*polygon)[2], int n_cap, const int (*cap)[3], double low, double high,
               enum rad_side side);
void add_cube(struct rad_deck *deck, const struct motion *motion, enum rad_side side);

/* --- scenes --- */

struct built {
  struct rad_scene scene;
  struct rad_notes notes;
  struct rad_error error;
  enum rad_code code;
};

struct built build(struct rad_deck *deck);
struct built build_well(struct rad_deck *deck); /* expects RAD_OK */
void drop(struct built *b, struct rad_deck *deck);

/* Build, expect RAD_OK, and free all but the scene. */
struct rad_scene build_scene(struct rad_deck *deck);

/* Area and normal of a triangle made by hand, from its corners. */
void measure_triangle(struct rad_triangle *t);

#endif
