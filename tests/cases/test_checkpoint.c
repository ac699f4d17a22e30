/* Checkpoints: what is written is read, half-done matrices are finished to the same bits, GMRES
 * goes on with the same bits, and damaged or foreign files are refused. */
#include <check.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "app/checkpoint.h"
#include "base/stop.h"
#include "output/checkpoint.h"
#include "output/seal.h"
#include "scene_text.h"
#include "suite.h"

static char folder[] = "/tmp/polyrad_checkpoint_XXXXXX", path[64];
static const unsigned seed = 20261125;

static void begin_folder(void) {
  ck_assert_ptr_nonnull(mkdtemp(folder));
  snprintf(path, sizeof path, "%s/run.ck", folder);
}

static void end_folder(void) { /* nothing but the checkpoint may have been left */
  unlink(path);
  ck_assert_int_eq(rmdir(folder), 0);
  strcpy(folder + strlen(folder) - 6, "XXXXXX");
}

static unsigned next_random(unsigned *state) { /* xorshift32 */
  *state ^= *state << 13;
  *state ^= *state >> 17;
  *state ^= *state << 5;
  return *state;
}

/* --- scenes --- */

static void square(struct deck_text *d, const char *name, double z, int up, double size,
                   double rho) {
  double s = 0.5 * size, sign = up ? 1 : -1;
  const double corner[4][3] = {
      {-s, -sign * s, z}, {s, -sign * s, z}, {s, sign * s, z}, {-s, sign * s, z}};
  deck_polygon(d, name, 4, corner, rho, 1 + z);
}

static void corner_scene(struct deck_text *d) {
  static const double face[3][3][3] = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                                       {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                       {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}}};
  for (int f = 0; f < 3; f++)
    deck_polygon(d, "face", 3, face[f], 0.5, 0.3 + f);
}

/* Two plates with a smaller one between them that casts shadows both ways. */
static void shadow_scene(struct deck_text *d) {
  square(d, "low", 0, 1, 1, 0.6);
  square(d, "high", 1, 0, 1, 0.6);
  square(d, "between", 0.5, 1, 0.5, 0.4);
}

static void gap_scene(struct deck_text *d) { /* GMRES needs several cycles */
  square(d, "low", 0, 1, 1, 0.999);
  square(d, "high", 0.003, 0, 1, 0.999);
}

struct problem {
  void (*scene)(struct deck_text *);
  const char *method;
};

static const struct problem problems[] = {
    {corner_scene,
     "mesh: paper, elements: 5, degree: 1, matrix: dense, quadrature_tolerance: 1e-8"},
    {corner_scene,
     "mesh: paper, elements: 5, degree: 1, matrix: hierarchical, "
     "quadrature_tolerance: 1e-6"}, /* single precision */
    {corner_scene,
     "mesh: graded, elements: 2, grading: 2, degree: 5, matrix: hierarchical, "
     "quadrature_tolerance: 1e-9"}, /* double */
    {corner_scene,
     "mesh: paper, elements: 4, grading: 2, degree: 1, matrix: hierarchical, "
     "quadrature_tolerance: 1e-6"}, /* sectors */
    {shadow_scene,
     "mesh: uniform, elements: 8, degree: 1, matrix: hierarchical, "
     "quadrature_tolerance: 1e-5"},
    {shadow_scene,
     "mesh: uniform, elements: 4, degree: 0, matrix: dense, "
     "quadrature_tolerance: 1e-6"},
    {corner_scene, "mesh: uniform, elements: 1, degree: 0, matrix: dense, solver: lu"}, /* facets */
    {shadow_scene, "mesh: uniform, elements: 4, degree: 0, solver: neumann, bounces: 7"},
};
enum { N_PROBLEM = sizeof problems / sizeof *problems };

static struct deck_text *deck_of(const struct problem *p) {
  struct deck_text *d = malloc(sizeof *d);
  deck_begin(d);
  p->scene(d);
  deck_add(d, "method: {%s}\n", p->method);
  return d;
}

static void solve(const struct deck_text *d, const char *restart, struct rad_case *c) {
  struct rad_error e;
  ck_assert_msg(deck_prepare(d, c, &e) == RAD_OK, "%s", e.text);
  if (restart)
    ck_assert_msg(rad_case_restart(c, restart, &e) == RAD_OK, "%s", e.text);
  ck_assert_msg(rad_case_solve(c, &e) == RAD_OK, "%s", e.text);
}

static void save(struct rad_case *c) {
  struct rad_error e;
  ck_assert_msg(rad_case_save(c, path, "test", 0, &e) == RAD_OK, "%s", e.text);
}

#define CHECK_SAME(a, b, n) ck_assert_int_eq(memcmp(a, b, sizeof *(a) * (size_t)(n)), 0)

static void check_blocks(const struct rad_h2_dense *a, const struct rad_h2_dense *b) {
  ck_assert_uint_eq(a->n, b->n);
  if (a->narrow)
    CHECK_SAME(a->narrow, b->narrow, a->n);
  else
    CHECK_SAME(a->wide, b->wide, a->n);
}

/* Matrices and solutions to the last bit. */
static void check_same(const struct rad_case *a, const struct rad_case *b) {
  size_t n = (size_t)a->mesh->n_point;
  CHECK_SAME(a->u, b->u, n);
  CHECK_SAME(a->h, b->h, n);
  ck_assert_int_eq(a->report.iterations, b->report.iterations);
  CHECK_SAME(&a->report.residual, &b->report.residual, 1);
  CHECK_SAME(&a->report.inverse_norm, &b->report.inverse_norm, 1);
  if (a->dense.k) {
    CHECK_SAME(a->dense.k, b->dense.k, n * n);
    return;
  }
  const struct rad_h2 *x = &a->h2, *y = &b->h2;
  ck_assert_uint_eq(x->n_far, y->n_far);
  ck_assert_uint_eq(x->row.n_data, y->row.n_data);
  ck_assert_uint_eq(x->column.n_data, y->column.n_data);
  CHECK_SAME(x->row.data, y->row.data, x->row.n_data);
  CHECK_SAME(x->column.data, y->column.data, x->column.n_data);
  CHECK_SAME(x->far, y->far, x->n_far);
  check_blocks(&x->near, &y->near);
  check_blocks(&x->sector, &y->sector);
  CHECK_SAME(&x->error, &y->error, 1);
  CHECK_SAME(&x->bytes, &y->bytes, 1);
}

static void check_counters(const struct rad_counters *a, const struct rad_counters *b) {
  ck_assert_int_eq(a->kernel_values, b->kernel_values);
  ck_assert_int_eq(a->near, b->near);
  ck_assert_int_eq(a->far, b->far);
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
  check_counters(&a.dense.counters, &b.dense.counters);
  check_counters(&a.h2.counters, &b.h2.counters);
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

/* --- adaptive runs --- */

static const struct problem adaptive_runs[] = {
    {corner_scene, "accuracy: {tolerance: 1e-7}\n"},
    {corner_scene, "accuracy: {tolerance: 1e-6}\nmethod: {matrix: hierarchical}\n"},
    {shadow_scene, "accuracy: {tolerance: 5e-4}\n"},
};
enum { N_ADAPTIVE = sizeof adaptive_runs / sizeof *adaptive_runs };

static struct deck_text *adaptive_deck(const struct problem *p) {
  struct deck_text *d = malloc(sizeof *d);
  deck_begin(d);
  p->scene(d);
  deck_add(d, "%s", p->method);
  return d;
}

static void check_same_adaptive(const struct rad_case *a, const struct rad_case *b) {
  const struct rad_adaptive *x = &a->adaptive, *y = &b->adaptive;
  ck_assert_int_eq(x->levels, y->levels);
  ck_assert_int_eq(a->mesh->n_element, b->mesh->n_element);
  ck_assert_int_eq(a->mesh->n_point, b->mesh->n_point);
  check_same(a, b);
  CHECK_SAME(&x->bound, &y->bound, 1);
  CHECK_SAME(&x->bound_limit, &y->bound_limit, 1);
  CHECK_SAME(x->element_bound, y->element_bound, a->mesh->n_element);
  check_counters(&a->dense.counters, &b->dense.counters);
  check_counters(&a->h2.counters, &b->h2.counters);
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
  struct deck_text *d = adaptive_deck(&adaptive_runs[_i]);
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

static size_t file_bytes(const char *name, char **bytes) {
  FILE *f = fopen(name, "rb");
  ck_assert_ptr_nonnull(f);
  fseek(f, 0, SEEK_END);
  size_t n = (size_t)ftell(f);
  rewind(f);
  *bytes = malloc(n);
  ck_assert_uint_eq(fread(*bytes, 1, n, f), n);
  fclose(f);
  return n;
}

static void check_equal_files(const char *name, size_t n, const char *bytes) {
  char *now;
  ck_assert_uint_eq(file_bytes(name, &now), n);
  ck_assert_int_eq(memcmp(now, bytes, n), 0);
  free(now);
}

/* Stopped before it has what its checkpoint had, a run keeps that, in the same or another file. */
START_TEST(nothing_is_lost) {
  struct deck_text *d = _i ? adaptive_deck(&adaptive_runs[1]) : deck_of(&problems[0]);
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
  struct deck_text *d = adaptive_deck(&adaptive_runs[1]);
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

/* --- parts --- */

enum { MOST_PARTS = 5 };

static const char *part_path(int i) {
  static char name[MOST_PARTS][80];
  snprintf(name[i], sizeof name[i], "%s/part_%d.h5", folder, i);
  return name[i];
}

static void write_part(const struct deck_text *d, int number, int n, const char *name) {
  struct rad_case c;
  struct rad_error e;
  const struct rad_part_number part = {number, n};
  ck_assert_msg(deck_prepare(d, &c, &e) == RAD_OK, "%s", e.text);
  ck_assert_msg(rad_case_write_part(&c, part, name, "test", 0, &e) == RAD_OK, "%s", e.text);
  rad_case_free(&c);
}

static const struct {
  int problem, n;
} part_runs[] = {{0, 1}, {0, 2}, {0, 4}, {1, 1}, {1, 2}, {1, 4}, {4, 1},
                 {4, 2}, {4, 4}, {2, 3}, {3, 4}, {5, 3}, {6, 2}, {6, MOST_PARTS}};

/* Assembled in parts, read in the wrong order: the same matrix, solution and counters. */
START_TEST(in_parts) {
  struct deck_text *d = deck_of(&problems[part_runs[_i].problem]);
  const char *name[MOST_PARTS];
  struct rad_case a, b;
  struct rad_error e;
  int n = part_runs[_i].n;
  begin_folder();
  for (int i = 0; i < n; i++) {
    name[n - 1 - i] = part_path(i);
    write_part(d, i + 1, n, part_path(i));
  }
  solve(d, NULL, &a);
  ck_assert_int_eq(deck_prepare(d, &b, &e), RAD_OK);
  ck_assert_msg(rad_case_join(&b, n, name, &e) == RAD_OK, "%s", e.text);
  ck_assert_msg(rad_case_solve(&b, &e) == RAD_OK, "%s", e.text);
  check_same(&a, &b);
  check_counters(&a.dense.counters, &b.dense.counters);
  check_counters(&a.h2.counters, &b.h2.counters);
  for (int i = 0; i < n; i++)
    ck_assert_int_eq(unlink(name[i]), 0);
  rad_case_free(&a);
  rad_case_free(&b);
  free(d);
  end_folder();
}
END_TEST

/* Every unit has one owner, whatever the number of parts. */
START_TEST(parts_cover) {
  struct deck_text *d = deck_of(&problems[_i]);
  struct rad_case c;
  struct rad_error e;
  ck_assert_int_eq(deck_prepare(d, &c, &e), RAD_OK);
  ck_assert_int_eq(rad_case_begin_matrix(&c, &e), RAD_OK);
  for (int n = 1; n < 40; n += 3) {
    int at = 0, end = c.dense.done ? c.mesh->n_point : c.h2.tree.n_cluster;
    for (int i = 1; i <= n; i++) {
      const struct rad_part_number p = {i, n};
      struct rad_part_range r =
          c.dense.done ? rad_part_columns(&c.dense, p) : rad_part_clusters(&c.h2, p);
      ck_assert_int_le(r.first, r.end);
      if (r.first < r.end)
        ck_assert_int_eq(r.first, at);
      at = r.first < r.end ? r.end : at;
    }
    ck_assert_int_eq(at, end);
  }
  rad_case_free(&c);
  free(d);
}
END_TEST

static void check_parts_refused(struct rad_case *c, int n, const char *const *name,
                                enum rad_code code, const char *words) {
  struct rad_error e = {0};
  ck_assert_int_eq(rad_case_join(c, n, name, &e), code);
  ck_assert_msg(strstr(e.text, words) && !strchr(e.text, '\n'), "%s", e.text);
}

/* Missing, given twice, of another number, of another form, of another deck, damaged. */
START_TEST(parts_refused) {
  struct deck_text *d = deck_of(&problems[6]), *other = deck_of(&problems[0]);
  struct rad_case c;
  struct rad_error e;
  begin_folder();
  for (int i = 0; i < 3; i++)
    write_part(d, i + 1, 3, part_path(i));
  write_part(d, 1, 2, part_path(3));
  write_part(other, 2, 3, part_path(4));
  const char *name[] = {part_path(0), part_path(1), part_path(2)};
  ck_assert_int_eq(deck_prepare(d, &c, &e), RAD_OK);
  check_parts_refused(&c, 2, name, RAD_EINPUT, "part 3 of 3 is missing");
  name[2] = name[0];
  check_parts_refused(&c, 3, name, RAD_EINPUT, "part_0.h5 are both part 1 of 3");
  name[2] = part_path(3);
  check_parts_refused(&c, 3, name, RAD_EINPUT, "part_3.h5 one of 2");
  name[2] = part_path(4);
  check_parts_refused(&c, 3, name, RAD_EINPUT, "part_4.h5 was made from another deck");
  ck_assert_int_eq(truncate(part_path(2), 600), 0);
  name[2] = part_path(2);
  check_parts_refused(&c, 3, name, RAD_ESYSTEM, "part_2.h5 is damaged");
  save(&c);
  name[2] = path;
  check_parts_refused(&c, 3, name, RAD_ESYSTEM, "run.ck is not a polyrad part");
  for (int i = 0; i < MOST_PARTS; i++)
    unlink(part_path(i));
  rad_case_free(&c);
  free(d);
  free(other);
  end_folder();
}
END_TEST

/* --- stopped by a signal, in a process of its own --- */

static void stop_after(double seconds) {
  timer_t timer;
  struct sigevent event = {.sigev_notify = SIGEV_SIGNAL, .sigev_signo = SIGUSR1};
  struct itimerspec when = {.it_value = {(time_t)seconds, (long)(1e9 * fmod(seconds, 1)) + 1}};
  rad_stop_on_signals();
  if (timer_create(CLOCK_MONOTONIC, &event, &timer) || timer_settime(timer, 0, &when, NULL))
    abort();
}

/* In a child: go on, be stopped after a while, write a checkpoint. True if it was not stopped. */
static int run_a_while(const struct deck_text *d, const char *restart, double seconds) {
  pid_t child = fork();
  if (child == 0) {
    struct rad_case c;
    struct rad_error e;
    if (deck_prepare(d, &c, &e) || (restart && rad_case_restart(&c, restart, &e)))
      _exit(3);
    stop_after(seconds);
    enum rad_code code = rad_case_solve(&c, &e);
    if (code == RAD_ESTOPPED && rad_case_save(&c, path, "test", 0, &e))
      _exit(4);
    _exit(code == RAD_ESTOPPED ? 0 : code == RAD_OK ? 1 : 5);
  }
  int status;
  ck_assert_int_eq(waitpid(child, &status, 0), child);
  ck_assert_msg(WIFEXITED(status) && WEXITSTATUS(status) < 2, "status %x", status);
  return WEXITSTATUS(status);
}

/* Stopped again and again until it is done. The time grows, so that it ends on any machine. */
static int run_in_pieces(const struct deck_text *d, double seconds) {
  int n = 0;
  for (; !run_a_while(d, n ? path : NULL, seconds); n++, seconds *= 1.6)
    ck_assert_int_lt(n, 40);
  return n;
}

/* The same for adaptive runs, which lose the level in which they are stopped. */
START_TEST(adaptive_in_pieces) {
  struct deck_text *d = adaptive_deck(&adaptive_runs[_i]);
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

/* The last checkpoint of a run in many pieces leads to the same bits as one run. */
START_TEST(in_pieces) {
  static const struct problem gap = {
      gap_scene, "mesh: uniform, elements: 14, degree: 0, matrix: dense, solver: gmres"};
  const struct problem *p = _i < N_PROBLEM ? &problems[_i] : &gap;
  struct deck_text *d = deck_of(p);
  begin_folder();
  int n = run_in_pieces(d, 0.02); /* OpenMP has no threads yet in this process: children may */
  struct rad_case a, b;
  solve(d, NULL, &a);
  solve(d, n ? path : NULL, &b);
  if (getenv("POLYRAD_TEST_VERBOSE"))
    printf("problem %d: %d pieces, %d steps\n", _i, n + 1, a.report.iterations);
  check_same(&a, &b);
  check_counters(&a.dense.counters, &b.dense.counters);
  check_counters(&a.h2.counters, &b.h2.counters);
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

static char *read_bytes(size_t *n) {
  struct stat is;
  ck_assert_int_eq(stat(path, &is), 0);
  char *bytes = malloc((size_t)is.st_size);
  FILE *f = fopen(path, "rb");
  *n = fread(bytes, 1, (size_t)is.st_size, f);
  fclose(f);
  return bytes;
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
  size_t size;
  char *bytes = read_bytes(&size);
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
  TCase *c = tcase_create("checkpoint"), *a = tcase_create("adaptive");
  tcase_set_timeout(c, 300);
  tcase_set_timeout(a, 300);
  tcase_add_loop_test(c, round_trip, 0, N_PROBLEM);
  tcase_add_loop_test(c, half_done, 0, N_PROBLEM);
  tcase_add_loop_test(c, in_pieces, 0, N_PROBLEM + 1);
  tcase_add_loop_test(a, adaptive_levels, 0, N_ADAPTIVE);
  tcase_add_loop_test(a, nothing_is_lost, 0, 2);
  tcase_add_test(a, stage_refused);
  tcase_add_loop_test(a, adaptive_in_pieces, 0, N_ADAPTIVE);
  tcase_add_loop_test(c, in_parts, 0, sizeof part_runs / sizeof *part_runs);
  tcase_add_loop_test(c, parts_cover, 0, N_PROBLEM);
  tcase_add_test(c, parts_refused);
  tcase_add_test(c, damaged);
  tcase_add_test(c, foreign);
  suite_add_tcase(s, c);
  suite_add_tcase(s, a);
  return run_suite(s);
}
