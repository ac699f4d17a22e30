/* Which program made a result: version, revision, compiler, libraries, and machine. */
#ifndef RAD_BASE_PROVENANCE_H
#define RAD_BASE_PROVENANCE_H

struct rad_provenance {
  const char *version, *git_revision, *compiler, *flags, *blas, *hdf5;
  int blas_parallel; /* openblas_get_parallel(): 0 serial, 1 pthread, 2 OpenMP; -1 unknown */
  char machine[128]; /* processor and number of them, as the system names them */
};

/* Fills in static strings and the machine; hdf5 is left NULL here (the output room knows it). */
void rad_provenance_get(struct rad_provenance *p);

#endif
