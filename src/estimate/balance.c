#include "estimate/balance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "visibility/facing.h"
#include "visibility/visibility.h"

/* What backs receive depends on all that is sent, which is as wrong as u: `sent_error`. */
static enum rad_code check_enclosed(const struct rad_balance *b, const char *band, int k,
                                    double sent_error, struct rad_error *e) {
  double error = b->error[k], rounding = 1e-12 * fabs(b->emitted[k]);
  if (b->on_backs[k] > 0)
    error += b->backs_error[k] + sent_error;
  if (!(fabs(b->rest[k] - b->on_backs[k]) > error + rounding))
    return RAD_OK;
  return rad_fail(e, RAD_ENUMERIC,
                  "band %s: of %.6g W emitted in this enclosed scene %.6g W are absorbed%s, which "
                  "the stated error of %.2g W does not explain: an error of polyrad; please report "
                  "the deck",
                  band, b->emitted[k], b->absorbed[k] + b->on_backs[k],
                  b->on_backs[k] > 0 ? " by faces and backs" : "", error);
}

enum rad_code rad_balance_make(const struct rad_scene *scene, const struct rad_means *m,
                               struct rad_balance *b, struct rad_error *e) {
  enum rad_code code = RAD_OK;
  *b = (struct rad_balance){.n_band = m->n_band, .is_enclosed = m->is_enclosed};
  for (int k = 0; k < m->n_band && !code; k++) {
    double left = 0, sent_error = 0;
    for (int t = 0; t < m->n; t++) {
      int i = t * m->n_band + k;
      double area = scene->triangle[t].area, rho = scene->rho[i];
      double absorbed = area * (1 - rho) * m->irradiance[i];
      b->absorbed[k] += absorbed;
      b->emitted[k] += area * (m->radiosity[i] - rho * m->irradiance[i]);
      b->given[k] += area * fabs(m->radiosity[i] - rho * m->irradiance[i]);
      b->error[k] += rho < 1 ? area * (1 - rho) * m->error_irradiance[i] : 0;
      sent_error += area * m->error_radiosity[i];
      left += area * m->radiosity[i];
    }
    b->rest[k] = b->emitted[k] - b->absorbed[k];
    b->imbalance[k] = left - m->sent[k];
    b->on_backs[k] = m->on_backs[k];
    b->backs_error[k] = m->backs_error[k];
    if (b->is_enclosed)
      code = check_enclosed(b, scene->band[k], k, sent_error, e);
  }
  return code;
}

/* ---- backs ------------------------------------------------------------------------------------
 */

static int has_vertices(const struct rad_triangle *i, const struct rad_triangle *j) {
  int same = 0;
  for (int k = 0; k < 9; k++)
    same += i->vertex[k / 3] == j->vertex[k % 3];
  return same == 3;
}

/* True for one side of a sheet: its back is another triangle. */
static int has_other_side(const struct rad_scene *s, int t) {
  for (int i = 0; i < s->n_triangle; i++)
    if (i != t && has_vertices(&s->triangle[i], &s->triangle[t]))
      return 1;
  return 0;
}

/* The scene with the backs of its one-sided triangles behind them. */
static enum rad_code make_backs(const struct rad_scene *scene, struct rad_scene *twin,
                                struct rad_error *e) {
  int n = scene->n_triangle;
  *twin = *scene;
  twin->progress = NULL;
  twin->visibility = NULL;
  twin->n_triangle = n;
  twin->triangle = rad_alloc(2 * (size_t)n, sizeof *twin->triangle);
  if (!twin->triangle)
    return rad_fail_memory(e, "the backs", 2.0 * n * (double)sizeof *twin->triangle);
  memcpy(twin->triangle, scene->triangle, (size_t)n * sizeof *twin->triangle);
  for (int t = 0; t < n; t++) {
    if (has_other_side(scene, t))
      continue;
    struct rad_triangle *back = &twin->triangle[twin->n_triangle++];
    *back = scene->triangle[t];
    for (int d = 0; d < 3; d++)
      back->normal[d] = -back->normal[d];
  }
  return RAD_OK;
}

/* True if some face may see the back of another. */
static int shows_backs(const struct rad_scene *twin, int n) {
  for (int i = 0; i < n; i++)
    for (int j = n; j < twin->n_triangle; j++)
      if (rad_faces(&twin->triangle[i], &twin->triangle[j]))
        return 1;
  return 0;
}

static enum rad_code receive(const struct rad_weights *w, struct rad_scene *twin,
                             const double *tolerance, double *value, double *error,
                             struct rad_error *e) {
  struct rad_visibility visibility;
  struct rad_received r = {0};
  int n = w->mesh->scene->n_triangle;
  enum rad_code code = rad_visibility_build(twin, &visibility, e);
  if (!code)
    code = rad_receive(w, twin, n, tolerance, &r, e);
  for (int t = 0; t < r.n_triangle && !code; t++)
    for (int k = 0; k < w->n; k++) {
      value[k] += r.value[t * w->n + k];
      error[k] += r.error[t * w->n + k];
    }
  rad_received_free(&r);
  rad_visibility_free(&visibility);
  return code;
}

enum rad_code rad_receive_on_backs(const struct rad_weights *w, const double *tolerance,
                                   double *value, double *error, struct rad_error *e) {
  struct rad_scene twin = {0};
  int few = w->mesh->scene->n_triangle <= RAD_MOST_BACKS;
  for (int k = 0; k < w->n; k++)
    value[k] = error[k] = few ? 0 : NAN;
  if (!few)
    return RAD_OK;
  enum rad_code code = make_backs(w->mesh->scene, &twin, e);
  if (!code && shows_backs(&twin, w->mesh->scene->n_triangle))
    code = receive(w, &twin, tolerance, value, error, e);
  free(twin.triangle);
  return code;
}
