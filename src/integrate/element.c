#include "integrate/element.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "integrate/far.h"
#include "integrate/near.h"
#include "integrate/strips.h"
#include "visibility/facing.h"

enum { N_CLASS = 2 * RAD_N_ORDER + 1 }; /* pairs of rules, nearest last; NEAR comes after them */

/* Which pair of rules suffices from which distance on. */
struct classes {
  int n;
  double d2[N_CLASS]; /* squared distance from center, descending */
  int angular[N_CLASS], radial[N_CLASS];
  double center[2];
};

enum rad_code rad_scratch_init(const struct rad_mesh *mesh, struct rad_scratch *s,
                               struct rad_error *e) {
  size_t most = 1;
  for (int i = 0; i < mesh->n_element; i++) {
    const struct rad_element *el = &mesh->element[i];
    size_t need = (size_t)(el->k_phi * el->k_r);
    most = need > most ? need : most;
  }
  *s = (struct rad_scratch){.far = rad_alloc(most * RAD_TILE, sizeof(double)),
                            .frame = rad_alloc(3 * RAD_BATCH, sizeof(double)),
                            .list = rad_alloc((N_CLASS + 1) * RAD_BATCH, sizeof(int)),
                            .count = rad_alloc(N_CLASS + 1, sizeof(int)),
                            .row = rad_alloc(RAD_BATCH, sizeof(int))};
  if (!s->far || !s->frame || !s->list || !s->count || !s->row)
    return rad_fail_memory(e, "the integrator", (double)most * RAD_TILE * 8);
  return RAD_OK;
}

void rad_scratch_free(struct rad_scratch *s) {
  free(s->far);
  free(s->frame);
  free(s->list);
  free(s->count);
  free(s->row);
  *s = (struct rad_scratch){0};
}

int rad_block_is_zero(const struct rad_scene *scene, int target, int source) {
  return target == source || !rad_faces(&scene->triangle[target], &scene->triangle[source]);
}

/* Distances at which the rules of an element suffice (theory 3.5): its longest segments of each
 * direction, and how far their middles lie from the element's. */
static void set_classes(const struct rad_patch *patch, const struct rad_element *e,
                        const struct rad_panel *angular, const struct rad_panel *radial,
                        struct classes *c) {
  double t0 = rad_angle_t(patch->angle, rad_graded(e->sigma[0], e->p_phi));
  double t1 = rad_angle_t(patch->angle, rad_graded(e->sigma[1], e->p_phi));
  double r0 = rad_graded(e->tau[0], e->p_r), r1 = rad_graded(e->tau[1], e->p_r);
  double t = 0.5 * (t0 + t1), r = 0.5 * (r0 + r1), b = hypot(patch->b1, patch->b2);
  double ray0 = hypot(patch->a1 + t0 * patch->b1, t0 * patch->b2);
  double ray1 = hypot(patch->a1 + t1 * patch->b1, t1 * patch->b2);
  double half_t = 0.5 * r1 * b * (t1 - t0), half_r = 0.5 * (r1 - r0) * fmax(ray0, ray1);
  double off_t = half_r, off_r = 0.5 * r * b * (t1 - t0);
  c->center[0] = r * (patch->a1 + t * patch->b1);
  c->center[1] = r * t * patch->b2;
  c->n = 0;
  int ot = 0, orr = 0;
  double from_t = off_t + half_t * angular->reach[0], from_r = off_r + half_r * radial->reach[0];
  while (1) {
    double from = fmax(from_t, from_r);
    if (isfinite(from)) {
      c->d2[c->n] = from * from;
      c->angular[c->n] = ot;
      c->radial[c->n++] = orr;
    }
    if (from_t >= from_r ? ++ot == RAD_N_ORDER : ++orr == RAD_N_ORDER)
      break;
    from_t = off_t + half_t * angular->reach[ot];
    from_r = off_r + half_r * radial->reach[orr];
  }
}

static int class_of(const struct classes *c, double d2) {
  int i = 0;
  while (i < c->n && d2 < c->d2[i])
    i++;
  return i < c->n ? i : N_CLASS;
}

/* Sort targets in front of the source into lists by rule; groups of eight share one where they can.
 */
static void sort_targets(const struct classes *c, const double *restrict x, int n,
                         struct rad_scratch *s) {
  enum { GROUP = 8 };
  const double *restrict y = x + RAD_BATCH, *restrict z = y + RAD_BATCH;
  for (int i = 0; i <= N_CLASS; i++)
    s->count[i] = 0;
  for (int g = 0; g < n; g += GROUP) {
    double d2[GROUP], least = INFINITY;
    int m = n - g < GROUP ? n - g : GROUP;
    for (int i = 0; i < m; i++) {
      double dx = x[g + i] - c->center[0], dy = y[g + i] - c->center[1], dz = z[g + i];
      d2[i] = dx * dx + dy * dy + dz * dz;
      least = fmin(least, d2[i]);
    }
    int all = class_of(c, least);
    for (int i = 0; i < m; i++) {
      int one = all == N_CLASS ? class_of(c, d2[i]) : all;
      s->list[one * RAD_BATCH + s->count[one]++] = g + i;
    }
  }
}

/* Column of a trial function in the caller's matrix; folded elements gather several. */
static void store(const struct rad_element *e, const double *value, int stride, double *k,
                  int64_t ld) {
  int n = e->k_phi * e->k_r;
  for (int f = 0; f < e->n_function; f++) {
    double sum = 0;
    if (e->fold)
      for (int b = 0; b < n; b++)
        sum += e->fold[f * n + b] * value[b * stride];
    else
      sum = value[f * stride];
    k[ld * (e->first + f)] = sum;
  }
}

static void far_targets(const struct rad_mesh *mesh, const struct rad_rules *rules, int element,
                        const struct rad_view *view, const struct classes *c, int one, double *k,
                        int64_t ld, struct rad_scratch *s) {
  const struct rad_element *e = &mesh->element[element];
  const struct rad_panel *angular = &rules->panel[rules->angular[element]];
  const struct rad_panel *radial = &rules->panel[rules->radial[element]];
  const int *list = s->list + one * RAD_BATCH;
  const double *x = s->frame, *y = x + RAD_BATCH, *z = y + RAD_BATCH;
  double *out = s->far;
  for (int start = 0; start < s->count[one]; start += RAD_TILE) {
    int n = s->count[one] - start < RAD_TILE ? s->count[one] - start : RAD_TILE;
    struct rad_tile tile;
    for (int i = 0; i < n; i++) {
      int j = list[start + i];
      tile.x[i] = x[j];
      tile.y[i] = y[j];
      tile.z[i] = z[j];
    }
    rad_far(&mesh->patch[e->patch], view, angular, c->angular[one], radial, c->radial[one], &tile,
            n, out);
    if (e->fold) {
      for (int i = 0; i < n; i++)
        store(e, out + i, RAD_TILE, k + s->row[list[start + i]], ld);
    } else {
      for (int b = 0; b < e->n_function; b++)
        for (int i = 0; i < n; i++)
          k[s->row[list[start + i]] + ld * (e->first + b)] = out[b * RAD_TILE + i];
    }
    s->counters.kernel_values +=
        (int64_t)n * rad_order[c->angular[one]] * rad_order[c->radial[one]];
    s->counters.far += n;
  }
}

static void near_targets(const struct rad_mesh *mesh, const struct rad_rules *rules, int element,
                         const struct rad_view *view, const struct rad_strip *strip, int n_strip,
                         const int *list, int n, double *k, int64_t ld, struct rad_scratch *s) {
  const struct rad_element *e = &mesh->element[element];
  struct rad_near w = {.gauss = &mesh->gauss,
                       .patch = &mesh->patch[e->patch],
                       .element = e,
                       .to_lagrange_phi = rules->to_lagrange[e->k_phi],
                       .to_lagrange_r = rules->to_lagrange[e->k_r],
                       .digits = log(100 / rules->tolerance),
                       .n0 = view->n0,
                       .na = view->na,
                       .nb = view->nb};
  for (int i = 0; i < n; i++) {
    int j = list ? list[i] : i;
    double *out = s->far;
    for (int d = 0; d < 3; d++)
      w.x[d] = s->frame[d * RAD_BATCH + j];
    if (w.x[2] > 0 && n_strip > 0)
      rad_near(&w, strip, n_strip, out);
    else
      for (int b = 0; b < e->k_phi * e->k_r; b++)
        out[b] = 0;
    store(e, out, 1, k + s->row[j], ld);
  }
  s->counters.near += n;
  s->counters.kernel_values += w.n_kernel;
}

/* One element for all targets in s->frame. */
static void element_block(const struct rad_mesh *mesh, const struct rad_rules *rules, int element,
                          const struct rad_view *view, int n, int cut, double *k, int64_t ld,
                          struct rad_scratch *s) {
  const struct rad_element *e = &mesh->element[element];
  const struct rad_patch *patch = &mesh->patch[e->patch];
  struct rad_strip strip[RAD_MAX_CORNER];
  if (cut) {
    struct rad_polygon part;
    rad_element_polygon(patch, e, &part);
    double lowest = INFINITY;
    for (int i = 0; i < part.n; i++)
      lowest = fmin(lowest, view->n0 + view->na * part.corner[i][0] + view->nb * part.corner[i][1]);
    if (lowest < 0) {
      rad_clip(&part, view->n0, view->na, view->nb);
      int n_strip = part.n ? rad_strips(patch, e, &part, strip) : 0;
      near_targets(mesh, rules, element, view, strip, n_strip, NULL, n, k, ld, s);
      return;
    }
  }
  struct classes classes;
  set_classes(patch, e, &rules->panel[rules->angular[element]],
              &rules->panel[rules->radial[element]], &classes);
  sort_targets(&classes, s->frame, n, s);
  for (int one = 0; one < classes.n; one++)
    far_targets(mesh, rules, element, view, &classes, one, k, ld, s);
  strip[0] = rad_strip_whole(e);
  near_targets(mesh, rules, element, view, strip, 1, s->list + N_CLASS * RAD_BATCH,
               s->count[N_CLASS], k, ld, s);
}

void rad_patch_block(const struct rad_mesh *mesh, const struct rad_rules *rules,
                     const struct rad_targets *targets, int patch, const unsigned char *wanted,
                     double *k, int64_t ld, struct rad_scratch *s) {
  const struct rad_scene *scene = mesh->scene;
  const struct rad_triangle *target = &scene->triangle[targets->triangle];
  const struct rad_triangle *source = &scene->triangle[mesh->patch[patch].triangle];
  struct rad_view view;
  rad_view_set(target, source, &mesh->patch[patch], &view);
  for (int i = 0; i < targets->n; i++) {
    double x[3];
    rad_view_point(&view, targets->base[i], targets->mu[i], x);
    for (int d = 0; d < 3; d++)
      s->frame[d * RAD_BATCH + i] = x[d];
    s->row[i] = targets->row ? targets->row[i] : i;
  }
  int cut = rad_side_of(target, source) == RAD_ACROSS;
  for (int i = mesh->element_first[patch]; i < mesh->element_first[patch + 1]; i++)
    if (!wanted || wanted[i])
      element_block(mesh, rules, i, &view, targets->n, cut, k, ld, s);
}
