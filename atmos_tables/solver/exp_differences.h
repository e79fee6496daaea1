// Divided differences of exp(-x). Every integral of an attenuated source along an attenuated line of sight is
// one of them, and their limits (beam cosine = eigenvalue, = view cosine, = node) are ordinary points: the
// classical closed forms are 0/0 there.
#pragma once

namespace raycube::atmos::solver {

/// (1 - exp(-x)) / x; 1 at x = 0. Any x > -700.
double exp_mean(double x);

/// (exp(-x) - exp(-y)) / (y - x), symmetric, positive; exp(-x) where x = y. x, y >= 0. Relative error below
/// 1e-15.
double exp_difference(double x, double y);

/// Second divided difference (f(x,y) - f(x,z)) / (z - y) of f = exp_difference; symmetric, positive;
/// exp(-x)/2 where all agree. x, y, z >= 0. Relative error below 1e-14.
double exp_difference(double x, double y, double z);

}  // namespace raycube::atmos::solver
