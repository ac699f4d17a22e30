#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "mesh/grade.h"

static double sub_grading(const struct rad_triangle *t, int sub, const struct rad_deck_method *m) {
  return t->n_grading == 6 ? t->grading[sub] : t->n_grading == 3 ? t->grading[sub / 2] : m->grading;
}

static int sub_elements(const struct rad_triangle *t, int sub, const struct rad_deck_method *m) {
  return t->n_elements == 6 ? t->elements[sub] : t->n_elements == 1 ? t->elements[0] : m->elements;
}

double rad_mesh_count(const struct rad_scene *scene, const struct rad_deck_method *m,
                      double *n_element) {
  double k = m->degree + 1, unknowns = 0;
  *n_element = 0;
  for (int i = 0; i < scene->n_triangle; i++) {
    const struct rad_triangle *t = &scene->triangle[i];
    for (int s = 0; s < (m->mesh == RAD_MESH_UNIFORM ? 1 : RAD_N_SUB); s++) {
      double n = sub_elements(t, s, m), p = sub_grading(t, s, m), count = n * n, plain = 0;
      if (m->mesh == RAD_MESH_PAPER) {
        count = rad_grade_count((int)n, p);
        plain = rad_grade_constants((int)n, p, m->constant_layers);
      }
      double functions = m->mesh == RAD_MESH_UNIFORM && m->degree == 1 ? 3 : k * k;
      *n_element += count;
      unknowns += plain + (count - plain) * functions;
    }
  }
  return unknowns;
}

/* Grows an array of n items to hold one more; doubles its room at powers of two. */
static int grow(void **array, int n, size_t item) {
  if (n & (n - 1))
    return 1;
  void *grown = realloc(*array, (size_t)(n ? 2 * n : 1) * item);
  *array = grown ? grown : *array;
  return grown != NULL;
}

void rad_mesh_add_patch(struct rad_mesh *mesh, const struct rad_patch *patch) {
  mesh->failed |= !grow((void **)&mesh->patch, mesh->n_patch, sizeof *patch);
  if (!mesh->failed)
    mesh->patch[mesh->n_patch++] = *patch;
}

void rad_mesh_add_element(struct rad_mesh *mesh, struct rad_element e) {
  mesh->failed |= !grow((void **)&mesh->element, mesh->n_element, sizeof e);
  e.patch = mesh->n_patch - 1;
  e.first = mesh->n_point;
  e.n_function = e.fold ? 3 : e.k_phi * e.k_r;
  mesh->failed |= mesh->n_point > RAD_MAX_POINT - e.n_function;
  if (mesh->failed)
    return;
  mesh->n_point += e.n_function;
  mesh->element[mesh->n_element++] = e;
}

/* Returns 0 when there is no memory. */
static int add_paper(struct rad_mesh *mesh, int n, double p, const struct rad_deck_method *m) {
  int total = (int)rad_grade_count(n, p);
  struct rad_rectangle *scratch = rad_alloc((size_t)total, sizeof *scratch);
  if (!scratch)
    return 0;
  rad_grade_fill(n, p, scratch);
  for (int i = 0; i < total; i++) {
    const struct rad_rectangle *q = &scratch[i];
    int k = rad_grade_constant(q->layer, n, p, m->constant_layers) ? 1 : m->degree + 1;
    rad_mesh_add_element(mesh, (struct rad_element){.sigma = {q->phi[0], q->phi[1]},
                                                    .tau = {q->r[0], q->r[1]},
                                                    .p_phi = 1,
                                                    .p_r = 1,
                                                    .k_phi = k,
                                                    .k_r = k});
  }
  free(scratch);
  return 1;
}

/* Border i of n intervals of a graded variable: equal, or 0, q^(n-1) .. q, 1 (geometric). */
static double border(int i, int n, const struct rad_deck_method *m) {
  if (m->mesh == RAD_MESH_GEOMETRIC)
    return i == 0 ? 0 : pow(m->ratio, n - i);
  return (double)i / n;
}

/* n x n elements; p = 1 if the mesh is geometric. */
static void add_tensor(struct rad_mesh *mesh, int n, double p, const struct rad_deck_method *m) {
  int k = m->degree + 1;
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++)
      rad_mesh_add_element(mesh,
                           (struct rad_element){.sigma = {border(i, n, m), border(i + 1, n, m)},
                                                .tau = {border(j, n, m), border(j + 1, n, m)},
                                                .p_phi = p,
                                                .p_r = p,
                                                .k_phi = k,
                                                .k_r = k});
}

/* Red refinement: n rows of small triangles, upright ones and, between them, inverted ones. */
static void add_uniform(struct rad_mesh *mesh, int triangle, int n, int degree) {
  for (int j = 0; j < n && !mesh->failed; j++)
    for (int i = 0; i < 2 * (n - j) - 1; i++) {
      int up = i % 2 == 0, c = i / 2;
      double corner[3][2] = {{up ? c : c + 1, j}, {c + 1, up ? j : j + 1}, {c, j + 1}};
      for (int v = 0; v < 3; v++)
        for (int d = 0; d < 2; d++)
          corner[v][d] /= n;
      struct rad_patch patch;
      rad_patch_plain(mesh->scene, triangle, (const double(*)[2])corner, &patch);
      rad_mesh_add_patch(mesh, &patch);
      int k = degree + 1;
      rad_mesh_add_element(mesh, (struct rad_element){.sigma = {0, 1},
                                                      .tau = {0, 1},
                                                      .p_phi = 1,
                                                      .p_r = 1,
                                                      .k_phi = k,
                                                      .k_r = k,
                                                      .fold = degree == 1 ? mesh->fold : NULL});
    }
}

/* Local coordinates of the uniform mesh's nodes: the centroid, or 1/6, 1/6, 2/3 and its turns. */
static const double uniform_node[2][3][2] = {{{0.5, 2.0 / 3}},
                                             {{0.5, 1.0 / 3}, {0.2, 5.0 / 6}, {0.8, 5.0 / 6}}};

/* phi or r of x in [-1, 1] of an interval of the graded variable; the limit, not the end itself,
 * at an edge or vertex, where h has no value. */
static double place(double x, const double range[2], double p) {
  double s = range[0] + 0.5 * (1 + x) * (range[1] - range[0]);
  return s > 0 ? rad_graded(s, p) : RAD_LIMIT;
}

void rad_element_point(const struct rad_mesh *mesh, const struct rad_element *e, int b, double *phi,
                       double *r) {
  const struct rad_patch *patch = &mesh->patch[e->patch];
  if (patch->corner < 0 && (e->fold || e->k_phi == 1)) {
    const double *node = uniform_node[e->fold != NULL][b];
    *phi = node[0];
    *r = node[1];
    return;
  }
  *phi = place(rad_nodes_at(&mesh->nodes, e->k_phi)[b % e->k_phi], e->sigma, e->p_phi);
  *r = place(rad_nodes_at(&mesh->nodes, e->k_r)[b / e->k_phi], e->tau, e->p_r);
}

static void set_points(struct rad_mesh *mesh) {
  for (int i = 0; i < mesh->n_element; i++) {
    const struct rad_element *e = &mesh->element[i];
    const struct rad_patch *patch = &mesh->patch[e->patch];
    for (int b = 0; b < e->n_function; b++) {
      double phi, r;
      rad_element_point(mesh, e, b, &phi, &r);
      mesh->point_base[e->first + b] = patch->base;
      rad_patch_mu(patch, phi, r, mesh->point_mu[e->first + b]);
    }
  }
}

/* fold[f,b] = value of the linear function f of the uniform mesh at tensor Gauss point b. */
static void set_fold(struct rad_mesh *mesh) {
  const double *x = rad_gauss_node(&mesh->gauss, 2);
  for (int b = 0; b < 4; b++) {
    double phi = 0.5 * (1 + x[b % 2]), r = 0.5 * (1 + x[b / 2]);
    double bary[3] = {1 - r, r * (1 - phi), r * phi};
    for (int f = 0; f < 3; f++) /* 1 at its node, 0 at the others: 2 bary - 1/3 */
      mesh->fold[4 * f + b] = 2 * bary[f] - 1.0 / 3;
  }
}

/* First patches, elements and points of triangles and patches, from the lists. */
static void set_firsts(struct rad_mesh *mesh) {
  int n_triangle = mesh->scene->n_triangle, patch = 0, element = 0;
  for (int t = 0; t <= n_triangle; t++) {
    while (patch < mesh->n_patch && mesh->patch[patch].triangle < t)
      patch++;
    mesh->patch_first[t] = patch;
  }
  for (int p = 0; p <= mesh->n_patch; p++) {
    while (element < mesh->n_element && mesh->element[element].patch < p)
      element++;
    mesh->element_first[p] = element;
  }
  for (int t = 0; t <= n_triangle; t++) {
    int e = mesh->element_first[mesh->patch_first[t]];
    mesh->point_first[t] = e < mesh->n_element ? mesh->element[e].first : mesh->n_point;
  }
}

enum rad_code rad_mesh_begin(const struct rad_scene *scene, const struct rad_node_choice *nodes,
                             struct rad_mesh *mesh, struct rad_error *e) {
  static const struct rad_node_choice usual = {.kind = RAD_NODES_GAUSS};
  *mesh = (struct rad_mesh){.scene = scene};
  enum rad_code code = rad_gauss_init(&mesh->gauss, e);
  if (!code)
    code = rad_nodes_init(&mesh->gauss, nodes ? nodes : &usual, &mesh->nodes, e);
  if (!code)
    set_fold(mesh);
  return code;
}

enum rad_code rad_mesh_finish(struct rad_mesh *mesh, struct rad_error *e) {
  mesh->patch_first = rad_calloc((size_t)mesh->scene->n_triangle + 1, sizeof(int));
  mesh->element_first = rad_calloc((size_t)mesh->n_patch + 1, sizeof(int));
  mesh->point_first = rad_calloc((size_t)mesh->scene->n_triangle + 1, sizeof(int));
  mesh->point_base = rad_calloc((size_t)mesh->n_point, sizeof(int));
  mesh->point_mu = rad_calloc((size_t)mesh->n_point, sizeof *mesh->point_mu);
  if (mesh->failed || !mesh->patch_first || !mesh->element_first || !mesh->point_first ||
      !mesh->point_base || !mesh->point_mu)
    return rad_fail_memory(e, "the mesh",
                           mesh->n_point * 20.0 + mesh->n_element * (double)sizeof *mesh->element);
  set_firsts(mesh);
  set_points(mesh);
  return RAD_OK;
}

/* All patches and elements of one triangle. */
static void add_triangle(struct rad_mesh *mesh, int i, const struct rad_deck_method *m) {
  const struct rad_triangle *t = &mesh->scene->triangle[i];
  if (m->mesh == RAD_MESH_UNIFORM) {
    add_uniform(mesh, i, sub_elements(t, 0, m), m->degree);
    return;
  }
  for (int s = 0; s < RAD_N_SUB && !mesh->failed; s++) {
    struct rad_patch patch;
    int n = sub_elements(t, s, m);
    rad_patch_sub_triangle(mesh->scene, i, s, m->angle, &patch);
    rad_mesh_add_patch(mesh, &patch);
    if (m->mesh == RAD_MESH_PAPER)
      mesh->failed |= !add_paper(mesh, n, sub_grading(t, s, m), m);
    else
      add_tensor(mesh, n, m->mesh == RAD_MESH_GRADED ? sub_grading(t, s, m) : 1, m);
  }
}

enum rad_code rad_mesh_build(const struct rad_scene *scene, const struct rad_deck_method *m,
                             struct rad_mesh *mesh, struct rad_error *e) {
  *mesh = (struct rad_mesh){.scene = scene};
  if (m->mesh == RAD_MESH_UNIFORM && m->degree > 1)
    return rad_fail(e, RAD_EINPUT,
                    "method.degree is %d, but the uniform mesh has degree 0 or 1 only; choose "
                    "mesh: paper or graded for higher degrees",
                    m->degree);
  double n_element, n_point = rad_mesh_count(scene, m, &n_element);
  if (n_point > RAD_MAX_POINT)
    return rad_fail(e, RAD_EINPUT,
                    "the mesh would have %.3g unknowns, more than %d; lower method.elements, "
                    "method.grading or method.degree",
                    n_point, RAD_MAX_POINT);
  enum rad_code code = rad_mesh_begin(scene, &m->nodes, mesh, e);
  for (int i = 0; i < scene->n_triangle && !code; i++)
    add_triangle(mesh, i, m);
  return code ? code : rad_mesh_finish(mesh, e);
}

void rad_mesh_free(struct rad_mesh *mesh) {
  rad_gauss_free(&mesh->gauss);
  rad_nodes_free(&mesh->nodes);
  free(mesh->patch);
  free(mesh->element);
  free(mesh->patch_first);
  free(mesh->element_first);
  free(mesh->point_first);
  free(mesh->point_base);
  free(mesh->point_mu);
  *mesh = (struct rad_mesh){0};
}
