#include "app/checkpoint.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <omp.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/place.h"
#include "base/stop.h"
#include "output/checkpoint.h"
#include "output/part_file.h"
#include "output/save.h"

static struct rad_origin origin_of(const struct rad_case *c, const char *command, double started) {
  return (struct rad_origin){.deck = &c->deck,
                             .n_set = c->n_set,
                             .set = c->set,
                             .scene = c->scene.triangle ? &c->scene : NULL,
                             .mesh = c->is_adaptive ? NULL : c->mesh,
                             .command = command,
                             .threads = omp_get_max_threads(),
                             .started = started};
}

static struct rad_part_matrix matrix_of(struct rad_case *c) {
  return (struct rad_part_matrix){c->dense.done ? &c->dense : NULL,
                                  c->h2.near_done ? &c->h2 : NULL};
}

static struct rad_checkpoint content_of(struct rad_case *c) {
  const struct rad_part_matrix m = matrix_of(c);
  return (struct rad_checkpoint){.dense = m.dense,
                                 .h2 = m.h2,
                                 .iterate = &c->iterate,
                                 .stage = c->adaptive.stage.leaf ? &c->adaptive.stage : NULL};
}

enum rad_code rad_case_save(struct rad_case *c, const char *path, const char *command,
                            double started, struct rad_error *e) {
  const struct rad_origin origin = origin_of(c, command, started);
  struct rad_checkpoint holds = content_of(c);
  if (c->is_adaptive && !holds.stage) /* the first level begins again */
    holds = (struct rad_checkpoint){0};
  return rad_checkpoint_write(path, &origin, &holds, e);
}

enum rad_code rad_case_restart(struct rad_case *c, const char *path, struct rad_error *e) {
  const struct rad_origin origin = origin_of(c, NULL, 0);
  enum rad_matrix form = RAD_MATRIX_AUTO;
  enum rad_code code = rad_checkpoint_look(path, &origin, &form, e);
  if (!code && form != RAD_MATRIX_AUTO && !c->is_adaptive)
    code = rad_case_keep_form(c, form, e);
  c->restart = path;
  return code;
}

enum rad_code rad_case_join(struct rad_case *c, int n_file, const char *const *file,
                            struct rad_error *e) {
  const struct rad_origin origin = origin_of(c, NULL, 0);
  enum rad_matrix form;
  if (c->is_adaptive)
    return rad_refuse_parts(c, e);
  enum rad_code code = rad_parts_look(n_file, file, &origin, &form, e);
  if (!code)
    code = rad_case_keep_form(c, form, e);
  c->n_part = n_file;
  c->part = file;
  return code;
}

enum rad_code rad_case_write_part(struct rad_case *c, struct rad_part_number part, const char *path,
                                  const char *command, double started, struct rad_error *e) {
  const struct rad_origin origin = origin_of(c, command, started);
  enum rad_code code = rad_case_begin_matrix(c, e);
  const struct rad_part_matrix m = matrix_of(c);
  if (!code && m.dense) {
    code = rad_part_mark_dense(m.dense, part, e);
    if (!code)
      code = rad_dense_finish(&c->rules, NULL, m.dense, e);
  } else if (!code) {
    rad_part_mark_h2(m.h2, part);
    code = rad_h2_part(m.h2, &c->rules, e);
  }
  return code ? code : rad_part_write(path, &origin, part, &m, e);
}

enum rad_code rad_case_restore(struct rad_case *c, struct rad_error *e) {
  const struct rad_origin origin = origin_of(c, NULL, 0);
  const struct rad_part_matrix m = matrix_of(c);
  if (!c->restart)
    return rad_parts_read(c->n_part, c->part, &origin, &m, e);
  const struct rad_checkpoint into = content_of(c);
  enum rad_code code = rad_checkpoint_read(c->restart, &origin, &into, e);
  c->is_restored = !code;
  return code;
}

static enum rad_code read_stage_matrix(void *context, struct rad_dense *dense, struct rad_h2 *h2,
                                       struct rad_error *e) {
  const struct rad_case *c = context;
  const struct rad_origin origin = origin_of(c, NULL, 0);
  const struct rad_checkpoint into = {.dense = dense, .h2 = h2};
  return rad_checkpoint_read(c->restart, &origin, &into, e);
}

enum rad_code rad_case_stage(struct rad_case *c, struct rad_stage *stage, struct rad_error *e) {
  const struct rad_origin origin = origin_of(c, NULL, 0);
  *stage = (struct rad_stage){0};
  enum rad_code code =
      c->restart ? rad_checkpoint_read_stage(c->restart, &origin, stage, e) : RAD_OK;
  stage->read = read_stage_matrix;
  stage->context = c;
  return code;
}

const char *rad_restart_find(const struct rad_command *command) {
  const char *path = command->restart;
  if (!path || access(path, F_OK) == 0 || !command->checkpoint ||
      !rad_is_same_file(path, command->checkpoint))
    return path;
  fprintf(command->log, "%s does not exist yet: the run starts from the beginning\n", path);
  return NULL;
}

/* True if a run has at least what the checkpoint had from which it goes on. */
static int is_ahead(const struct rad_case *c) {
  return c->is_adaptive ? c->adaptive.stage.leaf != NULL : c->is_restored;
}

static int copy_file(int to, void *path) {
  struct stat is;
  int from = open(path, O_RDONLY);
  int error = from < 0 || fstat(from, &is) ? errno : rad_copy_part(from, to, 0, is.st_size);
  if (from >= 0)
    close(from);
  return error;
}

enum rad_code rad_case_keep(struct rad_case *c, const struct rad_command *command, double started,
                            int *is_old, struct rad_error *e) {
  const char *old = command->restart, *path = command->checkpoint;
  *is_old = old && access(old, F_OK) == 0 && !is_ahead(c);
  if (!*is_old)
    return rad_case_save(c, path, command->line, started, e);
  return rad_is_same_file(old, path) ? RAD_OK : rad_save_by(path, copy_file, (void *)old, e);
}

enum rad_code rad_case_stopped(struct rad_case *c, const struct rad_command *command,
                               double started, struct rad_error *e) {
  const char *path = command->checkpoint;
  struct stat is;
  if (!path)
    return rad_fail(e, RAD_ESTOPPED,
                    "stopped by %s; nothing is written: with --checkpoint FILE the work would have "
                    "been kept",
                    rad_stop_name());
  if (!rad_case_is_read(c)) /* it comes from a pipe */
    return rad_fail(
        e, RAD_ECHECKPOINT,
        "stopped by %s before the deck was read; nothing is written: to begin, give the "
        "same command again",
        rad_stop_name());
  int is_old, again = command->restart && rad_is_same_file(path, command->restart);
  enum rad_code code = rad_case_keep(c, command, started, &is_old, e);
  if (code)
    return code;
  return rad_fail(e, RAD_ECHECKPOINT,
                  "stopped by %s; checkpoint %s %.400s (%.3g MB): to go on, give the same "
                  "command again%s%.400s",
                  rad_stop_name(), is_old && again ? "stays as it was in" : "written to", path,
                  stat(path, &is) ? NAN : (double)is.st_size / 1e6, again ? "" : " with --restart ",
                  again ? "" : path);
}
