#include "integrate/element.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/stop.h"
#include "base/vec.h"
#include "integrate/classes.h"
#include "integrate/far.h"
#include "integrate/near.h"
#include "integrate/strips.h"
#include "integrate/turn.h"
#include "visibility/facing.h"
#include "visibility/irradiance.h"

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
                            .list = rad_alloc((RAD_N_CLASS + 1) * RAD_BATCH, sizeof(int)),
                            .count = rad_alloc(RAD_N_CLASS + 1, sizeof(int)),
                            .row = rad_alloc(RAD_BATCH, sizeof(int)),
                            .frame_whole = rad_alloc(3 * RAD_BATCH, sizeof(double)),
                            .row_whole = rad_alloc(RAD_BATCH, sizeof(int))};
  if (!s->far || !s->frame || !s->list || !s->count || !s->row || !s->frame_whole || !s->row_whole)
    return rad_fail_memory(e, "the integrator", (double)most * RAD_TILE * 8);
  return rad_shade_init(mesh->scene, RAD_BATCH, &s->shade, e);
}

void rad_scratch_free(struct rad_scratch *s) {
  free(s->far);
  free(s->frame);
  free(s->list);
  free(s->count);
  free(s->row);
  free(s->frame_whole);
  free(s->row_whole);
  rad_shade_free(&s->shade);
  *s = (struct rad_scratch){0};
}

/* Targets that one element is integrated for, in the frame of its patch. */
struct batch {
  int n;
  const double *frame; /* [3, RAD_BATCH] */
  const int *row;      /* [n] of the result */
};

/* Sort targets in front of the source into lists by rule; groups of eight share one where they can.
 */
static void sort_targets(const struct rad_classes *c, const struct batch *t,
                         struct rad_scratch *s) {
  enum { GROUP = 8 };
  const double *restrict x = t->frame, *restrict y = x + RAD_BATCH, *restrict z = y + RAD_BATCH;
  for (int i = 0; i <= RAD_N_CLASS; i++)
    s->count[i] = 0;
  for (int g = 0; g < t->n; g += GROUP) {
    double d2[GROUP], least = INFINITY;
    int m = t->n - g < GROUP ? t->n - g : GROUP;
    for (int i = 0; i < m; i++) {
      double dx = x[g + i] - c->center[0], dy = y[g + i] - c->center[1], dz = z[g + i];
      d2[i] = dx * dx + dy * dy + dz * dz;
      least = fmin(least, d2[i]);
    }
    int all = rad_class_of(c, least);
    for (int i = 0; i < m; i++) {
      int one = all == RAD_N_CLASS ? rad_class_of(c, d2[i]) : all;
      s->list[one * RAD_BATCH + s->count[one]++] = g + i;
    }
  }
}

/* Columns of an element's trial functions; folded ones gather several. */
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
    k[ld * f] = sum;
  }
}

/* Targets of a list by one pair of rules. */
static void far_targets(const struct rad_mesh *mesh, const struct rad_rules *rules, int element,
                        const struct rad_view *view, const int rule[2], const struct batch *t,
                        const int *list, int n_list, double *k, int64_t ld, struct rad_scratch *s) {
  const struct rad_element *e = &mesh->element[element];
  const struct rad_panel *angular = &rules->panel[rules->angular[element]];
  const struct rad_panel *radial = &rules->panel[rules->radial[element]];
  const double *x = t->frame, *y = x + RAD_BATCH, *z = y + RAD_BATCH;
  double *out = s->far;
  for (int start = 0; start < n_list; start += RAD_TILE) {
    int n = n_list - start < RAD_TILE ? n_list - start : RAD_TILE;
    struct rad_tile tile;
    for (int i = 0; i < n; i++) {
      int j = list[start + i];
      tile.x[i] = x[j];
      tile.y[i] = y[j];
      tile.z[i] = z[j];
    }
    rad_far(&mesh->patch[e->patch], view, angular, rule[0], radial, rule[1], &tile, n, out);
    if (e->fold) {
      for (int i = 0; i < n; i++)
        store(e, out + i, RAD_TILE, k + t->row[list[start + i]], ld);
    } else {
      for (int b = 0; b < e->n_function; b++)
        for (int i = 0; i < n; i++)
          k[t->row[list[start + i]] + ld * b] = out[b * RAD_TILE + i];
    }
    s->counters.kernel_values += (int64_t)n * rad_order[rule[0]] * rad_order[rule[1]];
    s->counters.far += n;
  }
}

/* One element as the near integrator sees it; x is still to be set. */
static struct rad_near near_work(const struct rad_mesh *mesh, const struct rad_rules *rules,
                                 const struct rad_view *view, const struct rad_element *e) {
  double loss = mesh->nodes.loss[e->k_phi] * mesh->nodes.loss[e->k_r];
  return (struct rad_near){.gauss = &mesh->gauss,
                           .patch = &mesh->patch[e->patch],
                           .element = e,
                           .to_lagrange_phi = rad_nodes_matrix(&mesh->nodes, e->k_phi),
                           .to_lagrange_r = rad_nodes_matrix(&mesh->nodes, e->k_r),
                           .digits = log(100 * loss / rules->tolerance),
                           .n0 = view->n0,
                           .na = view->na,
                           .nb = view->nb};
}

/* Target i of a batch over the strips of an element. */
static void near_target(struct rad_near *w, const struct rad_strip *strip, int n_strip,
                        const struct batch *t, int i, double *k, int64_t ld,
                        struct rad_scratch *s) {
  const struct rad_element *e = w->element;
  double *out = s->far;
  for (int d = 0; d < 3; d++)
    w->x[d] = t->frame[d * RAD_BATCH + i];
  w->n_kernel = 0;
  if (w->x[2] > 0 && n_strip > 0)
    rad_near(w, strip, n_strip, out);
  else
    for (int b = 0; b < e->k_phi * e->k_r; b++)
      out[b] = 0;
  store(e, out, 1, k + t->row[i], ld);
  s->counters.near++;
  s->counters.kernel_values += w->n_kernel;
}

/* Targets near a whole element: those beside it still by rules, in groups of neighbours. */
static void close_block(const struct rad_mesh *mesh, const struct rad_rules *rules, int element,
                        const struct rad_view *view, const struct rad_classes *classes,
                        const struct batch *t, double *k, int64_t ld, struct rad_scratch *s) {
  enum { GROUP = 16 };
  const struct rad_element *e = &mesh->element[element];
  const int *list = s->list + RAD_N_CLASS * RAD_BATCH;
  struct rad_strip strip = rad_strip_whole(e);
  struct rad_near w = near_work(mesh, rules, view, e);
  int group[GROUP], n = 0, most[2] = {0, 0};
  for (int i = 0; i < s->count[RAD_N_CLASS]; i++) {
    int rule[2], j = list[i];
    double x[3] = {t->frame[j], t->frame[RAD_BATCH + j], t->frame[2 * RAD_BATCH + j]};
    if (!rad_class_close(classes, x, rule)) {
      near_target(&w, &strip, 1, t, j, k, ld, s);
      continue;
    }
    group[n++] = j;
    for (int d = 0; d < 2; d++)
      most[d] = rule[d] > most[d] ? rule[d] : most[d];
    if (n == GROUP) {
      far_targets(mesh, rules, element, view, most, t, group, n, k, ld, s);
      n = most[0] = most[1] = 0;
    }
  }
  far_targets(mesh, rules, element, view, most, t, group, n, k, ld, s);
}

/* A whole element in front of all targets of a batch, which see all of it. */
static void whole_block(const struct rad_mesh *mesh, const struct rad_rules *rules, int element,
                        const struct rad_view *view, const struct batch *t, double *k, int64_t ld,
                        struct rad_scratch *s) {
  const struct rad_element *e = &mesh->element[element];
  struct rad_classes classes;
  rad_classes_set(&mesh->patch[e->patch], e, &rules->panel[rules->angular[element]],
                  &rules->panel[rules->radial[element]], &classes);
  sort_targets(&classes, t, s);
  for (int one = 0; one < classes.n; one++)
    far_targets(mesh, rules, element, view, classes.rule[one], t, s->list + one * RAD_BATCH,
                s->count[one], k, ld, s);
  close_block(mesh, rules, element, view, &classes, t, k, ld, s);
}

/* Lambert's formula for constants on visible parts (theory 3.15). */
static double constant_part(const struct rad_mesh *mesh, const struct rad_near *w, int target,
                            struct rad_parts *parts) {
  const struct rad_patch *p = w->patch;
  const double *n = mesh->scene->triangle[target].normal;
  double normal[3] = {rad_dot(n, p->e1), rad_dot(n, p->e2),
                      rad_dot(n, mesh->scene->triangle[p->triangle].normal)};
  for (int i = 0; i < parts->n; i++)
    for (int c = 0; c < parts->part[i].n; c++) {
      double *y = parts->part[i].corner[c], r = y[0], rt = y[1];
      y[0] = r * p->a1 + rt * p->b1;
      y[1] = rt * p->b2;
    }
  return rad_parts_form_factor(parts, w->x, normal);
}

/* Target i of a batch over s->shade.parts of an element. */
static void parts_target(const struct rad_mesh *mesh, struct rad_near *w, int target,
                         const struct batch *t, int i, double *k, int64_t ld,
                         struct rad_scratch *s) {
  const struct rad_element *e = w->element;
  if (e->k_phi * e->k_r > 1) {
    int n_strip = rad_shade_strips(&s->shade, w->patch, e);
    near_target(w, s->shade.strip, n_strip, t, i, k, ld, s);
    return;
  }
  for (int d = 0; d < 3; d++)
    w->x[d] = t->frame[d * RAD_BATCH + i];
  double f = w->x[2] > 0 ? constant_part(mesh, w, target, &s->shade.parts) : 0;
  store(e, &f, 1, k + t->row[i], ld);
  s->counters.near++;
}

/* An element on which shadows fall, or that the horizon cuts: target by target. Those that see the
 * whole element are left for whole_block. */
static void parts_block(const struct rad_mesh *mesh, const struct rad_rules *rules, int element,
                        const struct rad_view *view, int target, int shaded,
                        const struct rad_polygon *part, int cut, double *k, int64_t ld,
                        struct rad_scratch *s) {
  const struct rad_element *e = &mesh->element[element];
  struct rad_near w = near_work(mesh, rules, view, e);
  struct batch all = {s->n, s->frame, s->row}, whole = {0, s->frame_whole, s->row_whole};
  for (int i = 0; i < s->n; i++) {
    enum rad_sight sight = rad_shade_polygon(&s->shade, shaded ? i : -1, part);
    if (sight == RAD_FREE && !cut) {
      for (int d = 0; d < 3; d++)
        s->frame_whole[d * RAD_BATCH + whole.n] = s->frame[d * RAD_BATCH + i];
      s->row_whole[whole.n++] = s->row[i];
    } else {
      parts_target(mesh, &w, target, &all, i, k, ld, s);
    }
  }
  if (whole.n)
    whole_block(mesh, rules, element, view, &whole, k, ld, s);
}

/* One element for all targets in s->frame; k: its first column. */
static void element_block(const struct rad_mesh *mesh, const struct rad_rules *rules, int element,
                          const struct rad_view *view, int target, int across, int shaded,
                          double *k, int64_t ld, struct rad_scratch *s) {
  const struct rad_element *e = &mesh->element[element];
  struct rad_polygon part;
  int cut = 0;
  if (across || shaded)
    rad_element_polygon(&mesh->patch[e->patch], e, &part);
  if (across) {
    double lowest = INFINITY;
    for (int i = 0; i < part.n; i++)
      lowest = fmin(lowest, view->n0 + view->na * part.corner[i][0] + view->nb * part.corner[i][1]);
    cut = lowest < 0;
    if (cut)
      rad_clip(&part, view->n0, view->na, view->nb);
  }
  if (cut || shaded)
    parts_block(mesh, rules, element, view, target, shaded, &part, cut, k, ld, s);
  else
    whole_block(mesh, rules, element, view, &(struct batch){s->n, s->frame, s->row}, k, ld, s);
}

/* A batch of targets before one patch. */
struct scene_of_batch {
  struct rad_view view;
  int across, shaded;
};

/* The targets in the frame of the patch, and the shadows that they see. */
static void begin(const struct rad_mesh *mesh, const struct rad_targets *targets, int patch,
                  struct scene_of_batch *b, struct rad_scratch *s) {
  const struct rad_scene *scene = mesh->scene;
  const struct rad_triangle *target = &scene->triangle[targets->triangle];
  const struct rad_triangle *source = &scene->triangle[mesh->patch[patch].triangle];
  rad_view_set(target, source, &mesh->patch[patch], &b->view);
  for (int i = 0; i < targets->n; i++) {
    double x[3];
    rad_view_point(&b->view, targets->base[i], targets->mu[i], x);
    for (int d = 0; d < 3; d++)
      s->frame[d * RAD_BATCH + i] = x[d];
    s->row[i] = targets->row ? targets->row[i] : i;
  }
  s->n = targets->n;
  b->across = rad_side_of(target, source) == RAD_ACROSS;
  b->shaded = rad_shade_cast(scene, targets->triangle, &mesh->patch[patch], targets->n,
                             targets->base, targets->mu, &s->shade);
}

/* Elements of one patch, with their columns. */
static void list_block(const struct rad_mesh *mesh, const struct rad_rules *rules,
                       const struct rad_targets *targets, int n, const int *element,
                       const int64_t *column, double *k, int64_t ld, struct rad_scratch *s) {
  struct scene_of_batch b;
  begin(mesh, targets, mesh->element[element[0]].patch, &b, s);
  for (int i = 0; i < n && !rad_stop_asked(); i++)
    element_block(mesh, rules, element[i], &b.view, targets->triangle, b.across, b.shaded,
                  k + ld * column[i], ld, s);
}

/* A whole triangle for targets that touch it, by the vertex that they are near; k: its first
 * column. */
static void touched_block(const struct rad_mesh *mesh, const struct rad_rules *rules,
                          const struct rad_targets *targets, int element, double *k, int64_t ld,
                          struct rad_scratch *s) {
  static const int64_t zero = 0;
  const int patch = mesh->element[element].patch, n_function = mesh->element[element].n_function;
  for (int base = 0; base < 3; base++) {
    int row[RAD_BATCH], of[RAD_BATCH];
    double mu[RAD_BATCH][2], value[4 * RAD_BATCH];
    struct rad_targets some = {targets->triangle, 0, of, (const double(*)[2])mu, row};
    struct rad_turn turn;
    for (int i = 0; i < targets->n; i++)
      if (targets->base[i] == base) {
        memcpy(mu[some.n], targets->mu[i], sizeof mu[0]);
        of[some.n] = base;
        row[some.n++] = targets->row ? targets->row[i] : i;
      }
    if (some.n == 0)
      continue;
    if (!rad_turn_set(mesh, rules, targets->triangle, base, patch, &turn)) {
      list_block(mesh, rules, &some, 1, &element, &zero, k, ld, s);
      continue;
    }
    some.row = NULL;
    list_block(&turn.mesh, &turn.rules, &some, 1, turn.zero, &zero, value, RAD_BATCH, s);
    for (int f = 0; f < n_function; f++)
      for (int i = 0; i < some.n; i++) {
        double sum = 0;
        for (int g = 0; g < n_function; g++)
          sum += value[g * RAD_BATCH + i] * turn.value[g][f];
        k[row[i] + ld * f] = sum;
      }
  }
}

void rad_patch_block(const struct rad_mesh *mesh, const struct rad_rules *rules,
                     const struct rad_targets *targets, int patch, const unsigned char *wanted,
                     double *k, int64_t ld, struct rad_scratch *s) {
  const int first = mesh->element_first[patch];
  struct scene_of_batch b;
  if (rad_turn_wanted(mesh, targets->triangle, patch)) {
    if (!wanted || wanted[first])
      touched_block(mesh, rules, targets, first, k + ld * mesh->element[first].first, ld, s);
    return;
  }
  begin(mesh, targets, patch, &b, s);
  for (int i = first; i < mesh->element_first[patch + 1] && !rad_stop_asked(); i++)
    if (!wanted || wanted[i])
      element_block(mesh, rules, i, &b.view, targets->triangle, b.across, b.shaded,
                    k + ld * mesh->element[i].first, ld, s);
}

void rad_element_list_block(const struct rad_mesh *mesh, const struct rad_rules *rules,
                            const struct rad_targets *targets, int n, const int *element,
                            const int64_t *column, double *k, int64_t ld, struct rad_scratch *s) {
  if (rad_turn_wanted(mesh, targets->triangle, mesh->element[element[0]].patch))
    touched_block(mesh, rules, targets, element[0], k + ld * column[0], ld, s);
  else
    list_block(mesh, rules, targets, n, element, column, k, ld, s);
}
