#include "base/error.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum rad_code rad_fail(struct rad_error *e, enum rad_code code, const char *fmt, ...) {
  va_list args;
  va_start(args, fmt);
  vsnprintf(e->text, sizeof e->text, fmt, args);
  va_end(args);
  e->code = code;
  return code;
}

enum rad_code rad_fail_memory(struct rad_error *e, const char *what, double bytes) {
  return rad_fail(e, RAD_ESYSTEM,
                  "out of memory: %s needs %.3g MB more; use fewer elements or a larger machine",
                  what, bytes / 1e6);
}

void rad_notes_add(struct rad_notes *notes, const char *fmt, ...) {
  char line[1024];
  va_list args;
  va_start(args, fmt);
  vsnprintf(line, sizeof line, fmt, args);
  va_end(args);
  char **grown = realloc(notes->text, sizeof(char *) * (size_t)(notes->n + 1));
  if (!grown)
    return; /* a warning is never worth dying for */
  notes->text = grown;
  char *copy = strdup(line);
  if (copy)
    notes->text[notes->n++] = copy;
}

void rad_notes_free(struct rad_notes *notes) {
  for (int i = 0; i < notes->n; i++)
    free(notes->text[i]);
  free(notes->text);
  *notes = (struct rad_notes){0};
}
