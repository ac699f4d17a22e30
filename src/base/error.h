/* Statuses and messages: how every module tells its caller what went wrong, and what was noticed.
 */
#ifndef RAD_BASE_ERROR_H
#define RAD_BASE_ERROR_H

/* The values are the program's exit codes (docs/format.md). */
enum rad_code {
  RAD_OK = 0,
  RAD_ENUMERIC = 1,    /* singular, not converged, not finite */
  RAD_EINPUT = 2,      /* deck, scene or command line */
  RAD_ESYSTEM = 3,     /* file, memory or device */
  RAD_ESTOPPED = 4,    /* by a signal; main then dies by it, so that this is no exit code */
  RAD_ECHECKPOINT = 85 /* stopped, and a checkpoint is written: start the run again from it */
};

struct rad_error {
  enum rad_code code;
  char text[1024]; /* one sentence: what, where, what to do; no newline at the end */
};

/**
 * Fill e and return code, so that callers write `return rad_fail(e, RAD_EINPUT, "...", ...)`.
 *
 * @param[out] e     may not be NULL
 * @param[in]  code  not RAD_OK
 * @param[in]  fmt   printf format of one sentence without a newline
 */
enum rad_code rad_fail(struct rad_error *e, enum rad_code code, const char *fmt, ...)
    __attribute__((format(printf, 3, 4)));

/* Out of memory for `what`: RAD_ESYSTEM with the size that was asked for. */
enum rad_code rad_fail_memory(struct rad_error *e, const char *what, double bytes);

/* Warnings collected on the way; only the application prints them. */
struct rad_notes {
  int n;
  char **text; /* owned [n] */
};

void rad_notes_add(struct rad_notes *notes, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
void rad_notes_free(struct rad_notes *notes); /* safe twice */

#endif
