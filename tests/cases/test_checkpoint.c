/* Checkpoints: what is written is read, half-done matrices are finished to the same bits, GMRES
 * goes on with the same bits, and damaged or foreign files are refused. */
#include <check.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "app/checkpoint.h"
#include "checkpoint_help.h"
#include "suite.h"

static const unsigned seed = 20261125;

static unsigned next_random(unsigned *state) { /* xorshift32 */
  *state ^= *state << 13;
  *state ^= *state >> 17;
  *state ^= *state << 5;
  return *state;
}

/* A whole operator: nothing is computed again, and all is the same. */
START_TEST(round_trip) {
  struct rad_case a, b;
  struct deck_text *d = deck_of(&problems[_i]);
  begin_folder();
  solve(d, NULL, &a);
  save(&a);
  solve(d, path, &b);
  check_same(&a, &b);
  check_counters(&a, &b);
  rad_case_free(&a);
  rad_case_free(&b);
  free(d);
  end_folder();
}
END_TEST

static void erase(struct rad_h2_dense *d, const struct rad_block_list *list, int t) {
  size_t at = d->at[list->first[t]], n = d->at[list->first[t + 1]] - at;
  if (d->narrow)
    memset(d->narrow + at, 0, sizeof(float) * n);
  else
    memset(d->wide + at, 0, sizeof(double) * n);
}

/* Undo a random half of the assembly. */
static void undo_half(struct rad_case *c) {
  unsigned state = seed;
  for (int64_t i = 0; i < c->dense.n_task; i++)
    c->dense.done[i] = next_random(&state) & 64 ? 1 : 0;
  for (int t = 0; c->h2.near_done && t < c->h2.tree.n_cluster; t++) {
    if (next_random(&state) & 64)
      continue;
    c->h2.near_done[t] = 0;
    erase(&c->h2.near, &c->h2.blocks.near, t);
    erase(&c->h2.sector, &c->h2.blocks.sector, t);
  }
}

START_TEST(half_done) {
  struct rad_case a, b;
  struct deck_text *d = deck_of(&problems[_i]);
  begin_folder();
  solve(d, NULL, &a);
  undo_half(&a);
  save(&a);
  solve(d, path, &b);
  rad_case_free(&a);
  solve(d, NULL, &a);
  check_same(&a, &b);
  rad_case_free(&a);
  rad_case_free(&b);
  free(d);
  end_folder();
}
END_TEST

/* The last checkpoint of a run in many pieces leads to the same bits as one run. */
START_TEST(in_pieces) {
  const struct problem *p = _i < N_PROBLEM ? &problems[_i] : &several_cycles;
  struct deck_text *d = deck_of(p);
  begin_folder();
  int n = run_in_pieces(d, 0.02); /* OpenMP has no threads yet in this process: children may */
  struct rad_case a, b;
  solve(d, NULL, &a);
  solve(d, n ? path : NULL, &b);
  if (getenv("POLYRAD_TEST_VERBOSE"))
    printf("problem %d: %d pieces, %d steps\n", _i, n + 1, a.report.iterations);
  check_same(&a, &b);
  check_counters(&a, &b);
  if (_i == N_PROBLEM)
    ck_assert_int_gt(a.report.iterations, 40); /* more than one cycle */
  rad_case_free(&a);
  rad_case_free(&b);
  free(d);
  end_folder();
}
END_TEST

/* --- files that are not what they should be --- */

static void write_bytes(const char *bytes, size_t n) {
  FILE *f = fopen(path, "wb");
  ck_assert_uint_eq(fwrite(bytes, 1, n, f), n);
  fclose(f);
}

static void check_refused(struct rad_case *c, enum rad_code code, const char *words) {
  struct rad_error e = {0};
  ck_assert_int_eq(rad_case_restart(c, path, &e), code);
  ck_assert_msg(strstr(e.text, words) && strstr(e.text, path) && !strchr(e.text, '\n'), "%s",
                e.text);
}

/* Cut anywhere, and any one byte changed anywhere: refused. */
START_TEST(damaged) {
  enum { N_CUT = 300, N_FLIP = 3000 };
  struct rad_case c, fresh;
  struct rad_error e;
  struct deck_text *d = deck_of(&problems[1]);
  begin_folder();
  solve(d, NULL, &c);
  save(&c);
  ck_assert_int_eq(deck_prepare(d, &fresh, &e), RAD_OK);
  ck_assert_int_eq(rad_case_restart(&fresh, path, &e), RAD_OK);
  char *bytes;
  size_t size = file_bytes(path, &bytes);
  unsigned state = seed;
  for (int i = 0; i < N_CUT; i++) {
    size_t at = i < 100 ? (size_t)i * 6 : next_random(&state) % size;
    write_bytes(bytes, at);
    struct rad_error refusal = {0};
    ck_assert_msg(rad_case_restart(&fresh, path, &refusal) == RAD_ESYSTEM, "cut at %zu", at);
    ck_assert_ptr_nonnull(strstr(refusal.text, path));
  }
  write_bytes(bytes, size);
  FILE *f = fopen(path, "r+b");
  for (int i = 0; i < N_FLIP; i++) {
    size_t at = i < 1500   ? (size_t)i
                : i < 2000 ? next_random(&state) % 20000 % size
                           : next_random(&state) % size;
    char changed = (char)(bytes[at] ^ (1 << next_random(&state) % 8));
    fseek(f, (long)at, SEEK_SET);
    fwrite(&changed, 1, 1, f);
    fflush(f);
    struct rad_error refusal = {0};
    ck_assert_msg(rad_case_restart(&fresh, path, &refusal) == RAD_ESYSTEM, "byte %zu", at);
    fseek(f, (long)at, SEEK_SET);
    fwrite(bytes + at, 1, 1, f);
  }
  fclose(f);
  ck_assert_int_eq(rad_case_restart(&fresh, path, &e), RAD_OK);
  free(bytes);
  rad_case_free(&c);
  rad_case_free(&fresh);
  free(d);
  end_folder();
}
END_TEST

/* Another deck, other overrides, another kind of file, no file. */
START_TEST(foreign) {
  struct rad_case c, other;
  struct rad_error e;
  struct deck_text *d = deck_of(&problems[6]);
  begin_folder();
  solve(d, NULL, &c);
  ck_assert_int_eq(rad_case_restart(&c, path, &e), RAD_ESYSTEM); /* there is none yet */
  save(&c);
  deck_add(d, "title: another\n");
  ck_assert_int_eq(deck_prepare(d, &other, &e), RAD_OK);
  check_refused(&other, RAD_EINPUT, "another deck");
  static const char *const set[] = {"method.degree=0", "title=x"};
  c.n_set = 2;
  c.set = set;
  check_refused(&c, RAD_EINPUT, "other --set options (none)");
  save(&c);
  c.n_set = 1;
  check_refused(&c, RAD_EINPUT, "(method.degree=0 title=x)");
  c.n_set = 2;
  ck_assert_int_eq(rad_case_restart(&c, path, &e), RAD_OK);
  c.scene.triangle[1].v[2][0] += 1e-15; /* as if a mesh file had changed */
  check_refused(&c, RAD_EINPUT, "another scene");
  struct rad_result result = {0};
  ck_assert_int_eq(rad_case_result(&c, "test", &result, &e), RAD_OK);
  ck_assert_int_eq(rad_result_write(path, &result, 0, &e), RAD_OK);
  check_refused(&c, RAD_ESYSTEM, "a result?");
  write_bytes("polyrad", 7);
  check_refused(&c, RAD_ESYSTEM, "is not a polyrad checkpoint");
  rad_result_free(&result);
  rad_case_free(&c);
  rad_case_free(&other);
  free(d);
  end_folder();
}
END_TEST

int main(void) {
  Suite *s = suite_create("checkpoint");
  TCase *c = tcase_create("checkpoint");
  tcase_set_timeout(c, 300);
  tcase_add_loop_test(c, in_pieces, 0, N_PROBLEM + 1);
  tcase_add_loop_test(c, round_trip, 0, N_PROBLEM);
  tcase_add_loop_test(c, half_done, 0, N_PROBLEM);
  tcase_add_test(c, damaged);
  tcase_add_test(c, foreign);
  suite_add_tcase(s, c);
  return run_suite(s);
}
