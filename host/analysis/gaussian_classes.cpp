#include "host/analysis/gaussian_classes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "host/analysis/detection.h"
#include "host/analysis/statistics.h"
#include "host/base/error.h"

namespace raycube::analysis {
namespace {

using base::Error;
using base::Fault;

}  // namespace

GaussianClasses::GaussianClasses(const std::vector<std::string>& names, const std::vector<Moments>& classes,
                                 const std::vector<double>& prior, double shrink) {
  for (std::size_t k = 0; k < classes.size(); ++k) {
    const std::string what = fmt::format("class \"{}\" of {} pixels", names[k], classes[k].count());
    const Inverse inverse = invert(shrunk(classes[k].covariance(), shrink), what);
    const double share = prior.empty() ? 1.0 / static_cast<double>(classes.size()) : prior[k];
    class_.push_back({classes[k].mean(), InverseNorm(inverse.lower, classes[k].bands()),
                      std::log(share) - 0.5 * inverse.log_determinant});
  }
}

void GaussianClasses::classify(const Pixels& pixels, std::vector<double>& out) const {
  const std::size_t n = pixels.bands, stride = padded(n);
  out.assign(pixels.count(), 0.0);
  std::vector<double> centred(kPixelsAtOnce * stride, 0.0), norm(kPixelsAtOnce, 0.0), best(kPixelsAtOnce);
  for (std::size_t first = 0; first < pixels.count(); first += kPixelsAtOnce) {
    const std::size_t many = std::min(kPixelsAtOnce, pixels.count() - first);
    std::fill(best.begin(), best.end(), -std::numeric_limits<double>::infinity());
    for (std::size_t k = 0; k < class_.size(); ++k) {
      for (std::size_t p = 0; p < many; ++p)
        for (std::size_t b = 0; b < n; ++b)
          centred[p * stride + b] = pixels.at(first + p)[b] - class_[k].mean[static_cast<Eigen::Index>(b)];
      class_[k].whitened.norms(centred.data(), kPixelsAtOnce, norm.data());
      for (std::size_t p = 0; p < many; ++p) {
        const double density = class_[k].constant - 0.5 * norm[p];
        if (pixels.counts[first + p] && density > best[p])
          best[p] = density, out[first + p] = static_cast<double>(k + 1);
      }
    }
  }
}

std::uint64_t Confusion::total() const {
  std::uint64_t out = 0;
  for (const auto& row : count)
    for (const std::uint64_t n : row) out += n;
  return out;
}

double Confusion::accuracy() const {
  std::uint64_t right = 0;
  for (std::size_t k = 0; k < count.size(); ++k) right += count[k][k];
  return static_cast<double>(right) / static_cast<double>(total());
}

double Confusion::kappa() const {
  double chance = 0;
  const double all = static_cast<double>(total());
  for (std::size_t k = 0; k < count.size(); ++k) {
    double row = 0, column = 0;
    for (std::size_t i = 0; i < count[k].size(); ++i) row += static_cast<double>(count[k][i]);
    for (std::size_t i = 0; i < count.size(); ++i) column += static_cast<double>(count[i][k]);
    chance += row / all * column / all;
  }
  return chance < 1 ? (accuracy() - chance) / (1 - chance) : std::numeric_limits<double>::quiet_NaN();
}

std::vector<double> Confusion::producer() const {
  std::vector<double> out;
  for (std::size_t k = 0; k < count.size(); ++k) {
    double row = 0;
    for (const std::uint64_t n : count[k]) row += static_cast<double>(n);
    out.push_back(static_cast<double>(count[k][k]) / row);
  }
  return out;
}

std::vector<double> Confusion::user() const {
  std::vector<double> out;
  for (std::size_t k = 0; k < count.size(); ++k) {
    double column = 0;
    for (const auto& row : count) column += static_cast<double>(row[k]);
    out.push_back(static_cast<double>(count[k][k]) / column);
  }
  return out;
}

ConfusionCount::ConfusionCount(const std::vector<std::string>& classes, const std::vector<Region>& truth)
    : names_(classes), truth_(truth) {
  for (const Region& region : truth) {
    const auto found = std::find(classes.begin(), classes.end(), region.name());
    if (found == classes.end())
      throw Error(Fault::input, fmt::format("the truth has \"{}\", which is no class; the classes are {}",
                                            region.name(), fmt::join(classes, ", ")));
    row_.push_back(static_cast<std::size_t>(found - classes.begin()));
  }
  part_.assign(kMostParts, std::vector(classes.size(), std::vector<std::uint64_t>(classes.size() + 1, 0)));
}

void ConfusionCount::add(std::size_t part, const Pixels& pixels, const std::vector<double>& found) {
  for_each_in(truth_, pixels, [&](std::size_t r, std::size_t p) {
    if (!pixels.counts[p]) return;
    const auto number = static_cast<std::size_t>(found[p]);
    ++part_[part][row_[r]][number == 0 ? names_.size() : number - 1];
  });
}

Confusion ConfusionCount::result() const {
  Confusion out{names_, std::vector(names_.size(), std::vector<std::uint64_t>(names_.size() + 1, 0))};
  for (const auto& part : part_)
    for (std::size_t i = 0; i < part.size(); ++i)
      for (std::size_t j = 0; j < part[i].size(); ++j) out.count[i][j] += part[i][j];
  return out;
}

}  // namespace raycube::analysis
