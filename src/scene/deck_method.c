/* Sections `accuracy` and `method` of the deck. */
#include "scene/deck_read.h"

enum rad_code rad_deck_read_accuracy(struct rad_yaml *y, const struct rad_yaml_node *node,
                                     struct rad_deck *deck) {
  static const struct rad_key key[] = {{.name = "tolerance",
                                        .type = RAD_KEY_REAL,
                                        .offset = offsetof(struct rad_deck, tolerance),
                                        .range = {0, 1, true}}};
  const struct rad_yaml_node *seen[1];
  return node ? rad_read_map(y, node, "section 'accuracy'", 1, key, deck, seen) : RAD_OK;
}

static const char *const meshes[] = {"paper", "graded", "uniform", "geometric", NULL};
static const char *const node_kinds[] = {"gauss", "biased", "equidistant", "vertex", NULL};
static const char *const angles[] = {"polar", "duffy", NULL};
static const char *const matrices[] = {"auto", "dense", "hierarchical", NULL};
static const char *const solvers[] = {"auto", "lu", "gmres", "neumann", NULL};

/* Key number i has the bit 1 << i of enum rad_given. */
enum {
  MESH,
  ELEMENTS,
  GRADING,
  DEGREE,
  ANGLE,
  LAYERS,
  QUADRATURE,
  MATRIX,
  SOLVER,
  PRECISION,
  BOUNCES,
  RATIO,
  NODES,
  N_KEY
};
_Static_assert(RAD_GIVEN_MESH == 1 << MESH && RAD_GIVEN_NODES == 1 << NODES, "enum rad_given");

#define REAL(member) .type = RAD_KEY_REAL, .offset = offsetof(struct rad_deck_method, member)
#define WHOLE(member) .type = RAD_KEY_WHOLE, .offset = offsetof(struct rad_deck_method, member)
#define CHOICE(member) .type = RAD_KEY_CHOICE, .offset = offsetof(struct rad_deck_method, member)

static const struct rad_key method_key[N_KEY] = {
    [MESH] = {.name = "mesh", CHOICE(mesh), .choice = meshes},
    [ELEMENTS] = {.name = "elements", WHOLE(elements), .range = {1, 4096, false}},
    [GRADING] = {.name = "grading", REAL(grading), .range = {1, 8, false}},
    [DEGREE] = {.name = "degree", WHOLE(degree), .range = {0, RAD_MAX_DEGREE, false}},
    [ANGLE] = {.name = "angle", CHOICE(angle), .choice = angles},
    [LAYERS] = {.name = "constant_layers", WHOLE(constant_layers), .range = {0, INT_MAX, false}},
    [QUADRATURE] = {.name = "quadrature_tolerance",
                    REAL(quadrature_tolerance),
                    .range = {1e-15, 1e-1, false}},
    [MATRIX] = {.name = "matrix", CHOICE(matrix), .choice = matrices},
    [SOLVER] = {.name = "solver", CHOICE(solver), .choice = solvers},
    [PRECISION] = {.name = "solver_tolerance",
                   REAL(solver_tolerance),
                   .range = {1e-18, 1e-1, false}},
    [BOUNCES] = {.name = "bounces", WHOLE(bounces), .range = {0, 100000, false}},
    [RATIO] = {.name = "ratio", REAL(ratio), .range = {0, 1, true}},
    [NODES] = {.name = "nodes"},
};

/* A name, or degree + 1 ascending places in [0, 1]. */
static enum rad_code read_nodes(struct rad_yaml *y, const struct rad_yaml_node *node,
                                const struct rad_deck_method *m, struct rad_node_choice *nodes) {
  if (node->kind != RAD_YAML_LIST) {
    int kind;
    enum rad_code code = rad_read_choice(y, node, "nodes", node_kinds, &kind);
    nodes->kind = code ? RAD_NODES_GAUSS : (enum rad_node_kind)kind;
    return code;
  }
  if (node->n != m->degree + 1)
    return rad_yaml_fail(y, node, "'nodes' lists %d points, but degree %d has %d in each direction",
                         node->n, m->degree, m->degree + 1);
  nodes->kind = RAD_NODES_LIST;
  nodes->n = node->n;
  enum rad_code code =
      rad_read_reals(y, node, "nodes", node->n, (struct rad_range){0, 1, false}, nodes->at);
  for (int a = 1; a < node->n && !code; a++)
    if (nodes->at[a] - nodes->at[a - 1] < 1e-3)
      return rad_yaml_fail(y, node, "'nodes' must ascend by 1e-3 or more; %.9g follows %.9g",
                           nodes->at[a], nodes->at[a - 1]);
  return code;
}

enum rad_code rad_deck_read_method(struct rad_yaml *y, const struct rad_yaml_node *node,
                                   struct rad_deck *deck) {
  struct rad_deck_method *m = &deck->method;
  *m = (struct rad_deck_method){.mesh = RAD_MESH_PAPER,
                                .elements = 8,
                                .grading = 1,
                                .degree = 1,
                                .angle = RAD_ANGLE_POLAR,
                                .quadrature_tolerance = 1e-10,
                                .matrix = RAD_MATRIX_AUTO,
                                .solver = RAD_SOLVER_AUTO,
                                .solver_tolerance = 1e-12,
                                .bounces = 10,
                                .ratio = 0.15};
  if (!node)
    return RAD_OK;
  const struct rad_yaml_node *seen[N_KEY];
  enum rad_code code = rad_read_map(y, node, "section 'method'", N_KEY, method_key, m, seen);
  if (code)
    return code;
  for (int i = 0; i < N_KEY; i++)
    m->given |= seen[i] ? 1u << i : 0;
  if (m->mesh == RAD_MESH_GRADED && m->grading != floor(m->grading))
    return rad_fail_value(y, seen[GRADING], "grading", "a whole number, as 'mesh: graded' needs");
  if (seen[NODES] && (code = read_nodes(y, seen[NODES], m, &m->nodes)))
    return code;
  if (m->nodes.kind != RAD_NODES_GAUSS && m->mesh == RAD_MESH_UNIFORM)
    return rad_yaml_fail(y, seen[NODES],
                         "'nodes' is for the meshes paper, graded and geometric; the uniform mesh "
                         "has nodes of its own, in space");
  if (seen[BOUNCES] && m->solver != RAD_SOLVER_NEUMANN)
    return rad_yaml_fail(y, seen[BOUNCES],
                         "'bounces' is for 'solver: neumann' only; set that solver or remove it");
  return RAD_OK;
}
