#include "host/planner/replicated.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace raycube::planner {

namespace {

/// Nominal seconds (CostModel) of four replicates, about what a first look takes, and of all that may be taken.
constexpr double kFour_s = 0.25, kAll_s = 0.3;
constexpr double kMostValues = 8e6;  ///< radiances and layers of the image, 16 bytes each while replicates are summed
constexpr double kPartOfMemory = 0.25;  ///< beyond it sums are not kept, and the image is rendered anew
constexpr double kToldTo = 1e-6;        ///< errors are told so finely: what sums round by their order moves no choice
constexpr int kFewest = 2;

double values_of(const scene::Simulation& simulation, const scene::Instrument& instrument) {
  return static_cast<double>(instrument.pixels) * instrument.lines *
         static_cast<double>(instrument.bands.size() + simulation.scene.materials.size());
}

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
  const auto told = [](double error) { return std::round(error / kToldTo) * kToldTo; };
  out.estimate = told(out.bands.worst_estimate()), out.bound = told(out.bands.worst_bound());
  return out;
}

bool may_replicate(const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::Plan& plan) {
  const bool open = !instrument.samples_given && !(simulation.sky_directions_given && plan.components() > 0);
  const bool plain = instrument.box_pixels() && instrument.first_samples == 0 &&
                     instrument.standard_error == scene::StandardError::off;
  return open && plain && values_of(simulation, instrument) <= kMostValues &&
         4 * replicate_s(instrument, plan) <= kFour_s;
}

namespace {

/// Doubles the replicates of an image and says what their mean errs: kept where there is memory for it, else all anew.
class Doubling {
 public:
  Doubling(render::Renderer& renderer, const scene::Simulation& simulation, const scene::Instrument& instrument,
           const plan::Plan& plan)
      : renderer_(renderer), simulation_(simulation), instrument_(instrument), plan_(plan) {
    instrument_.small_objects = scene::SmallObjects::off;  // the law of most pixels
    if (16 * values_of(simulation, instrument) <= kPartOfMemory * static_cast<double>(renderer.memory_bytes()))
      image_ = std::make_shared<render::RenderedImage>(renderer.no_replicates(instrument));
  }

  int count() const { return count_; }

  TrialError next() {
    const int more = std::max(kFewest, count_);
    count_ += more;
    if (image_) {
      renderer_.add_replicates(instrument_, plan_, simulation_.sun, simulation_.seed, more, *image_);
      return error_of(image_->sums.spread());
    }
    instrument_.replicates = count_;
    return error_of(renderer_.render(instrument_, plan_, simulation_.sun, simulation_.seed, [](const auto&) {}).spread);
  }

  std::shared_ptr<const render::RenderedImage> image() { return std::move(image_); }

 private:
  render::Renderer& renderer_;
  const scene::Simulation& simulation_;
  scene::Instrument instrument_;
  const plan::Plan& plan_;
  std::shared_ptr<render::RenderedImage> image_;
  int count_ = 0;
};

}  // namespace

Replicates render_replicates(render::Renderer& renderer, const scene::Simulation& simulation,
                             const scene::Instrument& given, const plan::Plan& planned, double budget) {
  scene::Instrument instrument = given;
  instrument.sampler = scene::SamplerKind::lattice;
  instrument.samples_u = kReplicateSamples, instrument.samples_v = 1;
  plan::Plan plan = planned;
  if (plan.components() > 0) plan.sky.rays = kReplicateDirections;
  const double each_s = replicate_s(instrument, plan);
  Doubling doubling(renderer, simulation, instrument, plan);
  Replicates out;
  for (bool fitted = false;;) {
    out.error = doubling.next();
    const int count = doubling.count();
    out.measured.push_back(fmt::format("{} x lattice {}, directions {}: {:.2g} %, at most {:.2g} %", count,
                                       kReplicateSamples, kReplicateDirections, 100 * out.error.estimate,
                                       100 * out.error.bound));
    const bool fits = out.error.bound <= budget;
    if (fits && fitted) break;
    const int all = fits ? 2 * count : foreseen(count, out.error.bound, budget);
    if (all > kMostReplicates || all * each_s > kAll_s) return out;
    fitted = fits;
  }
  out.count = doubling.count(), out.image = doubling.image();
  return out;
}

}  // namespace raycube::planner
