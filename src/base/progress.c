#include "base/progress.h"

#include <inttypes.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/memory.h"

void rad_progress_init(struct rad_progress *p, FILE *out) {
  const int terminal = isatty(fileno(out));
  *p = (struct rad_progress){.out = out,
                             .terminal = terminal,
                             .first = terminal ? 0.5 : 60,
                             .every = terminal ? 0.33 : 60,
                             .start = rad_seconds()};
  atomic_store(&p->next, (int_fast64_t)(1e3 * p->first));
}

static void print_seconds(double s, size_t size, char text[size]) {
  const int whole = s < 1e7 ? (int)(s + 0.5) : 10000000;
  if (whole < 60)
    snprintf(text, size, "%d s", whole);
  else if (whole < 3600)
    snprintf(text, size, "%d:%02d min", whole / 60, whole % 60);
  else
    snprintf(text, size, "%d:%02d h", whole / 3600, whole / 60 % 60);
}

/* A number in at most five characters or so. */
static void print_count(double n, size_t size, char text[size]) {
  if (n < 1e4)
    snprintf(text, size, n < 10 && n > 0 ? "%.2g" : "%.0f", n);
  else
    snprintf(text, size, n < 1e7 ? "%.0fk" : "%.0fM", n < 1e7 ? n / 1e3 : n / 1e6);
}

/* "1234 of 5678 blocks (22 %), 310/s, 14 s left" */
static void print_done(const struct rad_progress *p, double now, size_t size, char text[size]) {
  const double done = (double)atomic_load(&p->done), seconds = now - p->begin;
  const double rate = seconds > 0 ? done / seconds : 0;
  char count[24], speed[24], left[24];
  print_count(done, sizeof count, count);
  print_count(rate, sizeof speed, speed);
  if (p->total > 0 && rate > 0) {
    char all[24];
    print_count((double)p->total, sizeof all, all);
    print_seconds(((double)p->total - done) / rate, sizeof left, left);
    snprintf(text, size, ": %s of %s %s (%.0f %%), %s/s, %s left", count, all, p->unit,
             100 * done / (double)p->total, speed, left);
  } else {
    snprintf(text, size, ": %s %s, %s/s", count, p->unit, speed);
  }
}

/* A line that wraps cannot be written over. */
static void clip(const struct rad_progress *p, char *line) {
  struct winsize size = {0};
  if (ioctl(fileno(p->out), TIOCGWINSZ, &size) || size.ws_col < 2)
    size.ws_col = 80;
  if (strlen(line) >= size.ws_col)
    line[size.ws_col - 1] = '\0';
}

/* The line at this moment, written at once: other threads may print soon after. */
static void print(struct rad_progress *p, double now) {
  char done[160] = "", elapsed[24], line[320];
  if (p->unit)
    print_done(p, now, sizeof done, done);
  print_seconds(now - p->start, sizeof elapsed, elapsed);
  snprintf(line, sizeof line, "%s%s%s; %s, %.2f GB", p->run, p->phase, done, elapsed,
           rad_memory_peak() / 1e9);
  if (p->terminal)
    clip(p, line);
  fprintf(p->out, p->terminal ? "\r%s\033[K" : "progress: %s\n", line);
  fflush(p->out);
  atomic_store(&p->shown, p->terminal);
}

/* Print if it is time and nobody else does. */
static void notice(struct rad_progress *p) {
  const double now = rad_seconds();
  int_fast64_t due = atomic_load_explicit(&p->next, memory_order_relaxed);
  const int_fast64_t at = (int_fast64_t)(1e3 * (now - p->start));
  if (at >= due &&
      atomic_compare_exchange_strong(&p->next, &due, at + (int_fast64_t)(1e3 * p->every)))
    print(p, now);
}

void rad_progress_run(struct rad_progress *p, int number, int n) {
  if (p && n > 1)
    snprintf(p->run, sizeof p->run, "run %d of %d, ", number, n);
}

void rad_progress_phase(struct rad_progress *p, const char *fmt, ...) {
  if (!p)
    return;
  va_list args;
  va_start(args, fmt);
  vsnprintf(p->phase, sizeof p->phase, fmt, args);
  va_end(args);
  p->unit = NULL;
  notice(p);
}

void rad_progress_begin(struct rad_progress *p, const char *unit, int64_t total) {
  if (!p)
    return;
  p->unit = unit;
  p->total = total;
  p->begin = rad_seconds();
  atomic_store(&p->done, 0);
}

void rad_progress_add(struct rad_progress *p, int64_t n) {
  if (!p)
    return;
  atomic_fetch_add_explicit(&p->done, n, memory_order_relaxed);
  notice(p);
}

void rad_progress_clear(struct rad_progress *p) {
  if (!p || !atomic_exchange(&p->shown, 0))
    return;
  fputs("\r\033[K", p->out);
  fflush(p->out);
}
