/* What the files of the library (include/polyrad.h) share. */
#ifndef RAD_APP_LIBRARY_H
#define RAD_APP_LIBRARY_H

#include "app/case.h"
#include "polyrad.h"

struct polyrad {
  struct rad_case run; /* the scene points into it: a handle does not move */
  struct rad_error error;
  int n_surface;
  char **name; /* owned [n_surface] as the caller numbers them */
  int *caller; /* owned [n_surface] the caller's number of the scene's surface */
  polyrad_emission *emission_at;
  void *user;
  int threads; /* 0: what OpenMP has */
  int solved;
  int bad_triangle, bad_band; /* where emission_at was not finite first; -1: nowhere */
};

/* Copy, check and prepare a scene: fills p->run, name and caller. */
enum rad_code rad_library_scene(const struct polyrad_scene *scene, polyrad *p);

/* emission_at of the scene that asks the caller's function; context is a polyrad. Once that was not
 * finite, everything is NaN: the run ends soon. */
double rad_library_emission(void *context, int triangle, int band, int base, const double mu[2]);

/* POLYRAD_INPUT if the caller's function has been not finite, else code. */
enum rad_code rad_library_judge(polyrad *p, enum rad_code code);

/* Begin a call: no error, and OpenMP has the handle's threads; what it had is returned. OpenMP
 * keeps this number for each of the caller's threads apart. */
int rad_library_enter(polyrad *p);
/* End it: the threads are what they were. */
polyrad_status rad_library_leave(polyrad *p, int threads_before, enum rad_code code);

enum rad_code rad_library_fail_null(polyrad *p, const char *what);
enum rad_code rad_library_refuse_unsolved(polyrad *p);

#endif
