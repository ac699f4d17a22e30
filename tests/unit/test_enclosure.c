/* Which scenes light cannot leave, and where it comes to backs: known scenes, turned at random. */
#include <check.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/enclosure.h"
#include "scene_help.h"
#include "suite.h"

enum { OPEN, CLOSED, LIT_BACKS /* closed, and light comes to backs */ };
enum { IN, OUT, NONE };
enum { MOST_SHEETS = 2 };

/* The unit cube, its faces inwards or outwards, perhaps without its first triangle; another box
 * with this lowest corner and size; and sheets. */
static const struct {
  const char *what;
  int expected, room, skip, body;
  double low[3], size;
  int n_sheet, two_sided;
  double sheet[MOST_SHEETS][3][3];
} cases[] = {
    {"room", CLOSED, IN, 0, NONE, {0}, 0, 0, 0, {{{0}}}},
    {"cube from outside", OPEN, OUT, 0, NONE, {0}, 0, 0, 0, {{{0}}}},
    {"without a face", OPEN, IN, 1, NONE, {0}, 0, 0, 0, {{{0}}}},
    {"body", CLOSED, IN, 0, OUT, {.3, .3, .2}, .4, 0, 0, {{{0}}}},
    {"body on the floor, its base looks out below",
     OPEN,
     IN,
     0,
     OUT,
     {.3, .3, 0},
     .4,
     0,
     0,
     {{{0}}}},
    {"body outside", OPEN, IN, 0, OUT, {1.3, .3, 0}, .4, 0, 0, {{{0}}}},
    {"body outside with a vertex in common", OPEN, IN, 0, OUT, {1, 1, 1}, .4, 0, 0, {{{0}}}},
    {"body half outside", OPEN, IN, 0, OUT, {.8, .3, .2}, .4, 0, 0, {{{0}}}},
    {"room in a room", LIT_BACKS, IN, 0, IN, {.3, .3, .2}, .4, 0, 0, {{{0}}}},
    {"two rooms with a vertex in common", CLOSED, IN, 0, IN, {1, 1, 1}, .4, 0, 0, {{{0}}}},
    {"room within a body", OPEN, OUT, 0, IN, {.3, .3, .2}, .4, 0, 0, {{{0}}}},
    {"sheet", LIT_BACKS, IN, 0, NONE, {0}, 0, 1, 0, {{{.2, .2, .3}, {.7, .2, .4}, {.5, .8, .6}}}},
    {"sheet of two sides",
     CLOSED,
     IN,
     0,
     NONE,
     {0},
     0,
     1,
     1,
     {{{.2, .2, .3}, {.7, .2, .4}, {.5, .8, .6}}}},
    {"sheet in a room without a face",
     OPEN,
     IN,
     1,
     NONE,
     {0},
     0,
     1,
     1,
     {{{.2, .2, .3}, {.7, .2, .4}, {.5, .8, .6}}}},
    {"sheet from a wall to the floor",
     CLOSED,
     IN,
     0,
     NONE,
     {0},
     0,
     1,
     1,
     {{{0, .3, .2}, {0, .6, .8}, {.5, .5, 0}}}},
    {"sheet from a vertex",
     LIT_BACKS,
     IN,
     0,
     NONE,
     {0},
     0,
     1,
     0,
     {{{0, 0, 0}, {.6, .3, .2}, {.5, .5, .5}}}},
    {"sheet on an edge",
     LIT_BACKS,
     IN,
     0,
     NONE,
     {0},
     0,
     1,
     0,
     {{{0, 0, 0}, {0, 0, 1}, {.5, .5, .5}}}},
    {"sheets on edges",
     CLOSED,
     IN,
     0,
     NONE,
     {0},
     0,
     2,
     1,
     {{{0, 0, 0}, {0, 0, 1}, {.5, .5, .5}}, {{1, 1, 0}, {1, 1, 1}, {.5, .5, .5}}}},
    {"wall across",
     CLOSED,
     IN,
     0,
     NONE,
     {0},
     0,
     2,
     1,
     {{{0, 0, 0}, {1, 1, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}, {0, 0, 1}}}},
    {"sheet through a wall",
     OPEN,
     IN,
     0,
     NONE,
     {0},
     0,
     1,
     1,
     {{{.4, -.5, .4}, {.2, .3, .3}, {.8, .3, .5}}}},
    {"sheet through a wall along its diagonal",
     OPEN,
     IN,
     0,
     NONE,
     {0},
     0,
     1,
     1,
     {{{.5, -.5, .5}, {.2, .3, .2}, {.8, .3, .8}}}},
    {"sheet outside",
     OPEN,
     IN,
     0,
     NONE,
     {0},
     0,
     1,
     1,
     {{{.2, -.2, .3}, {.7, -.2, .4}, {.5, -.8, .6}}}},
    {"sheet on the outside of a wall",
     OPEN,
     IN,
     0,
     NONE,
     {0},
     0,
     1,
     0,
     {{{.3, 0, .1}, {.8, 0, .1}, {.8, 0, .3}}}},
};
enum { N_CASE = sizeof cases / sizeof *cases };

static void add_box(struct rad_deck *deck, const struct motion *m, const double low[3], double size,
                    int way) {
  double at[4][2];
  for (int k = 0; k < 8; k++)
    at[k / 2][k % 2] = low[k % 2] + size * SQUARE[k / 2][k % 2];
  if (way != NONE)
    add_prism(deck, m, 4, (const double(*)[2])at, 2, SQUARE_CAP, low[2], low[2] + size,
              way == IN ? RAD_SIDE_BACK : RAD_SIDE_FRONT);
}

START_TEST(known_scenes) {
  static const double origin[3] = {0, 0, 0};
  start_random();
  for (int k = 0; k < 20; k++) {
    struct motion m = random_motion(3);
    struct rad_deck deck = {0};
    struct rad_enclosure x;
    struct rad_error e;
    add_box(&deck, &m, origin, 1, cases[_i].room);
    deck.n_triangle -= cases[_i].skip;
    add_box(&deck, &m, cases[_i].low, cases[_i].size, cases[_i].body);
    for (int s = 0; s < cases[_i].n_sheet; s++)
      add_moved(&deck, &m, cases[_i].sheet[s],
                cases[_i].two_sided ? RAD_SIDE_BOTH : RAD_SIDE_FRONT);
    struct rad_scene scene = build_scene(&deck);
    ck_assert_int_eq(rad_find_enclosure(&scene, &x, &e), RAD_OK);
    int found = !x.is_closed ? OPEN : x.hides_backs ? CLOSED : LIT_BACKS;
    ck_assert_msg(found == cases[_i].expected, "%s: %d, not %d", cases[_i].what, found,
                  cases[_i].expected);
    rad_scene_free(&scene);
  }
}
END_TEST

/* Walls cut each its own way: no side is shared as a whole. */
START_TEST(walls_with_vertices_within_edges) {
  static const double hexagon[6][2] = {{0, 0}, {.5, 0}, {1, 0}, {1, 1}, {.4, 1}, {0, 1}};
  start_random();
  for (int k = 0; k < 2; k++) {
    struct motion m = random_motion(3);
    struct rad_deck deck = {0};
    struct rad_enclosure x;
    struct rad_error e;
    add_prism(&deck, &m, 6, hexagon, 0, SQUARE_CAP, 0, 1, RAD_SIDE_BACK);
    int n = deck.n_triangle;
    add_box(&deck, &m, (const double[3]){0, 0, 0}, 1, IN);
    memmove(&deck.triangle[n], &deck.triangle[n + 8], 4 * sizeof *deck.triangle); /* its caps */
    deck.n_triangle = n + 4 - k;
    struct rad_scene scene = build_scene(&deck);
    ck_assert_int_eq(rad_find_enclosure(&scene, &x, &e), RAD_OK);
    ck_assert_int_eq(x.is_closed, !k);
    ck_assert_int_eq(x.hides_backs, !k);
    rad_scene_free(&scene);
  }
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", seed());
  Suite *suite = suite_create("enclosure");
  TCase *tests = tcase_create("enclosure");
  tcase_add_loop_test(tests, known_scenes, 0, N_CASE);
  tcase_add_test(tests, walls_with_vertices_within_edges);
  tcase_set_timeout(tests, 120);
  suite_add_tcase(suite, tests);
  return run_suite(suite);
}
