#include "factors/triangle_rule.h"

const int rad_triangle_points[RAD_TRIANGLE_RULES] = {1, 3, 6, 7, 16, 64, 144};
const int rad_triangle_degree[RAD_TRIANGLE_RULES] = {1, 2, 4, 5, 8, 14, 22};

/* (1 - 2a, a, a) and its turns; D. A. Dunavant, Int. J. Numer. Meth. Engng 21 (1985) 1129-1148. */
static int add_turns(double a, double w, double (*lambda)[3], double *weight) {
  for (int m = 0; m < 3; m++) {
    for (int d = 0; d < 3; d++)
      lambda[m][d] = d == m ? 1 - 2 * a : a;
    weight[m] = w;
  }
  return 3;
}

static int add_center(double w, double (*lambda)[3], double *weight) {
  lambda[0][0] = lambda[0][1] = lambda[0][2] = 1.0 / 3;
  weight[0] = w;
  return 1;
}

static void six_turns(double a, double b, double w, double (*lambda)[3], double *weight) {
  const double at[3] = {a, b, 1 - a - b};
  for (int m = 0; m < 6; m++) {
    lambda[m][m % 3] = at[0];
    lambda[m][(m + 1 + m / 3) % 3] = at[1];
    lambda[m][(m + 2 - m / 3) % 3] = at[2];
    weight[m] = w;
  }
}

/* x = (1 - r) v_0 + r (1 - t) v_1 + r t v_2, dS = 2 area r dr dt, n points each way. */
static void product(const struct rad_gauss *g, int n, double (*lambda)[3], double *weight) {
  const double *x = rad_gauss_node(g, n), *w = rad_gauss_weight(g, n);
  for (int q = 0; q < n * n; q++) {
    double r = 0.5 * (1 + x[q / n]), t = 0.5 * (1 + x[q % n]);
    weight[q] = 0.5 * w[q / n] * w[q % n] * r;
    lambda[q][0] = 1 - r;
    lambda[q][1] = r * (1 - t);
    lambda[q][2] = r * t;
  }
}

void rad_triangle_rule(const struct rad_gauss *g, int rule, double (*lambda)[3], double *weight) {
  int n = 0;
  switch (rule) {
  case 0:
    add_center(1, lambda, weight);
    break;
  case 1:
    add_turns(1.0 / 6, 1.0 / 3, lambda, weight);
    break;
  case 2:
    n += add_turns(0.44594849091596488632, 0.22338158967801146570, lambda, weight);
    add_turns(0.09157621350977074346, 0.10995174365532186764, lambda + n, weight + n);
    break;
  case 3:
    n += add_center(0.225, lambda, weight);
    n += add_turns(0.47014206410511508977, 0.13239415278850618074, lambda + n, weight + n);
    add_turns(0.10128650732345633880, 0.12593918054482715260, lambda + n, weight + n);
    break;
  case 4:
    n += add_center(0.14431560767778716825, lambda, weight);
    n += add_turns(0.17056930775176020663, 0.10321737053471825028, lambda + n, weight + n);
    n += add_turns(0.05054722831703097545, 0.03245849762319808031, lambda + n, weight + n);
    n += add_turns(0.45929258829272315603, 0.09509163426728462479, lambda + n, weight + n);
    six_turns(0.26311282963463811342, 0.00839477740995760534, 0.02723031417443499426, lambda + n,
              weight + n);
    break;
  default:
    product(g, rule == 5 ? 8 : 12, lambda, weight);
  }
}
