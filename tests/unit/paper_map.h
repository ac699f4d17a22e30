/* The paper's odd-power transformation [H, (3.33) to (3.35)], for its Table 3.1 and for comparison.
 */
#ifndef POLYRAD_TEST_PAPER_MAP_H
#define POLYRAD_TEST_PAPER_MAP_H

/* x = t(y) on [0, 1], for a nearly singular place a + i eps. */
struct paper_map {
  double a, alpha1, alpha2;
  int q;
};

/* The smallest odd natural number that is >= z. */
int paper_odd(double z);

struct paper_map paper_map(double a, double eps);

/* t(y), and t'(y) in *slope. */
double paper_map_at(const struct paper_map *m, double y, double *slope);

#endif
