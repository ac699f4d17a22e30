#include "base/memory.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#define UNLIMITED 1e300

/* The number after `key` in a /proc style file, or -1. */
static double read_key(const char *path, const char *key) {
  FILE *f = fopen(path, "r");
  if (!f)
    return -1;
  char line[256];
  double value = -1;
  while (value < 0 && fgets(line, sizeof line, f))
    if (!strncmp(line, key, strlen(key)))
      sscanf(line + strlen(key), "%lf", &value);
  fclose(f);
  return value;
}

static double resource_rest(int resource, double used) {
  struct rlimit limit;
  if (getrlimit(resource, &limit) || limit.rlim_cur == RLIM_INFINITY)
    return UNLIMITED;
  double rest = (double)limit.rlim_cur - used;
  return rest > 0 ? rest : 0;
}

/* What the cgroup (version 2, then 1) leaves; "max" is no number and reads as unlimited. */
static double cgroup_rest(void) {
  static const char *const file[][2] = {
      {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"},
      {"/sys/fs/cgroup/memory/memory.limit_in_bytes",
       "/sys/fs/cgroup/memory/memory.usage_in_bytes"}};
  for (int v = 0; v < 2; v++) {
    double limit = read_key(file[v][0], ""), used = read_key(file[v][1], "");
    if (limit > 0 && limit < 1e18)
      return limit > used ? limit - used : 0;
  }
  return UNLIMITED;
}

double rad_memory_available(void) {
  double free_ram = 1024 * read_key("/proc/meminfo", "MemAvailable:");
  if (free_ram < 0)
    free_ram = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
  double used = 1024 * read_key("/proc/self/status", "VmSize:");
  double data = 1024 * read_key("/proc/self/status", "VmData:");
  double least = free_ram;
  double rest[] = {resource_rest(RLIMIT_AS, used), resource_rest(RLIMIT_DATA, data), cgroup_rest()};
  for (int i = 0; i < 3; i++)
    least = rest[i] < least ? rest[i] : least;
  return least;
}

double rad_memory_peak(void) {
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * (double)usage.ru_maxrss;
}

void *rad_pages_alloc(size_t bytes) {
  void *pages =
      mmap(NULL, bytes ? bytes : 1, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (pages == MAP_FAILED)
    return NULL;
#ifdef MADV_HUGEPAGE
  madvise(pages, bytes, MADV_HUGEPAGE); /* a wish: without it everything works, a little slower */
#endif
  return pages;
}

void rad_pages_free(void *pages, size_t bytes) {
  if (pages)
    munmap(pages, bytes ? bytes : 1);
}

void *rad_alloc(size_t n, size_t item) {
  if (item && n > SIZE_MAX / item)
    return NULL;
  return malloc(n && item ? n * item : 1);
}

void *rad_calloc(size_t n, size_t item) {
  return calloc(n ? n : 1, item);
}
