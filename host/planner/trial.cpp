#include "host/planner/trial.h"

#include <algorithm>
#include <numbers>

#include <nlohmann/json.hpp>


namespace raycube::planner {

namespace {

/// Cells of a reference's grid along a side, each with a random point: 1024 points, whose own error is a third of that of 11 x 11 grid
/// points and drops out of the estimate but for its noise.
constexpr int kReferenceSide = 32;
/// Directions of the one set that all pixels share while samples are tried.
constexpr int kSharedDirections = 8;
/// Sets of directions in the sky's trial: two seeds pick the same set for one pixel in 256, which is lost in the standard error.
constexpr int kTrialSets = 256;
/// Added to the seed for draws that must not repeat the render's.
constexpr std::uint64_t kOther = 0x5bd1e995u;

}  // namespace

void set_directions(plan::Plan& plan, const scene::Simulation& simulation, int directions, int most_sets) {
  if (plan.components() == 0) return;
  plan.sky = plan::make_sky_sets(plan.sky_basis, simulation.sun.azimuth_deg * std::numbers::pi / 180, directions, simulation.seed, plan.sky_components,
                                 plan.thermal.on ? &plan.thermal : nullptr, most_sets);
  auto report = nlohmann::json::parse(plan.report_json);
  report["sky"]["sets"] = plan.sky.sets;
  report["sky"]["directions"] = plan.sky.directions;
  plan.report_json = report.dump(2);
}

Trial::Trial(render::Renderer& renderer, const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::Plan& plan)
    : renderer_(renderer), simulation_(simulation), instrument_(instrument), plan_(plan), one_sky_(plan), tiles_(trial_tiles(instrument, simulation.seed)) {
  for (const auto& tile : tiles_) pixels_ += tile.pixels();
  if (plan.components() == 0) return;
  set_directions(one_sky_, simulation, kSharedDirections, plan::kFewestSets);
  const auto entries = static_cast<std::size_t>(kSharedDirections);
  one_sky_.sky.sets = 1;
  one_sky_.sky.direction.resize(entries);
  one_sky_.sky.weight.resize(entries * static_cast<std::size_t>(one_sky_.sky.quads));
}

TrialImage Trial::render(const scene::Instrument& instrument, const plan::Plan& plan, std::uint64_t seed) {
  TrialImage image;
  image.bands = instrument.bands.size();
  renderer_.probe(instrument, plan, simulation_.sun, seed, tiles_, [&](const render::PixelProbe& probe) {
    image.radiance.insert(image.radiance.end(), probe.radiance.begin(), probe.radiance.end());
    image.run_end.push_back(image.radiance.size() / image.bands);
  });
  const PixelCounts counts = pixel_counts(plan, static_cast<double>(instrument.samples_u) * instrument.samples_v, plan.sky.directions);
  rays_ += static_cast<std::uint64_t>((counts.samples + counts.sun_rays + counts.sky_rays) * static_cast<double>(pixels_));
  cost_s_ += CostModel().seconds(counts) * static_cast<double>(pixels_);
  return image;
}

void Trial::make_references() {
  if (!mean_.empty()) return;
  scene::Instrument fine = instrument_;
  fine.sampler = scene::SamplerKind::jittered;
  fine.samples_u = fine.samples_v = kReferenceSide;
  one_ = render(fine, one_sky_, simulation_.seed + kOther);
  two_ = render(fine, one_sky_, simulation_.seed + 2 * kOther);
  mean_ = judged_means(one_);
}

TrialError Trial::sampling_error(int samples_u, int samples_v) {
  make_references();
  scene::Instrument tried = instrument_;
  tried.samples_u = samples_u, tried.samples_v = samples_v;
  return error_against(render(tried, one_sky_, simulation_.seed), one_, two_, mean_);
}

TrialError Trial::sky_error(int directions, int samples_u, int samples_v) {
  if (plan_.components() == 0) return {};
  scene::Instrument tried = instrument_;
  tried.samples_u = samples_u, tried.samples_v = samples_v;
  // Points that the seed moves would put the samples' noise into the difference.
  if (tried.sampler != scene::SamplerKind::grid) tried.sampler = scene::SamplerKind::grid;
  plan::Plan plan = plan_;
  set_directions(plan, simulation_, directions, kTrialSets);
  const TrialImage one = render(tried, plan, simulation_.seed), two = render(tried, plan, simulation_.seed + kOther);
  return error_between(one, two, judged_means(one));
}

}  // namespace raycube::planner
