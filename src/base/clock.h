/* Wall-clock seconds since an arbitrary moment; only differences mean anything. */
#ifndef RAD_BASE_CLOCK_H
#define RAD_BASE_CLOCK_H

double rad_seconds(void);

#endif
