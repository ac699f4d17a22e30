#include "scene/enclosure.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/scramble.h"
#include "base/union_find.h"
#include "base/vec.h"
#include "scene/contact.h"
#include "scene/edge.h"
#include "scene/shell.h"

#define ASIDE 1e-10      /* of the scene's size: nearer vertices are one */
#define ROUNDING 64      /* of coordinates, in units of the last place */
#define FROM_VERTEX 1e-4 /* weights of the other vertices, beside a vertex */

/* The three vertices of a triangle in order. */
struct corners {
  int v[3], triangle;
};

struct search {
  const struct rad_scene *scene;
  int n_piece;
  int *piece;                  /* owned [n_triangle] joined over sides that just two have */
  struct rad_shells wall;      /* closed pieces; pieces that are not, by common vertices */
  double (*box)[2][3];         /* owned [wall.n] lowest and highest coordinates */
  unsigned char *meets;        /* owned [n_triangle] it touches one of another wall */
  unsigned char *has_back;     /* owned [n_triangle] no other triangle is its back */
  uint64_t *in_front, *behind; /* owned [n_piece] see regions_of */
  int *largest;                /* owned [n_piece] triangle */
  double aside;                /* [m] */
};

/* ---- pieces ---- */

static int is_turned(const struct rad_triangle *t) {
  double u[3], v[3], normal[3];
  rad_sub(t->v[1], t->v[0], u);
  rad_sub(t->v[2], t->v[0], v);
  rad_cross(u, v, normal);
  return rad_dot(normal, t->normal) < 0;
}

/* Edges numbered 3 t + c. */
static void list_edges(const struct rad_scene *s, struct rad_edge *edge) {
  for (int i = 0; i < 3 * s->n_triangle; i++) {
    const int *vertex = s->triangle[i / 3].vertex;
    edge[i] = rad_edge_of(vertex[i % 3], vertex[(i % 3 + 1) % 3], i);
  }
}

/* True if an edge runs from its vertex `high` to `low`, counterclockwise as seen from where its
 * triangle radiates. */
static int runs_down(const struct rad_scene *s, const struct rad_edge *edge) {
  const struct rad_triangle *t = &s->triangle[edge->number / 3];
  return (t->vertex[edge->number % 3] == edge->high) != is_turned(t);
}

/* Pieces by first triangles; their number. Where more than two meet, each may be an end. */
static int join(const struct rad_scene *s, struct rad_edge *edge, int *parent, int *piece) {
  int n = 0, n_edge = 3 * s->n_triangle;
  list_edges(s, edge);
  rad_edges_sort(n_edge, edge);
  for (int t = 0; t < s->n_triangle; t++)
    parent[t] = t;
  for (int first = 0, last; first < n_edge; first = last) {
    last = rad_edges_end(n_edge, edge, first);
    if (last - first == 2 && runs_down(s, &edge[first]) != runs_down(s, &edge[first + 1]))
      rad_unite(parent, edge[first].number / 3, edge[first + 1].number / 3);
  }
  for (int t = 0; t < s->n_triangle; t++)
    piece[t] = rad_find_root(parent, t) == t ? n++ : piece[rad_find_root(parent, t)];
  return n;
}

/* Each piece that is closed is a wall; the others are taken together where they have vertices in
 * common, for the sides of one may be parts of another's. */
static enum rad_code find_walls(struct search *q, struct rad_error *e) {
  const struct rad_scene *s = q->scene;
  struct rad_shells piece = {.n = q->n_piece, .shell = q->piece}, common = {0};
  enum rad_code code = rad_shells_measure(s, &piece, e);
  if (!code)
    code = rad_shells_find(s, &common, e);
  if (!code && !(q->wall.shell = rad_alloc((size_t)s->n_triangle, sizeof(int))))
    code = rad_fail_memory(e, "the search for enclosures", 4.0 * s->n_triangle);
  q->wall.n = piece.n + common.n;
  for (int t = 0; t < s->n_triangle && !code; t++)
    q->wall.shell[t] = piece.closed[q->piece[t]] ? q->piece[t] : piece.n + common.shell[t];
  piece.shell = NULL;
  rad_shells_free(&piece);
  rad_shells_free(&common);
  return code ? code : rad_shells_measure(s, &q->wall, e);
}

/* ---- what meets ---- */

/* A wall that something goes through divides it: what is inside at one point is not elsewhere. */
static void take_contact(void *context, int low, int high, enum rad_contact kind) {
  struct search *q = context;
  const int *wall = q->wall.shell;
  if (kind == RAD_CROSSING)
    q->wall.closed[wall[low]] = q->wall.closed[wall[high]] = 0;
  else if (wall[low] != wall[high])
    q->meets[low] = q->meets[high] = 1;
}

static enum rad_code find_contacts(struct search *q, struct rad_error *e) {
  int *number = rad_alloc((size_t)q->scene->n_triangle, sizeof *number);
  if (!number)
    return rad_fail_memory(e, "the search for enclosures", 4.0 * q->scene->n_triangle);
  for (int t = 0; t < q->scene->n_triangle; t++)
    number[t] = t;
  enum rad_code code = rad_find_contacts(q->scene, number, take_contact, q, e);
  free(number);
  return code;
}

static int compare_corners(const void *a, const void *b) {
  return memcmp(((const struct corners *)a)->v, ((const struct corners *)b)->v,
                sizeof((const struct corners *)a)->v);
}

static void sort_three(int v[3]) {
  for (int k = 0; k < 3; k++) {
    int a = k % 2, low = v[a] < v[a + 1] ? v[a] : v[a + 1];
    v[a + 1] += v[a] - low;
    v[a] = low;
  }
}

static enum rad_code find_backs(struct search *q, struct rad_error *e) {
  int n = q->scene->n_triangle;
  struct corners *c = rad_alloc((size_t)n, sizeof *c);
  if (!c)
    return rad_fail_memory(e, "the search for enclosures", 16.0 * n);
  for (int t = 0; t < n; t++) {
    memcpy(c[t].v, q->scene->triangle[t].vertex, sizeof c[t].v);
    sort_three(c[t].v);
    c[t].triangle = t;
  }
  qsort(c, (size_t)n, sizeof *c, compare_corners);
  memset(q->has_back, 1, (size_t)n);
  for (int k = 0; k + 1 < n; k++)
    if (!compare_corners(&c[k], &c[k + 1]))
      q->has_back[c[k].triangle] = q->has_back[c[k + 1].triangle] = 0;
  free(c);
  return RAD_OK;
}

/* ---- where a point is ---- */

/* Signed solid angle of a triangle seen from x (van Oosterom and Strackee), by its normal. */
static double solid_angle(const struct rad_triangle *t, const double x[3]) {
  double a[3], b[3], c[3], turn[3];
  rad_sub(t->v[0], x, a);
  rad_sub(t->v[1], x, b);
  rad_sub(t->v[2], x, c);
  rad_cross(b, c, turn);
  double la = rad_norm(a), lb = rad_norm(b), lc = rad_norm(c);
  double omega = 2 * atan2(rad_dot(a, turn), la * lb * lc + rad_dot(a, b) * lc +
                                                 rad_dot(a, c) * lb + rad_dot(b, c) * la);
  return is_turned(t) ? -omega : omega;
}

static void set_boxes(struct search *q) {
  for (int w = 0; w < q->wall.n; w++)
    for (int d = 0; d < 3; d++) {
      q->box[w][0][d] = INFINITY;
      q->box[w][1][d] = -INFINITY;
    }
  for (int t = 0; t < q->scene->n_triangle; t++)
    for (int m = 0; m < 9; m++) {
      double *low = q->box[q->wall.shell[t]][0], *high = q->box[q->wall.shell[t]][1];
      low[m % 3] = fmin(low[m % 3], q->scene->triangle[t].v[m / 3][m % 3]);
      high[m % 3] = fmax(high[m % 3], q->scene->triangle[t].v[m / 3][m % 3]);
    }
}

static int is_in_box(const double box[2][3], const double x[3]) {
  for (int d = 0; d < 3; d++)
    if (!(x[d] >= box[0][d] && x[d] <= box[1][d]))
      return 0;
  return 1;
}

/* Which walls are wound round x, as a number: the same where no wall is between. 0: none. */
static uint64_t regions_of(const struct search *q, const double x[3], double *omega) {
  uint64_t regions = 0;
  const int *wall = q->wall.shell;
  for (int w = 0; w < q->wall.n; w++)
    omega[w] = q->wall.closed[w] && is_in_box(q->box[w], x) ? 0 : NAN;
  for (int t = 0; t < q->scene->n_triangle; t++)
    if (!isnan(omega[wall[t]]))
      omega[wall[t]] += solid_angle(&q->scene->triangle[t], x);
  for (int w = 0; w < q->wall.n; w++)
    if (fabs(omega[w]) > 3 * M_PI) /* a multiple of 4 pi, but on the wall itself */
      regions ^= rad_scramble((uint64_t)w);
  return regions;
}

/* The same beside a point of a triangle, before it or behind it. */
static uint64_t regions_beside(const struct search *q, int triangle, const double weight[3],
                               double aside, double *omega) {
  const struct rad_triangle *t = &q->scene->triangle[triangle];
  double x[3];
  for (int d = 0; d < 3; d++)
    x[d] = weight[0] * t->v[0][d] + weight[1] * t->v[1][d] + weight[2] * t->v[2][d] +
           aside * t->normal[d];
  return regions_of(q, x, omega);
}

/* True if all corners of a triangle are where its piece is. */
static int is_with_piece(const struct search *q, int triangle, double *omega) {
  for (int c = 0; c < 3; c++) {
    double weight[3] = {FROM_VERTEX, FROM_VERTEX, FROM_VERTEX};
    weight[c] = 1 - 2 * FROM_VERTEX;
    if (regions_beside(q, triangle, weight, q->aside, omega) != q->in_front[q->piece[triangle]])
      return 0;
  }
  return 1;
}

/* ---- the answer ---- */

static void find_largest(struct search *q) {
  const struct rad_triangle *t = q->scene->triangle;
  for (int p = 0; p < q->n_piece; p++)
    q->largest[p] = -1;
  for (int i = 0; i < q->scene->n_triangle; i++) {
    int *largest = &q->largest[q->piece[i]];
    if (*largest < 0 || t[i].area > t[*largest].area)
      *largest = i;
  }
}

/* Pieces lie on one side of a wall, as nothing goes through it; but one that touches it may have
 * parts on both. */
static int is_closed(struct search *q, double *omega) {
  static const double inside[3] = {0.413, 0.329, 0.258}; /* no place where things tend to meet */
  for (int p = 0; p < q->n_piece; p++) {
    q->in_front[p] = regions_beside(q, q->largest[p], inside, q->aside, omega);
    if (!q->in_front[p])
      return 0;
    q->behind[p] = regions_beside(q, q->largest[p], inside, -q->aside, omega);
  }
  for (int t = 0; t < q->scene->n_triangle; t++)
    if (q->meets[t] && !is_with_piece(q, t, omega))
      return 0;
  return 1;
}

static int compare_numbers(const void *a, const void *b) {
  const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
  return (x > y) - (x < y);
}

/* True if no face looks into a region that backs look into. */
static int hides_backs(struct search *q) {
  qsort(q->in_front, (size_t)q->n_piece, sizeof *q->in_front, compare_numbers);
  for (int t = 0; t < q->scene->n_triangle; t++)
    if (q->has_back[t] && bsearch(&q->behind[q->piece[t]], q->in_front, (size_t)q->n_piece,
                                  sizeof *q->in_front, compare_numbers))
      return 0;
  return 1;
}

static enum rad_code begin(struct search *q, struct rad_error *e) {
  const struct rad_scene *s = q->scene;
  size_t n = (size_t)s->n_triangle;
  struct rad_edge *edge = rad_alloc(3 * n, sizeof *edge);
  int *parent = rad_alloc(n, sizeof *parent);
  double farthest = 0;
  for (int k = 0; k < 3 * s->n_vertex; k++)
    farthest = fmax(farthest, fabs(s->vertex[k / 3][k % 3]));
  q->aside = fmax(ASIDE * s->size, ROUNDING * DBL_EPSILON * farthest);
  q->piece = rad_alloc(n, sizeof *q->piece);
  q->meets = rad_calloc(n, 1);
  q->has_back = rad_alloc(n, 1);
  q->in_front = rad_alloc(n, sizeof *q->in_front);
  q->behind = rad_alloc(n, sizeof *q->behind);
  q->largest = rad_alloc(n, sizeof *q->largest);
  int made = edge && parent && q->piece && q->meets && q->has_back && q->in_front && q->behind &&
             q->largest;
  if (made)
    q->n_piece = join(s, edge, parent, q->piece);
  free(edge);
  free(parent);
  return made ? RAD_OK : rad_fail_memory(e, "the search for enclosures", 80.0 * (double)n);
}

/* With walls: what they hold. */
static enum rad_code look(struct search *q, struct rad_enclosure *x, struct rad_error *e) {
  double *omega = rad_alloc((size_t)q->wall.n, sizeof *omega);
  q->box = rad_alloc((size_t)q->wall.n, sizeof *q->box);
  enum rad_code code = omega && q->box
                           ? find_contacts(q, e)
                           : rad_fail_memory(e, "the search for enclosures", 56.0 * q->wall.n);
  if (!code)
    code = find_backs(q, e);
  if (!code) {
    set_boxes(q);
    find_largest(q);
    x->is_closed = is_closed(q, omega);
    x->hides_backs = x->is_closed && hides_backs(q);
  }
  free(omega);
  return code;
}

enum rad_code rad_find_enclosure(const struct rad_scene *scene, struct rad_enclosure *x,
                                 struct rad_error *e) {
  struct search q = {.scene = scene};
  *x = (struct rad_enclosure){0};
  enum rad_code code = begin(&q, e);
  if (!code)
    code = find_walls(&q, e);
  if (!code && memchr(q.wall.closed, 1, (size_t)q.wall.n))
    code = look(&q, x, e);
  rad_shells_free(&q.wall);
  free(q.box);
  free(q.piece);
  free(q.meets);
  free(q.has_back);
  free(q.in_front);
  free(q.behind);
  free(q.largest);
  return code;
}
