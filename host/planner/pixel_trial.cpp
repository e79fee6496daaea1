#include "host/planner/pixel_trial.h"

#include <algorithm>

namespace raycube::planner {

namespace {

/// Cells of a reference's grid along a side, each with a random point: 1024 points, whose own error is a third of that
/// of 11 x 11 grid points and drops out of the estimate but for its noise.
constexpr int kReferenceSide = 32;
constexpr int kWidestTile = 512;  ///< pixels traced at once
constexpr int kLookSide = 4;      ///< of the first look's lattice
/// Sky directions of a pixel while samples are tried: their noise drops out of the estimate but for its own.
constexpr int kLookDirections = 16, kTriedDirections = 32, kReferenceDirections = 128;
/// Added to the seed for draws that must not repeat the render's.
constexpr std::uint64_t kOther = 0x5bd1e995u;

}  // namespace

PixelTrial::PixelTrial(render::Renderer& renderer, const scene::Simulation& simulation,
                       const scene::Instrument& instrument, const plan::Plan& plan)
    : renderer_(renderer), simulation_(simulation), instrument_(instrument), plan_(plan) {
  instrument_.first_samples = 0;                         // errors of all samples
  instrument_.small_objects = scene::SmallObjects::off;  // and of the law that holds for most pixels
  look();
}

scene::Instrument PixelTrial::sampled(scene::SamplerKind sampler, int samples_u, int samples_v) const {
  scene::Instrument out = instrument_;
  out.sampler = sampler, out.samples_u = samples_u, out.samples_v = samples_v;
  return out;
}

/// Lattices, since every seed moves them.
void PixelTrial::look() {
  tiles_ = trial_tiles(instrument_, simulation_.seed, kLookRuns);
  for (const auto& tile : tiles_) pixels_ += tile.pixels();
  looked_at_ = pixels_;
  const scene::Instrument few = sampled(scene::SamplerKind::lattice, kLookSide, kLookSide);
  const TrialImage one = render(few, kLookDirections, simulation_.seed + 3 * kOther, 0),
                   two = render(few, kLookDirections, simulation_.seed + 4 * kOther, 0);
  mean_ = judged_means(one);
  const std::vector<double> error = run_differences(one, two, mean_);
  draws_ = draw_runs(error, simulation_.seed, kDraws, kWholeRuns);
  drawn_from_ = static_cast<double>(tiles_.size());
  left_out_ = 1 - static_cast<double>(looked_at_) / (static_cast<double>(instrument_.pixels) * instrument_.lines);
  std::vector<render::Tile> drawn;
  whole_ = left_out_ <= 0 && draws_.size() == tiles_.size() && tiles_.size() <= static_cast<std::size_t>(kWholeRuns);
  pixels_per_run_ = static_cast<double>(pixels_) / static_cast<double>(tiles_.size());
  pixels_ = 0;
  for (const Draw& draw : draws_) drawn.push_back(tiles_[draw.run]), pixels_ += drawn.back().pixels();
  tiles_ = std::move(drawn);
}

TrialImage PixelTrial::render(const scene::Instrument& instrument, int directions, std::uint64_t seed,
                              std::uint32_t sky_draw) {
  if (plan_.components() > 0) plan_.sky.rays = directions;
  plan_.sky.draw = sky_draw;
  TrialImage image;
  image.bands = instrument.bands.size();
  image.draw = draws_, image.pixels_per_run = pixels_per_run_;
  image.drawn_from = drawn_from_, image.left_out = left_out_;
  image.whole = whole_;
  renderer_.probe_together(instrument, plan_, simulation_.sun, seed, joined(tiles_, kWidestTile),
                           [&](const render::PixelProbe& probe) {
                             image.radiance.insert(image.radiance.end(), probe.radiance.begin(), probe.radiance.end());
                           });
  for (const auto& tile : tiles_)
    image.run_end.push_back((image.run_end.empty() ? 0 : image.run_end.back()) + tile.pixels());
  const PixelCounts counts =
      pixel_counts(plan_, static_cast<double>(instrument.samples_u) * instrument.samples_v, plan_.sky.rays);
  rays_ +=
      static_cast<std::uint64_t>((counts.samples + counts.sun_rays + counts.sky_rays) * static_cast<double>(pixels_));
  cost_s_ += CostModel().seconds(counts) * static_cast<double>(pixels_);
  return image;
}

void PixelTrial::make_references() {
  if (one_.bands > 0) return;
  const scene::Instrument fine = sampled(scene::SamplerKind::jittered, kReferenceSide, kReferenceSide);
  one_ = render(fine, kReferenceDirections, simulation_.seed + kOther, 0);
  two_ = render(fine, kReferenceDirections, simulation_.seed + 2 * kOther, 0);
}

TrialError PixelTrial::sampling_error(scene::SamplerKind sampler, int samples_u, int samples_v) {
  make_references();
  const scene::Instrument tried = sampled(sampler, samples_u, samples_v);
  const TrialImage image = render(tried, kTriedDirections, simulation_.seed, 0);
  if (plan_.components() == 0) return error_against(image, one_, two_, mean_);
  return common_error(image, render(tried, kTriedDirections, simulation_.seed, 1), one_, two_, mean_);
}

TrialError PixelTrial::sky_error(int directions, int samples_u, int samples_v) {
  if (plan_.components() == 0) return {0, 0, {{0}, {0}}};
  const scene::Instrument tried = sampled(scene::SamplerKind::grid, samples_u, samples_v);
  return error_between(render(tried, directions, simulation_.seed, 0), render(tried, directions, simulation_.seed, 1),
                       mean_);
}

}  // namespace raycube::planner
