/* The deck reader: every key, every default, and overrides. */
#include <check.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "deck_help.h"
#include "suite.h"

START_TEST(every_key_of_the_scene) {
  struct rad_deck d;
  read_good(full_deck, 0, NULL, &d);
  ck_assert_str_eq(d.path, deck_path);
  ck_assert_str_eq(d.text, full_deck);
  ck_assert_str_eq(d.title, "Every key");
  ck_assert_int_eq(d.n_band, 2);
  ck_assert_str_eq(d.band[1], "infrared");
  ck_assert_int_eq(d.n_triangle, 3);
  const struct rad_deck_triangle *t = d.triangle;
  ck_assert_str_eq(t[0].name, "floor");
  ck_assert_str_eq(t[1].name, "triangle_2");
  ck_assert_int_eq(t[0].line, 5);
  ck_assert_int_eq(t[1].line, 12);
  ck_assert(t[0].vertex[1][0] == 1 && t[0].vertex[2][1] == 1 && t[0].vertex[2][2] == -0.25);
  ck_assert_int_eq(t[0].optics.side, RAD_SIDE_NORMAL);
  ck_assert(t[0].optics.normal[2] == 2 && t[0].optics.normal[0] == 0);
  ck_assert_int_eq(t[1].optics.side, RAD_SIDE_BOTH);
  ck_assert_int_eq(t[2].optics.side, RAD_SIDE_UNSET);
  ck_assert(t[0].optics.has_rho && t[0].optics.rho[0] == 0.5 && t[0].optics.rho[1] == 0.5);
  ck_assert(t[1].optics.rho[0] == 0 && t[1].optics.rho[1] == 1);
  ck_assert(!t[2].optics.has_rho && !t[2].optics.has_emission);
  for (int v = 0; v < 3; v++)
    ck_assert(t[0].optics.emission[v][0] == 0.25 && t[0].optics.emission[v][1] == 4);
  ck_assert(t[1].optics.emission[0][1] == 1 && t[1].optics.emission[1][0] == 2);
  ck_assert(t[1].optics.emission[1][1] == 3 && t[1].optics.emission[2][0] == 0);
  ck_assert(t[0].n_grading == 3 && t[0].grading[2] == 3);
  ck_assert(t[1].n_grading == 3 && t[1].grading[0] == 2 && t[1].grading[2] == 2);
  ck_assert(t[2].n_grading == 6 && t[2].grading[5] == 8);
  ck_assert(t[0].n_elements == 6 && t[0].elements[5] == 6);
  ck_assert(t[1].n_elements == 1 && t[1].elements[0] == 7);
  ck_assert_int_eq(t[2].n_elements, 0);
  ck_assert_str_eq(d.mesh_file, "room.obj");
  ck_assert(d.mesh_scale == 1e-3);
  ck_assert_int_eq(d.n_surface, 2);
  ck_assert_str_eq(d.surface[0].name, "lamp");
  ck_assert(d.surface[0].optics.emission[2][1] == 12 && d.surface[0].optics.has_rho);
  ck_assert_int_eq(d.surface[0].optics.side, RAD_SIDE_FRONT);
  ck_assert_int_eq(d.surface[0].line, 23);
  ck_assert_int_eq(d.surface[1].optics.side, RAD_SIDE_BACK);
  ck_assert(!d.surface[1].optics.has_emission && d.surface[1].optics.rho[1] == 0.75);
  rad_deck_free(&d);
  rad_deck_free(&d);
}
END_TEST

START_TEST(every_key_of_the_other_sections) {
  struct rad_deck d;
  read_good(full_deck, 0, NULL, &d);
  ck_assert(d.tolerance == 1e-4);
  const struct rad_deck_method *m = &d.method;
  ck_assert_uint_eq(m->given, 8191);
  ck_assert_int_eq(m->mesh, RAD_MESH_GRADED);
  ck_assert_int_eq(m->elements, 16);
  ck_assert(m->grading == 3);
  ck_assert_int_eq(m->degree, 23);
  ck_assert_int_eq(m->angle, RAD_ANGLE_DUFFY);
  ck_assert_int_eq(m->constant_layers, 2);
  ck_assert(m->quadrature_tolerance == 1e-12 && m->solver_tolerance == 1e-16);
  ck_assert_int_eq(m->matrix, RAD_MATRIX_HIERARCHICAL);
  ck_assert_int_eq(m->solver, RAD_SOLVER_NEUMANN);
  ck_assert_int_eq(m->bounces, 0);
  ck_assert(m->ratio == 0.5 && m->nodes.kind == RAD_NODES_GAUSS);
  ck_assert_int_eq(d.n_probe, 2);
  ck_assert_str_eq(d.probe[0].name, "a");
  ck_assert_str_eq(d.probe[0].surface, "floor");
  ck_assert(d.probe[0].at[1] == 0.5);
  ck_assert_str_eq(d.probe[1].name, "probe_2");
  ck_assert_ptr_null(d.probe[1].surface);
  ck_assert_int_eq(d.probe[1].line, 42);
  ck_assert_str_eq(d.output.file, "corner.vtkhdf");
  ck_assert_int_eq(d.output.sampling, 64);
  ck_assert_uint_eq(d.output.fields, RAD_FIELD_IRRADIANCE);
  const struct rad_deck_study *s = &d.study;
  ck_assert(s->present && s->stability);
  ck_assert_int_eq(s->n_vary, 4);
  ck_assert_str_eq(s->vary[0].key, "method.elements");
  ck_assert_int_eq(s->vary[0].n, 3);
  ck_assert_str_eq(s->vary[0].value[2], "4");
  ck_assert_str_eq(s->vary[1].value[1], "[0, 1]");
  ck_assert_str_eq(s->vary[2].key, "scene.surfaces.wall.1.rho");
  ck_assert_str_eq(s->vary[3].value[0], "\"a, \\\"b\\\"\"");
  ck_assert_str_eq(s->vary[3].value[1], "plain text");
  ck_assert_int_eq(s->n_reference, 3);
  ck_assert_str_eq(s->reference[0].key, "method.degree");
  ck_assert_int_eq(s->reference[2].n, 1);
  ck_assert_str_eq(s->reference[2].value[0], "uniform");
  rad_deck_free(&d);
}
END_TEST

START_TEST(nodes) {
  struct rad_deck d;
  read_good(SCENE "method: {nodes: [.6, 0.8, 1], degree: 2, mesh: geometric}\n", 0, NULL, &d);
  ck_assert(d.method.mesh == RAD_MESH_GEOMETRIC && d.method.nodes.kind == RAD_NODES_LIST);
  ck_assert(d.method.nodes.n == 3 && d.method.nodes.at[1] == 0.8 && d.method.nodes.at[2] == 1);
  rad_deck_free(&d);
  read_good(SCENE "method: {nodes: vertex}\n", 0, NULL, &d);
  ck_assert(d.method.nodes.kind == RAD_NODES_VERTEX);
  rad_deck_free(&d);
}
END_TEST

START_TEST(defaults) {
  struct rad_deck d;
  read_good(SCENE
            "accuracy:   # an empty section counts as absent\nstudy: {vary: "
            "{method.degree: [0, 1]}, reference: last}\n",
            0, NULL, &d);
  ck_assert_str_eq(d.title, "");
  ck_assert_int_eq(d.n_band, 1);
  ck_assert_str_eq(d.band[0], "all");
  ck_assert_str_eq(d.triangle[0].name, "triangle_1");
  ck_assert_int_eq(d.triangle[0].n_grading, 0);
  ck_assert_ptr_null(d.mesh_file);
  ck_assert(d.mesh_scale == 1 && d.tolerance == 0);
  const struct rad_deck_method *m = &d.method;
  ck_assert_uint_eq(m->given, 0);
  ck_assert(m->mesh == RAD_MESH_PAPER && m->elements == 8 && m->grading == 1 && m->degree == 1);
  ck_assert(m->angle == RAD_ANGLE_POLAR && m->constant_layers == 0 && m->bounces == 10);
  ck_assert(m->matrix == RAD_MATRIX_AUTO && m->solver == RAD_SOLVER_AUTO);
  ck_assert(m->quadrature_tolerance == 1e-10 && m->solver_tolerance == 1e-12);
  ck_assert(m->ratio == 0.15 && m->nodes.kind == RAD_NODES_GAUSS);
  ck_assert_int_eq(d.n_probe, 0);
  char file[80];
  snprintf(file, sizeof file, "polyrad-deck-%ld.vtkhdf", (long)getpid());
  ck_assert_str_eq(d.output.file, file);
  ck_assert_int_eq(d.output.sampling, 4);
  ck_assert_uint_eq(d.output.fields, 0);
  ck_assert(d.study.present && d.study.n_reference == 0 && !d.study.stability);
  rad_deck_free(&d);
}
END_TEST

/* Ends of ranges are allowed, a byte-order mark and DOS line ends are read over. */
static const char *const also_good[] = {
    "\xEF\xBB\xBF" SCENE,
    "title: DOS\r\n" SCENE,
    "---\n" SCENE "...\n",
    "scene: {mesh: {file: a.obj}}\n",
    SCENE "method: {solver: neumann, bounces: 100000}\n",
    SCENE "method: {quadrature_tolerance: 1e-15, solver_tolerance: 1d-1, elements: 4096}\n",
    SCENE "method: {mesh: graded, grading: 8, degree: 0}\n",
    SCENE "method: {mesh: paper, grading: 1.5}\n",
    SCENE "method: {elements: 8.0}\n",
    SCENE "probes: []\n",
    SCENE "title: a\t# tabs between words\tand in comments\n",
    "title: \xC3\x9C\xE2\x82\xAC\xF0\x9F\x98\x80\n" SCENE,
    "bands: [a]\n" SCENE "study: {vary: {bands: [[a], [a, b]]}}\n",
    SCENE "study: {vary: {method.solver: [neumann], method.bounces: [1, 2]}}\n",
    /* the reference starts from the deck, not from the last run */
    SCENE
    "study: {vary: {method.solver: [neumann], method.bounces: [1]}, reference: {solver: lu}}\n",
};

START_TEST(also_accepted) {
  struct rad_deck d;
  read_good(also_good[_i], 0, NULL, &d);
  rad_deck_free(&d);
}
END_TEST

START_TEST(overrides) {
  static const char *const set[] = {"method.elements=4",
                                    "method.elements=16",
                                    "scene.triangles.0.rho=0.25",
                                    "scene.surfaces.wall.1.rho=[0.125]",
                                    "accuracy.tolerance=1d-3",
                                    "output={sampling: 2}",
                                    "study.vary.method.degree=[0, 1]",
                                    "title=a: b = c"};
  static const char *const quoted = "title=\"a: b = c\"";
  const char *all[COUNT(set)];
  memcpy(all, set, sizeof set);
  all[COUNT(set) - 1] = quoted;
  struct rad_deck d;
  read_good("scene: {triangles: [" TRIANGLE
            "], surfaces: {wall: {rho: 0}, wall.1: {rho: 1}}}\n"
            "accuracy:\n",
            COUNT(all), all, &d);
  ck_assert_int_eq(d.method.elements, 16);
  ck_assert_uint_eq(d.method.given, RAD_GIVEN_ELEMENTS);
  ck_assert(d.triangle[0].optics.rho[0] == 0.25);
  ck_assert(d.surface[0].optics.rho[0] == 0 && d.surface[1].optics.rho[0] == 0.125);
  ck_assert(d.tolerance == 1e-3);
  ck_assert_int_eq(d.output.sampling, 2);
  ck_assert_str_eq(d.study.vary[0].key, "method.degree");
  ck_assert_str_eq(d.title, "a: b = c");
  ck_assert_int_eq(d.n_triangle, 1);
  rad_deck_free(&d);
}
END_TEST

/* A study's texts mean as overrides what they meant in the deck. */
START_TEST(study_values_as_overrides) {
  static const char text[] =
      SCENE "study: {vary: {title: ['a, \"b\"', plain text, \"\\u2028\\U0001F600\\\\ #\", '8']}}\n";
  static const char *const title[] = {"a, \"b\"", "plain text", "\xE2\x80\xA8\xF0\x9F\x98\x80\\ #",
                                      "8"};
  struct rad_deck d;
  read_good(text, 0, NULL, &d);
  ck_assert_int_eq(d.study.vary[0].n, COUNT(title));
  for (int i = 0; i < COUNT(title); i++) {
    char set[200];
    snprintf(set, sizeof set, "title=%s", d.study.vary[0].value[i]);
    const char *one = set;
    struct rad_deck run;
    read_good(text, 1, &one, &run);
    ck_assert_str_eq(run.title, title[i]);
    rad_deck_free(&run);
  }
  rad_deck_free(&d);
}
END_TEST

int main(void) {
  Suite *suite = suite_create("deck");
  TCase *good = tcase_create("good");
  tcase_add_test(good, every_key_of_the_scene);
  tcase_add_test(good, every_key_of_the_other_sections);
  tcase_add_test(good, nodes);
  tcase_add_test(good, defaults);
  tcase_add_loop_test(good, also_accepted, 0, COUNT(also_good));
  tcase_add_test(good, overrides);
  tcase_add_test(good, study_values_as_overrides);
  suite_add_tcase(suite, good);
  return run_suite(suite);
}
