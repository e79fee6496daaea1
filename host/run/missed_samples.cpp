#include "host/run/missed_samples.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/render/truth.h"

namespace raycube::run {

namespace {

/// A fraction nearer to 1 is 1: sums of float weights, of chunks and point spreads too.
constexpr float kWhole = 1 - 1e-5f;

}  // namespace

MissedSamples::MissedSamples(const scene::Simulation& simulation, const scene::Instrument& instrument)
    : name_(instrument.name), pixels_per_line_(static_cast<std::size_t>(instrument.pixels)) {
  const auto layers = render::truth_layer_names(simulation.scene, instrument);
  layers_ = layers.size();
  const auto at =
      std::find_if(layers.begin(), layers.end(), [](const auto& layer) { return layer.name == "hit_fraction"; });
  layer_ = static_cast<std::size_t>(at - layers.begin());
}

void MissedSamples::add(const render::Strip& strip) {
  const std::size_t pixels = static_cast<std::size_t>(strip.lines) * pixels_per_line_;
  pixels_ += pixels;
  for (std::size_t p = 0; p < pixels; ++p) {
    const float hit = strip.truth[p * layers_ + layer_];
    if (hit >= kWhole) continue;
    if (line_ < 0) {
      line_ = strip.first_line + static_cast<int>(p / pixels_per_line_);
      sample_ = static_cast<int>(p % pixels_per_line_);
    }
    missed_ += 1.0 - static_cast<double>(hit);
    ++(hit > 0 ? partly_ : empty_);
  }
}

std::string MissedSamples::text() const {
  return fmt::format(
      "{}: {:.3g} % of the samples meet nothing: {} of {} pixels hold no ground at all and {} only in part, "
      "the first at line "
      "{}, sample {}; there is no light from beyond the scene's edge in them, nor from the ground around "
      "beyond it: let the ground go on "
      "beyond the view ([[plane]] as large as the view, a little under the scene's rim), or narrow the view "
      "(hit_fraction in "
      "truth.img says which)",
      name_, 100 * missed_ / static_cast<double>(std::max<std::uint64_t>(1, pixels_)), empty_, pixels_, partly_, line_,
      sample_);
}

std::string MissedSamples::json() const {
  nlohmann::json out = {{"share", missed_ / static_cast<double>(std::max<std::uint64_t>(1, pixels_))},
                        {"pixels_without_ground", empty_},
                        {"pixels_partly_without", partly_}};
  if (any()) out["first"] = {{"line", line_}, {"sample", sample_}};
  return out.dump();
}

}  // namespace raycube::run
