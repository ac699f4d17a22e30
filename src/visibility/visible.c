#include "visibility/visible.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LEAST 1e-30 /* of the polygon's area: smaller pieces are dropped */

/* Corners of a piece: one shadow adds at most one with each of its sides. */
enum { MOST_KEPT = RAD_MAX_CORNER - RAD_MAX_SHADOW_SIDE };

void rad_parts_free(struct rad_parts *parts) {
  free(parts->part);
  *parts = (struct rad_parts){0};
}

double rad_parts_area(const struct rad_parts *parts) {
  double sum = 0;
  for (int p = 0; p < parts->n; p++)
    sum += rad_polygon_area(&parts->part[p]);
  return sum;
}

/* Copies only the corners that there are. */
static inline void copy(const struct rad_polygon *from, struct rad_polygon *to) {
  to->n = from->n;
  memcpy(to->corner, from->corner, (size_t)from->n * sizeof *from->corner);
}

/* Room for n pieces more, each of which may become two; 0, or -1 without memory. */
static int make_room(struct rad_parts *parts, int n) {
  int need = parts->n + 2 * n;
  if (need <= parts->room)
    return 0;
  int room = 2 * need;
  struct rad_polygon *part = realloc(parts->part, (size_t)room * sizeof *part);
  if (!part)
    return -1;
  parts->part = part;
  parts->room = room;
  return 0;
}

/* Append a piece, in halves if it has many corners. */
static void append(struct rad_parts *parts, const struct rad_polygon *piece) {
  struct rad_polygon *first = &parts->part[parts->n++];
  copy(piece, first);
  if (piece->n <= MOST_KEPT)
    return;
  struct rad_polygon *second = &parts->part[parts->n++];
  int half = piece->n / 2;
  first->n = half + 1;
  second->n = piece->n - half + 1;
  memcpy(second->corner, piece->corner[half], (size_t)(piece->n - half) * sizeof *piece->corner);
  memcpy(second->corner[second->n - 1], piece->corner[0], sizeof *piece->corner);
}

/* Lowest and highest value of an affine function on a polygon. */
static inline void range_on(const struct rad_polygon *polygon, const double c[3], double *low,
                            double *high) {
  *low = INFINITY;
  *high = -INFINITY;
  for (int i = 0; i < polygon->n; i++) {
    double f = c[0] + c[1] * polygon->corner[i][0] + c[2] * polygon->corner[i][1];
    *low = f < *low ? f : *low;
    *high = f > *high ? f : *high;
  }
}

/* The half-plane that cuts deepest into the polygon, of those in `left`, which loses those that
 * contain the polygon; -1: it lies outside of one. */
static int deepest(const struct rad_polygon *polygon, const struct rad_half_planes *shadow,
                   unsigned *left) {
  int best = 0;
  double depth = 0;
  for (int s = 0; s < shadow->n; s++) {
    double low, high;
    if (!(*left >> s & 1))
      continue;
    range_on(polygon, shadow->c[s], &low, &high);
    if (!(high > 0))
      return -1;
    if (low >= 0)
      *left &= ~(1u << s);
    else if (-low >= depth * (high - low)) {
      depth = -low / (high - low);
      best = s;
    }
  }
  return best;
}

enum rad_sight rad_shadow_over(const struct rad_polygon *polygon,
                               const struct rad_half_planes *shadow) {
  unsigned left = (1u << shadow->n) - 1;
  if (deepest(polygon, shadow, &left) < 0)
    return RAD_FREE;
  return left ? RAD_PARTLY : RAD_HIDDEN;
}

/* Append the parts of a piece outside of the shadow; 0, and nothing appended, if it misses. Needs
 * room for shadow->n pieces. */
static int peel(const struct rad_polygon *piece, const struct rad_half_planes *shadow, double least,
                struct rad_parts *parts) {
  struct rad_polygon rest, inside, outside;
  int n = parts->n;
  unsigned left = (1u << shadow->n) - 1;
  copy(piece, &rest);
  for (;;) {
    int s = deepest(&rest, shadow, &left);
    if (s >= 0 && !left)
      break;
    if (s >= 0) {
      left &= ~(1u << s);
      rad_split(&rest, shadow->c[s][0], shadow->c[s][1], shadow->c[s][2], &inside, &outside);
      if (rad_polygon_area(&outside) > least)
        append(parts, &outside);
      copy(&inside, &rest);
    }
    if (s < 0 || !(rad_polygon_area(&rest) > least)) {
      parts->n = n;
      return 0;
    }
  }
  return 1;
}

/* Take one shadow off all pieces; 1 if it falls on one, 0, or -1 without memory. */
static int take_off(const struct rad_half_planes *shadow, double least, struct rad_parts *parts) {
  int n = parts->n, falls = 0, kept = 0;
  for (int p = 0; p < n; p++) {
    if (make_room(parts, shadow->n))
      return -1;
    struct rad_polygon piece;
    copy(&parts->part[p], &piece);
    if (peel(&piece, shadow, least, parts)) {
      parts->part[p].n = 0;
      falls = 1;
    }
  }
  for (int p = 0; falls && p < parts->n; p++)
    if (parts->part[p].n) {
      if (kept < p)
        copy(&parts->part[p], &parts->part[kept]);
      kept++;
    }
  parts->n = falls ? kept : n;
  return falls;
}

int rad_visible(const struct rad_polygon *polygon, int n_shadow,
                const struct rad_half_planes *shadow, struct rad_parts *parts) {
  double area = rad_polygon_area(polygon);
  int falls = 0;
  parts->n = 0;
  if (!(area > 0))
    return RAD_HIDDEN;
  for (int s = 0; s < n_shadow; s++)
    if (rad_shadow_over(polygon, &shadow[s]) == RAD_HIDDEN)
      return RAD_HIDDEN;
  if (make_room(parts, 1))
    return -1;
  append(parts, polygon);
  for (int s = 0; s < n_shadow && parts->n; s++) {
    int hit = rad_shadow_over(polygon, &shadow[s]) == RAD_FREE
                  ? 0
                  : take_off(&shadow[s], LEAST * area, parts);
    if (hit < 0)
      return -1;
    falls |= hit;
  }
  return !parts->n ? RAD_HIDDEN : falls ? RAD_PARTLY : RAD_FREE;
}
