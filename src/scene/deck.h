/* The input deck: what the user wrote, read and checked for form, nothing computed from it yet. */
#ifndef RAD_SCENE_DECK_H
#define RAD_SCENE_DECK_H

#include <stdbool.h>

#include "base/error.h"
#include "base/nodes.h"

enum { RAD_MAX_BAND = 16, RAD_MAX_DEGREE = 23 };

enum rad_side { RAD_SIDE_UNSET, RAD_SIDE_FRONT, RAD_SIDE_BACK, RAD_SIDE_BOTH, RAD_SIDE_NORMAL };

/* Optical properties; a triangle's own win over those of its surface. Given are rho and emission,
 * or emissivity and temperature, or emissivity and flux; in the latter two there is one band. */
struct rad_deck_optics {
  bool has_rho, has_emissivity;                 /* at most one of these two */
  bool has_emission, has_temperature, has_flux; /* and of these three */
  double emissivity;                            /* 0..1 */
  double temperature;                           /* [K] */
  double flux;                                  /* net, out of the face [W/m2] */
  double rho[RAD_MAX_BAND];                     /* [n_band] reflectivity, 0..1 */
  double emission[3][RAD_MAX_BAND]; /* [vertex][band] emitted E [W/m2]; equal when constant */
  enum rad_side side; /* RAD_SIDE_UNSET: the surface's, and front if that has none either */
  double normal[3];   /* when side is RAD_SIDE_NORMAL: any length > 0 */
};

struct rad_deck_triangle {
  char *name; /* owned; surface name, default triangle_1, triangle_2, ... by place in the list */
  double vertex[3][3];
  struct rad_deck_optics optics;
  int n_grading;     /* 0 (not given), 3 (edges v0v1 v1v2 v2v0) or 6 (sub-triangles) */
  double grading[6]; /* exponents p >= 1 */
  int n_elements;    /* 0, 1 (whole triangle) or 6 (sub-triangles) */
  int elements[6];   /* N */
  int line;          /* in the deck, for messages; 0 when it came by --set */
};

struct rad_deck_surface {
  char *name; /* owned */
  struct rad_deck_optics optics;
  int line;
};

struct rad_deck_probe {
  char *name;    /* owned; default probe_1, probe_2, ... */
  char *surface; /* owned, or NULL: the surface that holds the point */
  double at[3];
  int line;
};

enum rad_mesh_kind { RAD_MESH_PAPER, RAD_MESH_GRADED, RAD_MESH_UNIFORM, RAD_MESH_GEOMETRIC };
enum rad_angle { RAD_ANGLE_POLAR, RAD_ANGLE_DUFFY };
enum rad_matrix { RAD_MATRIX_AUTO, RAD_MATRIX_DENSE, RAD_MATRIX_HIERARCHICAL };
enum rad_solver { RAD_SOLVER_AUTO, RAD_SOLVER_LU, RAD_SOLVER_GMRES, RAD_SOLVER_NEUMANN };

/* Section `method`. Bit RAD_GIVEN_x in `given` says that the user wrote the key. */
struct rad_deck_method {
  unsigned given;
  enum rad_mesh_kind mesh;     /* default paper */
  int elements;                /* N, default 8 */
  double grading;              /* p, default 1 */
  int degree;                  /* default 1 */
  enum rad_angle angle;        /* default polar */
  int constant_layers;         /* i*, default 0 */
  double quadrature_tolerance; /* default 1e-10 */
  enum rad_matrix matrix;
  enum rad_solver solver;
  double solver_tolerance;      /* default 1e-12 */
  int bounces;                  /* neumann only, default 10 */
  double ratio;                 /* geometric only: of neighbouring layers, default 0.15 */
  struct rad_node_choice nodes; /* default Gauss points */
};

enum rad_given {
  RAD_GIVEN_MESH = 1,
  RAD_GIVEN_ELEMENTS = 2,
  RAD_GIVEN_GRADING = 4,
  RAD_GIVEN_DEGREE = 8,
  RAD_GIVEN_ANGLE = 16,
  RAD_GIVEN_CONSTANT_LAYERS = 32,
  RAD_GIVEN_QUADRATURE_TOLERANCE = 64,
  RAD_GIVEN_MATRIX = 128,
  RAD_GIVEN_SOLVER = 256,
  RAD_GIVEN_SOLVER_TOLERANCE = 512,
  RAD_GIVEN_BOUNCES = 1024,
  RAD_GIVEN_RATIO = 2048,
  RAD_GIVEN_NODES = 4096,
  RAD_GIVEN_ANY_MESH = 1 | 2 | 4 | 8 | 16 | 32 | 2048 | 4096
};

enum {
  RAD_FIELD_RADIOSITY = 1,
  RAD_FIELD_IRRADIANCE = 2,
  RAD_FIELD_NET_FLUX = 4, /* these two in thermal scenes only */
  RAD_FIELD_TEMPERATURE = 8
};

enum rad_cells { RAD_CELLS_LINEAR, RAD_CELLS_LAGRANGE };

/* From where tools/render looks; NAN where the deck does not say. */
struct rad_deck_camera {
  bool given;                   /* the deck says something */
  double from[3], to[3], up[3]; /* [m]; up: of any length */
  double angle;                 /* of view, of the picture's shorter side [degree] */
};

struct rad_deck_output {
  char *file;      /* owned; default: the deck's base name with .vtkhdf, in the working folder */
  int sampling;    /* sub-cells per element and direction, default 4 */
  unsigned fields; /* bits RAD_FIELD_*; 0: all that there are */
  enum rad_cells cells; /* of the picture; default linear */
  bool view_factors;    /* the matrix between surfaces; default no */
  struct rad_deck_camera camera;
};

/* One varied key of a study: its dotted name and the values as text, ready for `--set`. */
struct rad_deck_vary {
  char *key;    /* owned */
  int n;        /* >= 1 */
  char **value; /* owned [n] */
};

/* What the runs of a study are compared by; auto: u_h of meshes by hand, u* of adaptive runs. */
enum rad_study_values { RAD_VALUES_AUTO, RAD_VALUES_SOLUTION, RAD_VALUES_REPORTED };

struct rad_deck_study {
  bool present;
  bool stability;                  /* norms of the inverse of every run; default no */
  enum rad_study_values values;    /* default auto */
  int repeats;                     /* of each run, for its times; default 1 */
  int n_vary;                      /* keys; the study runs their product, first key slowest */
  struct rad_deck_vary *vary;      /* owned [n_vary] */
  int n_reference;                 /* 0: the last run is the reference */
  struct rad_deck_vary *reference; /* owned; keys of the reference run, n = 1 each */
};

struct rad_deck {
  char *path;  /* owned; as given */
  char *text;  /* owned; the file's bytes, for provenance */
  char *title; /* owned; "" when not given */
  int n_band;
  char *band[RAD_MAX_BAND]; /* owned; default one band "all" */
  int n_triangle;
  struct rad_deck_triangle *triangle; /* owned [n_triangle] */
  char *mesh_file;                    /* owned or NULL; scene.mesh.file */
  double mesh_scale;
  int n_named_mesh;
  char **
      named_mesh; /* owned [n_named_mesh] mesh_file, what overrides replaced, those of study runs */
  int n_surface;
  struct rad_deck_surface *surface; /* owned [n_surface] */
  double tolerance;                 /* accuracy.tolerance; 0 when not given */
  struct rad_deck_method method;
  int n_probe;
  struct rad_deck_probe *probe; /* owned [n_probe] */
  struct rad_deck_output output;
  struct rad_deck_study study;
};

/**
 * Read a deck and apply overrides.
 *
 * Messages read `PATH:LINE:COLUMN: error: ...`; those about an override `--set KEY=VALUE: error:
 * ...`. Every run of a study, and its reference, is tried here: its overrides will be accepted.
 *
 * @param[in]  path   file to read
 * @param[in]  set    [n_set] overrides "dotted.key=value"; the value is parsed as YAML
 * @param[out] deck   to be freed with rad_deck_free, also after an error
 * @return RAD_OK, RAD_EINPUT for anything wrong with the text, RAD_ESYSTEM if it cannot be read
 */
enum rad_code rad_deck_read(const char *path, int n_set, const char *const *set,
                            struct rad_deck *deck, struct rad_error *e);

void rad_deck_free(struct rad_deck *deck); /* safe twice */

#endif
