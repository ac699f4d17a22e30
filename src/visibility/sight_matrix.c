/* What all pairs of triangles see of one another. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/stop.h"
#include "base/vec.h"
#include "visibility/bvh.h"
#include "visibility/occluder.h"

/* Sheets: triangles of one plane with one normal. What is in front of a sheet's plane, or not, by
 * more than any rounding, is so for each of its triangles. */
enum { IS_BEHIND, IS_IN_FRONT, IS_UNSURE };
struct sheets {
  int n, *sheet;        /* owned [n_triangle] sheet of each triangle */
  unsigned char *front; /* owned [n, n_triangle] where each triangle reaches to */
};

static void free_sheets(struct sheets *s) {
  free(s->sheet);
  free(s->front);
}

static unsigned char reach(const struct rad_triangle *i, const struct rad_triangle *j,
                           double margin) {
  double most = -INFINITY;
  for (int m = 0; m < 3; m++) {
    double r[3];
    rad_sub(j->v[m], i->v[0], r);
    most = fmax(most, rad_dot(i->normal, r));
  }
  return most > margin ? IS_IN_FRONT : most < -margin ? IS_BEHIND : IS_UNSURE;
}

/* Few sheets with many triangles: else s->n is 0, and every pair is looked at by itself. */
static int find_sheets(const struct rad_occluders *o, struct sheets *s) {
  const struct rad_scene *scene = o->scene;
  size_t n = (size_t)scene->n_triangle;
  double margin = 1e3 * fmax(o->slack, 1e-12 * scene->size);
  int *first = malloc(2 * (size_t)(o->n_plane + 1) * sizeof *first); /* triangle of each sheet */
  *s = (struct sheets){.sheet = malloc(n * sizeof(int))};
  if (!first || !s->sheet || 8 * (size_t)o->n_plane > n) {
    free(first);
    return s->sheet != NULL;
  }
  int *known = calloc(2 * (size_t)o->n_plane, sizeof *known);
  for (size_t t = 0; known && t < n; t++) {
    int plane = o->plane[t], back = 0;
    if (known[2 * plane])
      back = rad_dot(scene->triangle[t].normal,
                     scene->triangle[first[known[2 * plane] - 1]].normal) < 0;
    int *number = &known[2 * plane + back];
    if (!*number) {
      first[s->n] = (int)t;
      *number = ++s->n;
    }
    s->sheet[t] = *number - 1;
  }
  s->front = malloc((size_t)s->n * n);
  for (int a = 0; known && s->front && a < s->n; a++)
    for (size_t t = 0; t < n; t++)
      s->front[(size_t)a * n + t] =
          s->sheet[t] == a ? IS_BEHIND
                           : reach(&scene->triangle[first[a]], &scene->triangle[t], margin);
  int done = known && s->front;
  free(known);
  free(first);
  return done;
}

static unsigned char sight_of(const struct rad_occluders *o, const struct sheets *s, int i, int j,
                              int *list, int *n_list) {
  if (s->n) {
    size_t n = (size_t)o->scene->n_triangle;
    int a = s->front[(size_t)s->sheet[i] * n + (size_t)j];
    int b = s->front[(size_t)s->sheet[j] * n + (size_t)i];
    if (a == IS_BEHIND || b == IS_BEHIND)
      return RAD_HIDDEN;
    if (a == IS_IN_FRONT && b == IS_IN_FRONT && o->bvh->n_node == 0)
      return RAD_FREE;
  }
  return (unsigned char)rad_sight_between(o, i, j, list, n_list);
}

/* Row i of the table above the diagonal, and the blockers of its pairs as far as `left` numbers may
 * still be stored: without memory, or beyond it, they are looked for again when needed. */
static void fill_row(const struct rad_occluders *o, const struct sheets *s, int i, int *list,
                     int64_t *left, unsigned char *sight, struct rad_sight_row *row) {
  const int n = o->scene->n_triangle;
  size_t room = 0;
  int used = 0;
  for (int j = i + 1; j < n && !rad_stop_asked(); j++) {
    int count = 0;
    sight[(size_t)i * (size_t)n + (size_t)j] = sight_of(o, s, i, j, list, &count);
    if (count == 0 || row->full)
      continue;
    int64_t rest;
#pragma omp atomic capture
    {
      *left -= count + 2;
      rest = *left;
    }
    size_t need = (size_t)used + (size_t)count + 2;
    row->full = rest < 0 || !rad_reserve((void **)&row->data, need, &room, sizeof *row->data);
    if (row->full)
      continue;
    row->data[used] = j;
    row->data[used + 1] = count;
    memcpy(row->data + used + 2, list, (size_t)count * sizeof *list);
    row->n = used += count + 2;
  }
}

/* The lower triangle from the upper one, in squares that stay in the first cache. */
static void mirror(unsigned char *sight, int n, int from) {
  enum { SQUARE = 64 };
  int end = from + SQUARE < n ? from + SQUARE : n;
  for (int first = 0; first < end; first += SQUARE)
    for (int i = from; i < end; i++)
      for (int j = first; j < first + SQUARE && j < i; j++)
        sight[(size_t)i * (size_t)n + (size_t)j] = sight[(size_t)j * (size_t)n + (size_t)i];
}

unsigned char *rad_sight_matrix(const struct rad_occluders *o, int64_t most,
                                struct rad_sight_row *row) {
  const int n = o->scene->n_triangle;
  struct sheets s;
  unsigned char *sight = rad_calloc((size_t)n * (size_t)n, 1);
  if (!find_sheets(o, &s) || !sight) {
    free_sheets(&s);
    free(sight);
    return NULL;
  }
  int failed = 0;
  struct rad_progress *progress = o->scene->progress;
  rad_progress_begin(progress, "triangles", n);
#pragma omp parallel default(none) shared(o, n, sight, s, most, row, failed, progress)
  {
    int *list = malloc(((size_t)o->n + 1) * sizeof *list);
    if (!list) {
#pragma omp atomic write
      failed = 1;
    }
#pragma omp for schedule(dynamic, 16)
    for (int i = 0; i < n; i++)
      if (list) {
        fill_row(o, &s, i, list, &most, sight, &row[i]);
        rad_progress_add(progress, 1);
      }
    free(list);
#pragma omp for schedule(dynamic)
    for (int i = 0; i < n; i += 64)
      mirror(sight, n, i);
  }
  free_sheets(&s);
  if (failed) {
    free(sight);
    return NULL;
  }
  return sight;
}
