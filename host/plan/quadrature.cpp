#include "host/plan/quadrature.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/base/error.h"

namespace raycube::plan {

namespace {

constexpr double kMergeUm = 1e-9;

double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at) {
  if (at < x.front() || at > x.back()) return 0;
  const auto upper = std::upper_bound(x.begin() + 1, x.end() - 1, at);
  const auto i = static_cast<std::size_t>(upper - x.begin()) - 1;
  const double t = (at - x[i]) / (x[i + 1] - x[i]);
  return y[i] + t * (y[i + 1] - y[i]);
}

}  // namespace

std::vector<std::pair<double, double>> gauss_legendre(int n) {
  std::vector<std::pair<double, double>> rule(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), slope = 1;
    for (int iteration = 0; iteration < 100; ++iteration) {
      double p0 = 1, p1 = x;
      for (int k = 2; k <= n; ++k) {
        const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
        p0 = p1;
        p1 = p2;
      }
      slope = n * (x * p1 - p0) / (x * x - 1);
      const double step = p1 / slope;
      x -= step;
      if (std::abs(step) < 1e-15) break;
    }
    rule[static_cast<std::size_t>(n - 1 - i)] = {x, 2 / ((1 - x * x) * slope * slope)};
  }
  return rule;
}

std::pair<double, double> band_support(const scene::Band& band) {
  if (band.wavelength_um.size() > 1) return {band.wavelength_um.front(), band.wavelength_um.back()};
  const double reach = kGaussianCutFwhm * band.fwhm_um;
  return {std::max(band.center_um - reach, band.from_um), std::min(band.center_um + reach, band.to_um)};
}

double band_response(const scene::Band& band, double wavelength_um) {
  if (band.wavelength_um.size() > 1) return interpolate(band.wavelength_um, band.response, wavelength_um);
  const auto [from, to] = band_support(band);
  const double t = (wavelength_um - band.center_um) / band.fwhm_um;
  return wavelength_um < from || wavelength_um > to ? 0.0 : std::exp(-4 * std::numbers::ln2 * t * t);
}

SpectralGrid make_spectral_grid(std::vector<double> breakpoints, const std::vector<scene::Band>& bands) {
  std::sort(breakpoints.begin(), breakpoints.end());
  std::vector<double> node;
  for (const double l : breakpoints)
    if (node.empty() || l - node.back() > kMergeUm) node.push_back(l);

  std::vector<char> touched(node.size(), 0);  // interval i: node[i] .. node[i + 1]
  for (const auto& band : bands) {
    const auto [lo, hi] = band_support(band);
    auto i = static_cast<std::size_t>(std::upper_bound(node.begin(), node.end(), lo) - node.begin());
    for (i = i > 0 ? i - 1 : 0; i + 1 < node.size() && node[i] < hi; ++i) touched[i] = 1;
  }
  SpectralGrid grid;
  for (std::size_t i = 0; i + 1 < node.size(); ++i) {
    if (!touched[i]) continue;
    if (grid.wavelength_um.empty() || grid.wavelength_um.back() != node[i]) grid.wavelength_um.push_back(node[i]);
    grid.interval.push_back(grid.wavelength_um.size() - 1);
    grid.wavelength_um.push_back(0.5 * (node[i] + node[i + 1]));
    grid.wavelength_um.push_back(node[i + 1]);
  }
  return grid;
}

BandQuadrature band_quadrature(const scene::Band& band, const SpectralGrid& grid) {
  static const auto rule = gauss_legendre(8);
  const auto [lo, hi] = band_support(band);
  const auto& l = grid.wavelength_um;
  auto first = std::upper_bound(grid.interval.begin(), grid.interval.end(), lo,
                                [&](double at, std::size_t i) { return at < l[i + 2]; });
  BandQuadrature quadrature;
  if (first == grid.interval.end())
    throw base::Error(base::Fault::bug, "band quadrature: the spectral grid does not reach band '" + band.name + "'");
  quadrature.first = *first;

  const bool tabulated = band.wavelength_um.size() > 1;
  double total = 0;
  std::vector<double> cut;
  for (auto it = first; it != grid.interval.end() && l[*it] < hi; ++it) {
    const std::size_t i = *it;
    const double a = std::max(l[i], lo), b = std::min(l[i + 2], hi), width = l[i + 2] - l[i];
    quadrature.weight.resize(i + 3 - quadrature.first, 0.0);
    double* weight = &quadrature.weight[i - quadrature.first];
    // pieces on which the response is smooth: between its own nodes, or half a FWHM of a Gaussian
    cut.assign(1, a);
    if (tabulated) {
      auto node = std::upper_bound(band.wavelength_um.begin(), band.wavelength_um.end(), a);
      for (; node != band.wavelength_um.end() && *node < b; ++node) cut.push_back(*node);
    } else {
      const int pieces = static_cast<int>(std::ceil((b - a) / (0.5 * band.fwhm_um)));
      for (int k = 1; k < pieces; ++k) cut.push_back(a + (b - a) * k / pieces);
    }
    cut.push_back(b);
    for (std::size_t k = 0; k + 1 < cut.size(); ++k) {
      const double half = 0.5 * (cut[k + 1] - cut[k]), mid = 0.5 * (cut[k + 1] + cut[k]);
      for (const auto& [node, gauss] : rule) {
        const double at = mid + half * node, t = (at - l[i]) / width;
        const double r = gauss * half * band_response(band, at);
        weight[0] += r * (2 * t - 1) * (t - 1);
        weight[1] += r * 4 * t * (1 - t);
        weight[2] += r * t * (2 * t - 1);
        total += r;
      }
    }
  }
  if (!(total > 0))
    throw base::Error(base::Fault::input, "band '" + band.name + "': its response integrates to " +
                                              std::to_string(total) + "; give a response with a positive area");
  for (auto& w : quadrature.weight) w /= total;
  return quadrature;
}

std::vector<double> in_bands(const std::vector<BandQuadrature>& bands, const std::vector<double>& spectrum) {
  std::vector<double> out;
  for (const BandQuadrature& band : bands) {
    double sum = 0;
    for (std::size_t i = 0; i < band.weight.size(); ++i) sum += band.weight[i] * spectrum[band.first + i];
    out.push_back(sum);
  }
  return out;
}

}  // namespace raycube::plan
