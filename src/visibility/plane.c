#include "visibility/plane.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec.h"
#include "scene/contact.h"

#define IN_PLANE 1e-12 /* height over extent or distance that counts as zero: rounding */

/* An edge of a triangle. */
struct edge {
  int low, high; /* vertices */
  int triangle;
};

struct by_area {
  double area;
  int triangle;
};

/* What lives only while planes are found. */
struct finder {
  const struct rad_scene *scene;
  double rounding;
  struct edge *edge; /* owned [3 n] sorted: those with the same vertices are neighbours */
  int *place;        /* owned [3 n] of edge m of triangle t in `edge`, at 3 t + m */
  int *queue;        /* owned [n] */
  struct by_area *order;
};

static int compare_edges(const void *a, const void *b) {
  const struct edge *p = a, *q = b;
  if (p->low != q->low)
    return p->low < q->low ? -1 : 1;
  if (p->high != q->high)
    return p->high < q->high ? -1 : 1;
  return (p->triangle > q->triangle) - (p->triangle < q->triangle);
}

static int compare_areas(const void *a, const void *b) {
  const struct by_area *p = a, *q = b;
  if (p->area != q->area)
    return p->area > q->area ? -1 : 1;
  return (p->triangle > q->triangle) - (p->triangle < q->triangle);
}

static int start(struct finder *f, struct rad_planes *p) {
  int n = f->scene->n_triangle;
  f->edge = rad_alloc(3 * (size_t)n, sizeof *f->edge);
  f->place = rad_alloc(3 * (size_t)n, sizeof *f->place);
  f->queue = rad_alloc((size_t)n, sizeof *f->queue);
  f->order = rad_alloc((size_t)n, sizeof *f->order);
  p->plane = rad_alloc((size_t)n, sizeof *p->plane);
  p->largest = rad_alloc((size_t)n, sizeof *p->largest);
  p->member = rad_alloc((size_t)n, sizeof *p->member);
  p->member_first = rad_calloc((size_t)n + 1, sizeof *p->member_first);
  if (!f->edge || !f->place || !f->queue || !f->order || !p->plane || !p->largest || !p->member ||
      !p->member_first)
    return -1;
  for (int t = 0; t < n; t++) {
    const struct rad_triangle *triangle = &f->scene->triangle[t];
    p->plane[t] = -1;
    f->order[t] = (struct by_area){triangle->area, t};
    for (int m = 0; m < 3; m++) {
      int a = triangle->vertex[m], b = triangle->vertex[(m + 1) % 3];
      f->edge[3 * t + m] = (struct edge){a < b ? a : b, a < b ? b : a, t};
    }
  }
  qsort(f->edge, 3 * (size_t)n, sizeof *f->edge, compare_edges);
  qsort(f->order, (size_t)n, sizeof *f->order, compare_areas);
  int *n_placed = f->queue; /* [n] until the queue is needed */
  memset(n_placed, 0, (size_t)n * sizeof *n_placed);
  for (int k = 0; k < 3 * n; k++)
    f->place[3 * f->edge[k].triangle + n_placed[f->edge[k].triangle]++] = k;
  return 0;
}

/* Heights of the vertices of u above the plane of t are rounding: of the distance, or of the
 * coordinates, which tilt the plane of a thin triangle. */
static int in_plane(const struct finder *f, const struct rad_triangle *t, double longest,
                    const struct rad_triangle *u) {
  for (int m = 0; m < 3; m++) {
    double r[3];
    rad_sub(u->v[m], t->v[0], r);
    double reach = fmax(longest, rad_norm(r)), width = 2 * t->area / longest;
    if (!(fabs(rad_dot(t->normal, r)) <= IN_PLANE * reach + f->rounding * (1 + reach / width)))
      return 0;
  }
  return 1;
}

/* Number everything that is joined to a triangle. */
static void flood(struct finder *f, int largest, struct rad_planes *p) {
  const struct rad_triangle *t = &f->scene->triangle[largest];
  double longest = rad_longest_edge(t);
  int n_queue = 1;
  f->queue[0] = largest;
  p->plane[largest] = p->n;
  for (int q = 0; q < n_queue; q++)
    for (int m = 0; m < 3; m++) {
      int k = f->place[3 * f->queue[q] + m];
      const struct edge e = f->edge[k];
      while (k > 0 && f->edge[k - 1].low == e.low && f->edge[k - 1].high == e.high)
        k--;
      for (; k < 3 * f->scene->n_triangle && f->edge[k].low == e.low && f->edge[k].high == e.high;
           k++) {
        int u = f->edge[k].triangle;
        if (p->plane[u] < 0 && in_plane(f, t, longest, &f->scene->triangle[u])) {
          p->plane[u] = p->n;
          f->queue[n_queue++] = u;
        }
      }
    }
  p->largest[p->n++] = largest;
}

static void list_members(int n_triangle, struct rad_planes *p) {
  for (int t = 0; t < n_triangle; t++)
    p->member_first[p->plane[t] + 1]++;
  for (int k = 0; k < p->n; k++)
    p->member_first[k + 1] += p->member_first[k];
  for (int t = n_triangle - 1; t >= 0; t--) /* the ends move down to the firsts */
    p->member[--p->member_first[p->plane[t] + 1]] = t;
  memmove(p->member_first, p->member_first + 1, (size_t)p->n * sizeof *p->member_first);
  p->member_first[p->n] = n_triangle;
}

int rad_planes_find(const struct rad_scene *scene, double rounding, struct rad_planes *p) {
  struct finder f = {.scene = scene, .rounding = rounding};
  *p = (struct rad_planes){0};
  int failed = start(&f, p);
  for (int k = 0; !failed && k < scene->n_triangle; k++)
    if (p->plane[f.order[k].triangle] < 0)
      flood(&f, f.order[k].triangle, p);
  if (!failed)
    list_members(scene->n_triangle, p);
  free(f.edge);
  free(f.place);
  free(f.queue);
  free(f.order);
  return failed;
}

void rad_planes_free(struct rad_planes *p) {
  free(p->plane);
  free(p->member_first);
  free(p->member);
  free(p->largest);
  *p = (struct rad_planes){0};
}
