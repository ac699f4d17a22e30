/* Exponents of the solution at edges and vertices: u = c + C s^beta at distance s from an edge and
 * u = c + C r^alpha v(phi) at distance r from a vertex (theory, section 5). */
#ifndef RAD_MESH_EXPONENTS_H
#define RAD_MESH_EXPONENTS_H

#include "base/gauss.h"
#include "scene/scene.h"

/**
 * The exponent beta in (0, 1) at an edge of two faces: sqrt(rho1 rho2) M(beta) = 1,
 *
 *   M(beta) = (sin^2 gamma / 2) int_0^inf t^(1+beta) (1 + t^2 - 2 t cos gamma)^(-3/2) dt
 *           = z pi beta (1+beta) / sin(pi beta) F(-beta, 1+beta; 2; z),  z = cos^2(gamma/2)
 *
 * M grows from z at 0 to infinity at 1: there is exactly one root as soon as the faces see each
 * other and neither is black. Good to 1e-14 relative, at small beta too, and 1 - beta to rounding
 * of beta, at all angles; about a microsecond.
 *
 * @param[in] rho1, rho2  reflectivities, 0..1
 * @param[in] gamma       dihedral angle on the radiating side [rad]
 * @return beta, or INFINITY if a face is black, gamma is not in (0, pi), or beta rounds to 1
 */
double rad_edge_exponent(double rho1, double rho2, double gamma);

/* A face of the cone that touches the scene at a vertex: a plane sector. */
struct rad_cone_face {
  double edge[2][3]; /* unit vectors along its two edges, away from the vertex, < 180 degrees */
  double normal[3];  /* unit normal of the radiating side, perpendicular to both */
  double rho;        /* reflectivity */
};

/**
 * The exponent alpha in (0, 1) at a vertex: the cone operator K_alpha has spectral radius 1,
 *
 *   (K_alpha v)(phi) = (rho / pi) sum_faces int a(phi') b(phi) I_alpha(omega) v(phi') dphi'
 *   I_alpha(omega) = int_0^inf nu^(2+alpha) (1 + nu^2 - 2 nu cos omega)^(-2) dnu
 *                  = pi [(2+alpha) sin(alpha q) - alpha sin((2+alpha) q)]
 *                    / (4 sin(alpha pi) sin^3 q),  q = pi - omega
 *
 * with a and b of [H, (2.18), (2.19)], each 0 where negative: a face reaches behind the other.
 *
 * Range. The integral exists for -3 < alpha < 1. It grows with alpha > -1 and tends to infinity at
 * 1, as the far field weighs ever more, hence so does the spectral radius. At 0 it is below 1,
 * since K_0 1 is the view factor of the cone, unless faces hide each other. So every cone in which
 * two faces with rho > 0 see each other has exactly one alpha in (0, 1).
 *
 * Edges. At an edge K_alpha is, to leading order, the edge operator of M, for any alpha. Its
 * essential spectrum reaches up to sqrt(rho1 rho2) M(0) = sqrt(rho1 rho2) (1 + cos gamma)/2 < 1
 * for continuous v (lower in L2, M is least at -1/2). So at alpha, where the spectral radius is 1,
 * an eigenvalue sets it, never the edges, and its v is c + C phi^beta with the edge's own beta. A
 * point within an edge is a cone of two half planes, where c = 0 and alpha = beta: the exponent of
 * a vertex with two edges on one line and nothing else.
 *
 * Visibility within the cone is ignored: faces count as seen if they are in front of each other.
 * A face hidden by a third one, possible where the cone is not convex, makes alpha too small,
 * which asks for more grading than needed.
 *
 * @param[in]  g       Gauss points
 * @param[in]  face    [n_face] any order; fewer than two or not facing each other is fine
 * @param[out] alpha   error below 1e-7 in cube corners and the like, 1e-5 with mirrors (rho = 1) at
 *                     10 degrees and with more than 16 faces. INFINITY if no two faces with
 *                     rho > 0 see each other or alpha > 1 - 1e-9; 0 if the spectral radius is 1
 *                     already at 0, which needs faces that hide each other
 * @return RAD_OK, RAD_ESYSTEM without memory
 */
enum rad_code rad_vertex_exponent(const struct rad_gauss *g, int n_face,
                                  const struct rad_cone_face *face, double *alpha,
                                  struct rad_error *e);

/* Exponents of all triangles of a scene; INFINITY where there is no singularity. */
struct rad_exponents {
  int n_triangle;
  double (*beta)[3];  /* owned [n_triangle] edges v0v1, v1v2, v2v0 */
  double (*alpha)[3]; /* owned [n_triangle] vertices v0, v1, v2 */
};

/**
 * Exponents of a scene: the least over its bands.
 *
 * Edges and vertices are equal by their numbers. Of several triangles at one edge only the next
 * one in front counts, as it hides the others. beta is INFINITY at an edge without a facing
 * neighbour, with a coplanar one, or if either face is black. alpha belongs to the scene's vertex
 * and is the same for all its triangles, save those black in every band: they have none. Vertices
 * whose faces are all in one plane are skipped. Linear in the number of triangles, but for a sort;
 * some milliseconds for each vertex that is not skipped, shared among the threads.
 *
 * @param[out] x  to be freed with rad_exponents_free, also after an error
 * @return RAD_OK, RAD_ESYSTEM without memory
 */
enum rad_code rad_scene_exponents(const struct rad_scene *scene, struct rad_exponents *x,
                                  struct rad_error *e);

void rad_exponents_free(struct rad_exponents *x); /* safe twice */

#endif
