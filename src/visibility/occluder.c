#include "visibility/occluder.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec.h"
#include "visibility/bvh.h"
#include "visibility/partition.h"
#include "visibility/plane.h"

#define IN_PLANE 1e-12 /* distance from a line over the plane's size that counts as zero */
#define OVERLAP 1e-10  /* of the scene's size: less counts as none; the welding distance */

/* What lives only while occluders are built. */
struct builder {
  const struct rad_scene *scene;
  struct rad_occluders *o;
  struct rad_planes planes;
  int room, line_room, n_corner;
  int *local;         /* owned [n_vertex] number in the plane at hand; only read for its vertices */
  double (*point)[2]; /* owned [n_vertex] of the plane at hand */
  int (*triangle)[3]; /* owned [n_triangle] of the plane at hand */
};

static int compare_ints(const void *a, const void *b) {
  return (*(const int *)a > *(const int *)b) - (*(const int *)a < *(const int *)b);
}

/* Sort, and leave each number once. */
static int make_unique(int *list, int n) {
  qsort(list, (size_t)n, sizeof *list, compare_ints);
  int n_unique = 0;
  for (int k = 0; k < n; k++)
    if (n_unique == 0 || list[k] != list[n_unique - 1])
      list[n_unique++] = list[k];
  return n_unique;
}

/* --- one plane --- */

/* Append the plane's vertices to o->in_plane. */
static void gather_vertices(struct builder *b, int plane) {
  struct rad_occluders *o = b->o;
  int *list = o->in_plane + o->in_plane_first[plane], n = 0;
  for (int k = b->planes.member_first[plane]; k < b->planes.member_first[plane + 1]; k++)
    for (int m = 0; m < 3; m++)
      list[n++] = b->scene->triangle[b->planes.member[k]].vertex[m];
  n = make_unique(list, n);
  o->in_plane_first[plane + 1] = o->in_plane_first[plane] + n;
}

/* Coordinates in the plane: without the one along which the normal is longest. The greatest
 * distance from the first. */
static double flatten(struct builder *b, int plane, const double normal[3]) {
  int axis = fabs(normal[0]) > fabs(normal[1]) ? 0 : 1;
  axis = fabs(normal[2]) > fabs(normal[axis]) ? 2 : axis;
  int x = (axis + 1) % 3, y = (axis + 2) % 3;
  const int *list = b->o->in_plane + b->o->in_plane_first[plane];
  int n = b->o->in_plane_first[plane + 1] - b->o->in_plane_first[plane];
  double reach = 0;
  for (int k = 0; k < n; k++) {
    const double *v = b->scene->vertex[list[k]];
    double r[3];
    b->local[list[k]] = k;
    b->point[k][0] = normal[axis] < 0 ? v[y] : v[x];
    b->point[k][1] = normal[axis] < 0 ? v[x] : v[y];
    rad_sub(v, b->scene->vertex[list[0]], r);
    reach = fmax(reach, rad_norm(r));
  }
  return reach;
}

static int compare_triples(const void *a, const void *b) {
  const int *p = a, *q = b;
  for (int m = 0; m < 3; m++)
    if (p[m] != q[m])
      return p[m] < q[m] ? -1 : 1;
  return 0;
}

/* Which of a plane's triangles. */
enum facing { BOTH = 0, FRONTS = 1, BACKS = -1 };

/* The plane's triangles by local numbers, counterclockwise, twins once; their number. */
static int gather_triangles(struct builder *b, int plane, const double normal[3],
                            enum facing facing) {
  int n = 0, n_unique = 0;
  for (int k = b->planes.member_first[plane]; k < b->planes.member_first[plane + 1]; k++) {
    const struct rad_triangle *t = &b->scene->triangle[b->planes.member[k]];
    if (facing != BOTH && rad_dot(t->normal, normal) * facing < 0)
      continue;
    for (int m = 0; m < 3; m++)
      b->triangle[n][m] = b->local[t->vertex[m]];
    qsort(b->triangle[n++], 3, sizeof b->triangle[0][0], compare_ints);
  }
  qsort(b->triangle, (size_t)n, sizeof *b->triangle, compare_triples);
  for (int k = 0; k < n; k++)
    if (k == 0 || compare_triples(b->triangle[k], b->triangle[n_unique - 1]))
      memmove(b->triangle[n_unique++], b->triangle[k], sizeof *b->triangle);
  for (int k = 0; k < n_unique; k++) {
    int *t = b->triangle[k];
    const double *p = b->point[t[0]], *q = b->point[t[1]], *r = b->point[t[2]];
    if ((q[0] - p[0]) * (r[1] - p[1]) < (q[1] - p[1]) * (r[0] - p[0])) {
      int kept = t[1];
      t[1] = t[2];
      t[2] = kept;
    }
  }
  return n_unique;
}

static void measure_side(struct rad_occluders *o, const double normal[3], int side, int next) {
  double edge[3];
  rad_sub(o->scene->vertex[o->corner[next]], o->scene->vertex[o->corner[side]], edge);
  rad_cross(normal, edge, o->inward[side]);
  double length = rad_norm(o->inward[side]);
  for (int d = 0; d < 3; d++)
    o->inward[side][d] /= length;
}

/* Append polygon k of a plane's partition. */
static void add_occluder(struct builder *b, int plane, const double normal[3],
                         const struct rad_partition *p, int k) {
  struct rad_occluders *o = b->o;
  const int *vertex = o->in_plane + o->in_plane_first[plane];
  struct rad_occluder *new = &o->occluder[o->n++];
  *new = (struct rad_occluder){.plane = plane, .n = p->first[k + 1] - p->first[k]};
  new->first = b->n_corner;
  memcpy(new->normal, normal, sizeof new->normal);
  for (int c = 0; c < new->n; c++)
    o->corner[b->n_corner++] = vertex[p->corner[p->first[k] + c]];
  for (int d = 0; d < 3; d++) {
    new->low[d] = INFINITY;
    new->high[d] = -INFINITY;
    for (int c = 0; c < new->n; c++) {
      new->low[d] = fmin(new->low[d], o->scene->vertex[o->corner[new->first + c]][d]);
      new->high[d] = fmax(new->high[d], o->scene->vertex[o->corner[new->first + c]][d]);
    }
  }
  for (int c = 0; c < new->n; c++) {
    int side = new->first + c, next = new->first + (c + 1) % new->n, n = 0;
    measure_side(o, normal, side, next);
    int *list = o->on_line + o->on_line_first[side];
    list[n++] = o->corner[side];
    list[n++] = o->corner[next];
    for (int q = p->line_first[p->first[k] + c]; q < p->line_first[p->first[k] + c + 1]; q++)
      list[n++] = vertex[p->line[q]];
    o->on_line_first[side + 1] = o->on_line_first[side] + make_unique(list, n);
  }
}

static void *grow(void *array, size_t n, size_t item, int *failed) {
  void *grown = realloc(array, n * item);
  *failed |= !grown;
  return grown ? grown : array;
}

/* Room for n more corners with n_line more vertices on their sides, besides the ends. */
static int make_room(struct builder *b, int n, int n_line) {
  struct rad_occluders *o = b->o;
  int failed = 0, lines = o->on_line_first[b->n_corner] + n_line + 2 * n;
  if (b->n_corner + n > b->room) {
    b->room = 2 * (b->n_corner + n);
    size_t room = (size_t)b->room;
    o->occluder = grow(o->occluder, room / 3 + 1, sizeof *o->occluder, &failed);
    o->corner = grow(o->corner, room, sizeof *o->corner, &failed);
    o->inward = grow(o->inward, room, sizeof *o->inward, &failed);
    o->on_line_first = grow(o->on_line_first, room + 1, sizeof *o->on_line_first, &failed);
  }
  if (lines > b->line_room) {
    b->line_room = 2 * lines;
    o->on_line = grow(o->on_line, (size_t)b->line_room, sizeof *o->on_line, &failed);
  }
  return failed;
}

/* The same corners, in the same order. */
static int same_polygon(const struct rad_occluders *o, const struct rad_occluder *a,
                        const struct rad_occluder *b) {
  int shift = 0, n = 0;
  while (shift < b->n && o->corner[b->first + shift] != o->corner[a->first])
    shift++;
  while (n < a->n && a->n == b->n &&
         o->corner[a->first + n] == o->corner[b->first + (shift + n) % b->n])
    n++;
  return n == a->n;
}

/* Append the polygons of a plane's triangles, of the backs only those that the fronts have not; of
 * both nothing if edges are crowded. */
static int add_triangles(struct builder *b, int plane, enum facing facing, int *n_crowded) {
  struct rad_occluders *o = b->o;
  const double *normal = b->scene->triangle[b->planes.largest[plane]].normal;
  double rounding = IN_PLANE * flatten(b, plane, normal) + o->rounding;
  int n_triangle = gather_triangles(b, plane, normal, facing), before = o->n;
  int n_point = o->in_plane_first[plane + 1] - o->in_plane_first[plane];
  struct rad_partition p;
  int failed = rad_partition_make(n_point, b->point, n_triangle, b->triangle, rounding,
                                  RAD_MAX_OCCLUDER_CORNER, &p);
  int wanted = facing != BOTH || !p.n_crowded;
  failed = failed || make_room(b, p.first[p.n], p.line_first[p.first[p.n]]);
  for (int k = 0; !failed && wanted && k < p.n; k++) {
    add_occluder(b, plane, normal, &p, k);
    for (int q = 0; facing == BACKS && q < before && o->occluder[before - 1 - q].plane == plane;
         q++)
      if (same_polygon(o, &o->occluder[before - 1 - q], &o->occluder[o->n - 1])) {
        b->n_corner = o->occluder[--o->n].first;
        break;
      }
  }
  *n_crowded = p.n_crowded;
  rad_partition_free(&p);
  return failed;
}

/* Triangles of either side may overlap, as where two rooms share a wall that each cuts its own way:
 * then they are merged by themselves. */
static int add_plane(struct builder *b, int plane) {
  int n_crowded;
  gather_vertices(b, plane);
  int failed = add_triangles(b, plane, BOTH, &n_crowded);
  if (!failed && n_crowded)
    failed =
        add_triangles(b, plane, FRONTS, &n_crowded) || add_triangles(b, plane, BACKS, &n_crowded);
  return failed;
}

/* The planes of each vertex, from the vertices of each plane. */
static int turn_around(struct rad_occluders *o) {
  int n_vertex = o->scene->n_vertex, n = o->in_plane_first[o->n_plane];
  o->plane_of_first = rad_calloc((size_t)n_vertex + 2, sizeof *o->plane_of_first);
  o->plane_of = rad_alloc((size_t)n, sizeof *o->plane_of);
  if (!o->plane_of_first || !o->plane_of)
    return -1;
  int *end = o->plane_of_first + 1; /* of each vertex's planes so far, from its first on */
  for (int k = 0; k < n; k++)
    end[o->in_plane[k] + 1]++;
  for (int v = 0; v < n_vertex; v++)
    end[v + 1] += end[v];
  for (int plane = 0; plane < o->n_plane; plane++)
    for (int k = o->in_plane_first[plane]; k < o->in_plane_first[plane + 1]; k++)
      o->plane_of[end[o->in_plane[k]]++] = plane;
  return 0;
}

/* --- what can cast shadows --- */

/* Bounds of normal.(x - origin) in a box. */
static void bound(const struct rad_box *box, const double origin[3], const double normal[3],
                  double *low, double *high) {
  *low = *high = 0;
  for (int d = 0; d < 3; d++) {
    double p = normal[d] * (box->low[d] - origin[d]), q = normal[d] * (box->high[d] - origin[d]);
    *low += fmin(p, q);
    *high += fmax(p, q);
  }
}

/* True if the scene has points on both sides of polygon k's plane; `all` holds every polygon. */
static int cuts_scene(const struct rad_occluders *o, const struct rad_bvh *all, int k) {
  const double *normal = o->occluder[k].normal;
  const double *origin = o->scene->vertex[o->corner[o->occluder[k].first]];
  int stack[RAD_BVH_DEPTH] = {0}, n_stack = 1, above = 0, below = 0;
  while (n_stack) {
    const struct rad_bvh_node *node = &all->node[stack[--n_stack]];
    double low, high;
    bound(&node->box, origin, normal, &low, &high);
    if (!((high > o->slack && !above) || (low < -o->slack && !below)))
      continue;
    if (node->n == 0) {
      stack[n_stack++] = node->first;
      stack[n_stack++] = node->first + 1;
    }
    for (int q = 0; q < node->n; q++) {
      const struct rad_occluder *other = &o->occluder[all->item[node->first + q]];
      for (int c = 0; c < other->n; c++) {
        double r[3];
        rad_sub(o->scene->vertex[o->corner[other->first + c]], origin, r);
        above |= rad_dot(normal, r) > o->slack;
        below |= rad_dot(normal, r) < -o->slack;
      }
    }
    if (above && below)
      return 1;
  }
  return 0;
}

static int build_bvh(struct rad_occluders *o) {
  struct rad_box *box = rad_alloc((size_t)o->n, sizeof *box);
  int *item = rad_alloc((size_t)o->n, sizeof *item), n = 0;
  struct rad_bvh *all = NULL;
  for (int k = 0; box && item && k < o->n; k++) {
    memcpy(box[k].low, o->occluder[k].low, sizeof box[k].low);
    memcpy(box[k].high, o->occluder[k].high, sizeof box[k].high);
    item[k] = k;
  }
  if (box && item)
    all = rad_bvh_build(o->n, item, box);
  for (int k = 0, cuts = 0; all && k < o->n; k++) {
    if (k == 0 || o->occluder[k].plane != o->occluder[k - 1].plane)
      cuts = cuts_scene(o, all, k);
    if (cuts)
      item[n++] = k;
  }
  if (all)
    o->bvh = rad_bvh_build(n, item, box);
  rad_bvh_free(all);
  free(box);
  free(item);
  return o->bvh ? 0 : -1;
}

/* --- the whole --- */

static void set_tolerances(struct builder *b) {
  double farthest = 0;
  for (int v = 0; v < b->scene->n_vertex; v++)
    for (int d = 0; d < 3; d++)
      farthest = fmax(farthest, fabs(b->scene->vertex[v][d]));
  b->o->rounding = 4 * DBL_EPSILON * farthest;
  b->o->slack = fmax(OVERLAP * b->scene->size, 4 * b->o->rounding);
}

static int build(struct builder *b) {
  struct rad_occluders *o = b->o;
  size_t n_vertex = (size_t)b->scene->n_vertex, n_triangle = (size_t)b->scene->n_triangle;
  set_tolerances(b);
  if (rad_planes_find(b->scene, b->o->rounding, &b->planes))
    return -1;
  o->n_plane = b->planes.n;
  o->plane = b->planes.plane;
  b->planes.plane = NULL;
  b->local = rad_alloc(n_vertex, sizeof *b->local);
  b->point = rad_alloc(n_vertex, sizeof *b->point);
  b->triangle = rad_alloc(n_triangle, sizeof *b->triangle);
  o->in_plane = rad_alloc(3 * n_triangle, sizeof *o->in_plane);
  o->in_plane_first = rad_calloc((size_t)o->n_plane + 1, sizeof *o->in_plane_first);
  o->on_line_first = rad_calloc(1, sizeof *o->on_line_first);
  int failed = !b->local || !b->point || !b->triangle || !o->in_plane || !o->in_plane_first ||
               !o->on_line_first;
  for (int plane = 0; !failed && plane < o->n_plane; plane++)
    failed = add_plane(b, plane);
  return failed || turn_around(o) ? -1 : build_bvh(o);
}

enum rad_code rad_occluders_build(const struct rad_scene *scene, struct rad_occluders *o,
                                  struct rad_error *e) {
  *o = (struct rad_occluders){.scene = scene};
  struct builder b = {.scene = scene, .o = o};
  int failed = build(&b);
  rad_planes_free(&b.planes);
  free(b.local);
  free(b.point);
  free(b.triangle);
  return failed ? rad_fail_memory(e, "what casts shadows", 500.0 * scene->n_triangle) : RAD_OK;
}

void rad_occluders_free(struct rad_occluders *o) {
  free(o->occluder);
  free(o->corner);
  free(o->inward);
  free(o->on_line_first);
  free(o->on_line);
  free(o->plane);
  free(o->in_plane_first);
  free(o->in_plane);
  free(o->plane_of_first);
  free(o->plane_of);
  rad_bvh_free(o->bvh);
  *o = (struct rad_occluders){0};
}

static int is_in(const int *list, int first, int last, int vertex) {
  while (first < last) {
    int middle = first + (last - first) / 2;
    if (list[middle] == vertex)
      return 1;
    if (list[middle] < vertex)
      first = middle + 1;
    else
      last = middle;
  }
  return 0;
}

int rad_on_line(const struct rad_occluders *o, int side, int vertex) {
  return is_in(o->on_line, o->on_line_first[side], o->on_line_first[side + 1], vertex);
}

int rad_in_plane(const struct rad_occluders *o, int plane, int vertex) {
  return is_in(o->in_plane, o->in_plane_first[plane], o->in_plane_first[plane + 1], vertex);
}
