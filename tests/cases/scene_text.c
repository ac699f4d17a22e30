#include "scene_text.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void deck_begin(struct deck_text *d) {
  d->length = 0;
  deck_add(d, "scene:\n  triangles:\n");
}

void deck_add(struct deck_text *d, const char *format, ...) {
  va_list args;
  va_start(args, format);
  d->length += vsnprintf(d->text + d->length, (size_t)(DECK_TEXT - d->length), format, args);
  va_end(args);
  if (d->length >= DECK_TEXT)
    abort();
}

void deck_polygon(struct deck_text *d, const char *name, int n, const double (*p)[3], double rho,
                  double emission) {
  for (int i = 1; i + 1 < n; i++)
    deck_add(d,
             "    - {name: %s, rho: %.17g, emission: %.17g, vertices: [[%.17g, %.17g, %.17g], "
             "[%.17g, %.17g, %.17g], [%.17g, %.17g, %.17g]]}\n",
             name, rho, emission, p[0][0], p[0][1], p[0][2], p[i][0], p[i][1], p[i][2], p[i + 1][0],
             p[i + 1][1], p[i + 1][2]);
}

void deck_cube(struct deck_text *d, const double rho[6], const double emission[6]) {
  static const double face[6][4][3] = {
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}},
      {{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}}, {{1, 0, 0}, {1, 0, 1}, {1, 1, 1}, {1, 1, 0}},
      {{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}}, {{0, 1, 0}, {1, 1, 0}, {1, 1, 1}, {0, 1, 1}}};
  static const char *const name[] = {"floor", "ceiling", "x0", "x1", "y0", "y1"};
  for (int f = 0; f < 6; f++)
    deck_polygon(d, name[f], 4, face[f], rho[f], emission[f]);
}

enum rad_code deck_prepare(const struct deck_text *d, struct rad_case *c, struct rad_error *e) {
  char path[] = "/tmp/polyrad_case_XXXXXX";
  int file = mkstemp(path);
  if (file < 0 || write(file, d->text, (size_t)d->length) != d->length)
    abort();
  close(file);
  enum rad_code code = rad_case_prepare(path, 0, NULL, NULL, c, e);
  unlink(path);
  return code;
}

enum rad_code deck_solve(const struct deck_text *d, struct rad_case *c, struct rad_error *e) {
  enum rad_code code = deck_prepare(d, c, e);
  return code ? code : rad_case_solve(c, e);
}

double surface_mean(const struct rad_case *c, const char *name, int irradiance) {
  int n = c->scene.n_triangle, nb = c->scene.n_band;
  const double *value = irradiance ? c->means.irradiance : c->means.radiosity;
  double sum = 0, area = 0;
  for (int t = 0; t < n; t++)
    if (!strcmp(c->scene.surface_name[c->scene.triangle[t].surface], name)) {
      sum += c->scene.triangle[t].area * value[t * nb];
      area += c->scene.triangle[t].area;
    }
  return sum / area;
}
