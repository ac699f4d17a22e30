/* Independent parts of an assembly, some of which may be done before a signal stops it. */
#ifndef RAD_INTEGRATE_TASK_H
#define RAD_INTEGRATE_TASK_H

#include <stddef.h>

#include "base/stop.h"
#include "integrate/element.h"

/* True if task i is still to be done, and there is no wish to stop. */
static inline int rad_task_begin(const unsigned char *done, size_t i) {
  return !done[i] && !rad_stop_asked();
}

/* A task that saw no wish to stop until its end is whole, and counts; else it will be done again.
 */
static inline void rad_task_end(unsigned char *done, size_t i, const struct rad_counters *before,
                                struct rad_scratch *scratch) {
  if (rad_stop_asked())
    scratch->counters = *before;
  else
    done[i] = 1;
}

#endif
