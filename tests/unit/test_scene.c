/* Scenes from decks: sides, optics, welding, areas, and refusals. */
#include <check.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/vec.h"
#include "scene_help.h"
#include "suite.h"

static const double RAISED[3][3] = {{0, 0, 2}, {3, 0, 2}, {0, 4, 2}};

/* Build, expect a refusal with exactly this text, and free everything. */
static void refused(struct rad_deck *deck, const char *text) {
  struct built b = build(deck);
  ck_assert_int_eq(b.code, RAD_EINPUT);
  ck_assert_str_eq(b.error.text, text);
  drop(&b, deck);
}

/* --- what a scene holds --- */

START_TEST(copies_a_triangle) {
  struct rad_deck deck = {0};
  struct rad_deck_triangle *t = add(&deck, "floor", RAISED);
  t->n_grading = 3;
  t->grading[2] = 2.5;
  t->n_elements = 1;
  t->elements[0] = 7;
  t->optics.emission[2][0] = 3;
  struct built b = build_well(&deck);
  const struct rad_scene *s = &b.scene;
  ck_assert_int_eq(s->n_triangle, 1);
  ck_assert_int_eq(s->n_vertex, 3);
  ck_assert_int_eq(s->n_surface, 1);
  ck_assert_int_eq(s->n_band, 1);
  ck_assert_str_eq(s->surface_name[0], "floor");
  ck_assert_str_eq(s->band[0], "all");
  ck_assert(s->size == 5 && s->triangle[0].area == 6);
  const double up[3] = {0, 0, 1};
  ck_assert_mem_eq(s->triangle[0].normal, up, sizeof up);
  ck_assert_mem_eq(s->triangle[0].v, RAISED, sizeof RAISED);
  ck_assert(s->triangle[0].n_grading == 3 && s->triangle[0].grading[2] == 2.5);
  ck_assert(s->triangle[0].n_elements == 1 && s->triangle[0].elements[0] == 7);
  ck_assert_int_eq(s->triangle[0].line, 10);
  ck_assert(s->rho[0] == 0.5 && s->emission[0] == 1 && s->emission[2] == 3);
  ck_assert_int_eq(b.notes.n, 0);
  drop(&b, &deck);
}
END_TEST

START_TEST(turns_normals_by_side) {
  struct rad_deck deck = {0};
  static const enum rad_side side[5] = {RAD_SIDE_UNSET, RAD_SIDE_FRONT, RAD_SIDE_BACK,
                                        RAD_SIDE_NORMAL, RAD_SIDE_NORMAL};
  static const double expected[5] = {1, 1, -1, 1, -1};
  for (int k = 0; k < 5; k++) {
    double v[3][3];
    memcpy(v, UNIT, sizeof v);
    for (int m = 0; m < 3; m++)
      v[m][2] = k;
    struct rad_deck_triangle *t = add(&deck, "plate", v);
    t->optics.side = side[k];
    t->optics.normal[2] = k == 3 ? 1e-200 : -1e200; /* any length */
  }
  struct built b = build_well(&deck);
  for (int k = 0; k < 5; k++) {
    const double normal[3] = {0, 0, expected[k]};
    ck_assert_mem_eq(b.scene.triangle[k].normal, normal, sizeof normal); /* no -0 either */
  }
  drop(&b, &deck);
}
END_TEST

START_TEST(makes_twins_of_both_sides) {
  struct rad_deck deck = {0};
  add(&deck, "floor", RAISED);
  struct rad_deck_triangle *t = add(&deck, "fin", UNIT);
  t->optics.side = RAD_SIDE_BOTH;
  t->optics.rho[0] = 0.25;
  t->optics.emission[1][0] = 9;
  add(&deck, "floor", (double[3][3]){{5, 0, 0}, {6, 0, 0}, {5, 1, 0}});
  struct built b = build_well(&deck);
  const struct rad_triangle *front = &b.scene.triangle[1], *back = &b.scene.triangle[2];
  ck_assert_int_eq(b.scene.n_triangle, 4);
  ck_assert_int_eq(b.scene.n_vertex, 9);
  ck_assert(front->normal[2] == 1 && back->normal[2] == -1);
  ck_assert_mem_eq(front->vertex, back->vertex, sizeof front->vertex);
  ck_assert_mem_eq(front->v, back->v, sizeof front->v);
  ck_assert(b.scene.rho[1] == 0.25 && b.scene.rho[2] == 0.25 && b.scene.rho[3] == 0.5);
  ck_assert(b.scene.emission[4] == 9 && b.scene.emission[7] == 9);
  ck_assert(b.scene.triangle[3].surface == 0 && back->surface == 1);
  ck_assert_int_eq(b.notes.n, 0);
  drop(&b, &deck);
}
END_TEST

START_TEST(own_optics_win_over_the_surface) {
  struct rad_deck deck = {0};
  double high[3][3];
  memcpy(high, RAISED, sizeof high);
  for (int m = 0; m < 3; m++)
    high[m][2] = 5;
  struct rad_deck_triangle *own = add(&deck, "lamp", UNIT);
  own->optics.rho[1] = 0.125;
  own->optics.has_emission = false;
  own->optics.side = RAD_SIDE_FRONT;
  add(&deck, "wall", high)->optics.emission[0][1] = 7;
  struct rad_deck_triangle *shared = add(&deck, "lamp", RAISED);
  shared->optics.has_rho = shared->optics.has_emission = false;
  struct rad_deck_surface lamp = {.name = "lamp", .line = 30};
  lamp.optics.has_rho = lamp.optics.has_emission = true;
  lamp.optics.rho[0] = 0.75;
  lamp.optics.emission[1][1] = 12;
  lamp.optics.side = RAD_SIDE_BACK;
  deck.n_surface = 1;
  deck.surface = &lamp;
  deck.n_band = 2;
  deck.band[1] = "infrared";
  struct built b = build_well(&deck);
  const struct rad_scene *s = &b.scene;
  ck_assert_int_eq(s->n_surface, 2);
  ck_assert_str_eq(s->surface_name[1], "wall");
  ck_assert_str_eq(s->band[1], "infrared");
  ck_assert(s->rho[0] == 0.5 && s->rho[1] == 0.125); /* [triangle, band] */
  ck_assert(s->rho[4] == 0.75 && s->rho[5] == 0);
  ck_assert(s->emission[0] == 0 && s->emission[3] == 12); /* [triangle, vertex, band] */
  ck_assert(s->emission[6 + 1] == 7 && s->emission[12 + 3] == 12);
  ck_assert(s->triangle[0].normal[2] == 1 && s->triangle[2].normal[2] == -1);
  drop(&b, &deck);
}
END_TEST

/* Height 2^-27 * (1 + ...) over an edge of length sqrt(2): the plain cross product of the edges
 * from the first vertex is wrong in its fourth digit. Exactly: (1 + a)(1 - a + b) - 1 = b - a^2 + a
 * b. */
START_TEST(area_of_a_thin_triangle_is_accurate) {
  const double a = 0x1p-27, b = 0x1p-43, area = (b - a * a + a * b) / 2;
  for (int first = 0; first < 3; first++) {
    const double corner[3][3] = {{0, 0, 0}, {1 + a, 1, 0}, {1, 1 - a + b, 0}};
    double v[3][3];
    for (int m = 0; m < 3; m++)
      memcpy(v[m], corner[(first + m) % 3], sizeof v[m]);
    struct rad_deck deck = {0};
    add(&deck, "sliver", v);
    struct built built = build_well(&deck);
    ck_assert_double_eq_tol(built.scene.triangle[0].area, area, 4 * DBL_EPSILON * area);
    ck_assert(built.scene.triangle[0].normal[2] == 1);
    drop(&built, &deck);
  }
}
END_TEST

/* Copies of a random mesh's vertices, each moved by less than half the welding distance, become one
 * vertex each with equal bits; vertices three welding distances apart stay two. */
START_TEST(welds_close_vertices) {
  enum { N_POINT = 200, N_TRIANGLE = 600 };
  start_random();
  struct rad_deck deck = {0};
  double point[N_POINT][3], size = sqrt(3.0); /* of the box; the first two points span it */
  int corner[N_TRIANGLE][3], met[N_POINT];
  for (int p = 0; p < N_POINT; p++)
    for (int m = 0; m < 3; m++) {
      point[p][m] = p < 2 ? p : uniform(0.001, 0.999);
      met[p] = -1;
    }
  for (int m = 0; m < 3; m++) /* two that must not weld */
    point[3][m] = point[2][m] + (m == 1 ? 3e-10 * size : 0);
  for (int t = 0; t < N_TRIANGLE; t++) {
    double v[3][3];
    for (int m = 0; m < 3; m++) {
      corner[t][m] = 4 + (t * 3 + m * (1 + t % 60)) % (N_POINT - 4);
      if (m == 0 && t < 8)
        corner[t][m] = t % 4;
      for (int d = 0; d < 3; d++)
        v[m][d] = point[corner[t][m]][d] + uniform(-0.28e-10, 0.28e-10) * size;
    }
    add(&deck, "cloud", v);
  }
  struct built b = build_well(&deck);
  int n_met = 0;
  for (int t = 0; t < N_TRIANGLE; t++)
    for (int m = 0; m < 3; m++) {
      int *number = &met[corner[t][m]], got = b.scene.triangle[t].vertex[m];
      if (*number < 0) {
        n_met++;
        *number = got;
      }
      ck_assert_msg(*number == got, "triangle %d corner %d: vertex %d, not %d", t, m, got, *number);
      ck_assert_mem_eq(b.scene.triangle[t].v[m], b.scene.vertex[got], 3 * sizeof(double));
      for (int d = 0; d < 3; d++)
        ck_assert(fabs(b.scene.vertex[got][d] - point[corner[t][m]][d]) < 0.3e-10 * size);
    }
  ck_assert_int_eq(b.scene.n_vertex, n_met);
  ck_assert_int_eq(n_met, N_POINT);
  ck_assert_int_ne(met[2], met[3]);
  drop(&b, &deck);
}
END_TEST

/* Both sides of the limit, in all directions and places relative to the grid of the welding. */
START_TEST(welds_up_to_the_limit) {
  start_random();
  for (int k = 0; k < 500; k++) {
    double direction[3], shift[3];
    for (int m = 0; m < 3; m++) {
      direction[m] = uniform(-1, 1);
      shift[m] = uniform(0.2, 0.8);
    }
    double length = rad_norm(direction), limit = 1e-10 * sqrt(3.0);
    double gap = limit * (k % 2 ? 0.999 : 1.001);
    double far[3][3] = {{0, 0, 0}, {0, 0, 1}, {1, 1, 1}}, a[3][3], b[3][3];
    for (int m = 0; m < 3; m++)
      for (int d = 0; d < 3; d++) {
        a[m][d] = shift[d] + (m && m - 1 == d ? 0.1 : 0);
        b[m][d] = m ? a[m][d] - 0.2 * (m - 1 == d) : a[0][d] + gap * direction[d] / length;
      }
    struct rad_deck deck = {0};
    add(&deck, "far", far);
    add(&deck, "a", a);
    add(&deck, "b", b);
    struct built built = build_well(&deck);
    ck_assert_msg(built.scene.n_vertex == (k % 2 ? 8 : 9), "gap %g limits: %d vertices",
                  gap / limit, built.scene.n_vertex);
    drop(&built, &deck);
  }
}
END_TEST

/* --- refusals --- */

START_TEST(refuses_a_deck_without_triangles) {
  struct rad_deck deck = {.path = "room.yml", .n_band = 1};
  refused(&deck, "room.yml: error: the scene is empty; give scene.triangles or scene.mesh");
}
END_TEST

START_TEST(refuses_missing_optics) {
  struct rad_deck deck = {0};
  add(&deck, "floor", UNIT);
  add(&deck, "lid", RAISED)->optics.has_rho = false;
  refused(&deck,
          "room.yml:11: error: triangle 2 (lid): no rho; give rho here or in "
          "scene.surfaces.lid");
  add(&deck, "floor", UNIT)->optics.has_emission = false;
  refused(&deck,
          "room.yml:10: error: triangle 1 (floor): no emission; give emission here or in "
          "scene.surfaces.floor");
}
END_TEST

/* --- heat radiation --- */

static void heat_surface(struct rad_deck *deck, struct rad_deck_surface *surface) {
  *surface = (struct rad_deck_surface){
      .name = "lid",
      .line = 30,
      .optics = {
          .has_emissivity = true, .emissivity = 0.25, .has_temperature = true, .temperature = 100}};
  deck->n_surface = 1;
  deck->surface = surface;
}

START_TEST(heat_of_triangles_and_surfaces) {
  struct rad_deck deck = {0};
  struct rad_deck_surface surface;
  add(&deck, "floor", UNIT);
  for (int k = 0; k < 3; k++) {
    double v[3][3];
    memcpy(v, RAISED, sizeof v);
    for (int m = 0; m < 3; m++)
      v[m][2] += k;
    struct rad_deck_optics *o = &add(&deck, "lid", v)->optics;
    *o = (struct rad_deck_optics){.has_temperature = k == 1,
                                  .temperature = 200,
                                  .has_flux = k == 2,
                                  .flux = -3,
                                  .has_emissivity = k == 2,
                                  .emissivity = 1};
  }
  heat_surface(&deck, &surface);
  struct built b = build_well(&deck);
  const struct rad_scene *s = &b.scene;
  static const enum rad_heat_kind kind[4] = {RAD_HEAT_NONE, RAD_HEAT_TEMPERATURE,
                                             RAD_HEAT_TEMPERATURE, RAD_HEAT_FLUX};
  /* 0.25 sigma 100^4 and 200^4, sigma = 5.670374419184429e-8 */
  static const double rho[4] = {0.5, 0.75, 0.75, 1},
                      e[4] = {1, 1.41759360479610725, 22.681497676737716, -3};
  for (int t = 0; t < 4; t++) {
    ck_assert_int_eq(s->heat[t].kind, kind[t]);
    ck_assert_double_eq(s->rho[t], rho[t]);
    for (int m = 0; m < 3; m++)
      ck_assert_double_eq_tol(s->emission[3 * t + m], e[t], 1e-14);
  }
  drop(&b, &deck);
}
END_TEST

START_TEST(refuses_heat_that_is_not_whole) {
  struct rad_deck deck = {0};
  struct rad_deck_surface surface;
  heat_surface(&deck, &surface);
  add(&deck, "lid", UNIT)->optics.has_emission = false;
  refused(&deck,
          "room.yml:10: error: triangle 1 (lid): 'rho' here and 'temperature' in "
          "scene.surfaces.lid exclude each other; give rho and emission, or emissivity and "
          "temperature, or emissivity and flux");
  heat_surface(&deck, &surface);
  add(&deck, "lid", UNIT)->optics.has_rho = false;
  refused(&deck,
          "room.yml:10: error: triangle 1 (lid): 'emission' here and 'emissivity' in "
          "scene.surfaces.lid exclude each other; give rho and emission, or emissivity and "
          "temperature, or emissivity and flux");
  add(&deck, "lid", UNIT)->optics =
      (struct rad_deck_optics){.has_flux = true, .has_emissivity = true};
  refused(&deck,
          "room.yml:10: error: triangle 1 (lid): emissivity is 0, so no temperature can give its "
          "flux; give a number above 0, at most 1");
  add(&deck, "lid", UNIT)->optics = (struct rad_deck_optics){.has_flux = true};
  refused(&deck,
          "room.yml:10: error: triangle 1 (lid): no emissivity; give emissivity here or in "
          "scene.surfaces.lid");
  add(&deck, "lid", UNIT)->optics = (struct rad_deck_optics){.has_emissivity = true};
  refused(&deck,
          "room.yml:10: error: triangle 1 (lid): no temperature (or flux); give temperature here "
          "or in scene.surfaces.lid");
}
END_TEST

START_TEST(refuses_an_unused_surface) {
  struct rad_deck deck = {0};
  struct rad_deck_surface surface[2] = {{.name = "lamp", .line = 30}, {.name = "flor", .line = 31}};
  add(&deck, "ceiling", UNIT);
  add(&deck, "floor", RAISED);
  add(&deck, "lamp", (double[3][3]){{5, 0, 0}, {6, 0, 0}, {5, 1, 0}});
  deck.n_surface = 2;
  deck.surface = surface;
  refused(&deck,
          "room.yml:31: error: scene.surfaces.flor: no triangle has this name; did you mean "
          "'floor'? rename or remove it");
}
END_TEST

START_TEST(refuses_bad_numbers) {
  struct rad_deck deck = {0};
  add(&deck, "floor", UNIT);
  add(&deck, "lid", RAISED)->vertex[1][2] = NAN;
  refused(&deck,
          "room.yml:11: error: triangle 2 (lid): vertex 2 has a coordinate that is not "
          "finite; correct it");
  add(&deck, "floor", UNIT)->optics.rho[0] = 1.5;
  refused(&deck,
          "room.yml:10: error: triangle 1 (floor): rho is 1.5 in band all; give a number "
          "from 0 to 1");
  add(&deck, "floor", UNIT)->optics.rho[0] = NAN;
  refused(&deck,
          "room.yml:10: error: triangle 1 (floor): rho is nan in band all; give a number "
          "from 0 to 1");
  struct rad_deck_triangle *t = add(&deck, "floor", UNIT);
  t->optics.emission[2][0] = INFINITY;
  t->line = 0;
  refused(&deck,
          "room.yml: error: triangle 1 (floor): emission is not finite in band all; "
          "correct it");
  add(&deck, "floor", UNIT)->vertex[1][0] = 1e200;
  refused(&deck,
          "room.yml: error: the bounding box of the scene has diameter 1e+200; give lengths "
          "in a unit that makes it 1e-60 to 1e+60");
}
END_TEST

START_TEST(refuses_degenerate_triangles) {
  struct rad_deck deck = {0};
  double v[3][3] = {{0, 0, 0}, {1, 0, 0}, {0.5, 1.9e-14, 0}};
  add(&deck, "floor", RAISED);
  add(&deck, "line", v);
  refused(&deck,
          "room.yml:11: error: triangle 2 (line): degenerate: its vertices lie on a line "
          "(area 9.5e-15, longest edge 1); move one or delete the triangle");
  v[2][1] = 2.1e-14;
  add(&deck, "thin", v);
  struct built b = build_well(&deck);
  drop(&b, &deck);
  v[2][0] = 1 + 4e-10; /* welds with its neighbour: the scene's size is 5 */
  add(&deck, "floor", RAISED);
  add(&deck, "line", v);
  refused(&deck,
          "room.yml:11: error: triangle 2 (line): degenerate: vertices 2 and 3 are equal to "
          "1e-10 of the scene's size; move one or delete the triangle");
}
END_TEST

START_TEST(refuses_normals_that_are_not_perpendicular) {
  struct rad_deck deck = {0};
  for (int k = 0; k < 4; k++) { /* tilted along x, y, up and down */
    for (int allowed = 0; allowed < 2; allowed++) {
      struct rad_deck_triangle *t = add(&deck, "floor", UNIT);
      t->optics.side = RAD_SIDE_NORMAL;
      t->optics.normal[k % 2] = 3 * (allowed ? 0.99e-6 : 1.01e-6);
      t->optics.normal[2] = k < 2 ? 3 : -3;
      struct built b = build(&deck);
      ck_assert_int_eq(b.code, allowed ? RAD_OK : RAD_EINPUT);
      if (allowed) /* exactly the geometric normal */
        ck_assert(b.scene.triangle[0].normal[2] == (k < 2 ? 1 : -1) &&
                  b.scene.triangle[0].normal[k % 2] == 0);
      drop(&b, &deck);
    }
  }
  struct rad_deck_triangle *t = add(&deck, "floor", UNIT);
  t->optics.side = RAD_SIDE_NORMAL;
  t->optics.normal[1] = t->optics.normal[2] = -1;
  refused(&deck,
          "room.yml:10: error: triangle 1 (floor): normal [0, -1, -1] is 45 degrees off the "
          "perpendicular; give [0, 0, -1], or side: front or back");
  add(&deck, "floor", UNIT)->optics.side = RAD_SIDE_NORMAL;
  refused(&deck,
          "room.yml:10: error: triangle 1 (floor): normal [0, 0, 0] has no direction; give "
          "three finite numbers that are not all zero, or side: front or back");
  t = add(&deck, "floor", UNIT);
  t->optics.side = RAD_SIDE_NORMAL;
  t->optics.normal[0] = NAN;
  t->optics.normal[2] = 1;
  refused(&deck,
          "room.yml:10: error: triangle 1 (floor): normal [nan, 0, 1] has no direction; give "
          "three finite numbers that are not all zero, or side: front or back");
}
END_TEST

START_TEST(refuses_duplicates_and_allows_slits) {
  const double turned[3][3] = {{0, 1, 0}, {0, 0, 0}, {1, 0, 0}};
  const double mirrored[3][3] = {{1, 0, 0}, {0, 0, 0}, {0, 1, 0}};
  struct rad_deck deck = {0};
  add(&deck, "floor", UNIT);
  add(&deck, "lid", RAISED);
  add(&deck, "copy", turned);
  refused(&deck,
          "room.yml:12: error: triangle 3 (copy): same vertices and same normal as triangle "
          "1 (floor); delete one of them, or give them opposite normals to make a slit");
  add(&deck, "floor", UNIT);
  add(&deck, "under", mirrored);
  struct built b = build_well(&deck);
  ck_assert_int_eq(b.notes.n, 0);
  drop(&b, &deck);
  add(&deck, "floor", UNIT);
  add(&deck, "copy", mirrored)->optics.side = RAD_SIDE_BACK;
  refused(&deck,
          "room.yml:11: error: triangle 2 (copy): same vertices and same normal as triangle "
          "1 (floor); delete one of them, or give them opposite normals to make a slit");
  add(&deck, "floor", UNIT);
  add(&deck, "under", mirrored);
  add(&deck, "copy", turned);
  refused(&deck,
          "room.yml:12: error: triangle 3 (copy): same vertices and same normal as triangle "
          "1 (floor); delete one of them, or give them opposite normals to make a slit");
  add(&deck, "slit", UNIT)->optics.side = RAD_SIDE_BOTH;
  add(&deck, "copy", mirrored);
  refused(&deck,
          "room.yml:11: error: triangle 2 (copy): same vertices and same normal as triangle "
          "1 (slit); delete one of them, or give them opposite normals to make a slit");
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", seed());
  Suite *suite = suite_create("scene");
  TCase *holds = tcase_create("holds"), *refuses = tcase_create("refuses");
  tcase_add_test(holds, copies_a_triangle);
  tcase_add_test(holds, turns_normals_by_side);
  tcase_add_test(holds, makes_twins_of_both_sides);
  tcase_add_test(holds, own_optics_win_over_the_surface);
  tcase_add_test(holds, area_of_a_thin_triangle_is_accurate);
  tcase_add_test(holds, welds_close_vertices);
  tcase_add_test(holds, welds_up_to_the_limit);
  tcase_add_test(refuses, refuses_a_deck_without_triangles);
  tcase_add_test(refuses, refuses_missing_optics);
  tcase_add_test(holds, heat_of_triangles_and_surfaces);
  tcase_add_test(refuses, refuses_heat_that_is_not_whole);
  tcase_add_test(refuses, refuses_an_unused_surface);
  tcase_add_test(refuses, refuses_bad_numbers);
  tcase_add_test(refuses, refuses_degenerate_triangles);
  tcase_add_test(refuses, refuses_normals_that_are_not_perpendicular);
  tcase_add_test(refuses, refuses_duplicates_and_allows_slits);
  tcase_set_timeout(holds, 120);
  suite_add_tcase(suite, holds);
  suite_add_tcase(suite, refuses);
  return run_suite(suite);
}
