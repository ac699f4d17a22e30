#include "visibility/partition.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/union_find.h"

enum { FEW = 10 }; /* triangles around a point that is taken away early */

/* Points on an edge between its ends: a linked list by struct mesh.link. */
struct chain {
  int head, tail; /* -1: none */
};

/* Loops of directed edges; each has its polygon on the left. */
struct mesh {
  const double (*point)[2];
  double rounding;
  int n_point, n_edge, n_crowded;
  int *origin, *next, *prev; /* [n_edge]; origin -1: not in use */
  int *twin;                 /* [n_edge] the same edge backwards, or -1 */
  struct chain *chain;       /* [n_edge] */
  char *corner;              /* [n_edge] whether its polygon has a corner at its origin */
  int *out;                  /* [n_point] an edge that starts there, or -1 */
  int *n_around;             /* [n_point] triangles with this corner */
  char *kept;                /* [n_point] never to be taken away */
  int *link;                 /* [n_point] next point of the chain it is in, or -1 */
  int *ints;                 /* owned: all arrays of int */
  char *chars;               /* owned: all arrays of char */
};

/* What surrounds a point, counterclockwise, and how it is cut without the point. */
struct star {
  int n;          /* triangles, of which the point is a corner */
  int open;       /* the point is on the outline */
  int n_ring;     /* points of the polygon that the triangles make without this one */
  int *spoke;     /* [n] edge from the point to ring point m */
  int *ring;      /* [n_ring] */
  int *side;      /* [n_ring] edge from ring point m to the next */
  int *at;        /* [n_ring] places in the ring that are not cut off yet */
  int *ear;       /* [n_ring - 3] places in `at` to cut off, in order */
  int *unused;    /* [2 n] edges that the new triangles take over */
  int through[2]; /* ring places whose diagonal passes through the point, or -1 */
  int room;       /* for n */
  int *ints;      /* owned: all arrays */
};

/* --- geometry --- */

/* Twice the area of a, b, c. */
static double twice_area(const struct mesh *m, int a, int b, int c) {
  const double *p = m->point[a], *q = m->point[b], *r = m->point[c];
  return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
}

static double length(const struct mesh *m, int a, int b) {
  double dx = m->point[b][0] - m->point[a][0], dy = m->point[b][1] - m->point[a][1];
  return sqrt(dx * dx + dy * dy);
}

/* True if a, b, c turn left by more than rounding. */
static int left_turn(const struct mesh *m, int a, int b, int c) {
  double longest = fmax(length(m, a, b), fmax(length(m, b, c), length(m, c, a)));
  return twice_area(m, a, b, c) > m->rounding * longest;
}

/* True if b lies between a and c on a line, within rounding. */
static int straight(const struct mesh *m, int a, int b, int c) {
  const double *p = m->point[a], *q = m->point[b], *r = m->point[c];
  double forward = (q[0] - p[0]) * (r[0] - q[0]) + (q[1] - p[1]) * (r[1] - q[1]);
  return forward > 0 && fabs(twice_area(m, a, b, c)) <= m->rounding * length(m, a, c);
}

/* --- the mesh of triangles --- */

struct sorted_edge {
  int low, high, edge;
};

static int compare_edges(const void *a, const void *b) {
  const struct sorted_edge *p = a, *q = b;
  if (p->low != q->low)
    return p->low < q->low ? -1 : 1;
  if (p->high != q->high)
    return p->high < q->high ? -1 : 1;
  return (p->edge > q->edge) - (p->edge < q->edge);
}

/* Join edges that have just one triangle on either side; the ends of crowded ones are kept. */
static int join_edges(struct mesh *m) {
  struct sorted_edge *s = rad_alloc((size_t)m->n_edge, sizeof *s);
  if (!s)
    return -1;
  for (int h = 0; h < m->n_edge; h++) {
    int a = m->origin[h], b = m->origin[m->next[h]];
    s[h] = (struct sorted_edge){a < b ? a : b, a < b ? b : a, h};
  }
  qsort(s, (size_t)m->n_edge, sizeof *s, compare_edges);
  for (int k = 0, end; k < m->n_edge; k = end) {
    for (end = k + 1; end < m->n_edge && s[end].low == s[k].low && s[end].high == s[k].high;)
      end++;
    int h = s[k].edge, g = s[end - 1].edge;
    if (end - k == 2 && m->origin[h] != m->origin[g]) {
      m->twin[h] = g;
      m->twin[g] = h;
    } else if (end - k > 1) {
      m->kept[s[k].low] = m->kept[s[k].high] = 1;
      m->n_crowded++;
    }
  }
  free(s);
  return 0;
}

static int make_mesh(struct mesh *m, int n_triangle, const int (*triangle)[3]) {
  int n = m->n_edge = 3 * n_triangle;
  size_t n_edge = (size_t)n, n_point = (size_t)m->n_point;
  m->ints = rad_alloc(4 * n_edge + 3 * n_point, sizeof *m->ints);
  m->chars = rad_calloc(n_edge + n_point, 1);
  m->chain = rad_alloc(n_edge, sizeof *m->chain);
  if (!m->ints || !m->chars || !m->chain)
    return -1;
  memset(m->ints, -1, (4 * n_edge + 3 * n_point) * sizeof *m->ints);
  memset(m->chain, -1, n_edge * sizeof *m->chain);
  m->origin = m->ints;
  m->next = m->origin + n;
  m->prev = m->next + n;
  m->twin = m->prev + n;
  m->out = m->twin + n;
  m->n_around = m->out + m->n_point;
  m->link = m->n_around + m->n_point;
  m->corner = m->chars;
  m->kept = m->corner + n;
  memset(m->n_around, 0, n_point * sizeof *m->n_around);
  for (int h = 0; h < n; h++) {
    int p = m->origin[h] = triangle[h / 3][h % 3];
    m->next[h] = h % 3 == 2 ? h - 2 : h + 1;
    m->prev[h] = h % 3 == 0 ? h + 2 : h - 1;
    m->corner[h] = 1;
    m->out[p] = h;
    m->n_around[p]++;
  }
  return join_edges(m);
}

static void free_mesh(struct mesh *m) {
  free(m->ints);
  free(m->chars);
  free(m->chain);
}

static struct chain join_chains(struct mesh *m, struct chain a, struct chain b) {
  if (a.head < 0 || b.head < 0)
    return a.head < 0 ? b : a;
  m->link[a.tail] = b.head;
  return (struct chain){a.head, b.tail};
}

/* Chain a, point p, chain b. */
static struct chain join_at(struct mesh *m, struct chain a, int p, struct chain b) {
  m->link[p] = -1;
  return join_chains(m, join_chains(m, a, (struct chain){p, p}), b);
}

/* --- points are taken away --- */

static int make_room(struct star *s, int n) {
  if (n <= s->room)
    return 0;
  free(s->ints);
  s->room = 2 * n;
  size_t room = (size_t)s->room + 1;
  s->ints = rad_alloc(7 * room, sizeof *s->ints);
  s->spoke = s->ints;
  if (!s->ints)
    return -1;
  s->ring = s->spoke + room;
  s->side = s->ring + room;
  s->at = s->side + room;
  s->ear = s->at + room;
  s->unused = s->ear + room;
  return 0;
}

/* Gather what is around p. False if p is to stay: a corner of the outline, or not a single fan that
 * turns once around. */
static int gather(const struct mesh *m, int p, struct star *s) {
  int h = m->out[p], start = h;
  while (m->twin[h] >= 0 && m->next[m->twin[h]] != start)
    h = m->next[m->twin[h]]; /* clockwise, to the outline if there is one */
  s->open = m->twin[h] < 0;
  int up_before = -1, n_up = 0, n_down = 0;
  for (s->n = 0; s->n < m->n_around[p]; h = m->twin[m->prev[h]]) {
    int a = m->origin[m->next[h]], b = m->origin[m->prev[h]];
    if (!(twice_area(m, p, a, b) > 0))
      return 0;
    double x = m->point[b][0] - m->point[p][0], y = m->point[b][1] - m->point[p][1];
    int up = y > 0 || (y == 0 && x > 0);
    n_up += up_before == 0 && up;
    n_down += up_before == 1 && !up;
    up_before = up;
    s->ring[s->n] = a;
    s->side[s->n] = m->next[h];
    s->spoke[s->n++] = h;
    if (m->twin[m->prev[h]] < 0 || m->twin[m->prev[h]] == s->spoke[0])
      break;
  }
  if (s->n != m->n_around[p] || n_up > 1 || n_down > 1)
    return 0;
  s->n_ring = s->n;
  if (!s->open)
    return s->n >= 3;
  s->side[s->n] = -1; /* the new part of the outline */
  s->ring[s->n_ring++] = m->origin[m->prev[s->spoke[s->n - 1]]];
  return s->n >= 2 && straight(m, s->ring[s->n], p, s->ring[0]);
}

/* Cut the ring into triangles by ears; it is star-shaped about p. An ear a, b, c with p not beyond
 * the diagonal a c holds no other point of the ring, because nothing but b is in the wedge a p c;
 * and of the two ears that every polygon has one is such. False if rounding leaves none. */
static int plan_ears(const struct mesh *m, int p, struct star *s) {
  int n = s->n_ring, n_ear = 0;
  s->through[0] = s->through[1] = -1;
  for (int k = 0; k < n; k++)
    s->at[k] = k;
  for (int k = 0, n_tried = 0; n > 3; k = (k + 1) % n) {
    int ia = s->at[k], ib = s->at[(k + 1) % n], ic = s->at[(k + 2) % n];
    int a = s->ring[ia], b = s->ring[ib], c = s->ring[ic];
    double across = twice_area(m, p, a, c), zero = m->rounding * length(m, a, c);
    if (n_tried++ >= n)
      return 0;
    if (across < -zero || !left_turn(m, a, b, c))
      continue;
    if (across <= zero && !s->open && straight(m, a, p, c)) {
      s->through[0] = ia;
      s->through[1] = ic;
    }
    int cut = (k + 1) % n;
    s->ear[n_ear++] = cut;
    n--;
    memmove(s->at + cut, s->at + cut + 1, (size_t)(n - cut) * sizeof *s->at);
    k -= cut == 0; /* a is where it was, or one to the left */
    n_tried = 0;
  }
  return left_turn(m, s->ring[s->at[0]], s->ring[s->at[1]], s->ring[s->at[2]]);
}

static void make_triangle(struct mesh *m, int e, int f, int g) {
  int edge[3] = {e, f, g};
  for (int k = 0; k < 3; k++) {
    m->next[edge[k]] = edge[(k + 1) % 3];
    m->prev[edge[k]] = edge[(k + 2) % 3];
    m->out[m->origin[edge[k]]] = edge[k];
    m->n_around[m->origin[edge[k]]]++;
  }
}

/* Undo the triangles around p; their edges at p become unused. */
static void open_star(struct mesh *m, int p, struct star *s) {
  for (int k = 0; k < s->n; k++) {
    int out = s->spoke[k], in = m->prev[out];
    s->unused[2 * k] = out;
    s->unused[2 * k + 1] = in;
    m->n_around[m->origin[s->side[k]]]--;
    m->n_around[m->origin[in]]--;
    m->origin[out] = m->origin[in] = -1;
  }
  m->out[p] = -1;
}

static int take_edge(struct mesh *m, struct star *s, int *n_taken, int from) {
  int h = s->unused[(*n_taken)++];
  m->origin[h] = from;
  m->twin[h] = -1;
  m->chain[h] = (struct chain){-1, -1};
  return h;
}

/* Replace the triangles around p by those that were planned. */
static void take_away(struct mesh *m, int p, struct star *s) {
  struct chain line = {-1, -1}; /* of the edge that p is on, if any */
  if (s->open)
    line = join_at(m, m->chain[s->spoke[0]], p, m->chain[m->prev[s->spoke[s->n - 1]]]);
  else if (s->through[0] >= 0)
    line = join_at(m, m->chain[s->spoke[s->through[0]]], p, m->chain[s->spoke[s->through[1]]]);
  open_star(m, p, s);
  int n_taken = 0, n = s->n_ring;
  for (int k = 0; k < n; k++)
    s->at[k] = k;
  if (s->open) {
    s->side[n - 1] = take_edge(m, s, &n_taken, s->ring[n - 1]);
    m->chain[s->side[n - 1]] = line;
  }
  for (int k = 0; n > 3; k++) {
    int b = s->ear[k], a = (b + n - 1) % n, c = (b + 1) % n;
    int ia = s->at[a], ib = s->at[b], ic = s->at[c];
    int in = take_edge(m, s, &n_taken, s->ring[ic]), on = take_edge(m, s, &n_taken, s->ring[ia]);
    m->twin[in] = on;
    m->twin[on] = in;
    if (ia == s->through[0] && ic == s->through[1])
      m->chain[in] = m->chain[on] = line;
    make_triangle(m, s->side[ia], s->side[ib], in);
    s->side[ia] = on;
    n--;
    memmove(s->at + b, s->at + b + 1, (size_t)(n - b) * sizeof *s->at);
  }
  make_triangle(m, s->side[s->at[0]], s->side[s->at[1]], s->side[s->at[2]]);
}

/* Points with few triangles first: taking one away loads its neighbours. At least a constant part
 * of the points that can go has few, so that the rounds' cost adds up to n. */
static int take_points_away(struct mesh *m) {
  struct star s = {0};
  int n_left = m->n_point, few = FEW, done = 0;
  while (!done) {
    int n_gone = 0, most = 0;
    for (int p = 0; p < m->n_point; p++) {
      if (m->out[p] < 0 || m->kept[p])
        continue;
      most = m->n_around[p] > most ? m->n_around[p] : most;
      if (m->n_around[p] > few)
        continue;
      if (make_room(&s, m->n_around[p])) {
        free(s.ints);
        return -1;
      }
      if (gather(m, p, &s) && plan_ears(m, p, &s)) {
        take_away(m, p, &s);
        n_gone++;
      }
    }
    done = !n_gone && few >= most;
    n_left -= n_gone;
    if (8 * n_gone < n_left && few < most)
      few *= 2;
  }
  free(s.ints);
  return 0;
}

/* --- triangles are merged --- */

struct diagonal {
  double length;
  int edge;
};

static int compare_diagonals(const void *a, const void *b) {
  const struct diagonal *p = a, *q = b;
  if (p->length != q->length)
    return p->length > q->length ? -1 : 1;
  return (p->edge > q->edge) - (p->edge < q->edge);
}

/* What a, b, c make of b: 0 a straight line, 1 a convex corner, -1 a reflex one or a spike. */
static int kind_of_corner(const struct mesh *m, int a, int b, int c) {
  if (straight(m, a, b, c))
    return 0;
  return a != c && twice_area(m, a, b, c) > m->rounding * length(m, a, c) ? 1 : -1;
}

/* Remove edge h between two polygons if one convex polygon with few corners results. */
static void merge_over(struct mesh *m, int h, int n_most, int *parent, int *n_corner) {
  int g = m->twin[h], root = rad_find_root(parent, h), other = rad_find_root(parent, g);
  if (root == other)
    return;
  int before_h = m->prev[h], before_g = m->prev[g], after_h = m->next[h], after_g = m->next[g];
  int a = m->origin[h], b = m->origin[g];
  int at_a = kind_of_corner(m, m->origin[before_h], a, m->origin[m->next[after_g]]);
  int at_b = kind_of_corner(m, m->origin[before_g], b, m->origin[m->next[after_h]]);
  int n = n_corner[root] + n_corner[other] - m->corner[h] - m->corner[g] - m->corner[after_h] -
          m->corner[after_g] + at_a + at_b;
  if (at_a < 0 || at_b < 0 || n > n_most)
    return;
  m->next[before_h] = after_g;
  m->prev[after_g] = before_h;
  m->next[before_g] = after_h;
  m->prev[after_h] = before_g;
  m->corner[after_g] = (char)at_a;
  m->corner[after_h] = (char)at_b;
  m->origin[h] = m->origin[g] = -1;
  parent[other] = root;
  n_corner[root] = n;
}

static int merge_triangles(struct mesh *m, int n_most) {
  int *parent = rad_alloc((size_t)m->n_edge, sizeof *parent);
  int *n_corner = rad_alloc((size_t)m->n_edge, sizeof *n_corner);
  struct diagonal *d = rad_alloc((size_t)m->n_edge, sizeof *d);
  int n = 0, failed = !parent || !n_corner || !d;
  for (int h = 0; !failed && h < m->n_edge; h++)
    if (m->origin[h] >= 0) {
      int next = m->next[h], prev = m->prev[h];
      parent[h] = h < next ? (h < prev ? h : prev) : (next < prev ? next : prev);
      n_corner[h] = 3;
      if (h < m->twin[h])
        d[n++] = (struct diagonal){length(m, m->origin[h], m->origin[next]), h};
    }
  if (!failed)
    qsort(d, (size_t)n, sizeof *d, compare_diagonals);
  for (int k = 0; !failed && k < n; k++)
    merge_over(m, d[k].edge, n_most, parent, n_corner);
  free(parent);
  free(n_corner);
  free(d);
  return failed ? -1 : 0;
}

/* --- the result --- */

/* Write the polygon of an edge, whose edges are then not in use any more. */
static void write_polygon(struct mesh *m, int h, struct rad_partition *p) {
  int n_corner = p->first[p->n], n_line = p->line_first[n_corner];
  while (!m->corner[h])
    h = m->next[h];
  for (; m->origin[h] >= 0; h = m->next[h]) {
    if (m->corner[h])
      p->corner[n_corner++] = m->origin[h];
    else
      p->line[n_line++] = m->origin[h];
    for (int q = m->chain[h].head; q >= 0; q = q == m->chain[h].tail ? -1 : m->link[q])
      p->line[n_line++] = q;
    p->line_first[n_corner] = n_line;
    m->origin[h] = -1;
  }
  p->first[++p->n] = n_corner;
}

static int write_polygons(struct mesh *m, struct rad_partition *p) {
  size_t n = (size_t)m->n_edge;
  p->first = rad_calloc(n + 1, sizeof *p->first);
  p->corner = rad_alloc(n, sizeof *p->corner);
  p->line_first = rad_calloc(n + 1, sizeof *p->line_first);
  p->line = rad_alloc(n + 2 * (size_t)m->n_point, sizeof *p->line);
  if (!p->first || !p->corner || !p->line_first || !p->line)
    return -1;
  for (int h = 0; h < m->n_edge; h++)
    if (m->origin[h] >= 0)
      write_polygon(m, h, p);
  return 0;
}

int rad_partition_make(int n_point, const double (*point)[2], int n_triangle,
                       const int (*triangle)[3], double rounding, int n_most,
                       struct rad_partition *p) {
  struct mesh m = {.point = point, .rounding = rounding, .n_point = n_point};
  *p = (struct rad_partition){0};
  int failed = make_mesh(&m, n_triangle, triangle) || take_points_away(&m) ||
               merge_triangles(&m, n_most) || write_polygons(&m, p);
  p->n_crowded = m.n_crowded;
  free_mesh(&m);
  return failed ? -1 : 0;
}

void rad_partition_free(struct rad_partition *p) {
  free(p->first);
  free(p->corner);
  free(p->line_first);
  free(p->line);
  *p = (struct rad_partition){0};
}
