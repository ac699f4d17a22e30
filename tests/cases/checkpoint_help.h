/* Shared by the tests of checkpoints, of adaptive levels and of parts: a folder, small problems,
 * and what "the same to the last bit" means. */
#ifndef POLYRAD_CHECKPOINT_HELP_H
#define POLYRAD_CHECKPOINT_HELP_H

#include <check.h>
#include <string.h>

#include "app/case.h"
#include "scene_text.h"

/* A folder for one test, and the name of a checkpoint in it. */
extern char folder[], path[64];
void begin_folder(void);
void end_folder(void); /* nothing but the checkpoint may have been left */

/* A whole file; the caller frees its bytes. */
size_t file_bytes(const char *name, char **bytes);

/* A scene, and further lines of its deck. */
struct problem {
  void (*scene)(struct deck_text *);
  const char *lines;
};
enum { N_PROBLEM = 8, N_ADAPTIVE = 3 };
extern const struct problem problems[N_PROBLEM]; /* meshes by hand */
extern const struct problem adaptive_runs[N_ADAPTIVE];
extern const struct problem several_cycles; /* GMRES begins anew more than once */

/* The caller frees it. */
struct deck_text *deck_of(const struct problem *p);

/* Prepare, go on from the checkpoint `restart` unless it is NULL, and solve. */
void solve(const struct deck_text *d, const char *restart, struct rad_case *c);

/* A checkpoint of c at `path`. */
void save(struct rad_case *c);

/* Run it in children that are stopped by a signal, each going on from the checkpoint of the one
 * before; the first after `seconds`, then later and later, so that it ends on any machine.
 * @return how many were stopped. OpenMP must not have begun in this process: children use it. */
int run_in_pieces(const struct deck_text *d, double seconds);

#define CHECK_SAME(a, b, n) ck_assert_int_eq(memcmp(a, b, sizeof *(a) * (size_t)(n)), 0)

/* Matrices and solutions; what was counted while the matrices were made. */
void check_same(const struct rad_case *a, const struct rad_case *b);
void check_counters(const struct rad_case *a, const struct rad_case *b);

#endif
