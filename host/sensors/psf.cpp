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

std::vector<float> psf_weights(const scene::Instrument& instrument) {
  const int nu = instrument.samples_u, nv = instrument.samples_v;
  const double sigma = instrument.psf_sigma_px, support = instrument.psf_support_px;
  const auto refuse = [&](const std::string& what) {
    return base::Error(base::Fault::input, "instrument '" + instrument.name + "': " + what);
  };
  if (nu < 1 || nv < 1) throw refuse("a pixel has at least one sample, found " + std::to_string(nu) + " x " + std::to_string(nv));
  if (!(sigma >= 0) || !(support > 0))
    throw refuse("point spread needs sigma >= 0 and support > 0, found " + std::to_string(sigma) + " and " + std::to_string(support));
  const std::size_t count = static_cast<std::size_t>(nu) * nv;
  if (sigma == 0 && support == 1) return std::vector<float>(count, static_cast<float>(1.0 / count));
  if (instrument.sampler == scene::SamplerKind::lattice)
    throw refuse("a point spread needs the grid or jittered sampler: the lattice is shifted in each pixel and has no cells");
  const auto along = cell_shares(nu, support, sigma), across = cell_shares(nv, support, sigma);
  double sum_u = 0, sum_v = 0;
  for (double share : along) sum_u += share;
  for (double share : across) sum_v += share;
  if (sum_u * sum_v < 0.99)
    throw refuse("point spread sigma " + std::to_string(sigma) + " px needs a wider support than " + std::to_string(support) +
                 " px, which holds only " + std::to_string(100 * sum_u * sum_v) + " % of it; try " +
                 std::to_string(std::ceil(1 + 5 * sigma)));
  std::vector<float> weights(count);
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i)
      weights[static_cast<std::size_t>(j) * nu + i] = static_cast<float>(along[i] * across[j] / (sum_u * sum_v));
  return weights;
}

}  // namespace raycube::sensors
