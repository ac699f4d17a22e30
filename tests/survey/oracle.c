// survey_oracle FILE means|factors|rays [first=N] [most=N] [rays=N] [paths=N] [replicates=N]
// [closed=N] [target=X] [seed=N] Lines `what i j value error`: factor i j (from i to j), row_sum i
// 0, direct_irradiance i band (by emission alone); with means also irradiance, radiosity and net
// (radiosity less irradiance) of surface i in a band. The error: a standard error, and what so many
// points may have missed.
#include "oracle.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool power_of_two(double x) {
  for (double p = 1; p <= 1 << 24; p *= 2)
    if (x == p)
      return true;
  return false;
}

static void set(struct oracle_settings *o, const char *text) {
  const char *equal = strchr(text, '=');
  const double x = equal ? atof(equal + 1) : 0;
  const size_t n = equal ? (size_t)(equal - text) : 0;
  if (n == 5 && !strncmp(text, "first", n) && power_of_two(x))
    o->first = (uint32_t)x;
  else if (n == 4 && !strncmp(text, "most", n) && power_of_two(x))
    o->most = (uint32_t)x;
  else if (n == 4 && !strncmp(text, "rays", n) && power_of_two(x))
    o->rays = (uint32_t)x;
  else if (n == 5 && !strncmp(text, "paths", n) && power_of_two(x))
    o->paths = (uint32_t)x;
  else if (n == 10 && !strncmp(text, "replicates", n) && x >= 2 && x <= oracle_replicates)
    o->replicates = (int)x;
  else if (n == 6 && !strncmp(text, "closed", n) && x >= 0)
    o->closed = (int)x;
  else if (n == 6 && !strncmp(text, "target", n) && x >= 0)
    o->target = x;
  else if (n == 4 && !strncmp(text, "seed", n))
    o->seed = (uint64_t)x;
  else
    oracle_die("what is %s?", text);
}

int main(int argc, char **argv) {
  struct oracle_settings o = {.first = 64,
                              .most = 1024,
                              .rays = 64,
                              .paths = 1024,
                              .replicates = 16,
                              .closed = 16,
                              .target = 1e-5,
                              .seed = 1};
  if (argc < 3)
    oracle_die(
        "usage: FILE means|factors|rays [first=N] [most=N] [rays=N] [paths=N] [replicates=N] "
        "[closed=N] [target=X] [seed=N]");
  for (int i = 3; i < argc; i++)
    set(&o, argv[i]);
  const bool means = !strcmp(argv[2], "means"), rays = !strcmp(argv[2], "rays");
  if (!means && !rays && strcmp(argv[2], "factors") != 0)
    oracle_die("what is %s?", argv[2]);
  struct oracle_scene *s = oracle_read(argv[1]);
  if (rays) {
    oracle_rays(s, &o);
  } else {
    struct oracle_sums q = oracle_sum_factors(s, &o);
    oracle_factors(s, o.replicates, &q);
    if (means)
      oracle_means(s, &o, &q);
    oracle_free_sums(&q);
  }
  oracle_free(s);
  return 0;
}
