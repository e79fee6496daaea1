#include "host/planner/own_error.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/planner/plan_lines.h"
#include "host/planner/trial_pixels.h"

namespace raycube::planner {

namespace {

constexpr std::uint64_t kOtherSeed = 0x632be5abu;  ///< added: draws that neither the image nor a trial makes
constexpr int kWidestTile = 512;                   ///< pixels traced at once
constexpr int kFewestSamples = 4;                  ///< whose parts have a spread

/// The trial's even draw of pixels, rendered as the image is.
TrialImage few_pixels(render::Renderer& renderer, const scene::Simulation& simulation,
                      const scene::Instrument& instrument, const plan::Plan& plan, std::uint64_t seed,
                      std::vector<float>* band_error) {
  const auto tiles = trial_tiles(instrument, simulation.seed);
  TrialImage image;
  image.bands = instrument.bands.size();
  const auto file = [&](const render::PixelProbe& probe) {
    image.radiance.insert(image.radiance.end(), probe.radiance.begin(), probe.radiance.end());
    if (band_error) band_error->insert(band_error->end(), probe.band_error.begin(), probe.band_error.end());
  };
  renderer.probe(instrument, plan, simulation.sun, seed, joined(tiles, kWidestTile), file);
  for (const auto& tile : tiles)
    image.run_end.push_back((image.run_end.empty() ? 0 : image.run_end.back()) + tile.pixels());
  return image;
}

/// By rendering a few pixels twice.
void from_spread(OwnError& out, render::Renderer& renderer, const scene::Simulation& simulation,
                 const scene::Instrument& given, const plan::Plan& plan) {
  const int samples = given.samples_u * given.samples_v;
  scene::Instrument instrument = given;
  instrument.first_samples = 0, instrument.small_objects = scene::SmallObjects::off;
  instrument.standard_error =
      samples >= kFewestSamples ? scene::StandardError::bands : scene::StandardError::off;
  std::vector<float> band_error;
  const TrialImage one = few_pixels(renderer, simulation, instrument, plan, simulation.seed, &band_error);
  instrument.standard_error = scene::StandardError::off;
  const std::vector<double> mean = judged_means(one);
  const bool grid = instrument.sampler == scene::SamplerKind::grid, sky = plan.components() > 0;
  double drawn = 0;
  if (!grid || sky)
    drawn =
        error_between(
            one, few_pixels(renderer, simulation, instrument, plan, simulation.seed + kOtherSeed, nullptr),
            mean)
            .estimate;
  if (samples >= kFewestSamples) {
    TrialImage moved = one;
    for (std::size_t i = 0; i < moved.radiance.size(); ++i) moved.radiance[i] += band_error[i];
    out.samples = error_from(moved, one, mean).estimate;
  }
  if (grid) {
    out.sky = drawn;
    if (out.samples >= 0) out.total = std::hypot(out.plan, out.samples, out.sky);
    out.from = out.samples >= 0 ? "spread of its samples" : "fewer than 4 samples have no spread";
  } else {
    if (!sky) out.sky = 0, out.samples = drawn;
    out.total = std::hypot(out.plan, drawn);
    out.from = "two draws of its samples and directions";
  }
  out.from += fmt::format(" on {} pixels; `raycube plan` measures it", one.pixels());
}

}  // namespace

OwnError own_error(render::Renderer& renderer, const scene::Simulation& simulation,
                   const scene::Instrument& instrument, const plan::Plan& plan, const Decision& decision) {
  OwnError out;
  out.tolerance = simulation.tolerance, out.plan = decision.plan_error;
  if (decision.total_error >= 0) {
    out.samples = decision.samples_error, out.sky = decision.sky_error, out.total = decision.total_error;
    out.from = fmt::format("the plan's trial of {} pixels", decision.trial_pixels);
  } else {
    from_spread(out, renderer, simulation, instrument, plan);
  }
  return out;
}

std::string own_error_text(const OwnError& e) {
  const std::string head = !e.known()
                               ? fmt::format("error not known, tolerance {:.3g} %", 100 * e.tolerance)
                               : fmt::format("error about {} of {:.3g} % tolerated{}", percent_text(e.total),
                                             100 * e.tolerance, e.kept() ? "" : ": NOT KEPT");
  const auto part = [](const char* name, double value) {
    return fmt::format("{} {}", name, value < 0 ? "not known" : percent_text(value));
  };
  return fmt::format("{} ({}, {}, {}; by {})", head, part("samples", e.samples),
                     e.sky < 0 && e.known() ? "sky directions in the total" : part("sky directions", e.sky),
                     part("nodes and components", e.plan), e.from);
}

std::string own_error_json(const OwnError& e) {
  const auto number = [](double value) { return value < 0 ? nlohmann::json() : nlohmann::json(value); };
  return nlohmann::json{{"tolerance", e.tolerance},
                        {"total", number(e.total)},
                        {"within_tolerance", e.known() ? nlohmann::json(e.kept()) : nlohmann::json()},
                        {"samples", number(e.samples)},
                        {"sky_directions", number(e.sky)},
                        {"nodes_and_components", e.plan},
                        {"from", e.from}}
      .dump();
}

}  // namespace raycube::planner
