/* A wish to stop: a signal sets a flag, which long loops look at. */
#ifndef RAD_BASE_STOP_H
#define RAD_BASE_STOP_H

#include "base/error.h"

/* From now on SIGTERM and SIGUSR1 only set the flag, also where the parent has blocked them: what
 * is pending comes at once. For programs, not for the library's users. */
void rad_stop_on_signals(void);

/* They do again what they did before; one that came meanwhile does it now. */
void rad_stop_release(void);

/* The signal that came first, or 0. Once set it stays: what is finished while it is 0 is whole. */
int rad_stop_asked(void);

/* Wait until fd has something to read, or its end. 0: nothing has come, and a stop is asked for. */
int rad_stop_await(int fd);

/* "SIGTERM", "SIGUSR1" */
const char *rad_stop_name(void);

/* RAD_ESTOPPED, for a loop that was left early. */
enum rad_code rad_fail_stopped(struct rad_error *e);

/* Die by the signal, as if it had not been caught; returns if none came. */
void rad_stop_die(void);

#endif
