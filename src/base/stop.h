/* A wish to stop: a signal sets a flag, which long loops look at. */
#ifndef RAD_BASE_STOP_H
#define RAD_BASE_STOP_H

#include "base/error.h"

/* From now on SIGTERM and SIGUSR1 only set the flag. For programs, not for the library's users. */
void rad_stop_on_signals(void);

/* The signal that came first, or 0. Once set it stays: what is finished while it is 0 is whole. */
int rad_stop_asked(void);

/* "SIGTERM", "SIGUSR1" */
const char *rad_stop_name(void);

/* RAD_ESTOPPED, for a loop that was left early. */
enum rad_code rad_fail_stopped(struct rad_error *e);

/* Die by the signal, as if it had not been caught; returns if none came. */
void rad_stop_die(void);

#endif
