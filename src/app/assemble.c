/* polyrad assemble and polyrad solve: the matrix in parts, made by many and solved with by one. */
#include <math.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "app/checkpoint.h"
#include "app/files.h"
#include "base/text.h"
#include "output/stamp.h"

enum rad_code rad_refuse_parts(const struct rad_case *c, struct rad_error *e) {
  return rad_fail(e, RAD_EINPUT,
                  "%s: error: the matrix of an adaptive run cannot be assembled in parts: its mesh "
                  "is found while it is solved; give a mesh by hand (method: {mesh: .., elements: "
                  "..}), or use polyrad run",
                  c->deck.path);
}

/* Where the part goes: -o, or NAME_part_2_of_4.h5 of the result's name. */
static char *name_file(const struct rad_case *c, const struct rad_command *command) {
  if (command->output)
    return rad_path_of(command->output, "", NULL);
  char tail[64];
  int width = snprintf(NULL, 0, "%d", command->n_part);
  snprintf(tail, sizeof tail, "_part_%0*d_of_%d", width, command->part, command->n_part);
  return rad_path_of(c->deck.output.file, tail, ".h5");
}

static void say(const struct rad_case *c, const struct rad_command *command, const char *path) {
  struct stat is;
  double bytes = stat(path, &is) ? NAN : (double)is.st_size;
  if (!command->quiet)
    fprintf(command->out, "part %d of %d of a %s matrix, %d unknowns: written %s (%.3g MB)\n",
            command->part, command->n_part,
            c->plan.system.matrix == RAD_MATRIX_DENSE ? "dense" : "hierarchical", c->mesh->n_point,
            path, bytes / 1e6);
}

/* A case that is prepared: its part, and the file. */
static enum rad_code assemble(struct rad_case *c, const struct rad_command *command,
                              const char *path, double started, struct rad_error *e) {
  if (c->is_adaptive)
    return rad_refuse_parts(c, e);
  const struct rad_part_number part = {command->part, command->n_part};
  rad_progress_phase(c->scene.progress, "matrix");
  enum rad_code code = rad_case_write_part(c, part, path, command->line, started, e);
  rad_progress_clear(c->scene.progress);
  if (!code)
    say(c, command, path);
  return code;
}

enum rad_code rad_app_assemble(const struct rad_command *command, struct rad_error *e) {
  if (!command->n_part)
    return rad_fail(e, RAD_EINPUT, "error: polyrad assemble needs --part I/N, for example 1/4");
  struct rad_case c;
  struct rad_progress line, *progress = command->quiet ? NULL : &line;
  double started = rad_stamp_now();
  rad_progress_init(&line, command->log);
  enum rad_code code = rad_case_read(command->deck, command->n_set, command->set, progress, &c, e);
  char *path = code ? NULL : name_file(&c, command);
  if (!code)
    code = path ? rad_files_check(command, &c.deck, path, e)
                : rad_fail_memory(e, "the name of a file", 0);
  if (!code)
    code = rad_case_build(progress, &c, e);
  rad_progress_clear(progress);
  for (int i = 0; i < c.notes.n; i++)
    fprintf(command->log, "%s\n", c.notes.text[i]);
  if (!code)
    code = assemble(&c, command, path, started, e);
  free(path);
  rad_case_free(&c);
  return code;
}

enum rad_code rad_app_solve(const struct rad_command *command, struct rad_error *e) {
  if (!command->joins || command->n_file < 2)
    return rad_fail(e, RAD_EINPUT,
                    "error: polyrad solve needs the parts of the matrix: polyrad solve DECK "
                    "--parts FILE...; polyrad assemble makes them");
  return rad_app_run(command, e);
}
