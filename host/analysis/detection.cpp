#include "host/analysis/detection.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "host/base/error.h"

namespace raycube::analysis {
namespace {

using base::Error;
using base::Fault;

bool is_of_targets(const std::string& detector) { return detector != "rx"; }
bool asks_norm(const std::string& detector) { return detector != "mf" && detector != "cem" && detector != "sam"; }

double dot(const Eigen::VectorXd& a, const double* b) { return a.dot(Eigen::Map<const Eigen::VectorXd>(b, a.size())); }

}  // namespace

const std::vector<std::string>& detector_names() {
  static const std::vector<std::string> names = {"mf", "ace", "ace_signed", "cem", "sam", "rx"};
  return names;
}

Eigen::MatrixXd shrunk(const Eigen::MatrixXd& symmetric, double share) {
  const double mean = symmetric.trace() / static_cast<double>(symmetric.rows());
  return (1 - share) * symmetric + share * mean * Eigen::MatrixXd::Identity(symmetric.rows(), symmetric.rows());
}

Detection::Detection(const std::vector<std::string>& detectors, std::vector<NamedSpectrum> targets,
                     const Moments& background, double shrink)
    : detectors_(detectors), mean_(background.mean()) {
  const auto uses = [&](const auto& is) { return std::any_of(detectors.begin(), detectors.end(), is); };
  for (const std::string& name : detectors)
    if (std::find(detector_names().begin(), detector_names().end(), name) == detector_names().end())
      throw Error(Fault::input,
                  fmt::format("no detector is called \"{}\"; there are {}", name, fmt::join(detector_names(), ", ")));
  if (targets.empty() && uses(is_of_targets))
    throw Error(Fault::input, "a detector of targets needs one; give --target NAME=FILE.csv or NAME=X0:X1,Y0:Y1");
  std::optional<Inverse> covariance, correlation;
  if (uses([](const std::string& name) { return name != "sam" && name != "cem"; }))
    covariance = invert(shrunk(background.covariance(), shrink), "the background's covariance");
  if (uses([](const std::string& name) { return name == "cem"; }))
    correlation = invert(shrunk(background.correlation(), shrink), "the background's correlation");
  if (uses(asks_norm)) whitened_.emplace(covariance->lower, background.bands());
  for (const NamedSpectrum& target : targets) {
    Target& t = targets_.emplace_back();
    t.spectrum = target.value, t.length = target.value.norm();
    if (!(t.length > 0)) throw Error(Fault::input, "target \"" + target.name + "\" is zero in every band");
    if (covariance) {
      const Eigen::VectorXd d = target.value - mean_;
      t.matched = covariance->whole * d, t.own = d.dot(t.matched);
      if (!(t.own > 0)) throw Error(Fault::input, "target \"" + target.name + "\" is the background's mean");
    }
    if (correlation) {
      t.constrained = correlation->whole * target.value;
      t.constrained /= target.value.dot(t.constrained);
    }
  }
  for (const NamedSpectrum& target : targets)
    for (const std::string& name : detectors)
      if (is_of_targets(name)) layers_.push_back(name + " " + target.name);
  for (const std::string& name : detectors)
    if (!is_of_targets(name)) layers_.push_back(name);
}

double Detection::score_of(const std::string& detector, const Target& target, const double* x, const double* y,
                           double norm) const {
  if (detector == "cem") return dot(target.constrained, x);
  if (detector == "sam") {
    const double length = Eigen::Map<const Eigen::VectorXd>(x, mean_.size()).norm() * target.length;
    return length > 0 ? std::acos(std::clamp(dot(target.spectrum, x) / length, -1.0, 1.0))
                      : std::numeric_limits<double>::quiet_NaN();
  }
  const double along = dot(target.matched, y);
  if (detector == "mf") return along / target.own;
  const double ace = norm > 0 ? along * along / (target.own * norm) : 0;
  return detector == "ace_signed" ? std::copysign(ace, along) : ace;
}

void Detection::score(const Pixels& pixels, std::vector<double>& out) const {
  const std::size_t layers = layers_.size(), n = pixels.bands, stride = padded(n);
  out.resize(pixels.count() * layers);
  thread_local std::vector<double> centred;
  centred.assign(kPixelsAtOnce * stride, 0.0);
  std::vector<double> norm(kPixelsAtOnce, 0.0);
  for (std::size_t first = 0; first < pixels.count(); first += kPixelsAtOnce) {
    const std::size_t many = std::min(kPixelsAtOnce, pixels.count() - first);
    for (std::size_t p = 0; p < many; ++p)
      for (std::size_t b = 0; b < n; ++b)
        centred[p * stride + b] = pixels.at(first + p)[b] - mean_[static_cast<Eigen::Index>(b)];
    if (whitened_) whitened_->norms(centred.data(), kPixelsAtOnce, norm.data());
    for (std::size_t p = 0; p < many; ++p) {
      double* score = out.data() + (first + p) * layers;
      if (!pixels.counts[first + p]) {
        std::fill(score, score + layers, std::numeric_limits<double>::quiet_NaN());
        continue;
      }
      for (const Target& target : targets_)
        for (const std::string& name : detectors_)
          if (is_of_targets(name))
            *score++ = score_of(name, target, pixels.at(first + p), centred.data() + p * stride, norm[p]);
      for (const std::string& name : detectors_)
        if (!is_of_targets(name)) *score++ = norm[p];
    }
  }
}

}  // namespace raycube::analysis
