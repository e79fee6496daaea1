#include "host/planner/own_error.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/planner/judged_pixels.h"
#include "host/planner/model_trial.h"
#include "host/planner/plan_lines.h"
#include "host/planner/replicated.h"
#include "host/planner/sample_pattern.h"
#include "host/planner/trial_pixels.h"

namespace raycube::planner {

namespace {

constexpr std::uint64_t kOtherSeed = 0x632be5abu;  ///< added: draws that neither the image nor a trial makes
constexpr double kFewRays = 3e5, kPart = 0.01;     ///< rays of an image that is tried whole; part of any other
constexpr int kFiner = 2;                          ///< times as many cells along a pixel under a point spread
constexpr int kWidestOwnTile = 512;                ///< pixels traced at once

/// Runs of kRunPixels pixels: all of an image whose rays are soon traced, else a hundredth of it.
int runs_of(const scene::Instrument& instrument) {
  const double pixels = static_cast<double>(instrument.pixels) * instrument.lines;
  if (pixels * instrument.samples_u * instrument.samples_v <= kFewRays) return kWholeRuns;
  return std::clamp(static_cast<int>(kPart * pixels / kRunPixels), kTrialRuns, kWholeRuns);
}

/// The trial's even draw of pixels, rendered as the instrument is.
TrialImage few_pixels(render::Renderer& renderer, const scene::Simulation& simulation,
                      const scene::Instrument& instrument, const plan::Plan& plan, std::uint64_t seed) {
  const auto tiles = trial_tiles(instrument, simulation.seed, runs_of(instrument));
  TrialImage image;
  image.bands = instrument.bands.size();
  renderer.probe_together(instrument, plan, simulation.sun, seed, joined(tiles, kWidestOwnTile),
                          [&](const render::PixelProbe& probe) {
                            image.radiance.insert(image.radiance.end(), probe.radiance.begin(), probe.radiance.end());
                          });
  for (const auto& tile : tiles)
    image.run_end.push_back((image.run_end.empty() ? 0 : image.run_end.back()) + tile.pixels());
  image.figure = simulation.tolerance_of.figure;
  image.weight = pixel_weights(renderer, simulation, instrument, plan, tiles);
  if (std::all_of(image.weight.begin(), image.weight.end(), [](float weight) { return weight <= 0; }))
    image.weight.clear();
  image.left_out =
      1 - static_cast<double>(image.pixels()) / (static_cast<double>(instrument.pixels) * instrument.lines);
  image.whole =
      image.pixels() == static_cast<std::size_t>(instrument.pixels) * static_cast<std::size_t>(instrument.lines);
  return image;
}

void sum_up(OwnError& out, double likely_drawn) {
  out.total = together(out.measure.figure, out.plan, out.drawn);
  out.likely = together(out.measure.figure, out.plan, likely_drawn);
}

/// Puts what is measured in place of the bound for the worst place.
void measure_plan(OwnError& out, const ModelError& measured) {
  const double likely_drawn = left_beside(out.measure.figure, out.likely, out.plan);
  out.plan = std::min(out.plan, measured.total.bound), out.plan_pixels = measured.pixels;
  sum_up(out, likely_drawn);
}

/// E[(a - r1)(a - r2)] = E[(a - truth)^2] for r1 and r2 without bias and independent of each other and of a,
/// however coarse they are.
void from_few_pixels(OwnError& out, render::Renderer& renderer, const scene::Simulation& simulation,
                     const scene::Instrument& given, const plan::Plan& plan) {
  scene::Instrument instrument = given;
  instrument.small_objects = scene::SmallObjects::off;
  instrument.standard_error = scene::StandardError::off;
  scene::Instrument random = instrument;
  random.first_samples = 0;
  // Cells weigh a point spread by their means: finer ones tell most of what that errs.
  if (!given.box_pixels())
    random.samples_u = std::min(kMostSide, kFiner * given.samples_u),
    random.samples_v = std::min(kMostSide, kFiner * given.samples_v);
  random.sampler = given.box_pixels() ? scene::SamplerKind::lattice : scene::SamplerKind::jittered;
  const TrialImage image = few_pixels(renderer, simulation, instrument, plan, simulation.seed);
  const TrialImage one = few_pixels(renderer, simulation, random, plan, simulation.seed + kOtherSeed);
  const TrialImage two = few_pixels(renderer, simulation, random, plan, simulation.seed + 2 * kOtherSeed);
  const TrialError drawn = of_pixels(error_against(image, one, two, judged_means(image)), given);
  out.drawn = drawn.bound;
  sum_up(out, drawn.estimate);
  out.from = fmt::format("{} pixels rendered three times; `raycube plan` measures it", image.pixels());
}

/// Of the image's own replicates, on all its pixels.
void from_replicates(OwnError& out, const render::ReplicateSpread& spread, const scene::Instrument& instrument) {
  const int replicates = instrument.replicates;
  const TrialError drawn = of_pixels(error_of(spread), instrument);
  out.drawn = drawn.bound;
  sum_up(out, drawn.estimate);
  out.from = fmt::format("the spread of the image's {} replicates", replicates);
}

}  // namespace

OwnError own_error(render::Renderer& renderer, const scene::Simulation& simulation, const scene::Instrument& instrument,
                   const plan::Plan& plan, const atmos::RenderTable& table, const Decision& decision,
                   const render::ReplicateSpread& spread, int threads) {
  OwnError out;
  out.tolerance = simulation.tolerance, out.measure = simulation.tolerance_of, out.plan = decision.plan_error;
  if (decision.total_error >= 0 && !instrument.adaptive()) {  // the trial takes all samples of every pixel
    out.samples = decision.samples_error, out.sky = decision.sky_error, out.total = decision.total_error;
    out.drawn = left_beside(out.measure.figure, out.total, out.plan);
    out.from = instrument.replicates > 1 ? fmt::format("the spread of {} replicates", instrument.replicates)
                                         : fmt::format("the plan's trial of {} pixels", decision.trial_pixels);
  } else {
    out.plan_pixels = decision.model_pixels;
    if (instrument.replicates > 1 && out.measure.plain())
      from_replicates(out, spread, instrument);
    else
      from_few_pixels(out, renderer, simulation, instrument, plan);
    if (!out.kept() && out.drawn <= out.tolerance && out.plan_pixels == 0)
      measure_plan(out, model_error(simulation, instrument, plan, table, threads));
  }
  return out;
}

std::string own_error_text(const OwnError& e) {
  const std::string drawn =
      e.samples < 0 ? fmt::format("samples and sky directions {}", percent_text(e.drawn))
                    : fmt::format("samples {}, sky directions {}", percent_text(e.samples), percent_text(e.sky));
  const auto percent_text = [&](double error) {  // as fine as it takes to tell it from the tolerance
    const std::string text = planner::percent_text(error);
    return text == planner::percent_text(e.tolerance) ? fmt::format("{:.3g} %", 100 * error) : text;
  };
  const std::string total = e.likely < 0
                                ? "at most " + percent_text(e.total)
                                : fmt::format("about {}, at most {},", percent_text(e.likely), percent_text(e.total));
  return fmt::format(
      "error {} of {:.3g} % tolerated{} ({}; bounds, each of its own worst band: {}, nodes and components {}{}; by {})",
      total, 100 * e.tolerance, e.kept() ? "" : ": NOT KEPT", measure_text(e.measure), drawn, percent_text(e.plan),
      e.plan_pixels > 0 ? fmt::format(" on {} pixels", e.plan_pixels) : "", e.from);
}

std::string own_error_json(const OwnError& e) {
  const auto number = [](double value) { return value < 0 ? nlohmann::json() : nlohmann::json(value); };
  return nlohmann::json{{"tolerance", e.tolerance},
                        {"tolerance_of", figure_name(e.measure.figure)},
                        {"tolerance_materials", e.measure.materials},
                        {"total", e.total},
                        {"likely", number(e.likely)},
                        {"within_tolerance", e.kept()},
                        {"samples_and_sky_directions", e.drawn},
                        {"samples", number(e.samples)},
                        {"sky_directions", number(e.sky)},
                        {"nodes_and_components", e.plan},
                        {"nodes_and_components_pixels", e.plan_pixels},
                        {"from", e.from}}
      .dump();
}

}  // namespace raycube::planner
