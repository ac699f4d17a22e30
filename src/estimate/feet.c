#include "estimate/feet.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec.h"

/* A face has several points of the estimate along its diameter: what is farther than this part of
 * it is resolved. */
#define REACH 0.5

void rad_feet_free(struct rad_feet *f) {
  free(f->feature);
  free(f->foot);
  *f = (struct rad_feet){0};
}

/* x at weights of a triangle's vertices. */
static void mix(const struct rad_triangle *t, const double w[3], double x[3]) {
  for (int d = 0; d < 3; d++)
    x[d] = w[0] * t->v[0][d] + w[1] * t->v[1][d] + w[2] * t->v[2][d];
}

/* The projection lies inside, or the nearest point is that of one of the edges. */
double rad_nearest_point(const struct rad_triangle *t, const double x[3], double weight[3]) {
  double best = INFINITY, to[3], side[3], at[3], w[3];
  rad_triangle_weights(t, x, weight);
  if (weight[0] >= 0 && weight[1] >= 0 && weight[2] >= 0) {
    rad_sub(x, t->v[0], to);
    return fabs(rad_dot(to, t->normal));
  }
  for (int c = 0; c < 3; c++) {
    int n = (c + 1) % 3;
    rad_sub(t->v[n], t->v[c], side);
    rad_sub(x, t->v[c], to);
    double s = fmin(fmax(rad_dot(to, side) / rad_dot(side, side), 0), 1);
    memset(w, 0, sizeof w);
    w[c] = 1 - s;
    w[n] = s;
    mix(t, w, at);
    rad_sub(x, at, to);
    double distance = rad_norm(to);
    if (distance < best) {
      best = distance;
      memcpy(weight, w, sizeof w);
    }
  }
  return best;
}

/* Centre and radius of a circle around a triangle, not the least one; its size, of equal area. */
struct disk {
  double center[3], radius;
};

static struct disk disk_of(const struct rad_triangle *t) {
  static const double third[3] = {1.0 / 3, 1.0 / 3, 1.0 / 3};
  struct disk d = {.radius = 0};
  mix(t, third, d.center);
  for (int c = 0; c < 3; c++) {
    double to[3];
    rad_sub(t->v[c], d.center, to);
    d.radius = fmax(d.radius, rad_norm(to));
  }
  return d;
}

/* The unit vector in a face across a segment; 0 if the segment has no direction there. */
static void set_across(const struct rad_triangle *face, struct rad_feature *f) {
  double along[3], across[3];
  rad_sub(f->p[1], f->p[0], along);
  rad_cross(face->normal, along, across);
  double length = rad_norm(across);
  for (int d = 0; d < 3 && length > 0; d++)
    f->across[d] = across[d] / length;
}

static int add_feature(struct rad_feet *feet, const struct rad_triangle *face,
                       struct rad_feature f) {
  if (!rad_reserve((void **)&feet->feature, (size_t)feet->n_feature + 1, &feet->room_feature,
                   sizeof f))
    return 0;
  set_across(face, &f);
  feet->feature[feet->n_feature++] = f;
  return 1;
}

static int shared(const struct rad_triangle *t, int vertex) {
  return t->vertex[0] == vertex || t->vertex[1] == vertex || t->vertex[2] == vertex;
}

/* The edges of a triangle as features, and their ends by themselves, from which things change in
 * all directions. Not where both triangles meet: the gradings there are made for that. */
static int add_edges(struct rad_feet *feet, const struct rad_scene *s, int face, int near,
                     int own) {
  const struct rad_triangle *f = &s->triangle[face], *n = &s->triangle[near];
  const struct rad_triangle *t = own ? f : n, *other = own ? n : f;
  int done = 1;
  for (int c = 0; c < 3 && done; c++) {
    int d = (c + 1) % 3, touch = shared(other, t->vertex[c]);
    struct rad_feature one = {.face = face, .near = near, .own = own};
    memcpy(one.p[0], t->v[c], sizeof one.p[0]);
    memcpy(one.p[1], t->v[c], sizeof one.p[0]);
    if (!touch)
      done = add_feature(feet, f, one);
    memcpy(one.p[1], t->v[d], sizeof one.p[1]);
    if (!touch && !shared(other, t->vertex[d]) && done)
      done = add_feature(feet, f, one);
  }
  return done;
}

static int add_pair(struct rad_feet *feet, const struct rad_scene *s, int face, int near,
                    const struct disk *disk) {
  struct rad_feature middle = {.face = face, .near = near};
  const struct rad_triangle *n = &s->triangle[near];
  memcpy(middle.p[0], disk[near].center, sizeof middle.p[0]);
  memcpy(middle.p[1], disk[near].center, sizeof middle.p[1]);
  middle.width = 0.5 * n->area / disk[near].radius;
  return add_feature(feet, &s->triangle[face], middle) && add_edges(feet, s, face, near, 0) &&
         add_edges(feet, s, face, near, 1);
}

static int find_features(const struct rad_scene *s, const unsigned char *sees,
                         const unsigned char *passive, struct rad_feet *feet) {
  int n = s->n_triangle, done = 1;
  struct disk *disk = rad_alloc((size_t)n, sizeof *disk);
  if (!disk)
    return 0;
  for (int t = 0; t < n; t++)
    disk[t] = disk_of(&s->triangle[t]);
  for (int face = 0; face < n; face++)
    for (int near = 0; near < n && done && !(passive && passive[face]); near++) {
      double apart[3];
      if (!sees[(size_t)face * (size_t)n + (size_t)near])
        continue;
      rad_sub(disk[face].center, disk[near].center, apart);
      if (rad_norm(apart) < (1 + REACH) * disk[face].radius + disk[near].radius)
        done = add_pair(feet, s, face, near, disk);
    }
  free(disk);
  return done;
}

enum rad_code rad_feet_find(const struct rad_mesh *mesh, const unsigned char *sees,
                            const unsigned char *passive, struct rad_feet *feet,
                            struct rad_error *e) {
  *feet = (struct rad_feet){0};
  int done = find_features(mesh->scene, sees, passive, feet);
  for (int i = 0; i < feet->n_feature && done; i++)
    done = rad_feet_walk(mesh, i, 0, 1, feet);
  return done ? RAD_OK : rad_fail_memory(e, "the error estimate", 200.0 * feet->n_feature);
}
