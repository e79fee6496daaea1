// The incomplete gamma function: gamma-gamma irradiance, tails of Poisson counts.
#pragma once

namespace raycube::lidar {

/// ln Gamma(x), x > 0; safe to call from several threads.
double log_gamma(double x);
/// Regularised lower incomplete gamma function P(a, x), a > 0: series below a + 1, continued fraction (Lentz)
/// above; Numerical Recipes 6.2. Small values keep their relative precision of 1e-12 (x < a + 1). P(n, mean)
/// is the probability of n or more Poisson counts.
double gamma_p(double a, double x);

}  // namespace raycube::lidar
