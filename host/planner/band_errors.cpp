#include "host/planner/band_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "host/base/error.h"

namespace raycube::planner {

namespace {

double largest(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

}  // namespace

double BandErrors::worst_estimate() const { return largest(estimate); }
double BandErrors::worst_bound() const { return largest(bound); }

BandSquares::BandSquares(const BandErrors& errors) {
  square_.reserve(errors.estimate.size()), deviation_.reserve(errors.estimate.size());
  for (std::size_t b = 0; b < errors.estimate.size(); ++b) {
    const double estimate = errors.estimate[b], bound = errors.bound[b];
    square_.push_back(estimate * estimate);
    deviation_.push_back(bound > estimate ? bound * bound - estimate * estimate : 0);
  }
}

double BandSquares::with(const BandSquares& other, double enough, std::size_t& first_band) const {
  const std::size_t ours = square_.size(), theirs = other.square_.size(), bands = std::max(ours, theirs);
  if (ours != theirs && ours != 1 && theirs != 1)
    throw base::Error(base::Fault::bug, fmt::format("errors of {} and of {} bands put together", ours, theirs));
  const std::size_t step = ours > 1 ? 1 : 0, their_step = theirs > 1 ? 1 : 0;
  const auto sum = [&](std::size_t band) {
    const double d1 = deviation_[step * band], d2 = other.deviation_[their_step * band];
    return square_[step * band] + other.square_[their_step * band] +
           kSure * std::sqrt(d1 * d1 + d2 * d2 + 2 * kTogether * d1 * d2);
  };
  if (first_band >= bands) first_band = 0;
  double worst = sum(first_band);
  for (std::size_t band = 0; band < bands && worst <= enough; ++band)
    if (const double here = sum(band); here > worst) worst = here, first_band = band;
  return worst;
}

double bound_together(const BandErrors& one, const BandErrors& other) {
  std::size_t band = 0;
  return std::sqrt(BandSquares(one).with(BandSquares(other), std::numeric_limits<double>::infinity(), band));
}

}  // namespace raycube::planner
