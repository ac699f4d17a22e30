/* Decks made in tests: polygons as fans of triangles, written to a temporary file. */
#ifndef POLYRAD_TEST_SCENE_TEXT_H
#define POLYRAD_TEST_SCENE_TEXT_H

#include "app/case.h"

enum { DECK_TEXT = 1 << 16 };

struct deck_text {
  char text[DECK_TEXT];
  int length;
};

void deck_begin(struct deck_text *d);
void deck_add(struct deck_text *d, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* A convex polygon as triangles around its first corner; front is the right-hand side. */
void deck_polygon(struct deck_text *d, const char *name, int n, const double (*corner)[3],
                  double rho, double emission);

/* The unit cube seen from inside, six faces of two triangles; rho and emission per face. */
void deck_cube(struct deck_text *d, const double rho[6], const double emission[6]);

/* Written to a temporary file, read and prepared, and solved; the file is removed. */
enum rad_code deck_prepare(const struct deck_text *d, struct rad_case *c, struct rad_error *e);
enum rad_code deck_solve(const struct deck_text *d, struct rad_case *c, struct rad_error *e);

/* Area-weighted means over a surface (band 0). */
double surface_mean(const struct rad_case *c, const char *name, int irradiance);

#endif
