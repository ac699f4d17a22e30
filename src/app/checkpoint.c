#include "app/checkpoint.h"

#include <math.h>
#include <omp.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/stop.h"
#include "output/checkpoint.h"

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

enum rad_code rad_case_save(struct rad_case *c, const char *path, const char *command,
                            double started, struct rad_error *e) {
  const struct rad_origin origin = origin_of(c, command, started);
  struct rad_checkpoint holds = {0};
  if (!c->is_adaptive) /* which begins again */
    holds = (struct rad_checkpoint){c->dense.done ? &c->dense : NULL,
                                    c->h2.near_done ? &c->h2 : NULL, &c->iterate};
  return rad_checkpoint_write(path, &origin, &holds, e);
}

enum rad_code rad_case_restart(struct rad_case *c, const char *path, struct rad_error *e) {
  const struct rad_origin origin = origin_of(c, NULL, 0);
  enum rad_matrix form = RAD_MATRIX_AUTO;
  enum rad_code code = rad_checkpoint_look(path, &origin, &form, e);
  if (!code && form != RAD_MATRIX_AUTO)
    code = rad_case_keep_form(c, form, e);
  c->restart = path;
  return code;
}

enum rad_code rad_case_restore(struct rad_case *c, struct rad_error *e) {
  const struct rad_origin origin = origin_of(c, NULL, 0);
  const struct rad_checkpoint into = {c->dense.done ? &c->dense : NULL,
                                      c->h2.near_done ? &c->h2 : NULL, &c->iterate};
  return rad_checkpoint_read(c->restart, &origin, &into, e);
}

const char *rad_restart_find(const struct rad_command *command) {
  const char *path = command->restart;
  if (!path || access(path, F_OK) == 0 || !command->checkpoint ||
      strcmp(path, command->checkpoint) != 0)
    return path;
  fprintf(command->log, "%s does not exist yet: the run starts from the beginning\n", path);
  return NULL;
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
  enum rad_code code = rad_case_save(c, path, command->line, started, e);
  if (code)
    return code;
  int again = command->restart && !strcmp(path, command->restart);
  return rad_fail(e, RAD_ECHECKPOINT,
                  "stopped by %s; checkpoint written to %.400s (%.3g MB): to go on, give the same "
                  "command again%s%.400s",
                  rad_stop_name(), path, stat(path, &is) ? NAN : (double)is.st_size / 1e6,
                  again ? "" : " with --restart ", again ? "" : path);
}
