/* What a long run is doing: one line on a terminal, a line a minute elsewhere.
 *
 * Serial code names a phase and begins a count; loops add what they have done, from any thread, and
 * whichever thread finds that it is time prints. Every call takes NULL for silence. */
#ifndef RAD_BASE_PROGRESS_H
#define RAD_BASE_PROGRESS_H

#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>

struct rad_progress {
  FILE *out; /* borrowed */
  int terminal;
  double first, every; /* seconds until the first line, and between lines */
  double start;        /* of the run */
  char run[48];        /* which of several runs, or empty */
  char phase[48];
  const char *unit; /* of the count, or NULL: nothing is counted */
  double begin;     /* of the count */
  int64_t total;    /* 0: unknown */
  atomic_int_fast64_t done;
  atomic_int_fast64_t next; /* when to print again [ms since start] */
  atomic_int shown;         /* there is a line on the terminal */
};

/* out a terminal: a line after half a second, renewed three times a second; else every minute. */
void rad_progress_init(struct rad_progress *p, FILE *out);

/* Serial code only: which run of how many; the phase; what will be counted, and how often. */
void rad_progress_run(struct rad_progress *p, int number, int n);
void rad_progress_phase(struct rad_progress *p, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
void rad_progress_begin(struct rad_progress *p, const char *unit, int64_t total);

/* Any thread: n more are done. A clock reading, and now and then a line. */
void rad_progress_add(struct rad_progress *p, int64_t n);

/* Clear the line before something else is printed; serial code only. */
void rad_progress_clear(struct rad_progress *p);

#endif
