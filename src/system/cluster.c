#include "system/cluster.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec.h"
#include "integrate/strips.h"
#include "system/fan.h"

/* What clusters are divided by: places of elements in the plane; of elements of a fan this is the
 * fan's vertex, so that fans stay whole until nothing else is left, and then are divided by their
 * distance from it, by patch, by angle. */
enum { ALONG_0, ALONG_1, LAYER, PATCH, ANGLE, N_KEY };

/* An element while the trees are made. */
struct item {
  double low[2], high[2], area, key[N_KEY];
  int fan; /* its number, or -1 */
};

static void set_plane(const struct rad_triangle *t, struct rad_plane *p) {
  memcpy(p->origin, t->v[0], sizeof p->origin);
  memcpy(p->axis[2], t->normal, sizeof p->axis[2]);
  rad_sub(t->v[1], t->v[0], p->axis[0]);
  double length = rad_norm(p->axis[0]);
  for (int d = 0; d < 3; d++)
    p->axis[0][d] /= length;
  rad_cross(p->axis[2], p->axis[0], p->axis[1]);
}

static void flat(const struct rad_plane *p, const double x[3], double y[2]) {
  double r[3];
  rad_sub(x, p->origin, r);
  y[0] = rad_dot(r, p->axis[0]);
  y[1] = rad_dot(r, p->axis[1]);
}

/* Corners (r, r t) of an element. */
static void element_polygon(const struct rad_mesh *mesh, int element, struct rad_polygon *corners) {
  const struct rad_element *e = &mesh->element[element];
  rad_element_polygon(&mesh->patch[e->patch], e, corners);
}

double rad_element_area(const struct rad_mesh *mesh, int element) {
  const struct rad_patch *p = &mesh->patch[mesh->element[element].patch];
  struct rad_polygon corners;
  element_polygon(mesh, element, &corners);
  return rad_polygon_area(&corners) * p->a1 * p->b2;
}

void rad_element_box(const struct rad_tree *tree, int element, double low[2], double high[2]) {
  const struct rad_patch *p = &tree->mesh->patch[tree->mesh->element[element].patch];
  struct rad_polygon corners;
  element_polygon(tree->mesh, element, &corners);
  for (int d = 0; d < 2; d++) {
    low[d] = INFINITY;
    high[d] = -INFINITY;
  }
  for (int c = 0; c < corners.n; c++) {
    double x[3], y[2];
    for (int d = 0; d < 3; d++)
      x[d] = p->v[d] + corners.corner[c][0] * p->a[d] + corners.corner[c][1] * p->b[d];
    flat(&tree->plane[p->triangle], x, y);
    for (int d = 0; d < 2; d++) {
      low[d] = fmin(low[d], y[d]);
      high[d] = fmax(high[d], y[d]);
    }
  }
}

static void set_item(const struct rad_tree *tree, int element, int fan, struct item *item) {
  const struct rad_element *e = &tree->mesh->element[element];
  const struct rad_patch *p = &tree->mesh->patch[e->patch];
  *item = (struct item){.area = rad_element_area(tree->mesh, element), .fan = fan};
  rad_element_box(tree, element, item->low, item->high);
  for (int d = 0; d < 2; d++)
    item->key[ALONG_0 + d] = 0.5 * (item->low[d] + item->high[d]);
  if (fan < 0)
    return;
  flat(&tree->plane[p->triangle], p->v, &item->key[ALONG_0]);
  item->key[LAYER] = e->tau[0];
  item->key[PATCH] = e->patch;
  item->key[ANGLE] = 0.5 * (e->sigma[0] + e->sigma[1]);
}

/* Rectangle, area and unknowns of a cluster from its elements. */
static void gather(const struct rad_tree *tree, const struct item *item, struct rad_cluster *c) {
  c->area = 0;
  c->n = 0;
  c->sector = item[tree->element[c->element]].fan >= 0;
  for (int d = 0; d < 2; d++) {
    c->low[d] = INFINITY;
    c->high[d] = -INFINITY;
  }
  for (int i = c->element; i < c->element + c->n_element; i++) {
    const struct item *one = &item[tree->element[i]];
    for (int d = 0; d < 2; d++) {
      c->low[d] = fmin(c->low[d], one->low[d]);
      c->high[d] = fmax(c->high[d], one->high[d]);
    }
    c->area += one->area;
    c->n += tree->mesh->element[tree->element[i]].n_function;
    c->sector &= one->fan == item[tree->element[c->element]].fan;
  }
}

/* Ranges of the keys of a cluster's elements. */
static void range_of(const struct rad_tree *tree, const struct item *item,
                     const struct rad_cluster *c, double low[N_KEY], double high[N_KEY]) {
  for (int k = 0; k < N_KEY; k++) {
    low[k] = INFINITY;
    high[k] = -INFINITY;
    for (int i = c->element; i < c->element + c->n_element; i++) {
      low[k] = fmin(low[k], item[tree->element[i]].key[k]);
      high[k] = fmax(high[k], item[tree->element[i]].key[k]);
    }
  }
}

/* Sort the elements of a cluster to the two sides of the middle of their places, along the longer
 * direction, or of the first other key that differs; returns how many are below. Elements keep
 * their order on each side. */
static int divide(struct rad_tree *tree, const struct item *item, const struct rad_cluster *c,
                  int *spare) {
  int *list = tree->element + c->element, below = 0, above = 0;
  double low[N_KEY], high[N_KEY];
  range_of(tree, item, c, low, high);
  int by = high[ALONG_1] - low[ALONG_1] > high[ALONG_0] - low[ALONG_0] ? ALONG_1 : ALONG_0;
  for (int k = LAYER; k < N_KEY && high[by] == low[by]; k++)
    by = k;
  double mid = 0.5 * (low[by] + high[by]);
  for (int i = 0; i < c->n_element; i++)
    if (item[list[i]].key[by] < mid)
      list[below++] = list[i];
    else
      spare[above++] = list[i];
  memcpy(list + below, spare, sizeof(int) * (size_t)above);
  return below > 0 && above > 0 ? below : c->n_element / 2;
}

/* Append the children of a cluster that is large enough; 0 without memory. */
static int split(struct rad_tree *tree, const struct item *item, int parent, int *room,
                 int *spare) {
  struct rad_cluster c = tree->cluster[parent];
  if (c.n <= tree->leaf || c.n_element < 2)
    return 1;
  if (tree->n_cluster + 2 > *room) {
    struct rad_cluster *grown = realloc(tree->cluster, 2 * (size_t)*room * sizeof *tree->cluster);
    if (!grown)
      return 0;
    tree->cluster = grown;
    *room *= 2;
  }
  int below = divide(tree, item, &c, spare);
  tree->cluster[parent].child = tree->n_cluster;
  for (int side = 0; side < 2; side++) {
    struct rad_cluster *child = &tree->cluster[tree->n_cluster++];
    *child = (struct rad_cluster){
        .triangle = c.triangle, .level = c.level + 1, .parent = parent, .child = -1};
    child->element = side ? c.element + below : c.element;
    child->n_element = side ? c.n_element - below : below;
    gather(tree, item, child);
    child->first = side ? child[-1].first + child[-1].n : c.first;
  }
  return 1;
}

static int grow_trees(struct rad_tree *tree, const struct item *item, int *room, int *spare) {
  const struct rad_mesh *mesh = tree->mesh;
  for (int t = 0; t < mesh->scene->n_triangle; t++) {
    struct rad_cluster *c = &tree->cluster[tree->n_cluster++];
    *c = (struct rad_cluster){.triangle = t, .parent = -1, .child = -1};
    c->element = mesh->element_first[mesh->patch_first[t]];
    c->n_element = mesh->element_first[mesh->patch_first[t + 1]] - c->element;
    c->first = mesh->point_first[t];
    gather(tree, item, c);
  }
  for (int c = 0; c < tree->n_cluster; c++)
    if (!split(tree, item, c, room, spare))
      return 0;
  return 1;
}

/* Level by level, and unknowns in the order of the elements. */
static int finish(struct rad_tree *tree) {
  const struct rad_mesh *mesh = tree->mesh;
  tree->n_level = tree->cluster[tree->n_cluster - 1].level + 1;
  tree->level_first = rad_alloc((size_t)tree->n_level + 1, sizeof(int));
  tree->unknown = rad_alloc((size_t)mesh->n_point, sizeof(int));
  if (!tree->level_first || !tree->unknown)
    return 0;
  for (int c = tree->n_cluster - 1; c >= 0; c--)
    tree->level_first[tree->cluster[c].level] = c;
  tree->level_first[tree->n_level] = tree->n_cluster;
  for (int i = 0, at = 0; i < mesh->n_element; i++) {
    const struct rad_element *e = &mesh->element[tree->element[i]];
    for (int f = 0; f < e->n_function; f++)
      tree->unknown[at++] = e->first + f;
  }
  return 1;
}

enum rad_code rad_tree_build(const struct rad_mesh *mesh, int leaf, struct rad_tree *tree,
                             struct rad_error *e) {
  size_t n_triangle = (size_t)mesh->scene->n_triangle, n_element = (size_t)mesh->n_element;
  int room = mesh->scene->n_triangle + mesh->n_point / leaf + 2;
  *tree = (struct rad_tree){.mesh = mesh, .leaf = leaf};
  tree->plane = rad_alloc(n_triangle, sizeof *tree->plane);
  tree->element = rad_alloc(n_element, sizeof(int));
  tree->cluster = rad_alloc((size_t)room, sizeof *tree->cluster);
  struct item *item = rad_alloc(n_element, sizeof *item);
  int *spare = rad_alloc(n_element, sizeof(int));
  int done = tree->plane && tree->element && tree->cluster && item && spare;
  done = done && rad_fans_find(mesh, leaf, spare);
  if (done) {
    for (size_t t = 0; t < n_triangle; t++)
      set_plane(&mesh->scene->triangle[t], &tree->plane[t]);
    for (int i = 0; i < mesh->n_element; i++) {
      tree->element[i] = i;
      set_item(tree, i, spare[i], &item[i]);
    }
    done = grow_trees(tree, item, &room, spare) && finish(tree);
  }
  free(item);
  free(spare);
  return done ? RAD_OK : rad_fail_memory(e, "the cluster trees", 100.0 * (double)n_element);
}

void rad_tree_free(struct rad_tree *tree) {
  free(tree->cluster);
  free(tree->level_first);
  free(tree->element);
  free(tree->unknown);
  free(tree->plane);
  *tree = (struct rad_tree){0};
}

size_t rad_tree_most(const struct rad_tree *tree, size_t *element) {
  size_t most = 1;
  *element = 1;
  for (int c = 0; c < tree->n_cluster; c++)
    if (tree->cluster[c].child < 0 && (size_t)tree->cluster[c].n > most)
      most = (size_t)tree->cluster[c].n;
  for (int i = 0; i < tree->mesh->n_element; i++) {
    const struct rad_element *el = &tree->mesh->element[i];
    size_t need = (size_t)(el->k_phi * el->k_r + el->k_r);
    *element = need > *element ? need : *element;
  }
  return most;
}

void rad_cluster_polygon(const struct rad_tree *tree, int cluster, struct rad_polygon *polygon) {
  const struct rad_cluster *c = &tree->cluster[cluster];
  const struct rad_plane *plane = &tree->plane[c->triangle];
  polygon->n = 3;
  for (int v = 0; v < 3; v++)
    flat(plane, tree->mesh->scene->triangle[c->triangle].v[v], polygon->corner[v]);
  for (int d = 0; d < 2; d++) {
    rad_clip(polygon, -c->low[d], d == 0, d == 1);
    rad_clip(polygon, c->high[d], -(d == 0), -(d == 1));
  }
}

void rad_cluster_box(const struct rad_tree *tree, const struct rad_cluster *c,
                     struct rad_box *box) {
  const struct rad_plane *p = box->plane = &tree->plane[c->triangle];
  for (int d = 0; d < 3; d++) {
    box->center[d] = p->origin[d];
    for (int m = 0; m < 2; m++) {
      box->center[d] += 0.5 * (c->low[m] + c->high[m]) * p->axis[m][d];
      box->half[m][d] = 0.5 * (c->high[m] - c->low[m]) * p->axis[m][d];
    }
  }
}

/* The gap between the projections on an axis, over its length. */
double rad_box_distance(const struct rad_box *a, const struct rad_box *b) {
  double between[3], most = 0;
  rad_sub(b->center, a->center, between);
  for (int i = 0; i < 7; i++) {
    const double *axis = i == 6 ? between : (i < 3 ? a : b)->plane->axis[i % 3];
    double gap = fabs(rad_dot(between, axis)), length = rad_norm(axis);
    for (int m = 0; m < 2; m++)
      gap -= fabs(rad_dot(a->half[m], axis)) + fabs(rad_dot(b->half[m], axis));
    if (gap > most * length)
      most = gap / length;
  }
  return most;
}

double rad_cluster_distance(const struct rad_tree *tree, const struct rad_cluster *a,
                            const struct rad_cluster *b) {
  struct rad_box box[2];
  rad_cluster_box(tree, a, &box[0]);
  rad_cluster_box(tree, b, &box[1]);
  return rad_box_distance(&box[0], &box[1]);
}
