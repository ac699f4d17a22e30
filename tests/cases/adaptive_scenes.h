/* The scenes on which adaptive runs are held to their tolerance: tests and benchmark. */
#ifndef POLYRAD_TEST_ADAPTIVE_SCENES_H
#define POLYRAD_TEST_ADAPTIVE_SCENES_H

#include "scene_text.h"

/* S1, S2, S2 exchanged, angles 10, 45, 90, 150, tetrahedron, cube, box 1:1:30. */
enum { N_ADAPTIVE_SCENE = 10 };

/* The deck of scene i, without `accuracy`; returns its name. */
const char *adaptive_scene(int i, struct deck_text *d);

/* Two squares with a triangle between them. */
void blocker_scene(struct deck_text *d);

extern const double face_s1[3][3][3];
void three_faces(struct deck_text *d, const double face[3][3][3], const double rho[3],
                 const double e[3]);

#endif
