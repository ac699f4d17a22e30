/* Where the light goes: emitted, absorbed, escaped, lost on backs. */
#ifndef RAD_ESTIMATE_BALANCE_H
#define RAD_ESTIMATE_BALANCE_H

#include "estimate/means.h"

/* Per band [W]. */
struct rad_balance {
  int n_band;
  int is_enclosed;               /* by topology: then nothing escapes */
  double emitted[RAD_MAX_BAND];  /* int E dS */
  double given[RAD_MAX_BAND];    /* int |E| dS: what the imbalance is compared with */
  double absorbed[RAD_MAX_BAND]; /* int (1 - rho) h dS */
  double rest[RAD_MAX_BAND];     /* emitted less absorbed = int (u - h) dS: escaped and on backs */
  double error[RAD_MAX_BAND];    /* of absorbed and of rest; NAN: not known */
  double on_backs[RAD_MAX_BAND]; /* of the rest, what meets the backs of faces; NAN: not known */
  double backs_error[RAD_MAX_BAND];
  double imbalance[RAD_MAX_BAND]; /* int of E + rho h less int of the u that h is made from */
};

/**
 * The balance of means over triangles (theory 17.3).
 *
 * @return RAD_ENUMERIC for an enclosed scene whose rest is not on backs, to their errors
 */
enum rad_code rad_balance_make(const struct rad_scene *scene, const struct rad_means *m,
                               struct rad_balance *b, struct rad_error *e);

enum { RAD_MOST_BACKS = 1000 }; /* triangles of a scene whose backs are looked at */

/**
 * What backs of one-sided faces receive from w, in all.
 *
 * @param[out] value, error  [w->n] [W]; NAN for scenes of more than RAD_MOST_BACKS triangles
 * Cost: visibility of a scene of twice as many triangles, and the integrals.
 */
enum rad_code rad_receive_on_backs(const struct rad_weights *w, const double *tolerance,
                                   double *value, double *error, struct rad_error *e);

#endif
