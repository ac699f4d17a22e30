/* Near blocks: integrals as for a dense matrix. */
#ifndef RAD_SYSTEM_H2_NEAR_H
#define RAD_SYSTEM_H2_NEAR_H

#include "system/h2.h"

/* Integrate all near blocks of h, in parallel over target leaves; narrow: single precision. */
enum rad_code rad_h2_near(struct rad_h2 *h, const struct rad_rules *rules, int narrow,
                          struct rad_error *e);

/* One integrator for each thread, or none at all. */
struct rad_scratch *rad_scratch_make(const struct rad_mesh *mesh, int n_thread,
                                     struct rad_error *e);

/* Adds their counters, if not NULL; RAD_ESYSTEM if one of them ran out of memory. */
enum rad_code rad_scratch_end(struct rad_scratch *scratch, int n_thread,
                              struct rad_counters *counters, struct rad_error *e);

#endif
