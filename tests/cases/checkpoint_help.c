#include "checkpoint_help.h"

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "app/checkpoint.h"
#include "base/stop.h"

char folder[] = "/tmp/polyrad_checkpoint_XXXXXX", path[64];

void begin_folder(void) {
  ck_assert_ptr_nonnull(mkdtemp(folder));
  snprintf(path, sizeof path, "%s/run.ck", folder);
}

void end_folder(void) { /* nothing but the checkpoint may have been left */
  unlink(path);
  ck_assert_int_eq(rmdir(folder), 0);
  strcpy(folder + strlen(folder) - 6, "XXXXXX");
}

size_t file_bytes(const char *name, char **bytes) {
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

/* --- problems --- */

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

const struct problem problems[N_PROBLEM] = {
    {corner_scene,
     "method: {mesh: paper, elements: 5, degree: 1, matrix: dense, quadrature_tolerance: 1e-8}"},
    {corner_scene,
     "method: {mesh: paper, elements: 5, degree: 1, matrix: hierarchical, "
     "quadrature_tolerance: 1e-6}"}, /* single precision */
    {corner_scene,
     "method: {mesh: graded, elements: 2, grading: 2, degree: 5, matrix: hierarchical, "
     "quadrature_tolerance: 1e-9}"}, /* double */
    {corner_scene,
     "method: {mesh: paper, elements: 4, grading: 2, degree: 1, matrix: hierarchical, "
     "quadrature_tolerance: 1e-6}"}, /* sectors */
    {shadow_scene,
     "method: {mesh: uniform, elements: 8, degree: 1, matrix: hierarchical, "
     "quadrature_tolerance: 1e-5}"},
    {shadow_scene,
     "method: {mesh: uniform, elements: 4, degree: 0, matrix: dense, "
     "quadrature_tolerance: 1e-6}"},
    {corner_scene,
     "method: {mesh: uniform, elements: 1, degree: 0, matrix: dense, solver: lu}"}, /* facets */
    {shadow_scene, "method: {mesh: uniform, elements: 4, degree: 0, solver: neumann, bounces: 7}"},
};
const struct problem several_cycles = {
    gap_scene, "method: {mesh: uniform, elements: 14, degree: 0, matrix: dense, solver: gmres}"};

const struct problem adaptive_runs[N_ADAPTIVE] = {
    {corner_scene, "accuracy: {tolerance: 1e-7}"},
    {corner_scene, "accuracy: {tolerance: 1e-6}\nmethod: {matrix: hierarchical}"},
    {shadow_scene, "accuracy: {tolerance: 5e-4}"},
};
struct deck_text *deck_of(const struct problem *p) {
  struct deck_text *d = malloc(sizeof *d);
  deck_begin(d);
  p->scene(d);
  deck_add(d, "%s\n", p->lines);
  return d;
}

void solve(const struct deck_text *d, const char *restart, struct rad_case *c) {
  struct rad_error e;
  ck_assert_msg(deck_prepare(d, c, &e) == RAD_OK, "%s", e.text);
  if (restart)
    ck_assert_msg(rad_case_restart(c, restart, &e) == RAD_OK, "%s", e.text);
  ck_assert_msg(rad_case_solve(c, &e) == RAD_OK, "%s", e.text);
}

void save(struct rad_case *c) {
  struct rad_error e;
  ck_assert_msg(rad_case_save(c, path, "test", 0, &e) == RAD_OK, "%s", e.text);
}

/* --- to the last bit --- */

static void check_blocks(const struct rad_h2_dense *a, const struct rad_h2_dense *b) {
  ck_assert_uint_eq(a->n, b->n);
  if (a->narrow)
    CHECK_SAME(a->narrow, b->narrow, a->n);
  else
    CHECK_SAME(a->wide, b->wide, a->n);
}

/* Matrices and solutions to the last bit. */
void check_same(const struct rad_case *a, const struct rad_case *b) {
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

static void check_count(const struct rad_counters *a, const struct rad_counters *b) {
  ck_assert_int_eq(a->kernel_values, b->kernel_values);
  ck_assert_int_eq(a->near, b->near);
  ck_assert_int_eq(a->far, b->far);
}

void check_counters(const struct rad_case *a, const struct rad_case *b) {
  check_count(&a->dense.counters, &b->dense.counters);
  check_count(&a->h2.counters, &b->h2.counters);
}

/* --- stopped by a signal, in a process of its own --- */

/* Of processor time, which does not count what else the machine does. */
static void stop_after(double seconds) {
  timer_t timer;
  struct sigevent event = {.sigev_notify = SIGEV_SIGNAL, .sigev_signo = SIGUSR1};
  struct itimerspec when = {.it_value = {(time_t)seconds, (long)(1e9 * fmod(seconds, 1)) + 1}};
  rad_stop_on_signals();
  if (timer_create(CLOCK_PROCESS_CPUTIME_ID, &event, &timer) ||
      timer_settime(timer, 0, &when, NULL))
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
int run_in_pieces(const struct deck_text *d, double seconds) {
  int n = 0;
  for (; !run_a_while(d, n ? path : NULL, seconds); n++, seconds *= 1.6)
    ck_assert_int_lt(n, 40);
  return n;
}
