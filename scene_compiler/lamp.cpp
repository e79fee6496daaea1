#include "scene_compiler/lamp.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/base/planck.h"

namespace raycube::scene {

namespace {

constexpr double kStefanBoltzmann = 5.670374419e-8;  ///< W m-2 K-4 (CODATA 2018)
constexpr double kLargestEfficacy_lm_W = 683;
constexpr double kPhotopicFirst_um = 0.38, kPhotopicStep_um = 0.005;

/// V of the CIE's standard observer (CIE 018:2019, table 1) every 5 nm from 380 to 780 nm; linear between.
constexpr double kPhotopic[] = {
    0.000039, 0.000064, 0.00012, 0.000217, 0.000396, 0.00064,  0.00121,  0.00218,  0.004,    0.0073,  0.0116,  0.01684,
    0.023,    0.0298,   0.038,   0.048,    0.06,     0.0739,   0.09098,  0.1126,   0.13902,  0.1693,  0.20802, 0.2586,
    0.323,    0.4073,   0.503,   0.6082,   0.71,     0.7932,   0.862,    0.91485,  0.954,    0.9803,  0.99495, 1.0,
    0.995,    0.9786,   0.952,   0.9154,   0.87,     0.8163,   0.757,    0.6949,   0.631,    0.5668,  0.503,   0.4412,
    0.381,    0.321,    0.265,   0.217,    0.175,    0.1382,   0.107,    0.0816,   0.061,    0.04458, 0.032,   0.0232,
    0.017,    0.01192,  0.00821, 0.005723, 0.004102, 0.002929, 0.002091, 0.001484, 0.001047, 0.00074, 0.00052, 0.000361,
    0.000249, 0.000172, 0.00012, 0.000085, 0.000060, 0.000042, 0.000030, 0.000021, 0.000015};

double photopic(double um) {
  const double at = (um - kPhotopicFirst_um) / kPhotopicStep_um;
  const auto last = static_cast<double>(std::size(kPhotopic) - 1);
  if (at < 0 || at > last) return 0;
  const auto low = static_cast<std::size_t>(std::min(at, last - 1));
  const double f = at - static_cast<double>(low);
  return (1 - f) * kPhotopic[low] + f * kPhotopic[low + 1];
}

/// Integral of (a + b (x - low)) sin x from low to high, rad.
double sine_moment(double low, double high, double at_low, double at_high) {
  if (!(high > low)) return 0;
  const double slope = (at_high - at_low) / (high - low);
  return at_low * std::cos(low) - at_high * std::cos(high) + slope * (std::sin(high) - std::sin(low));
}

}  // namespace

double LampSpectrum::at(double um) const {
  if (temperature_K > 0)
    return std::numbers::pi * base::planck_radiance(um, temperature_K) /
           (kStefanBoltzmann * std::pow(temperature_K, 4));
  const auto above = std::upper_bound(wavelength_um.begin(), wavelength_um.end(), um) - wavelength_um.begin();
  if (above == 0) return 0;
  if (above == static_cast<std::ptrdiff_t>(wavelength_um.size())) return um == wavelength_um.back() ? per_um.back() : 0;
  const auto i = static_cast<std::size_t>(above);
  const double f = (um - wavelength_um[i - 1]) / (wavelength_um[i] - wavelength_um[i - 1]);
  return (1 - f) * per_um[i - 1] + f * per_um[i];
}

double LampSpectrum::efficacy_lm_W() const {
  std::vector<double> nodes = wavelength_um;
  for (std::size_t i = 0; i < std::size(kPhotopic); ++i)
    nodes.push_back(kPhotopicFirst_um + kPhotopicStep_um * static_cast<double>(i));
  std::sort(nodes.begin(), nodes.end());
  double sum = 0;
  for (std::size_t i = 1; i < nodes.size(); ++i) {  // Simpson's rule: exact for products of lines
    const double a = nodes[i - 1], b = nodes[i], in = 1e-9 * (b - a);
    const auto light = [&](double um) { return at(um) * photopic(um); };
    sum += (b - a) / 6 * (light(a + in) + 4 * light((a + b) / 2) + light(b - in));
  }
  return kLargestEfficacy_lm_W * sum;
}

double LampDistribution::solid_angle_sr() const {
  const std::size_t rows = vertical_deg.size(), columns = horizontal_deg.size();
  constexpr double rad = std::numbers::pi / 180;
  const auto of_plane = [&](std::size_t plane) {
    double sum = 0;
    for (std::size_t v = 1; v < rows; ++v)
      sum += sine_moment(vertical_deg[v - 1] * rad, vertical_deg[v] * rad, value[plane * rows + v - 1],
                         value[plane * rows + v]);
    return sum;
  };
  if (columns == 1) return 2 * std::numbers::pi * of_plane(0);
  double sum = 0;
  for (std::size_t h = 1; h < columns; ++h)
    sum += 0.5 * (horizontal_deg[h] - horizontal_deg[h - 1]) * rad * (of_plane(h - 1) + of_plane(h));
  return sum;
}

}  // namespace raycube::scene
