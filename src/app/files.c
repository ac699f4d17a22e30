#include "app/files.h"

#include <stdlib.h>
#include <string.h>

#include "base/place.h"
#include "output/save.h"

/* A file that is written: what it is, and the option that names another. */
struct made {
  const char *path, *what, *option;
};

static enum rad_code fail(const struct made *m, const char *what, const char *path,
                          struct rad_error *e) {
  return rad_fail(e, RAD_EINPUT,
                  "error: the %s (%.300s) would overwrite the %s (%.300s); give another file by %s",
                  m->what, m->path, what, path, m->option);
}

/* A file is written under a temporary name first, which is made anew. */
static enum rad_code refuse(const struct made *m, const char *what, const char *path,
                            struct rad_error *e) {
  if (rad_is_same_file(m->path, path))
    return fail(m, what, path, e);
  char *temporary = rad_save_temporary(m->path);
  const bool same = temporary && rad_is_same_file(temporary, path);
  free(temporary);
  return same ? fail(m, what, path, e) : RAD_OK;
}

static enum rad_code refuse_meshes(const struct made *m, const struct rad_deck *deck,
                                   struct rad_error *e) {
  enum rad_code code = RAD_OK;
  for (int i = 0; deck && i < deck->n_named_mesh && !code; i++) {
    char *path = rad_path_beside(deck->path, deck->named_mesh[i]);
    code = path ? refuse(m, "mesh of the deck", path, e) : rad_fail_memory(e, "a name", 1000);
    free(path);
  }
  return code;
}

/* What the command makes. */
static const char *product(const struct rad_command *c) {
  return c->n_part ? "part" : !strcmp(c->verb, "study") && !c->n_task ? "table" : "result";
}

/* What a file named without an option is. */
static const char *role(const struct rad_command *c, int k) {
  return c->collects ? "file of a task" : k == 0 ? "deck" : "file of a part";
}

static enum rad_code refuse_given(const struct rad_command *c, const struct rad_deck *deck,
                                  const struct made *m, struct rad_error *e) {
  enum rad_code code = RAD_OK;
  for (int k = 0; k < c->n_file && !code; k++)
    code = refuse(m, role(c, k), c->file[k], e);
  if (!code && c->restart && m->path != c->checkpoint)
    code = refuse(m, "checkpoint of --restart", c->restart, e);
  return code ? code : refuse_meshes(m, deck, e);
}

/* Opening a pipe waits for who reads it. */
static enum rad_code refuse_obstacle(const struct made *m, struct rad_error *e) {
  const char *obstacle = rad_save_obstacle(m->path);
  if (!obstacle)
    return RAD_OK;
  return rad_fail(e, RAD_EINPUT,
                  "error: the %s cannot be written to %.300s, which is %s; give a file by %s",
                  m->what, m->path, obstacle, m->option);
}

enum rad_code rad_files_check(const struct rad_command *c, const struct rad_deck *deck,
                              const char *output, struct rad_error *e) {
  const struct made made[] = {{output, product(c), "-o"},
                              {c->checkpoint, "checkpoint", "--checkpoint"}};
  const int n = c->checkpoint ? 2 : 1;
  enum rad_code code = RAD_OK;
  for (int i = 0; i < n && !code; i++)
    code = refuse_given(c, deck, &made[i], e);
  if (!code && n == 2)
    code = refuse(&made[1], made[0].what, output, e);
  for (int i = 0; i < n && !code; i++)
    code = refuse_obstacle(&made[i], e);
  for (int i = 0; i < n && !code; i++)
    code = rad_save_try(made[i].path, e);
  return code;
}
