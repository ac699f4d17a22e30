#include "system/facets.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "integrate/constant.h"
#include "integrate/task.h"
#include "visibility/facing.h"
#include "visibility/occluder.h"

enum {
  TILE = 64,     /* targets that stay in the first cache while the columns of a task pass */
  COMPONENTS = 9 /* of a target: vertex, offset, normal */
};
_Static_assert(TILE % RAD_FACET_LANES == 0, "a tile is whole groups of lanes");

/* The whole assembly; what a thread changes is in its scratch. */
struct facets {
  const struct rad_mesh *mesh;
  const struct rad_rules *rules;
  const unsigned char *sees;
  double *k;
  double *component; /* owned [COMPONENTS, room] of all targets, padded with copies of the last */
  size_t room;
};

static struct rad_facet_targets targets_in(const double *component, size_t room) {
  struct rad_facet_targets t;
  for (int d = 0; d < 3; d++) {
    t.v[d] = component + room * (size_t)d;
    t.d[d] = component + room * (size_t)(3 + d);
    t.normal[d] = component + room * (size_t)(6 + d);
  }
  return t;
}

int rad_mesh_is_facets(const struct rad_mesh *mesh) {
  int n = mesh->scene->n_triangle, same = 1;
  if (mesh->n_patch != n || mesh->n_element != n || mesh->n_point != n)
    return 0;
  for (int i = 0; i < n && same; i++) {
    const struct rad_patch *p = &mesh->patch[i];
    const struct rad_element *e = &mesh->element[i];
    int whole = p->base == 0 && p->mu0[0] == 0 && p->mu0[1] == 0 && p->mu_a[0] == 1 &&
                p->mu_a[1] == 0 && p->mu_b[0] == -1 && p->mu_b[1] == 1;
    int all = e->sigma[0] == 0 && e->sigma[1] == 1 && e->tau[0] == 0 && e->tau[1] == 1;
    same = whole && all && !e->fold && e->k_phi == 1 && e->k_r == 1 && p->triangle == i &&
           e->patch == i && e->first == i;
  }
  return same;
}

/* Vertex, offset and normal of every target. */
static int set_targets(struct facets *f) {
  const struct rad_mesh *mesh = f->mesh;
  size_t n = (size_t)mesh->n_point;
  f->room = (n + TILE - 1) / TILE * TILE;
  f->component = rad_alloc(f->room * COMPONENTS, sizeof(double));
  for (size_t i = 0; f->component && i < f->room; i++) {
    size_t at = i < n ? i : n - 1;
    const struct rad_triangle *t = &mesh->scene->triangle[at];
    int base = mesh->point_base[at];
    const double *v = t->v[base], *v1 = t->v[(base + 1) % 3], *v2 = t->v[(base + 2) % 3];
    for (size_t d = 0; d < 3; d++) {
      f->component[f->room * d + i] = v[d];
      f->component[f->room * (3 + d) + i] =
          mesh->point_mu[at][0] * (v1[d] - v[d]) + mesh->point_mu[at][1] * (v2[d] - v[d]);
      f->component[f->room * (6 + d) + i] = t->normal[d];
    }
  }
  return f->component != NULL;
}

/* Any entry, to full accuracy and at full cost. */
static double by_patch(const struct facets *f, int i, int j, struct rad_scratch *scratch) {
  const struct rad_mesh *mesh = f->mesh;
  struct rad_targets target = {i, 1, mesh->point_base + i, (const double(*)[2])mesh->point_mu + i,
                               NULL};
  double value = 0;
  rad_patch_block(mesh, f->rules, &target, j, NULL, &value, 0, scratch);
  return value;
}

/* An entry that the vector loop was not sure of: cut at the horizon, or hard to round. */
static double with_care(const struct facets *f, const struct rad_facet_source *source, int i, int j,
                        struct rad_scratch *scratch) {
  const struct rad_triangle *t = f->mesh->scene->triangle;
  struct rad_facet_targets all = targets_in(f->component, f->room);
  struct rad_polygon front;
  rad_facet_front(source, &all, i, rad_side_of(&t[i], &t[j]) == RAD_ACROSS, &front);
  double value =
      rad_facet_part(source, &all, i, &front, (struct rad_facet_error){f->rules->tolerance, 0});
  if (isnan(value))
    return by_patch(f, i, j, scratch);
  scratch->counters.far++;
  return value;
}

/* Targets first..first+n of column j that see all of its source. */
static void fill_seen(const struct facets *f, const struct rad_facet_source *source, int first,
                      int n, int j, struct rad_scratch *scratch) {
  size_t n_point = (size_t)f->mesh->n_point;
  const unsigned char *sees = f->sees + n_point * (size_t)j + first;
  double gathered[COMPONENTS * TILE], value[TILE], *k = f->k + n_point * (size_t)j + first;
  int list[TILE], seen = 0, doubts = 0;
  for (int i = 0; i < n; i++)
    if (sees[i] == RAD_FREE)
      list[seen++] = i;
  int padded = (seen + RAD_FACET_LANES - 1) / RAD_FACET_LANES * RAD_FACET_LANES;
  for (int i = seen; i < padded; i++)
    list[i] = list[seen - 1];
  struct rad_facet_targets targets = targets_in(f->component + first, f->room);
  if (seen < n) {
    for (int c = 0; c < COMPONENTS; c++)
      for (int i = 0; i < padded; i++)
        gathered[c * TILE + i] = f->component[f->room * (size_t)c + (size_t)(first + list[i])];
    targets = targets_in(gathered, TILE);
  }
  for (int at = 0; at < padded; at += RAD_FACET_LANES)
    doubts |= rad_facet_values(source, &targets, at,
                               (struct rad_facet_error){f->rules->tolerance, 0}, value + at);
  scratch->counters.far += seen;
  for (int i = 0; i < seen; i++)
    k[list[i]] = value[i];
  for (int i = 0; i < seen && doubts; i++)
    if (isnan(value[i])) {
      scratch->counters.far--;
      k[list[i]] = with_care(f, source, first + list[i], j, scratch);
    }
}

/* Columns first..first+n, tile by tile. */
static void fill_columns(const struct facets *f, int first, int n, struct rad_scratch *scratch) {
  int n_point = f->mesh->n_point;
  struct rad_facet_source source[RAD_FACET_COLUMNS];
  for (int c = 0; c < n; c++)
    rad_facet_source_set(&f->mesh->scene->triangle[first + c], &source[c]);
  for (int row = 0; row < n_point && !rad_stop_asked(); row += TILE)
    for (int c = 0; c < n; c++) {
      int j = first + c, m = n_point - row < TILE ? n_point - row : TILE;
      const unsigned char *sees = f->sees + (size_t)n_point * (size_t)j + row;
      if (memchr(sees, RAD_FREE, (size_t)m))
        fill_seen(f, &source[c], row, m, j, scratch);
      for (int i = 0; i < m; i++)
        if (sees[i] == RAD_PARTLY)
          f->k[(size_t)n_point * (size_t)j + (size_t)(row + i)] = by_patch(f, row + i, j, scratch);
    }
}

int64_t rad_facets_tasks(const struct rad_mesh *mesh) {
  return (mesh->n_point + RAD_FACET_COLUMNS - 1) / RAD_FACET_COLUMNS;
}

enum rad_code rad_facets_assemble(const struct rad_mesh *mesh, const struct rad_rules *rules,
                                  const unsigned char *sees, double *k, unsigned char *done,
                                  struct rad_scratch *scratch, struct rad_error *e) {
  int n = mesh->n_point;
  struct facets f = {.mesh = mesh, .rules = rules, .sees = sees, .k = k};
  if (!set_targets(&f))
    return rad_fail_memory(e, "the facets", 8.0 * COMPONENTS * n);
  struct rad_progress *progress = mesh->scene->progress;
  rad_progress_begin(progress, "columns", n);
#pragma omp parallel for schedule(dynamic) default(none) shared(f, n, scratch, done, progress)
  for (int j = 0; j < n; j += RAD_FACET_COLUMNS) {
    int width = n - j < RAD_FACET_COLUMNS ? n - j : RAD_FACET_COLUMNS;
    struct rad_scratch *own = &scratch[omp_get_thread_num()];
    const struct rad_counters before = own->counters;
    if (rad_task_begin(done, (size_t)(j / RAD_FACET_COLUMNS))) {
      fill_columns(&f, j, width, own);
      rad_task_end(done, (size_t)(j / RAD_FACET_COLUMNS), &before, own);
    }
    rad_progress_add(progress, width);
  }
  free(f.component);
  return RAD_OK;
}
