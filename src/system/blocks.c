#include "system/blocks.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/stop.h"
#include "base/vec.h"
#include "system/sector.h"
#include "visibility/facing.h"
#include "visibility/part_sight.h"
#include "visibility/visibility.h"

/* Least distance of far clusters, over the larger diameter. */
#define APART 0.7

struct entry {
  int target, source;
};

enum kind { FAR, NEAR, SECTOR, N_KIND };

/* A growing list of blocks. */
struct bag {
  size_t n, room;
  struct entry *entry; /* owned */
};

/* The division of the rows of one triangle. */
struct division {
  const struct rad_tree *tree;
  int places; /* on a line of a sector */
  double least;
  int across[2]; /* of the present pair: the target's plane cuts the source; and vice versa */
  struct bag bag[N_KIND];
  int failed;
};

static void put(struct division *d, enum kind kind, int target, int source) {
  struct bag *bag = &d->bag[kind];
  if (bag->n == bag->room) {
    size_t room = bag->room ? 2 * bag->room : 64;
    struct entry *grown = realloc(bag->entry, room * sizeof *grown);
    if (!grown) {
      d->failed = 1;
      return;
    }
    bag->entry = grown;
    bag->room = room;
  }
  bag->entry[bag->n++] = (struct entry){target, source};
}

/* The part of a cluster in front of the plane of another triangle, in space; *cut: not all is. */
static void front_part(const struct rad_tree *tree, int cluster, int other, int across,
                       struct rad_part *part, int *cut) {
  const struct rad_plane *own = &tree->plane[tree->cluster[cluster].triangle];
  const struct rad_plane *plane = &tree->plane[other];
  struct rad_polygon polygon;
  rad_cluster_polygon(tree, cluster, &polygon);
  *cut = 0;
  if (across) {
    double r[3], slope[2];
    rad_sub(own->origin, plane->origin, r);
    double height = rad_dot(r, plane->axis[2]);
    for (int d = 0; d < 2; d++)
      slope[d] = rad_dot(own->axis[d], plane->axis[2]);
    for (int c = 0; c < polygon.n; c++)
      *cut |= height + slope[0] * polygon.corner[c][0] + slope[1] * polygon.corner[c][1] < 0;
    rad_clip(&polygon, height, slope[0], slope[1]);
  }
  part->n = polygon.n < RAD_MAX_PART_CORNER ? polygon.n : RAD_MAX_PART_CORNER;
  for (int c = 0; c < part->n; c++)
    for (int d = 0; d < 3; d++)
      part->corner[c][d] = own->origin[d] + polygon.corner[c][0] * own->axis[0][d] +
                           polygon.corner[c][1] * own->axis[1][d];
}

/* What two clusters see of each other. *cut: a horizon passes through one of them. The occluders in
 * list [*n] are thinned. */
static enum rad_sight sight_of(const struct division *d, int target, int source, int *list, int *n,
                               int *cut) {
  const struct rad_tree *tree = d->tree;
  *cut = 0;
  if (!d->across[0] && !d->across[1] && !*n)
    return RAD_FREE;
  struct rad_part p, q;
  int cut_target, cut_source;
  front_part(tree, target, tree->cluster[source].triangle, d->across[1], &p, &cut_target);
  front_part(tree, source, tree->cluster[target].triangle, d->across[0], &q, &cut_source);
  *cut = cut_target || cut_source;
  if (!p.n || !q.n)
    return RAD_HIDDEN;
  return *n ? rad_sight_parts(&tree->mesh->scene->visibility->occluders, &p, &q, list, n)
            : RAD_FREE;
}

static int is_apart(const struct division *d, const struct rad_cluster *t,
                    const struct rad_cluster *s) {
  double distance = rad_cluster_distance(d->tree, t, s);
  return distance >= d->least &&
         distance >= APART * fmax(rad_cluster_diameter(t), rad_cluster_diameter(s));
}

/* The target is of one fan, its places are few, and the source far from its lines. */
static int is_sector(const struct division *d, const struct rad_cluster *t,
                     const struct rad_cluster *s) {
  if (!t->sector || !d->places || 2 * rad_sector_places(d->tree, d->places, t) > t->n)
    return 0;
  struct rad_sector sector;
  rad_sector_set(d->tree, t, &sector);
  return rad_sector_distance(d->tree, &sector, s) >= APART;
}

/* One pair of clusters with the occluders list [n] that may stand between them; behind it there is
 * room for the lists of all that it is divided into. */
static void visit(struct division *d, int target, int source, int *list, int n) {
  const struct rad_cluster *t = &d->tree->cluster[target], *s = &d->tree->cluster[source];
  int *own = list + n, n_own = n, cut;
  memcpy(own, list, sizeof(int) * (size_t)n);
  enum rad_sight sight = sight_of(d, target, source, own, &n_own, &cut);
  if (sight == RAD_HIDDEN)
    return;
  if (sight == RAD_FREE && !cut && is_apart(d, t, s)) {
    put(d, FAR, target, source);
    return;
  }
  int sector = sight == RAD_FREE && !cut && is_sector(d, t, s);
  if (t->child < 0 && s->child < 0 && !sector) {
    put(d, NEAR, target, source);
  } else if (sector && s->child < 0) {
    put(d, SECTOR, target, source);
  } else if (!sector && (s->child < 0 ||
                         (t->child >= 0 && rad_cluster_diameter(t) >= rad_cluster_diameter(s)))) {
    visit(d, t->child, source, own, n_own);
    visit(d, t->child + 1, source, own, n_own);
  } else {
    visit(d, target, s->child, own, n_own);
    visit(d, target, s->child + 1, own, n_own);
  }
}

/* Divide the block of two triangles. */
static void divide(struct division *d, int i, int j) {
  const struct rad_scene *scene = d->tree->mesh->scene;
  const struct rad_visibility *v = scene->visibility;
  int sight = v->sight[(size_t)i * (size_t)scene->n_triangle + (size_t)j], n = 0;
  if (sight == RAD_HIDDEN)
    return;
  d->across[0] = rad_side_of(&scene->triangle[i], &scene->triangle[j]) == RAD_ACROSS;
  d->across[1] = rad_side_of(&scene->triangle[j], &scene->triangle[i]) == RAD_ACROSS;
  int *all = rad_alloc((size_t)v->occluders.n, sizeof(int));
  const int *blocker = all;
  if (all && sight == RAD_PARTLY)
    blocker = rad_blockers(v, i, j, all, &n);
  int *stack = all ? rad_alloc((size_t)n * (size_t)(2 * d->tree->n_level + 1), sizeof(int)) : NULL;
  if (stack) {
    memcpy(stack, blocker, sizeof(int) * (size_t)n);
    visit(d, i, j, stack, n);
  }
  d->failed |= !stack;
  free(all);
  free(stack);
}

static int ascending(const void *a, const void *b) {
  return (*(const int *)a > *(const int *)b) - (*(const int *)a < *(const int *)b);
}

/* The bags of one kind as one list by target. */
static enum rad_code sort_blocks(const struct rad_tree *tree, const struct division *d,
                                 enum kind kind, struct rad_block_list *list, struct rad_error *e) {
  size_t total = 0, n = (size_t)tree->n_cluster;
  int n_triangle = tree->mesh->scene->n_triangle;
  list->first = rad_calloc(n + 2, sizeof(size_t));
  for (int i = 0; i < n_triangle; i++)
    total += d[i].bag[kind].n;
  list->source = rad_alloc(total, sizeof(int));
  if (!list->first || !list->source)
    return rad_fail_memory(e, "the list of blocks", 4.0 * (double)total + 8.0 * (double)n);
  for (int fill = 0; fill < 2; fill++) {
    for (int i = 0; i < n_triangle; i++) {
      const struct bag *bag = &d[i].bag[kind];
      for (size_t b = 0; b < bag->n; b++) {
        const struct entry *at = &bag->entry[b];
        if (fill)
          list->source[list->first[at->target + 1]++] = at->source;
        else
          list->first[at->target + 2]++;
      }
    }
    for (size_t t = 0; t < n && !fill; t++)
      list->first[t + 2] += list->first[t + 1];
  }
  for (size_t t = 0; t < n; t++)
    qsort(list->source + list->first[t], list->first[t + 1] - list->first[t], sizeof(int),
          ascending);
  return RAD_OK;
}

/* places: on a line of a sector; 0: one place for each point. */
static double count_entries(const struct rad_tree *tree, const struct rad_block_list *list,
                            int places) {
  double sum = 0;
  for (int t = 0; t < tree->n_cluster; t++) {
    const struct rad_cluster *target = &tree->cluster[t];
    double rows = places ? rad_sector_places(tree, places, target) : target->n;
    for (size_t b = list->first[t]; b < list->first[t + 1]; b++)
      sum += rows * tree->cluster[list->source[b]].n;
  }
  return sum;
}

enum rad_code rad_blocks_build(const struct rad_tree *tree, int places, double least,
                               struct rad_blocks *blocks, struct rad_error *e) {
  int n = tree->mesh->scene->n_triangle, failed = 0;
  *blocks = (struct rad_blocks){0};
  struct division *d = rad_calloc((size_t)n, sizeof *d);
  if (!d)
    return rad_fail_memory(e, "the list of blocks", (double)n * sizeof *d);
  struct rad_progress *progress = tree->mesh->scene->progress;
  rad_progress_begin(progress, "triangles", n);
#pragma omp parallel for schedule(dynamic) default(none) shared(n, tree, places, least, d, progress)
  for (int i = 0; i < n; i++) {
    d[i].tree = tree;
    d[i].places = places;
    d[i].least = least;
    for (int j = 0; j < n && !rad_stop_asked(); j++)
      divide(&d[i], i, j);
    rad_progress_add(progress, 1);
  }
  for (int i = 0; i < n; i++)
    failed |= d[i].failed;
  enum rad_code code = failed ? rad_fail_memory(e, "the list of blocks", 0) : RAD_OK;
  if (!code && rad_stop_asked())
    code = rad_fail_stopped(e);
  if (!code)
    code = sort_blocks(tree, d, FAR, &blocks->far, e);
  if (!code)
    code = sort_blocks(tree, d, NEAR, &blocks->near, e);
  if (!code)
    code = sort_blocks(tree, d, SECTOR, &blocks->sector, e);
  if (!code) {
    blocks->near_entries = count_entries(tree, &blocks->near, 0);
    blocks->sector_entries = count_entries(tree, &blocks->sector, places);
  }
  for (int i = 0; i < n; i++)
    for (int kind = 0; kind < N_KIND; kind++)
      free(d[i].bag[kind].entry);
  free(d);
  return code;
}

void rad_blocks_free(struct rad_blocks *blocks) {
  free(blocks->far.first);
  free(blocks->far.source);
  free(blocks->near.first);
  free(blocks->near.source);
  free(blocks->sector.first);
  free(blocks->sector.source);
  *blocks = (struct rad_blocks){0};
}
