/* Checkpoints of adaptive runs: levels that are done are kept, the rest comes out with the same
 * bits. */
#include <check.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "app/checkpoint.h"
#include "checkpoint_help.h"
#include "output/checkpoint.h"
#include "suite.h"

static void check_same_adaptive(const struct rad_case *a, const struct rad_case *b) {
  const struct rad_adaptive *x = &a->adaptive, *y = &b->adaptive;
  ck_assert_int_eq(x->levels, y->levels);
  ck_assert_int_eq(a->mesh->n_element, b->mesh->n_element);
  ck_assert_int_eq(a->mesh->n_point, b->mesh->n_point);
  check_same(a, b);
  CHECK_SAME(&x->bound, &y->bound, 1);
  CHECK_SAME(&x->bound_limit, &y->bound_limit, 1);
  CHECK_SAME(x->element_bound, y->element_bound, a->mesh->n_element);
  check_counters(a, b);
}

/* Levels that the checkpoint at `path` saves. */
static int levels_saved(const struct rad_case *c) {
  const struct rad_origin origin = {.deck = &c->deck, .scene = &c->scene, .threads = 1};
  struct rad_stage stage;
  struct rad_error e;
  ck_assert_msg(rad_checkpoint_read_stage(path, &origin, &stage, &e) == RAD_OK, "%s", e.text);
  int levels = stage.levels;
  rad_stage_free(&stage);
  return levels;
}

/* Stopped at the very end: the last level is solved again with the matrix that is there. */
START_TEST(adaptive_levels) {
  struct rad_case a, b;
  struct deck_text *d = deck_of(&adaptive_runs[_i]);
  begin_folder();
  solve(d, NULL, &a);
  ck_assert_int_ge(a.adaptive.levels, 2);
  save(&a);
  ck_assert_int_eq(levels_saved(&a), a.adaptive.levels - 1);
  solve(d, path, &b);
  check_same_adaptive(&a, &b);
  rad_case_free(&b);
  rad_case_free(&a);
  free(d);
  end_folder();
}
END_TEST

static void check_equal_files(const char *name, size_t n, const char *bytes) {
  char *now;
  ck_assert_uint_eq(file_bytes(name, &now), n);
  ck_assert_int_eq(memcmp(now, bytes, n), 0);
  free(now);
}

/* Stopped before it has what its checkpoint had, a run keeps that, in the same or another file. */
START_TEST(nothing_is_lost) {
  struct deck_text *d = _i ? deck_of(&adaptive_runs[1]) : deck_of(&problems[0]);
  struct rad_case a, b;
  struct rad_error e;
  char other[80], *bytes;
  int is_old;
  begin_folder();
  snprintf(other, sizeof other, "%s/other.ck", folder);
  solve(d, NULL, &a);
  save(&a);
  size_t n = file_bytes(path, &bytes);
  struct rad_command command = {.checkpoint = path, .restart = path, .line = "test"};
  ck_assert_int_eq(deck_prepare(d, &b, &e), RAD_OK);
  ck_assert_int_eq(rad_case_restart(&b, path, &e), RAD_OK);
  ck_assert_int_eq(rad_case_keep(&b, &command, 0, &is_old, &e), RAD_OK);
  ck_assert(is_old);
  check_equal_files(path, n, bytes);
  command.checkpoint = other;
  ck_assert_int_eq(rad_case_keep(&b, &command, 0, &is_old, &e), RAD_OK);
  ck_assert(is_old);
  check_equal_files(other, n, bytes);
  ck_assert_int_eq(rad_case_solve(&b, &e), RAD_OK);
  ck_assert_int_eq(rad_case_keep(&b, &command, 0, &is_old, &e), RAD_OK);
  ck_assert(!is_old); /* now it has all of it */
  rad_case_free(&b);
  solve(d, other, &b);
  check_same(&a, &b);
  ck_assert_int_eq(unlink(other), 0);
  rad_case_free(&a);
  rad_case_free(&b);
  free(bytes);
  free(d);
  end_folder();
}
END_TEST

static void check_stage_refused(const struct deck_text *d, struct rad_case *a) {
  struct rad_case b;
  struct rad_error e = {0};
  save(a);
  ck_assert_int_eq(deck_prepare(d, &b, &e), RAD_OK);
  ck_assert_int_eq(rad_case_restart(&b, path, &e), RAD_OK);
  ck_assert_int_eq(rad_case_solve(&b, &e), RAD_EINPUT);
  ck_assert_msg(strstr(e.text, "the mesh in the checkpoint is not one of this scene"), "%s",
                e.text);
  rad_case_free(&b);
}

/* Leaves that do not cover their patches, or are no leaves. */
START_TEST(stage_refused) {
  struct rad_case a;
  struct deck_text *d = deck_of(&adaptive_runs[1]);
  begin_folder();
  solve(d, NULL, &a);
  struct rad_stage *stage = &a.adaptive.stage;
  struct rad_leaf *leaf = &stage->leaf[stage->n_leaf / 2], good = *leaf;
  leaf->phi[1] = 0.5 * (leaf->phi[0] + leaf->phi[1]);
  check_stage_refused(d, &a);
  *leaf = good;
  leaf->k_r = RAD_MAX_POINTS_1D + 1;
  check_stage_refused(d, &a);
  *leaf = good;
  leaf->patch = 1000;
  check_stage_refused(d, &a);
  *leaf = good;
  stage->n_leaf--;
  check_stage_refused(d, &a);
  rad_case_free(&a);
  free(d);
  end_folder();
}
END_TEST

/* In pieces, each of which loses the level in which it is stopped. */
START_TEST(adaptive_in_pieces) {
  struct deck_text *d = deck_of(&adaptive_runs[_i]);
  begin_folder();
  int n = run_in_pieces(d, 0.05);
  struct rad_case a, b;
  solve(d, NULL, &a);
  solve(d, n ? path : NULL, &b);
  if (getenv("POLYRAD_TEST_VERBOSE"))
    printf("adaptive run %d: %d pieces, %d of %d levels saved\n", _i, n + 1,
           n ? levels_saved(&a) : 0, a.adaptive.levels);
  check_same_adaptive(&a, &b);
  rad_case_free(&a);
  rad_case_free(&b);
  free(d);
  end_folder();
}
END_TEST

int main(void) {
  Suite *s = suite_create("levels");
  TCase *c = tcase_create("levels");
  tcase_set_timeout(c, 300);
  tcase_add_loop_test(c, adaptive_in_pieces, 0, N_ADAPTIVE);
  tcase_add_loop_test(c, adaptive_levels, 0, N_ADAPTIVE);
  tcase_add_loop_test(c, nothing_is_lost, 0, 2);
  tcase_add_test(c, stage_refused);
  suite_add_tcase(s, c);
  return run_suite(s);
}
