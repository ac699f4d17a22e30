/* What a run says of itself: the lines of its summary, and its warnings. */
#ifndef RAD_APP_SUMMARY_H
#define RAD_APP_SUMMARY_H

#include <stdio.h>

#include "app/case.h"

const char *rad_solver_name(enum rad_solver s);

void rad_print_notes(const struct rad_case *c, FILE *log);
void rad_print_head(const struct rad_case *c, FILE *out);

/* Why triangles have no unknowns, and how many. */
void rad_print_passive(const struct rad_layout *l, FILE *out);

/**
 * Mesh, error, means, heat and balance of a solution.
 *
 * @param out  NULL: warnings only
 * @return RAD_ENUMERIC where light that should balance does not
 */
enum rad_code rad_print_solution(const struct rad_case *c, const struct rad_result *r, FILE *out,
                                 FILE *log, struct rad_error *e);

void rad_print_time(const struct rad_result *r, FILE *out);

#endif
