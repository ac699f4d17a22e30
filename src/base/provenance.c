#include "base/provenance.h"

#include <stdio.h>
#include <unistd.h>

#include "build_info.h" /* made by the build: RAD_VERSION, RAD_GIT_REVISION, RAD_COMPILER, RAD_FLAGS */

/* Only OpenBLAS has these; with another BLAS they are absent, and NULL. */
extern char *openblas_get_config(void) __attribute__((weak));
extern int openblas_get_parallel(void) __attribute__((weak));

/* "AMD EPYC, 2 processors"; the name is that of Linux's /proc/cpuinfo. */
static void name_machine(size_t size, char *name) {
  char line[256], model[96] = "unknown processor";
  FILE *f = fopen("/proc/cpuinfo", "r");
  while (f && fgets(line, sizeof line, f))
    if (sscanf(line, "model name : %95[^\n]", model) == 1)
      break;
  if (f)
    fclose(f);
  snprintf(name, size, "%s, %ld processors", model, sysconf(_SC_NPROCESSORS_ONLN));
}

void rad_provenance_get(struct rad_provenance *p) {
  *p = (struct rad_provenance){
      .version = RAD_VERSION,
      .git_revision = RAD_GIT_REVISION,
      .compiler = RAD_COMPILER,
      .flags = RAD_FLAGS,
      .blas = openblas_get_config ? openblas_get_config() : "not OpenBLAS",
      .hdf5 = NULL,
      .blas_parallel = openblas_get_parallel ? openblas_get_parallel() : -1,
  };
  name_machine(sizeof p->machine, p->machine);
}
