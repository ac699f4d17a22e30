#include "system/groups.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "system/coupling.h"

/* Light between two groups, a < b. */
struct edge {
  int a, b;
  double light, strength;
};

struct graph {
  int n;        /* groups */
  int *size;    /* owned [n] unknowns */
  double *area; /* owned [n] */
  int *of;      /* owned [n_element] group of an element of the tree's order */
  int *next;    /* owned [n] group that a group becomes; -1: not known yet */
  size_t n_edge;
  struct edge *edge; /* owned */
};

static int by_pair(const void *x, const void *y) {
  const struct edge *p = x, *q = y;
  int a = (p->a > q->a) - (p->a < q->a), b = (p->b > q->b) - (p->b < q->b);
  return a ? a : b ? b : (p->light > q->light) - (p->light < q->light);
}

/* The strongest first; equal ones in the order of their groups. */
static int by_strength(const void *x, const void *y) {
  const struct edge *p = x, *q = y;
  if (p->strength != q->strength)
    return p->strength < q->strength ? 1 : -1;
  return by_pair(x, y);
}

/* Edges of one pair become one, those within a group vanish. */
static void merge_edges(struct graph *g) {
  size_t n = 0;
  for (size_t i = 0; i < g->n_edge; i++) {
    struct edge x = g->edge[i];
    if (x.a == x.b)
      continue;
    g->edge[n++] = x.a < x.b ? x : (struct edge){x.b, x.a, x.light, 0};
  }
  if (n)
    qsort(g->edge, n, sizeof *g->edge, by_pair);
  g->n_edge = 0;
  for (size_t i = 0; i < n; i++) {
    struct edge *last = g->n_edge ? &g->edge[g->n_edge - 1] : NULL;
    if (last && last->a == g->edge[i].a && last->b == g->edge[i].b)
      last->light += g->edge[i].light;
    else
      g->edge[g->n_edge++] = g->edge[i];
  }
}

/* Pairs, the strongest first; returns how many. */
static int match(struct graph *g) {
  int pairs = 0;
  for (size_t i = 0; i < g->n_edge; i++)
    g->edge[i].strength = g->edge[i].light / fmin(g->area[g->edge[i].a], g->area[g->edge[i].b]);
  if (g->n_edge)
    qsort(g->edge, g->n_edge, sizeof *g->edge, by_strength);
  for (int i = 0; i < g->n; i++)
    g->next[i] = -1;
  for (size_t i = 0; i < g->n_edge; i++) {
    int a = g->edge[i].a, b = g->edge[i].b;
    if (g->next[a] >= 0 || g->next[b] >= 0 || g->size[a] + g->size[b] > RAD_GROUP)
      continue;
    g->next[a] = g->next[b] = a;
    pairs++;
  }
  return pairs;
}

/* The pairs become groups, in the order of their first members. */
static void join(struct graph *g, int n_element) {
  int n = 0;
  for (int i = 0; i < g->n; i++) {
    int size = g->size[i], is_second = g->next[i] >= 0 && g->next[i] < i;
    double area = g->area[i];
    if (is_second) { /* its first already has its new number */
      int to = g->next[g->next[i]];
      g->next[i] = to;
      g->size[to] += size;
      g->area[to] += area;
      continue;
    }
    g->next[i] = n;
    g->size[n] = size;
    g->area[n++] = area;
  }
  g->n = n;
  for (int i = 0; i < n_element; i++)
    g->of[i] = g->next[g->of[i]];
  for (size_t i = 0; i < g->n_edge; i++) {
    g->edge[i].a = g->next[g->edge[i].a];
    g->edge[i].b = g->next[g->edge[i].b];
  }
  merge_edges(g);
}

/* Each element by itself, and its partners. */
static enum rad_code begin(const struct rad_operator *k, const struct rad_tree *tree,
                           struct graph *g, struct rad_error *e) {
  int n = tree->mesh->n_element;
  size_t room = (size_t)n;
  *g = (struct graph){.n = n,
                      .size = rad_alloc(room, sizeof(int)),
                      .area = rad_alloc(room, sizeof(double)),
                      .of = rad_alloc(room, sizeof(int)),
                      .next = rad_alloc(room, sizeof(int)),
                      .edge = rad_alloc(room * RAD_PARTNERS, sizeof *g->edge)};
  struct rad_partner *partner = rad_alloc(room * RAD_PARTNERS, sizeof *partner);
  int *count = g->next;
  enum rad_code code = RAD_OK;
  if (!g->size || !g->area || !g->of || !g->next || !g->edge || !partner)
    code = rad_fail_memory(e, "the preconditioner", 40.0 * RAD_PARTNERS * n);
  for (int i = 0; i < n && !code; i++) {
    g->size[i] = tree->mesh->element[tree->element[i]].n_function;
    g->area[i] = rad_element_area(tree->mesh, tree->element[i]);
    g->of[i] = i;
  }
  if (!code)
    code = rad_coupling(k, tree, g->area, count, partner, e);
  for (int i = 0; i < n && !code; i++)
    for (int j = 0; j < count[i]; j++) {
      struct rad_partner p = partner[(size_t)i * RAD_PARTNERS + (size_t)j];
      g->edge[g->n_edge++] = (struct edge){i, p.other, p.light, 0};
    }
  free(partner);
  if (!code)
    merge_edges(g);
  return code;
}

/* The unknowns, group by group; size becomes the place of a group's next one. */
static enum rad_code list_unknowns(const struct rad_tree *tree, struct graph *g,
                                   struct rad_groups *groups, struct rad_error *e) {
  size_t n = (size_t)tree->mesh->n_point;
  groups->n = g->n;
  groups->first = rad_alloc((size_t)g->n + 1, sizeof(int));
  groups->unknown = rad_alloc(n, sizeof(int));
  groups->place = rad_alloc(n, sizeof(int));
  if (!groups->first || !groups->unknown || !groups->place)
    return rad_fail_memory(e, "the preconditioner", 8.0 * (double)n);
  groups->first[0] = 0;
  for (int i = 0; i < g->n; i++) {
    groups->first[i + 1] = groups->first[i] + g->size[i];
    groups->most = g->size[i] > groups->most ? g->size[i] : groups->most;
    g->size[i] = groups->first[i];
  }
  for (int i = 0, place = 0; i < tree->mesh->n_element; i++)
    for (int f = tree->mesh->element[tree->element[i]].n_function; f > 0; f--, place++) {
      int at = g->size[g->of[i]]++;
      groups->unknown[at] = tree->unknown[place];
      groups->place[at] = place;
    }
  return RAD_OK;
}

enum rad_code rad_groups_build(const struct rad_operator *k, const struct rad_tree *tree,
                               struct rad_groups *groups, struct rad_error *e) {
  struct graph g;
  *groups = (struct rad_groups){0};
  enum rad_code code = begin(k, tree, &g, e);
  while (!code && match(&g))
    join(&g, tree->mesh->n_element);
  if (!code)
    code = list_unknowns(tree, &g, groups, e);
  free(g.size);
  free(g.area);
  free(g.of);
  free(g.next);
  free(g.edge);
  return code;
}

void rad_groups_free(struct rad_groups *groups) {
  free(groups->first);
  free(groups->unknown);
  free(groups->place);
  *groups = (struct rad_groups){0};
}
