#include "base/memory.h"

#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#define UNLIMITED 1e300
#define HUGE_PAGE ((size_t)2 << 20) /* bytes */
#define THREAD_BYTES 1.5e8 /* malloc's arena of 64 MB, BLAS's buffer of 32 MB, stack and holes */

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

/* The rest of one cgroup folder; "max" is no number and reads as unlimited. */
static double folder_rest(const char *folder, const char *limit_name, const char *used_name) {
  char path[PATH_MAX + 64];
  snprintf(path, sizeof path, "%s/%s", folder, limit_name);
  double limit = read_key(path, "");
  snprintf(path, sizeof path, "%s/%s", folder, used_name);
  double used = read_key(path, "");
  if (limit < 0 || limit > 1e18)
    return UNLIMITED;
  return limit > used ? limit - fmax(used, 0) : 0;
}

/* What this process's cgroup and those above it leave: the line "0::/path" (version 2) or
 * "n:memory:/path" (version 1) of /proc/self/cgroup, walked up to the root. */
static double cgroup_rest(void) {
  FILE *f = fopen("/proc/self/cgroup", "r");
  char line[PATH_MAX], folder[PATH_MAX + 32];
  double least = UNLIMITED;
  while (f && fgets(line, sizeof line, f)) {
    char *name = strchr(line, ':'), *path = name ? strchr(name + 1, ':') : NULL;
    if (!path)
      continue;
    *path++ = 0;
    path[strcspn(path, "\n")] = 0;
    int unified = !strcmp(name, ":");
    if (!unified && strcmp(name, ":memory"))
      continue;
    snprintf(folder, sizeof folder, "/sys/fs/cgroup%s%s", unified ? "" : "/memory",
             strcmp(path, "/") ? path : "");
    while (strlen(folder) >= strlen("/sys/fs/cgroup")) {
      least = fmin(least,
                   unified ? folder_rest(folder, "memory.max", "memory.current")
                           : folder_rest(folder, "memory.limit_in_bytes", "memory.usage_in_bytes"));
      *strrchr(folder, '/') = 0;
    }
  }
  if (f)
    fclose(f);
  return least;
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

double rad_memory_reserved(int n_thread) {
  return resource_rest(RLIMIT_AS, 0) < UNLIMITED ? THREAD_BYTES * n_thread : 0;
}

double rad_memory_resident(void) {
  return 1024 * fmax(read_key("/proc/self/status", "VmRSS:"), 0);
}

/* Not ru_maxrss, which a process inherits from the one that started it. */
double rad_memory_peak(void) {
  struct rusage usage;
  double peak = 1024 * read_key("/proc/self/status", "VmHWM:");
  if (peak > 0)
    return peak;
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * (double)usage.ru_maxrss;
}

/* Whole huge pages: only then does Linux place the first one on such a page's boundary. */
static size_t whole_pages(size_t bytes) {
  size_t page = bytes < HUGE_PAGE ? 4096 : HUGE_PAGE;
  return (bytes + RAD_BEYOND + page - 1) / page * page;
}

void *rad_pages_alloc(size_t bytes) {
  if (bytes > SIZE_MAX / 2)
    return NULL;
  size_t whole = whole_pages(bytes);
  void *pages = mmap(NULL, whole, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (pages == MAP_FAILED)
    return NULL;
#ifdef MADV_HUGEPAGE
  madvise(pages, whole, MADV_HUGEPAGE); /* a wish: without it everything works, a little slower */
#endif
  return pages;
}

void rad_pages_free(void *pages, size_t bytes) {
  if (pages)
    munmap(pages, whole_pages(bytes));
}

void *rad_alloc(size_t n, size_t item) {
  if (item && n > SIZE_MAX / item)
    return NULL;
  return malloc(n && item ? n * item : 1);
}

void *rad_calloc(size_t n, size_t item) {
  return calloc(n ? n : 1, item);
}

int rad_reserve(void **array, size_t n, size_t *room, size_t item) {
  if (n <= *room)
    return 1;
  size_t more = n > 2 * *room ? n : 2 * *room;
  void *grown = realloc(*array, more * item);
  if (!grown)
    return 0;
  *array = grown;
  *room = more;
  return 1;
}
