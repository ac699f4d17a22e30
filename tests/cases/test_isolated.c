/* Scenes, shells and fluxes that see nothing are told; rooms with objects in them are not. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "rooms.h"
#include "suite.h"
#include "visibility/isolated.h"

/* --- what is said --- */

struct told {
  enum rad_code code;
  struct rad_notes notes;
  struct rad_error error;
};

static struct told tell(struct rad_deck *deck) {
  struct told told = {0};
  struct rad_visibility visibility = {0};
  struct built b = build(deck);
  told.code = b.code;
  told.error = b.error;
  told.notes = b.notes;
  b.notes = (struct rad_notes){0};
  if (!told.code) {
    ck_assert_int_eq(rad_visibility_build(&b.scene, &visibility, &told.error), RAD_OK);
    told.code = rad_check_isolated(&b.scene, "room.yml", &told.notes, &told.error);
  }
  rad_visibility_free(&visibility);
  drop(&b, deck);
  return told;
}

static int count(const struct told *t, const char *part) {
  int n = 0;
  for (int k = 0; k < t->notes.n; k++)
    n += strstr(t->notes.text[k], part) != NULL;
  return n;
}

/* Expects n_shell shells and, `dark`, a scene in which nothing sees anything; nothing else. */
static void expect(struct rad_deck *deck, int n_shell, int dark, const char *what, int k) {
  struct told t = tell(deck);
  ck_assert_msg(t.code == RAD_OK, "%s, step %d, seed %llu: %s", what, k, seed(), t.error.text);
  ck_assert_msg(count(&t, "radiates outwards") == n_shell && count(&t, "sees another") == dark &&
                    t.notes.n == n_shell + dark,
                "%s, step %d, seed %llu: %d notes, %s", what, k, seed(), t.notes.n,
                t.notes.n ? t.notes.text[0] : "");
  rad_notes_free(&t.notes);
}

/* --- scenes --- */

/* Turned, 1e-3 to 1e3 in scale, and up to 1e6 away; 1e5 sizes at most, for thin slits. */
static struct motion any_motion(void) {
  struct motion m = random_motion(3);
  double away = fmin(pow(10, uniform(-3, 6)), 1e5 * m.scale);
  for (int d = 0; d < 3; d++)
    m.shift[d] = away * uniform(-1, 1);
  return m;
}

/* Boxes, each in a cell of its own of 2 x 2 x 2 in the unit cube, and sheets between the layers. */
static int add_objects(struct rad_deck *deck, const struct motion *motion, enum rad_side side) {
  int n = 0;
  for (int cell = 0; cell < 8; cell++) {
    double low[3], high[3];
    if (uniform(0, 1) < 0.5)
      continue;
    for (int d = 0; d < 3; d++) {
      double from = 0.5 * (cell >> d & 1);
      low[d] = from + uniform(0.02, 0.2);
      high[d] = from + uniform(0.3, 0.48);
    }
    add_box(deck, motion, low, high, side);
    n++;
  }
  if (uniform(0, 1) < 0.5) {
    const double sheet[3][3] = {{0.1, 0.1, 0.5}, {0.9, 0.2, 0.5}, {0.3, 0.8, 0.5}};
    add_moved(deck, motion, sheet, RAD_SIDE_BOTH);
  }
  return n;
}

START_TEST(rooms_are_silent) {
  start_random();
  for (int k = 0; k < 150; k++) {
    struct motion motion = any_motion();
    struct rad_deck deck = {0};
    if (k % 3 == 2)
      add_prism(&deck, &motion, 6, ELL, 4, ELL_CAP, -0.5, 1.5, RAD_SIDE_BACK);
    else
      add_cube(&deck, &motion, RAD_SIDE_BACK);
    if (k % 3 != 2)
      add_objects(&deck, &motion, RAD_SIDE_FRONT);
    expect(&deck, 0, 0, "room", k);
  }
}
END_TEST

/* Convex rooms inside out see nothing, others are told as shells; bodies in them face nothing. */
START_TEST(rooms_inside_out_are_told) {
  start_random();
  for (int k = 0; k < 150; k++) {
    struct motion motion = any_motion();
    struct rad_deck deck = {0};
    if (k % 3 == 0) {
      add_cube(&deck, &motion, RAD_SIDE_FRONT);
      expect(&deck, 1, 1, "cube", k);
    } else if (k % 3 == 1) {
      add_prism(&deck, &motion, 6, ELL, 4, ELL_CAP, 0, 1, RAD_SIDE_FRONT);
      expect(&deck, 1, 0, "ell", k);
    } else { /* all of it turned: the objects see only themselves, from within */
      add_cube(&deck, &motion, RAD_SIDE_FRONT);
      int n = add_objects(&deck, &motion, RAD_SIDE_BACK);
      expect(&deck, 1, n == 0, "turned room", k);
    }
  }
}
END_TEST

/* Two bodies in space face each other, unless a wall hides them; an open box is no shell. */
START_TEST(bodies_in_space) {
  static const double low[3] = {0, 0, 2}, high[3] = {1, 1, 3};
  static const double wall[3][3] = {{-60, -60, 1.5}, {60, -60, 1.5}, {0, 90, 1.5}};
  start_random();
  for (int k = 0; k < 40; k++) {
    struct motion motion = any_motion();
    struct rad_deck deck = {0};
    add_cube(&deck, &motion, RAD_SIDE_FRONT);
    add_box(&deck, &motion, low, high, RAD_SIDE_FRONT);
    if (k % 4 == 1)
      add_moved(&deck, &motion, wall, RAD_SIDE_BOTH); /* each sees the wall */
    expect(&deck, 0, 0, "two bodies", k);
    add_cube(&deck, &motion, RAD_SIDE_FRONT);
    deck.n_triangle -= 1 + k % 2;
    expect(&deck, 0, 1, "an open box", k);
  }
}
END_TEST

/* A cube's face that is cut without regard to its neighbours leaves it closed. */
START_TEST(edges_within_edges_close) {
  start_random();
  for (int k = 0; k < 40; k++) {
    struct motion motion = any_motion();
    struct rad_deck deck = {0};
    add_cube(&deck, &motion, RAD_SIDE_FRONT);
    deck.n_triangle = 8; /* without bottom and top */
    double x = uniform(0.1, 0.9);
    const double fan[3][2][3][3] = {
        {{{0, 0, 0}, {0, 1, 0}, {x, 0, 0}}, {{0, 0, 1}, {x, 0, 1}, {0, 1, 1}}},
        {{{x, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{x, 0, 1}, {1, 1, 1}, {0, 1, 1}}},
        {{{x, 0, 0}, {1, 1, 0}, {1, 0, 0}}, {{x, 0, 1}, {1, 0, 1}, {1, 1, 1}}}};
    for (int t = 0; t < 6; t++)
      add_moved(&deck, &motion, fan[t / 2][t % 2], RAD_SIDE_FRONT);
    struct told t = tell(&deck);
    ck_assert_int_eq(t.code, RAD_OK);
    ck_assert_msg(count(&t, "radiates outwards") == 1, "step %d, seed %llu", k, seed());
    ck_assert_int_gt(count(&t, "touches"), 0);
    rad_notes_free(&t.notes);
  }
}
END_TEST

/* A block's bottom on the floor, a million sizes from the origin: rounding is no gap between them.
 */
START_TEST(rounding_is_no_gap) {
  start_random();
  for (int k = 0; k < 40; k++) {
    static const double bottom[3][3] = {{0.1, 0.1, 0}, {0.1, 0.5, 0}, {0.5, 0.2, 0}};
    struct motion motion = random_motion(0);
    struct rad_deck deck = {0};
    for (int d = 0; d < 3; d++)
      motion.shift[d] = 1e6 * uniform(-1, 1);
    add_moved(&deck, &motion, UNIT, RAD_SIDE_FRONT);
    add_moved(&deck, &motion, bottom, RAD_SIDE_FRONT);
    expect(&deck, 0, 1, "block on a floor", k);
  }
}
END_TEST

/* --- fluxes --- */

/* A hot face below, and faces above it with this flux: one looks at it, one away, one has a sheet.
 */
static struct told tell_flux(double flux, int away, enum rad_side side) {
  static const double above[3][3] = {{0, 0, 1}, {0, 1, 1}, {1, 0, 1}};
  struct rad_deck deck = {0};
  struct rad_deck_triangle *hot = add(&deck, "hot", UNIT);
  hot->optics = (struct rad_deck_optics){
      .has_emissivity = true, .emissivity = 1, .has_temperature = true, .temperature = 300};
  for (int k = 0; k < 1 + away; k++) {
    double v[3][3];
    memcpy(v, above, sizeof v);
    for (int m = 0; m < 3; m++)
      v[m][2] += k; /* the second one sees the first one's back */
    add(&deck, "load", v)->optics = (struct rad_deck_optics){.has_emissivity = true,
                                                             .emissivity = 0.5,
                                                             .has_flux = true,
                                                             .flux = flux,
                                                             .side = k ? RAD_SIDE_BACK : side};
  }
  return tell(&deck);
}

START_TEST(fluxes) {
  struct told t = tell_flux(0, 0, RAD_SIDE_FRONT);
  ck_assert(t.code == RAD_OK && t.notes.n == 0);
  rad_notes_free(&t.notes);
  t = tell_flux(0, 1, RAD_SIDE_FRONT);
  ck_assert(t.code == RAD_OK && t.notes.n == 1);
  ck_assert_ptr_nonnull(strstr(t.notes.text[0],
                               "room.yml: warning: surface 'load' has a flux, but "
                               "1 of its 2 triangles see no other face"));
  rad_notes_free(&t.notes);
  t = tell_flux(-5, 0, RAD_SIDE_FRONT);
  ck_assert(t.code == RAD_OK && t.notes.n == 0);
  t = tell_flux(-5, 1, RAD_SIDE_FRONT);
  ck_assert_int_eq(t.code, RAD_EINPUT);
  ck_assert_ptr_nonnull(strstr(t.error.text, "surface 'load' takes up 5 W/m2"));
  rad_notes_free(&t.notes);
  t = tell_flux(1, 0, RAD_SIDE_BOTH);
  ck_assert(t.code == RAD_OK && t.notes.n == 2);
  ck_assert_ptr_nonnull(strstr(t.notes.text[0], "surface 'load' has a flux and two sides"));
  ck_assert_ptr_nonnull(strstr(t.notes.text[1], "1 of its 2 triangles see no other face"));
  rad_notes_free(&t.notes);
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", seed());
  Suite *suite = suite_create("isolated");
  TCase *told = tcase_create("told");
  tcase_add_test(told, rooms_are_silent);
  tcase_add_test(told, rooms_inside_out_are_told);
  tcase_add_test(told, bodies_in_space);
  tcase_add_test(told, edges_within_edges_close);
  tcase_add_test(told, rounding_is_no_gap);
  tcase_add_test(told, fluxes);
  tcase_set_timeout(told, 120);
  suite_add_tcase(suite, told);
  return run_suite(suite);
}
