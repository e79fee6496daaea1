#include "host/analysis/unmixing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/QR>
#include <fmt/format.h>

#include "host/base/error.h"

namespace raycube::analysis {
namespace {

using base::Error;
using base::Fault;

constexpr double kLeastApart = 1e-10;  ///< of endmembers, over their size
constexpr double kSmall = 1e-12;       ///< of gradients, over the largest: roundings

}  // namespace

Constraint parse_constraint(const std::string& text) {
  return text == "none" ? Constraint::none : text == "sum" ? Constraint::sum : Constraint::full;
}

Unmixing::Unmixing(const std::vector<NamedSpectrum>& endmembers, Constraint constraint) : constraint_(constraint) {
  if (endmembers.size() < 2 || endmembers.size() > kMostEndmembers)
    throw Error(Fault::input, fmt::format("unmixing takes 2 to {} endmembers (found {}); give --endmember NAME=WHAT",
                                          kMostEndmembers, endmembers.size()));
  const Eigen::Index bands = endmembers.front().value.size(), count = static_cast<Eigen::Index>(endmembers.size());
  const Eigen::Index most = bands + (constraint == Constraint::none ? 0 : 1);
  if (count > most)
    throw Error(Fault::input,
                fmt::format("{} endmembers in {} bands have no one solution; at most {} have", count, bands, most));
  spectra_.resize(bands, count);
  for (Eigen::Index e = 0; e < count; ++e) spectra_.col(e) = endmembers[static_cast<std::size_t>(e)].value;
  // What must be independent: the endmembers, or with a sum of 1 their differences.
  Eigen::MatrixXd apart = spectra_;
  if (constraint != Constraint::none) apart = spectra_.rightCols(count - 1).colwise() - spectra_.col(0);
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> rank(apart);
  const double last = std::abs(rank.matrixR()(apart.cols() - 1, apart.cols() - 1)),
               size = spectra_.cwiseAbs().maxCoeff();
  if (!(last > kLeastApart * size * std::sqrt(static_cast<double>(bands))))
    throw Error(Fault::input, "one endmember is a mixture of the others (or two are the same); leave one out");
  // A pixel's part across the endmembers says all: |x - E a|^2 = |z - T a|^2 + what no mixture explains. Where shares
  // sum to 1 it is the same from the first endmember on, and close endmembers lose no digits.
  from_ =
      constraint == Constraint::none ? Eigen::VectorXd(Eigen::VectorXd::Zero(bands)) : Eigen::VectorXd(spectra_.col(0));
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(apart);
  across_ = qr.householderQ() * Eigen::MatrixXd::Identity(bands, std::min(bands, apart.cols()));
  triangle_ = across_.transpose() * (spectra_.colwise() - from_);
  const std::uint32_t sets = 1u << endmembers.size();
  supports_.resize(sets);
  for (std::uint32_t set = 1; set < sets; ++set)
    if (constraint == Constraint::full || set + 1 == sets) supports_[set] = make_support(set);
}

Unmixing::Support Unmixing::make_support(std::uint32_t set) const {
  Support out;
  for (int e = 0; e < static_cast<int>(spectra_.cols()); ++e)
    if (set >> e & 1) out.member.push_back(e);
  const auto count = static_cast<Eigen::Index>(out.member.size()), rows = triangle_.rows();
  out.times = Eigen::MatrixXd::Zero(count, rows), out.plus = Eigen::VectorXd::Zero(count);
  const auto column = [&](Eigen::Index k) { return triangle_.col(out.member[static_cast<std::size_t>(k)]); };
  if (constraint_ == Constraint::none) {
    Eigen::MatrixXd all(rows, count);
    for (Eigen::Index k = 0; k < count; ++k) all.col(k) = column(k);
    out.times = all.colPivHouseholderQr().solve(Eigen::MatrixXd::Identity(rows, rows));
    return out;
  }
  // The first one's share is 1 less the others': least squares of the differences.
  out.plus[0] = 1;
  if (count == 1) return out;
  Eigen::MatrixXd differences(rows, count - 1);
  for (Eigen::Index k = 1; k < count; ++k) differences.col(k - 1) = column(k) - column(0);
  const Eigen::MatrixXd inverse = differences.colPivHouseholderQr().solve(Eigen::MatrixXd::Identity(rows, rows));
  const Eigen::VectorXd moved = inverse * column(0);
  out.times.bottomRows(count - 1) = inverse, out.plus.tail(count - 1) = -moved;
  out.times.row(0) = -inverse.colwise().sum(), out.plus[0] = 1 + moved.sum();
  return out;
}

/// Active sets (Nocedal & Wright, Numerical Optimization, 16.5): from the best single endmember on, the best shares of
/// the set; where one of these is below 0, as far towards them as none is, and that one leaves; where all are right,
/// the endmember that would lower the rest most comes in, until none would. Each set has one best, and the rest falls,
/// so no set comes twice.
std::uint32_t Unmixing::constrained_set(const Eigen::VectorXd& z, Eigen::VectorXd& share) const {
  const Eigen::Index count = triangle_.cols();
  Eigen::Index best = 0;
  (triangle_.colwise() - z).colwise().squaredNorm().minCoeff(&best);
  std::uint32_t set = 1u << best;
  share = Eigen::VectorXd::Unit(count, best);
  const double apart = triangle_.cwiseAbs().maxCoeff(), size = apart * std::max(apart, z.cwiseAbs().maxCoeff());
  for (int round = 0; round < 100; ++round) {
    const Support& here = support(set);
    const Eigen::VectorXd wanted = here.times * z + here.plus;
    double step = 1;
    int leaves = -1;
    for (std::size_t k = 0; k < here.member.size(); ++k) {
      const double to = wanted[static_cast<Eigen::Index>(k)], from = share[here.member[k]];
      if (to >= 0 || here.member.size() == 1) continue;
      const double until = from / (from - to);
      if (until < step || leaves < 0) step = std::min(step, until), leaves = here.member[k];
    }
    for (std::size_t k = 0; k < here.member.size(); ++k)
      share[here.member[k]] += step * (wanted[static_cast<Eigen::Index>(k)] - share[here.member[k]]);
    if (leaves >= 0) {
      share[leaves] = 0, set &= ~(1u << leaves);
      continue;
    }
    const Eigen::VectorXd slope = triangle_.transpose() * (triangle_ * share - z);  // all alike inside the set
    double level = 0;
    for (const int e : here.member) level += slope[e] / static_cast<double>(here.member.size());
    int comes = -1;
    double steepest = -kSmall * size;
    for (int e = 0; e < static_cast<int>(count); ++e)
      if (!(set >> e & 1) && slope[e] - level < steepest) steepest = slope[e] - level, comes = e;
    if (comes < 0) break;
    set |= 1u << comes;
  }
  return set;
}

double Unmixing::solve(const double* pixel, double* share) const {
  const Eigen::Map<const Eigen::VectorXd> x(pixel, spectra_.rows());
  const Eigen::VectorXd z = across_.transpose() * (x - from_);
  Eigen::VectorXd found;
  if (constraint_ == Constraint::full) {
    constrained_set(z, found);
  } else {
    const Support& all = support(static_cast<std::uint32_t>(supports_.size()) - 1);
    found = all.times * z + all.plus;
  }
  std::copy(found.data(), found.data() + found.size(), share);
  return (x - spectra_ * found).norm() / std::sqrt(static_cast<double>(x.size()));
}

void Unmixing::solve(const Pixels& pixels, std::vector<double>& out) const {
  const std::size_t layers = endmembers() + 1;
  out.assign(pixels.count() * layers, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t p = 0; p < pixels.count(); ++p)
    if (pixels.counts[p]) out[p * layers + layers - 1] = solve(pixels.at(p), out.data() + p * layers);
}

}  // namespace raycube::analysis
