#include "host/planner/replicated.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "host/planner/planner.h"

namespace raycube::planner {

namespace {

/// Nominal seconds (CostModel) of four replicates, about what a first look takes, and of all that may be taken.
constexpr double kFour_s = 0.25, kAll_s = 0.6;
/// Of loading another size's programs.
constexpr double kPrograms_s = 0.15;
/// What two replicates of the smallest size err in an image of wires, fences and targets (3.5 to 5 % in twenty seeded
/// scenes, bench/planner_accuracy.py): what a first size is chosen by.
constexpr double kTypicalError = 0.045;
/// Samples of a replicate. Few numbers, since each has programs of its own.
constexpr std::array kSizes = {kReplicateSamples, 34, 89, 233, 610};
/// How samples and directions go up where the error is to come down by a factor: the usual laws of error_law.h, not
/// the careful ones, since twice as many replicates are the worst that comes of it.
constexpr double kSamplesPower = 1.0 / 0.75, kDirectionsPower = 1.0 / 0.7;
constexpr double kMostValues = 8e6;  ///< radiances and layers of the image, 16 bytes each while replicates are summed
constexpr double kPartOfMemory = 0.25;  ///< beyond it sums are not kept, and the image is rendered anew
constexpr double kToldTo = 1e-6;        ///< errors are told so finely: what sums round by their order moves no choice
constexpr int kFewest = 2;

double values_of(const scene::Simulation& simulation, const scene::Instrument& instrument) {
  return static_cast<double>(instrument.pixels) * instrument.lines *
         static_cast<double>(instrument.bands.size() + simulation.scene.materials.size());
}

double replicate_s(const scene::Instrument& instrument, const plan::Plan& plan, ReplicateSize size = {}) {
  const double pixels = static_cast<double>(instrument.pixels) * instrument.lines;
  return pixels * CostModel().seconds(pixel_counts(plan, size.samples, size.directions));
}

/// With what a pixel takes whatever its size.
double whole_s(const scene::Instrument& instrument, const plan::Plan& plan, ReplicateSize size) {
  return CostModel().whole_image_s(pixel_counts(plan, size.samples, size.directions),
                                   static_cast<double>(instrument.pixels) * instrument.lines);
}

/// As many as double the count until the error seen fits, and once more.
int foreseen(int count, double error, double budget) {
  double needed = count * (error / budget) * (error / budget);
  int out = count;
  while (out < needed && out < 2 * kMostReplicates) out *= 2;
  return std::min(2 * out, 4 * kMostReplicates);
}

template <class Levels>
int nearest(const Levels& levels, double wanted) {
  return *std::min_element(levels.begin(), levels.end(), [&](int a, int b) {
    return std::abs(std::log(a / wanted)) < std::abs(std::log(b / wanted));
  });
}

/// Of which two may be hoped to fit, where `count` of this size err by so much.
ReplicateSize larger(ReplicateSize size, int count, double error, double budget) {
  const double fall = error * std::sqrt(0.5 * count) / budget;
  return {std::max(size.samples, nearest(kSizes, size.samples * std::pow(fall, kSamplesPower))),
          std::max(size.directions, nearest(direction_levels(), size.directions * std::pow(fall, kDirectionsPower)))};
}

constexpr double kNever_s = std::numeric_limits<double>::infinity();

/// The size to go on with after `count` of `size` that err by `error`; none: either way takes more than it may.
std::optional<ReplicateSize> next_size(const scene::Instrument& instrument, const plan::Plan& plan, ReplicateSize size,
                                       int count, double error, double budget) {
  const bool fits = error <= budget;
  const int all = fits ? 2 * count : foreseen(count, error, budget);
  const ReplicateSize more = larger(size, count, error, budget);
  const auto unless = [](bool never, double s) { return never || s > kAll_s ? kNever_s : s; };
  const double doubled_s = unless(all > kMostReplicates, all * replicate_s(instrument, plan, size)),
               larger_s = unless(more.samples == size.samples, 2 * kFewest * replicate_s(instrument, plan, more));
  if (std::min(doubled_s, larger_s) == kNever_s) return std::nullopt;
  if (fits) return doubled_s < kNever_s ? std::optional(size) : std::nullopt;
  if (larger_s == kNever_s) return size;
  if (doubled_s == kNever_s) return more;
  const bool sooner =
      (all - count) * whole_s(instrument, plan, size) <= 2 * kFewest * whole_s(instrument, plan, more) + kPrograms_s;
  return sooner ? size : more;
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

ReplicateSize first_size(const scene::Instrument& instrument, const plan::Plan& plan, double tolerance) {
  for (double hoped = tolerance;; hoped *= 1.25) {
    const ReplicateSize size = larger({}, kFewest, kTypicalError, hoped);
    if (size == ReplicateSize() || 4 * replicate_s(instrument, plan, size) <= kFour_s) return size;
  }
}

bool may_replicate(const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::Plan& plan) {
  const bool open = !instrument.samples_given && !(simulation.sky_directions_given && plan.sends_rays());
  const bool plain = instrument.box_pixels() && instrument.first_samples == 0 &&
                     instrument.standard_error == scene::StandardError::off;
  return open && plain && simulation.tolerance_of.plain() && values_of(simulation, instrument) <= kMostValues &&
         4 * replicate_s(instrument, plan) <= kFour_s;
}

namespace {

/// Doubles the replicates of an image and says what their mean errs: kept where there is memory for it, else all anew.
class Doubling {
 public:
  Doubling(render::Renderer& renderer, const scene::Simulation& simulation, const scene::Instrument& instrument,
           const plan::Plan& plan, ReplicateSize size)
      : renderer_(renderer), simulation_(simulation), instrument_(instrument), plan_(plan) {
    instrument_.sampler = scene::SamplerKind::lattice;
    instrument_.samples_u = size.samples, instrument_.samples_v = 1;
    if (plan_.sends_rays()) plan_.sky.rays = size.directions;
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
  plan::Plan plan_;
  std::shared_ptr<render::RenderedImage> image_;
  int count_ = 0;
};

}  // namespace

Replicates render_replicates(render::Renderer& renderer, const scene::Simulation& simulation,
                             const scene::Instrument& instrument, const plan::Plan& plan, double budget) {
  Replicates out;
  out.size = first_size(instrument, plan, simulation.tolerance / instrument.share_of_draws);
  auto doubling = std::make_unique<Doubling>(renderer, simulation, instrument, plan, out.size);
  for (bool fitted = false;;) {
    out.error = of_pixels(doubling->next(), instrument);
    const int count = doubling->count();
    out.measured.push_back(fmt::format("{} x lattice {}, directions {}: {:.2g} %, at most {:.2g} %", count,
                                       out.size.samples, out.size.directions, 100 * out.error.estimate,
                                       100 * out.error.bound));
    const bool fits = out.error.bound <= budget;
    if (fits && fitted) break;
    fitted = fits;
    const auto next = next_size(instrument, plan, out.size, count, out.error.bound, budget);
    if (!next) return out;
    if (*next == out.size) continue;
    out.size = *next;
    doubling = std::make_unique<Doubling>(renderer, simulation, instrument, plan, out.size);
  }
  out.count = doubling->count(), out.image = doubling->image();
  return out;
}

}  // namespace raycube::planner
