/* Scenes from a deck and a mesh file together: names, properties, order, messages. */
#include <check.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "scene/scene.h"
#include "suite.h"

static char folder[64];

static const char *path_of(const char *name) {
  static char path[4][100];
  static int k;
  k = (k + 1) % 4;
  snprintf(path[k], sizeof path[k], "%s/%s", folder, name);
  return path[k];
}

static void write_file(const char *name, const char *text) {
  FILE *f = fopen(path_of(name), "w");
  ck_assert_ptr_nonnull(f);
  ck_assert(fputs(text, f) >= 0);
  ck_assert_int_eq(fclose(f), 0);
}

static void make_folder(void) {
  snprintf(folder, sizeof folder, "/tmp/polyrad-mesh-%ld", (long)getpid());
  ck_assert_int_eq(mkdir(folder, 0700), 0);
}

static void remove_folder(void) {
  unlink(path_of("room.yml"));
  unlink(path_of("room.obj"));
  rmdir(folder);
}

struct built {
  struct rad_deck deck;
  struct rad_scene scene;
  struct rad_notes notes;
  struct rad_error e;
  enum rad_code code;
};

static struct built build(const char *deck, const char *obj) {
  struct built b = {0};
  write_file("room.yml", deck);
  if (obj)
    write_file("room.obj", obj);
  else
    unlink(path_of("room.obj"));
  b.code = rad_deck_read(path_of("room.yml"), 0, NULL, &b.deck, &b.e);
  ck_assert_msg(!b.code, "%s", b.e.text);
  b.code = rad_scene_build(&b.deck, &b.scene, &b.notes, &b.e);
  return b;
}

static void drop(struct built *b) {
  rad_scene_free(&b->scene);
  rad_notes_free(&b->notes);
  rad_deck_free(&b->deck);
}

/* Floor and lid of one metre, in millimetres; the lamp is a triangle by itself. */
#define OBJ                                                                                        \
  "v 0 0 0\nv 1000 0 0\nv 1000 1000 0\nv 0 1000 0\nv 0 0 1000\nv 1000 0 1000\nv 0 1000 1000\n"     \
  "usemtl floor\nf 1 2 3 4\nusemtl lamp\nf 5 7 6\n"
#define MESH "scene:\n  mesh: {file: room.obj, scale: 1e-3}\n"
#define FLOOR "    floor: {rho: 0.5, emission: 0}\n"
#define LAMP "    lamp: {rho: 0, emission: 12}\n"
#define SURFACES "  surfaces:\n"

START_TEST(mesh_alone) {
  struct built b = build(MESH SURFACES FLOOR LAMP, OBJ);
  ck_assert_msg(!b.code, "%s", b.e.text);
  const struct rad_scene *s = &b.scene;
  ck_assert_int_eq(s->n_triangle, 3);
  ck_assert_int_eq(s->n_vertex, 7);
  ck_assert_int_eq(s->n_surface, 2);
  ck_assert_str_eq(s->surface_name[0], "floor");
  ck_assert_str_eq(s->surface_name[1], "lamp");
  ck_assert(s->triangle[0].area == 0.5 && s->triangle[0].normal[2] == 1);
  ck_assert(s->triangle[1].line == 9 && s->triangle[2].line == 11);
  ck_assert(s->triangle[2].normal[2] == -1 && s->triangle[2].v[0][2] == 1e-3 * 1000);
  ck_assert(s->rho[0] == 0.5 && s->rho[2] == 0 && s->emission[6] == 12 && s->emission[0] == 0);
  ck_assert_int_eq(b.notes.n, 0);
  drop(&b);
}
END_TEST

/* Inline triangles come first, share names with the mesh, and weld with it. */
START_TEST(mesh_and_triangles) {
  struct built b = build(
      "bands: [a, b]\n" MESH
      "  triangles:\n"
      "    - {name: lamp, vertices: [[1,0,1],[0,1,1],[1,1,1]], side: back, rho: 1}\n"
      "    - {name: wall, vertices: [[0,0,0],[0,1,0],[0,0,1]], rho: 0, emission: 1}\n" SURFACES
      "    floor: {rho: [0.5, 0.25], emission: 0, side: both}\n"
      "    lamp: {rho: 0, emission: [3, 4]}\n",
      OBJ);
  ck_assert_msg(!b.code, "%s", b.e.text);
  const struct rad_scene *s = &b.scene;
  static const int surface[7] = {0, 1, 2, 2, 2, 2, 0};
  ck_assert_int_eq(s->n_triangle, 7);
  ck_assert_int_eq(s->n_surface, 3);
  ck_assert_int_eq(s->n_vertex, 8);
  for (int t = 0; t < 7; t++)
    ck_assert_int_eq(s->triangle[t].surface, surface[t]);
  for (int t = 2; t < 6; t++)
    ck_assert(s->triangle[t].normal[2] == (t % 2 ? -1 : 1) && s->rho[2 * t + 1] == 0.25);
  ck_assert(s->rho[0] == 1 && s->rho[12] == 0);              /* own before the surface's */
  ck_assert(s->emission[1] == 4 && s->emission[6 * 6] == 3); /* the surface's for both */
  ck_assert(s->triangle[0].line == 5 && s->triangle[6].line == 11);
  ck_assert_int_eq(b.notes.n, 0);
  drop(&b);
}
END_TEST

/* @ is the folder. */
static const struct {
  const char *deck, *obj;
  enum rad_code code;
  const char *message;
} bad[] = {
    {MESH SURFACES LAMP, OBJ, RAD_EINPUT,
     "@/room.obj:9: error: triangle 1 (floor): no rho; give scene.surfaces.floor.rho in "
     "@/room.yml"},
    {MESH SURFACES FLOOR "    lamp: {rho: 0}\n", OBJ, RAD_EINPUT,
     "@/room.obj:11: error: triangle 3 (lamp): no emission; give scene.surfaces.lamp.emission in "
     "@/room.yml"},
    {MESH, OBJ, RAD_EINPUT,
     "@/room.obj:9: error: triangle 1 (floor): no rho; give scene.surfaces.floor.rho in "
     "@/room.yml"},
    {MESH SURFACES FLOOR LAMP "    lmap: {rho: 0, emission: 0}\n", OBJ, RAD_EINPUT,
     "@/room.yml:6: error: scene.surfaces.lmap: no triangle has this name; did you mean 'lamp'? "
     "rename or remove it"},
    {MESH SURFACES FLOOR LAMP, NULL, RAD_ESYSTEM,
     "@/room.obj: error: cannot open the mesh (scene.mesh.file): No such file or directory; check "
     "its name and permissions"},
    {"scene: {mesh: {file: .}}\n", OBJ, RAD_ESYSTEM,
     "@/.: error: cannot read the mesh (scene.mesh.file): Is a directory; give a text file"},
    {"scene: {mesh: {file: /nonexistent/x.obj}}\n", OBJ, RAD_ESYSTEM,
     "/nonexistent/x.obj: error: cannot open the mesh (scene.mesh.file): No such file or "
     "directory; "
     "check its name and permissions"},
    {MESH SURFACES FLOOR, "v 0 0 0\nv 1 0 0\nf 1 2 3\n", RAD_EINPUT,
     "@/room.obj:3: error: there is no vertex 3, only 2 above this line; correct the number"},
    {"scene:\n  mesh: {file: room.obj, scale: 1e300}\n" SURFACES
     "    floor: {rho: 0, emission: 0}\n",
     "g floor\nv 0 0 0\nv 1e10 0 0\nv 0 1 0\nf 1 2 3\n", RAD_EINPUT,
     "@/room.obj:5: error: triangle 1 (floor): vertex 2 has a coordinate that is not finite; "
     "correct "
     "it"},
    {MESH SURFACES FLOOR, "g floor\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 1e-12 1e-12\nf 1 2 3\nf 1 3 4\n",
     RAD_EINPUT,
     "@/room.obj:7: error: triangle 2 (floor): degenerate: vertices 3 and 1 are equal to 1e-10 of "
     "the "
     "scene's size; move one or delete the triangle"},
    {MESH SURFACES FLOOR, "g floor\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 2 3 1\n", RAD_EINPUT,
     "@/room.obj:6: error: triangle 2 (floor): same vertices and same normal as triangle 1 "
     "(floor); "
     "delete one of them, or give them opposite normals to make a slit"},
};

static void expand(const char *text, char *out) {
  for (*out = '\0'; *text; text++)
    if (*text == '@')
      out += sprintf(out, "%s", folder);
    else
      *out++ = *text, *out = '\0';
}

START_TEST(refuses) {
  struct built b = build(bad[_i].deck, bad[_i].obj);
  char expected[700];
  ck_assert_msg(b.code == bad[_i].code, "code %d: %s", b.code, b.e.text);
  if (bad[_i].message) {
    expand(bad[_i].message, expected);
    ck_assert_str_eq(b.e.text, expected);
  }
  drop(&b);
}
END_TEST

/* Warnings name the mesh's lines. */
START_TEST(warns_of_contacts_in_the_mesh) {
  struct built b = build(MESH SURFACES "    floor: {rho: 0, emission: 0}\n",
                         "g floor\nv 0 0 0\nv 2 0 0\nv 0 2 0\nv 1 0 0\nv 1 0 1\nv 2 0 1\nf 1 2 3\n"
                         "f 4 5 6\n");
  ck_assert_msg(!b.code, "%s", b.e.text);
  ck_assert_int_eq(b.notes.n, 1);
  char expected[300];
  snprintf(expected, sizeof expected,
           "%s/room.obj:9: warning: triangle 2 (floor) touches triangle 1 (floor) other than in a "
           "vertex or a whole edge; divide them so that they share vertices and edges",
           folder);
  ck_assert_str_eq(b.notes.text[0], expected);
  drop(&b);
}
END_TEST

/* A box of 12 n^2 facets, closed: all vertices weld, nothing touches that should not. */
START_TEST(many_facets) {
  enum { N = 60 };
  char *text = malloc(6 * N * N * 300), *s = text;
  for (int f = 0; f < 6 * N * N; f++) {
    int axis = f / (N * N) / 2, far = f / (N * N) % 2, i = f / N % N, j = f % N;
    for (int k = 0; k < 4; k++) {
      int x[3], corner = far ? 3 - k : k;
      x[axis] = far * N;
      x[(axis + 1) % 3] = i + (corner == 1 || corner == 2);
      x[(axis + 2) % 3] = j + (corner >= 2);
      s += sprintf(s, "v %.15g %.15g %.15g\n", x[0] / 7.0, x[1] / 7.0, x[2] / 7.0);
    }
    s += sprintf(s, "f -4 -3 -2 -1\n");
  }
  struct built b = build(MESH SURFACES "    room: {rho: 0.5, emission: 1}\n", text);
  free(text);
  ck_assert_msg(!b.code, "%s", b.e.text);
  ck_assert_int_eq(b.scene.n_triangle, 12 * N * N);
  ck_assert_int_eq(b.scene.n_vertex, 6 * N * N + 2);
  ck_assert_int_eq(b.notes.n, 0);
  drop(&b);
}
END_TEST

int main(void) {
  Suite *suite = suite_create("scene mesh");
  TCase *mesh = tcase_create("mesh");
  tcase_add_checked_fixture(mesh, make_folder, remove_folder);
  tcase_add_test(mesh, mesh_alone);
  tcase_add_test(mesh, mesh_and_triangles);
  tcase_add_loop_test(mesh, refuses, 0, sizeof bad / sizeof *bad);
  tcase_add_test(mesh, warns_of_contacts_in_the_mesh);
  tcase_add_test(mesh, many_facets);
  tcase_set_timeout(mesh, 60);
  suite_add_tcase(suite, mesh);
  return run_suite(suite);
}
