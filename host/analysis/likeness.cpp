#include "host/analysis/likeness.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace raycube::analysis {
namespace {

double root_mean_square(const Eigen::ArrayXd& v) { return std::sqrt(v.square().mean()); }

double angle_deg(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return std::acos(std::clamp(a.dot(b) / (a.norm() * b.norm()), -1.0, 1.0)) * 180 / std::numbers::pi;
}

}  // namespace

SortedBands::SortedBands(const Cube& cube, const Pass& pass, std::size_t most) : band_(cube.bands()) {
  const std::size_t step = std::max<std::size_t>(1, cube.pixels() / most);
  std::vector<std::vector<std::vector<double>>> part(kMostParts, std::vector<std::vector<double>>(cube.bands()));
  for_each_part(cube, pass, [&](std::size_t number, const Pixels& pixels) {
    const auto first = static_cast<std::size_t>(pixels.first_line * pixels.samples);
    for (std::size_t p = 0; p < pixels.count(); ++p)
      for (std::size_t b = 0; pixels.counts[p] && (first + p) % step == 0 && b < pixels.bands; ++b)
        part[number][b].push_back(pixels.at(p)[b]);
  });
  for (std::size_t b = 0; b < band_.size(); ++b) {
    for (const auto& one : part) band_[b].insert(band_[b].end(), one[b].begin(), one[b].end());
    std::sort(band_[b].begin(), band_[b].end());
  }
}

double largest_distance(const std::vector<double>& a, const std::vector<double>& b) {
  double out = 0;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    const double x = std::min(a[i], b[j]);
    while (i < a.size() && a[i] <= x) ++i;
    while (j < b.size() && b[j] <= x) ++j;
    out = std::max(out, std::abs(static_cast<double>(i) / static_cast<double>(a.size()) -
                                 static_cast<double>(j) / static_cast<double>(b.size())));
  }
  return out;
}

std::vector<Score> likeness(const Moments& of_a, const SortedBands& sorted_a, const Moments& of_b,
                            const SortedBands& sorted_b, std::size_t count) {
  const std::size_t bands = of_a.bands();
  std::vector<Score> out;
  const Eigen::MatrixXd covariance_a = of_a.covariance(), covariance_b = of_b.covariance();
  const Eigen::ArrayXd mean_a = of_a.mean(), mean_b = of_b.mean(), spread_a = covariance_a.diagonal().array().sqrt(),
                       spread_b = covariance_b.diagonal().array().sqrt();
  out.push_back({"difference of the bands' means, rms over the first's mean", "%",
                 100 * root_mean_square(mean_b - mean_a) / std::abs(mean_a.mean()), 0});
  out.push_back({"angle between the mean spectra", "deg", angle_deg(of_a.mean(), of_b.mean()), 0});
  out.push_back({"ratio of the bands' standard deviations, mean", "", (spread_b / spread_a.max(1e-300)).mean(), 1});
  double worst = 0, sum = 0;
  for (std::size_t b = 0; b < bands; ++b) {
    const double distance = largest_distance(sorted_a.band(b), sorted_b.band(b));
    worst = std::max(worst, distance), sum += distance / static_cast<double>(bands);
  }
  out.push_back({"distance of the distributions, mean over bands", "", sum, 0});
  out.push_back({"distance of the distributions, worst band", "", worst, 0});
  const EigenStructure first = eigen_structure(covariance_a), second = eigen_structure(covariance_b);
  for (std::size_t k = 1; k <= std::min(count, bands); ++k)
    out.push_back({fmt::format("largest angle between the first {} eigenvectors", k), "deg",
                   principal_angles_deg(first, second, k).back(), 0});
  const Eigen::ArrayXd share_a = first.values / first.values.sum(), share_b = second.values / second.values.sum();
  out.push_back({"difference of the eigenvalues' shares, largest", "", (share_a - share_b).abs().maxCoeff(), 0});
  return out;
}

}  // namespace raycube::analysis
