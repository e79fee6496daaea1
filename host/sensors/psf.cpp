#include "host/sensors/psf.h"

#include <algorithm>
#include <cmath>

#include "host/base/error.h"

namespace raycube::sensors {
namespace {

// Integral of the Gaussian's distribution function: int Phi(t / s) dt = t Phi(t / s) + s phi(t / s).
double ramp(double t, double sigma) {
  if (sigma == 0) return std::max(t, 0.0);
  const double z = t / sigma;
  return t * 0.5 * std::erfc(-z / std::sqrt(2.0)) + sigma * std::exp(-0.5 * z * z) / std::sqrt(2.0 * M_PI);
}

// Share of the one-dimensional response left of x.
double response_below(double x, double sigma) { return ramp(x + 0.5, sigma) - ramp(x - 0.5, sigma); }

std::vector<double> cell_shares(int cells, double support, double sigma) {
  std::vector<double> shares(cells);
  for (int i = 0; i < cells; ++i)
    shares[i] = response_below(support * ((i + 1.0) / cells - 0.5), sigma) -
                response_below(support * (double(i) / cells - 0.5), sigma);
  return shares;
}

}  // namespace

SampleWeights::SampleWeights(const scene::Instrument& instrument) {
  const int nu = instrument.samples_u, nv = instrument.samples_v;
  const double sigma = instrument.psf_sigma_px, support = instrument.psf_support_px;
  const auto refuse = [&](const std::string& what) {
    return base::Error(base::Fault::input, "instrument '" + instrument.name + "': " + what);
  };
  if (nu < 1 || nv < 1)
    throw refuse("a pixel has at least one sample, found " + std::to_string(nu) + " x " + std::to_string(nv));
  if (!(sigma >= 0) || !(support > 0))
    throw refuse("point spread needs sigma >= 0 and support > 0, found " + std::to_string(sigma) + " and " +
                 std::to_string(support));
  count_ = static_cast<std::size_t>(nu) * nv;
  columns_ = instrument.sampler == scene::SamplerKind::lattice || nu < 2 || nv < 2 ? 0 : static_cast<std::size_t>(nu);
  if (instrument.box_pixels()) return;
  if (instrument.sampler == scene::SamplerKind::lattice)
    throw refuse(
        "a point spread needs the grid or jittered sampler: the lattice is shifted in each pixel and has no cells");
  along_ = cell_shares(nu, support, sigma);
  across_ = cell_shares(nv, support, sigma);
  double sum_u = 0, sum_v = 0;
  for (double share : along_) sum_u += share;
  for (double share : across_) sum_v += share;
  if (sum_u * sum_v < 0.99)
    throw refuse("point spread sigma " + std::to_string(sigma) + " px needs a wider support than " +
                 std::to_string(support) + " px, which holds only " + std::to_string(100 * sum_u * sum_v) +
                 " % of it; try " + std::to_string(std::ceil(1 + 5 * sigma)));
  for (double& share : along_) share /= sum_u;
  for (double& share : across_) share /= sum_v;
}

std::vector<float> SampleWeights::stretch(std::size_t first, std::size_t count) const {
  std::vector<float> weights(count, 1.0f);
  if (along_.empty()) return weights;
  for (std::size_t s = 0; s < count; ++s)
    weights[s] =
        static_cast<float>(along_[(first + s) % along_.size()] * across_[(first + s) / along_.size()] * double(count_));
  return weights;
}

int SampleWeights::subset_of(std::size_t sample) const {
  if (columns_ == 0) return static_cast<int>(sample % kSampleSubsets);
  return static_cast<int>(sample % columns_ % 2 + 2 * (sample / columns_ % 2));
}

double SampleWeights::share_of(int subset) const {
  if (subset == kAllSamples) return 1;
  double part = 0;
  const std::vector<float> all = stretch(0, count_);
  for (std::size_t s = 0; s < count_; ++s)
    if (subset_of(s) == subset) part += all[s];
  return part / static_cast<double>(count_);
}

std::vector<float> SampleWeights::stretch(std::size_t first, std::size_t count, int subset) const {
  std::vector<float> weights = stretch(first, count);
  if (subset == kAllSamples) return weights;
  const double share = share_of(subset);
  for (std::size_t s = 0; s < count; ++s)
    weights[s] = subset_of(first + s) == subset ? static_cast<float>(weights[s] / share) : 0.0f;
  return weights;
}

std::vector<float> psf_weights(const scene::Instrument& instrument) {
  const SampleWeights weights(instrument);
  std::vector<float> out = weights.stretch(0, weights.count());
  for (float& w : out) w = static_cast<float>(double{w} / static_cast<double>(weights.count()));
  return out;
}

}  // namespace raycube::sensors
