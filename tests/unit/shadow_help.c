#include "shadow_help.h"

#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "clip_oracle.h"
#include "scene_help.h"

/* --- occluders --- */

static void sort3(int v[3]) {
  for (int a = 0; a < 3; a++)
    for (int b = a + 1; b < 3; b++)
      if (v[b] < v[a]) {
        int swap = v[a];
        v[a] = v[b];
        v[b] = swap;
      }
}

struct rad_occluders occluders_by_hand(const struct rad_scene *scene) {
  int n = scene->n_triangle;
  size_t room = (size_t)n;
  struct rad_occluders o = {.scene = scene, .n = n, .n_plane = n};
  o.occluder = calloc(room, sizeof *o.occluder);
  o.corner = malloc(3 * room * sizeof *o.corner);
  o.inward = malloc(3 * room * sizeof *o.inward);
  o.on_line_first = calloc(3 * room + 1, sizeof *o.on_line_first);
  o.on_line = malloc(6 * room * sizeof *o.on_line);
  o.plane = malloc(room * sizeof *o.plane);
  o.in_plane_first = calloc(room + 1, sizeof *o.in_plane_first);
  o.in_plane = malloc(3 * room * sizeof *o.in_plane);
  for (int k = 0; k < n; k++) {
    const struct rad_triangle *t = &scene->triangle[k];
    struct rad_occluder *p = &o.occluder[k];
    *p = (struct rad_occluder){.plane = k, .n = 3, .first = 3 * k};
    memcpy(p->normal, t->normal, sizeof p->normal);
    double u[3], v[3], right[3];
    rad_sub(t->v[1], t->v[0], u);
    rad_sub(t->v[2], t->v[0], v);
    rad_cross(u, v, right);
    int back = rad_dot(right, t->normal) < 0;
    o.plane[k] = k;
    o.in_plane_first[k + 1] = 3 * (k + 1);
    for (int m = 0; m < 3; m++) {
      int side = 3 * k + m;
      o.corner[side] = t->vertex[back ? 2 - m : m];
      o.in_plane[side] = t->vertex[m];
      o.on_line_first[side + 1] = 2 * (side + 1);
    }
    sort3(&o.in_plane[3 * k]);
    for (int m = 0; m < 3; m++) {
      int a = o.corner[3 * k + m], b = o.corner[3 * k + (m + 1) % 3], *pair;
      pair = &o.on_line[2 * (3 * k + m)];
      pair[0] = a < b ? a : b;
      pair[1] = a < b ? b : a;
      double along[3], *inward = o.inward[3 * k + m];
      rad_sub(scene->vertex[b], scene->vertex[a], along);
      rad_cross(t->normal, along, inward);
      double length = rad_norm(inward);
      for (int d = 0; d < 3; d++)
        inward[d] /= length;
    }
  }
  return o;
}

struct rad_occluders occluders_merged(const struct rad_scene *scene) {
  struct rad_occluders o;
  struct rad_error e;
  ck_assert_int_eq(rad_occluders_build(scene, &o, &e), RAD_OK);
  return o;
}

/* --- looking --- */

double visible_fraction(const struct rad_occluders *o, const struct look *look) {
  static const double zero[2] = {0, 0}, one[2][2] = {{1, 0}, {0, 1}};
  const struct rad_polygon whole = {.n = 3,
                                    .corner = {{0, 0}, {look->shrink, 0}, {0, look->shrink}}};
  struct rad_half_planes *planes = malloc(((size_t)o->n + 1) * sizeof *planes);
  struct rad_parts parts = {0};
  int n = 0;
  for (int k = 0; k < o->n; k++) {
    struct rad_shadow_frame frame;
    struct rad_shadow shadow;
    rad_shadow_frame_set(o, look->target, look->source, k, &frame);
    rad_shadow_cast(&frame, look->base, look->mu, &shadow);
    if (shadow.n)
      rad_half_planes_set(&shadow, look->corner, zero, one[0], one[1], &planes[n++]);
  }
  int sight = rad_visible(&whole, n, planes, &parts);
  double area = rad_parts_area(&parts) / rad_polygon_area(&whole);
  ck_assert_int_ge(sight, 0);
  ck_assert_msg(area >= 0 && area <= 1 + 1e-14, "visible fraction %.17g", area);
  ck_assert((sight == RAD_HIDDEN) == (area == 0));
  ck_assert(sight != RAD_FREE || area == 1);
  rad_parts_free(&parts);
  free(planes);
  return area;
}

static int in_plane_of(const struct rad_triangle *plane, const struct rad_triangle *k) {
  double u[3], v[3], normal[3], r[3];
  rad_sub(plane->v[1], plane->v[0], u);
  rad_sub(plane->v[2], plane->v[0], v);
  rad_cross(u, v, normal);
  int n = 0;
  for (int m = 0; m < 3; m++) {
    rad_sub(k->v[m], plane->v[0], r);
    n += rad_dot(normal, r) == 0;
  }
  return n == 3;
}

double oracle_fraction(const struct rad_scene *scene, const struct look *look) {
  const struct rad_triangle *t = scene->triangle, *i = &t[look->target], *j = &t[look->source];
  double(*blocker)[3][3] = malloc((size_t)scene->n_triangle * sizeof *blocker), source[3][3];
  int n = 0;
  for (int k = 0; k < scene->n_triangle; k++)
    if (k != look->target && k != look->source && !in_plane_of(i, &t[k]) && !in_plane_of(j, &t[k]))
      memcpy(blocker[n++], t[k].v, sizeof *blocker);
  for (int m = 0; m < 3; m++)
    for (int d = 0; d < 3; d++) {
      double v = j->v[look->corner][d];
      source[m][d] = look->shrink < 1 ? v + look->shrink * (j->v[m][d] - v) : j->v[m][d];
    }
  double fraction =
      clip_oracle(i->v, look->base, look->mu, source, n, (const double(*)[3][3])blocker);
  free(blocker);
  return fraction;
}

void expect_fraction(double got, double expected, double tolerance, const struct look *look,
                     const char *what, struct tally *tally) {
  tally->n++;
  tally->n_hidden += expected < 1e-12;
  tally->n_free += expected > 1 - 1e-12;
  tally->n_part += expected >= 1e-12 && expected <= 1 - 1e-12;
  tally->worst = fmax(tally->worst, fabs(got - expected));
  ck_assert_msg(
      fabs(got - expected) <= tolerance,
      "%s: %d sees of %d %.17g, expected %.17g, difference %.2g; base %d, mu %.17g %.17g, "
      "corner %d shrunk by %.2g, seed %llu",
      what, look->target, look->source, got, expected, got - expected, look->base, look->mu[0],
      look->mu[1], look->corner, look->shrink, seed());
}

void print_tally(const char *what, const struct tally *t) {
  printf("%s: %d looks, %d free, %d hidden, %d in part; worst %.1e\n", what, t->n, t->n_free,
         t->n_hidden, t->n_part, t->worst);
  fflush(stdout);
}

struct look random_look(int n_triangle) {
  struct look look = {.target = (int)uniform(0, n_triangle),
                      .base = (int)uniform(0, 3),
                      .corner = (int)uniform(0, 3),
                      .shrink = 1};
  do
    look.source = (int)uniform(0, n_triangle);
  while (n_triangle > 1 && look.source == look.target);
  do {
    look.mu[0] = uniform(0, 1);
    look.mu[1] = uniform(0, 1);
  } while (look.mu[0] + look.mu[1] > 1);
  return look;
}
