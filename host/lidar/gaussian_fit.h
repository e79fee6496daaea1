// A waveform as a sum of Gaussian echoes integrated over bins.
#pragma once

#include <vector>

namespace raycube::lidar {

/// Position and sigma in bins (position 0: start of bin 0 of the data), area in the data's unit.
struct GaussianEcho {
  double area = 0, position = 0, sigma = 1;
};

/// Expected value of a bin.
double gaussian_bin(const GaussianEcho& echo, double bin);

/// Least squares over data[first..last) with variance = floor^2 + slope * (model + 0.3), re-weighted with the model
/// twice, which makes it maximum likelihood for counts; floor = slope = 0: every bin as if known to 1 % of the highest.
/// Levenberg-Marquardt (Marquardt
/// 1963) on (area, position, log sigma). Returns chi^2; echoes hold the solution. Areas stay positive, sigma above 0.02
/// bins, positions within the window.
double fit_gaussians(const std::vector<double>& data, std::size_t first, std::size_t last, double floor, double slope,
                     std::vector<GaussianEcho>& echoes);

}  // namespace raycube::lidar
