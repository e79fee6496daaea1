#include "host/planner/replicated.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace raycube::planner {

namespace {

/// Nominal seconds (CostModel) of four replicates, about what a first look takes, and of all that may be taken.
constexpr double kFour_s = 0.25, kAll_s = 0.3;
constexpr std::size_t kMostValues = 24'000'000;  ///< radiances and layers of the image: 16 bytes each
constexpr int kFewest = 2;

double replicate_s(const scene::Instrument& instrument, const plan::Plan& plan) {
  const double pixels = static_cast<double>(instrument.pixels) * instrument.lines;
  return pixels * CostModel().seconds(pixel_counts(plan, kReplicateSamples, kReplicateDirections));
}

/// As many as double the count until the error seen fits, and once more.
int foreseen(int count, double error, double budget) {
  double needed = count * (error / budget) * (error / budget);
  int out = count;
  while (out < needed && out < 2 * kMostReplicates) out *= 2;
  return std::min(2 * out, 4 * kMostReplicates);
}

}  // namespace

TrialError error_of(const render::ReplicateSpread& spread) {
  const std::vector<double> mean = judged_means(spread.radiance, spread.pixels);
  TrialError out;
  for (std::size_t b = 0; b < mean.size(); ++b) {
    const double judged = spread.pixels * mean[b] * mean[b], square = spread.square[b] / judged;
    out.bands.estimate.push_back(std::sqrt(square));
    out.bands.bound.push_back(std::sqrt(square + std::sqrt(spread.noise[b]) / judged));
  }
  out.estimate = out.bands.worst_estimate(), out.bound = out.bands.worst_bound();
  return out;
}

bool may_replicate(const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::Plan& plan) {
  const bool open = !instrument.samples_given && !(simulation.sky_directions_given && plan.components() > 0);
  const bool plain = instrument.box_pixels() && instrument.first_samples == 0 &&
                     instrument.standard_error == scene::StandardError::off;
  const double values = static_cast<double>(instrument.pixels) * instrument.lines *
                        static_cast<double>(instrument.bands.size() + simulation.scene.materials.size());
  return open && plain && values <= kMostValues && 4 * replicate_s(instrument, plan) <= kFour_s;
}

Replicates render_replicates(render::Renderer& renderer, const scene::Simulation& simulation,
                             const scene::Instrument& given, const plan::Plan& planned, double budget) {
  scene::Instrument instrument = given;
  instrument.sampler = scene::SamplerKind::lattice;
  instrument.samples_u = kReplicateSamples, instrument.samples_v = 1;
  plan::Plan plan = planned;
  if (plan.components() > 0) plan.sky.rays = kReplicateDirections;
  const double each_s = replicate_s(instrument, plan);
  auto image = std::make_shared<render::RenderedImage>(renderer.no_replicates(instrument));
  Replicates out;
  for (bool fitted = false;;) {
    const int count = image->sums.count();
    renderer.add_replicates(instrument, plan, simulation.sun, simulation.seed, std::max(kFewest, count), *image);
    out.error = error_of(image->sums.spread());
    out.measured.push_back(fmt::format("{} x lattice {}, directions {}: {:.2g} %, at most {:.2g} %",
                                       image->sums.count(), kReplicateSamples, kReplicateDirections,
                                       100 * out.error.estimate, 100 * out.error.bound));
    const bool fits = out.error.bound <= budget;
    if (fits && fitted) break;
    const int all = fits ? 2 * image->sums.count() : foreseen(image->sums.count(), out.error.bound, budget);
    if (all > kMostReplicates || all * each_s > kAll_s) return out;
    fitted = fits;
  }
  out.image = std::move(image);
  return out;
}

}  // namespace raycube::planner
