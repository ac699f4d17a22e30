#include "output/stamp.h"

#include <math.h>
#include <stdio.h>
#include <time.h>

#include "base/provenance.h"

double rad_stamp_now(void) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Empty when the time is no time. */
static void iso_time(double seconds, char text[32]) {
  struct tm utc;
  text[0] = '\0';
  if (!(fabs(seconds) < 1e11)) /* the year 5000; also NAN */
    return;
  const time_t whole = (time_t)floor(seconds);
  if (gmtime_r(&whole, &utc))
    strftime(text, 32, "%Y-%m-%dT%H:%M:%SZ", &utc);
}

static void set_program(struct rad_hdf *h, hid_t group) {
  struct rad_provenance program = {0};
  rad_provenance_get(&program);
  unsigned major = 0, minor = 0, release = 0;
  char hdf5[48] = "unknown";
  if (H5get_libversion(&major, &minor, &release) >= 0)
    snprintf(hdf5, sizeof hdf5, "%u.%u.%u", major, minor, release);
  rad_hdf_set_text(h, group, "version", program.version);
  rad_hdf_set_text(h, group, "git_revision", program.git_revision);
  rad_hdf_set_text(h, group, "compiler", program.compiler);
  rad_hdf_set_text(h, group, "flags", program.flags);
  rad_hdf_set_text(h, group, "blas", program.blas);
  rad_hdf_set_integer(h, group, "blas_parallel", program.blas_parallel);
  rad_hdf_set_text(h, group, "hdf5", hdf5);
  rad_hdf_set_text(h, group, "machine", program.machine);
}

hid_t rad_stamp(struct rad_hdf *h, const struct rad_deck *deck, const char *command, int threads,
                double started) {
  const hid_t group = rad_hdf_group(h, h->file, "polyrad");
  char when[32];
  iso_time(started, when);
  set_program(h, group);
  rad_hdf_set_text(h, group, "title", deck->title);
  rad_hdf_set_texts(h, group, "bands", (size_t)deck->n_band, (const char *const *)deck->band);
  rad_hdf_set_integer(h, group, "threads", threads);
  rad_hdf_set_text(h, group, "started", when);
  rad_hdf_set_text(h, group, "deck", deck->text);
  rad_hdf_set_text(h, group, "command", command);
  return group;
}
