/* The scene: triangles with topology, surfaces and optical properties, checked and ready for
 * meshing. */
#ifndef RAD_SCENE_SCENE_H
#define RAD_SCENE_SCENE_H

#include "base/error.h"
#include "base/progress.h"
#include "scene/deck.h"

struct rad_triangle {
  double v[3][3];   /* vertices [m], in deck order; equal vertices of the scene are bitwise equal */
  double normal[3]; /* unit normal of the radiating side */
  double area;      /* [m2] */
  int vertex[3]; /* scene vertex numbers: two triangles touch in a vertex iff a number is equal */
  int surface;   /* number of its surface */
  int n_grading, n_elements; /* as in the deck; 0 when not given */
  double grading[6];
  int elements[6];
  int line; /* in the deck, or in the mesh file for triangles from there; 0 if none */
};

/* How the radiation of a triangle was given. */
enum rad_heat_kind { RAD_HEAT_NONE /* rho and emission */, RAD_HEAT_TEMPERATURE, RAD_HEAT_FLUX };

struct rad_heat {
  enum rad_heat_kind kind;
  double emissivity;
  double temperature; /* [K], of RAD_HEAT_TEMPERATURE */
  double flux;        /* [W/m2], of RAD_HEAT_FLUX */
};

struct rad_visibility;

/* E at a point of a triangle [W/m2]; mu counts from vertex base, as in rad_patch. */
typedef double rad_emission_at(void *context, int triangle, int band, int base, const double mu[2]);

struct rad_scene {
  int n_triangle, n_vertex, n_surface, n_band;
  struct rad_triangle *triangle; /* owned [n_triangle] */
  double (*vertex)[3];           /* owned [n_vertex] */
  char **surface_name;           /* owned [n_surface] */
  char *band[RAD_MAX_BAND];      /* owned [n_band] */
  double *rho;                   /* owned [n_triangle, n_band] reflectivity */
  double *emission;              /* owned [n_triangle, 3, n_band] E at the vertices [W/m2] */
  struct rad_heat *heat;         /* owned [n_triangle], or NULL: RAD_HEAT_NONE everywhere */
  rad_emission_at *emission_at;  /* in place of emission, or NULL; asked by one thread at a time */
  void *emission_context;        /* borrowed */
  double size;                   /* diameter of the bounding box [m] */
  const struct rad_visibility *visibility; /* borrowed; NULL: shadows were not looked for */
  struct rad_progress *progress;           /* borrowed; NULL: none is shown */
};

/**
 * Build the scene of a deck and check it; a mesh file is read here, from the deck's folder.
 *
 * The deck's triangles come first, then those of the mesh, whose optics are those of
 * scene.surfaces and whose coordinates are scaled by scene.mesh.scale.
 * Vertices closer than 1e-10 of the scene's size are one vertex. `side: both` makes two triangles,
 * back to back, with consecutive numbers, the front first; a side that is not given is the front.
 * Normals are the geometric ones, also where the deck gives one. Refused: a degenerate triangle,
 * two triangles with the same vertices and the same normal, or of one plane with the same normal
 * and area in common, numbers that are not finite, rho
 * outside 0..1, a normal that is not perpendicular (1e-6), a triangle without rho or emission, or
 * with these and a temperature or flux, a surface that no triangle names. Warned: triangles that
 * cross, or touch other than in a vertex or a whole edge, and a flux on both sides of a sheet.
 *
 * @param[out] scene  to be freed with rad_scene_free, also after an error
 * @param[out] notes  warnings are appended
 * @return RAD_OK, RAD_EINPUT with the path of the deck or mesh and, if there is one, the line;
 *         RAD_ESYSTEM without memory, or if the mesh cannot be read. Cost n log n
 */
enum rad_code rad_scene_build(const struct rad_deck *deck, struct rad_scene *scene,
                              struct rad_notes *notes, struct rad_error *e);

void rad_scene_free(struct rad_scene *scene); /* safe twice */

#endif
