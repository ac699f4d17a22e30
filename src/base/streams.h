/* Standard streams: that they are there, and that what was printed has arrived. */
#ifndef RAD_BASE_STREAMS_H
#define RAD_BASE_STREAMS_H

#include "base/error.h"

/* First in a program: takes the place of streams that were closed (>&-), so that no file that is
 * opened later gets their numbers, and messages do not end in it. Writing to them fails as before.
 */
void rad_streams_begin(void);

/* Last in a program: RAD_ESYSTEM if anything that was printed on standard output is lost. */
enum rad_code rad_streams_end(struct rad_error *e);

#endif
