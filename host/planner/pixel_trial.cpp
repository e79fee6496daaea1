#include "host/planner/pixel_trial.h"

#include <algorithm>
#include <numeric>

#include "host/base/units.h"

namespace raycube::planner {

namespace {

/// Cells of a reference's grid along a side, each with a random point: 1024 points, whose own error is a third of that
/// of 11 x 11 grid points and drops out of the estimate but for its noise.
constexpr int kReferenceSide = 32;
constexpr int kWidestTile = 512;  ///< pixels traced at once
constexpr int kLookSide = 4;      ///< of the first look's lattice
/// Directions of the one set that all pixels share while samples are tried.
constexpr int kSharedDirections = 8;
/// Sets of directions in the sky's trial: two seeds pick the same set for one pixel in 256, which is lost in the
/// standard error.
constexpr int kTrialSets = 256;
/// Added to the seed for draws that must not repeat the render's.
constexpr std::uint64_t kOther = 0x5bd1e995u;

}  // namespace

plan::SkySets sky_for(const plan::Plan& plan, const scene::Simulation& simulation, int directions, int share,
                      int most_sets) {
  plan::SkySets sky =
      plan::make_sky_sets(plan.sky_basis, base::rad_by_division(simulation.sun.azimuth_deg), directions,
                          simulation.seed, plan.sky_components, plan.thermal.on ? &plan.thermal : nullptr, most_sets);
  sky.share = share;
  return sky;
}

void set_directions(plan::Plan& plan, const scene::Simulation& simulation, int samples, int directions) {
  if (plan.components() == 0) return;
  plan.sky = sky_for(plan, simulation, directions, plan::sky_share(simulation.sky_share, samples, directions));
}

PixelTrial::PixelTrial(render::Renderer& renderer, const scene::Simulation& simulation,
                       const scene::Instrument& instrument, const plan::Plan& plan)
    : renderer_(renderer), simulation_(simulation), instrument_(instrument), plan_(plan) {
  instrument_.first_samples = 0;                         // errors of all samples
  instrument_.small_objects = scene::SmallObjects::off;  // and of the law that holds for most pixels
  if (plan.components() > 0) {
    one_sky_ = sky_for(plan, simulation, kSharedDirections, 1,
                       plan::kFewestSets);  // a share would add the sky to the samples' error
    const auto entries = static_cast<std::size_t>(kSharedDirections);
    one_sky_.sets = 1;
    one_sky_.direction.resize(entries);
    one_sky_.weight.resize(entries * static_cast<std::size_t>(one_sky_.quads));
  }
  look();
}

scene::Instrument PixelTrial::sampled(scene::SamplerKind sampler, int samples_u, int samples_v) const {
  scene::Instrument out = instrument_;
  out.sampler = sampler, out.samples_u = samples_u, out.samples_v = samples_v;
  return out;
}

/// Lattices, since every seed moves them; the last differs from the first by its sky alone.
void PixelTrial::look() {
  tiles_ = trial_tiles(instrument_, simulation_.seed, kLookRuns);
  for (const auto& tile : tiles_) pixels_ += tile.pixels();
  looked_at_ = pixels_;
  const scene::Instrument few = sampled(scene::SamplerKind::lattice, kLookSide, kLookSide);
  const TrialImage one = render(few, one_sky_, simulation_.seed + 3 * kOther),
                   two = render(few, one_sky_, simulation_.seed + 4 * kOther);
  mean_ = judged_means(one);
  std::vector<double> error = run_differences(one, two, mean_);
  const double sampling = std::accumulate(error.begin(), error.end(), 0.0);
  if (plan_.components() > 0) {
    const plan::SkySets sky = sky_for(plan_, simulation_, kSharedDirections, 1, kTrialSets);
    const auto changed = run_differences(one, render(few, sky, simulation_.seed + 3 * kOther), mean_);
    // Either kind of error draws half.
    const double all = std::accumulate(changed.begin(), changed.end(), 0.0),
                 scale = all > 0 && sampling > 0 ? sampling / all : 1;
    for (std::size_t r = 0; r < error.size(); ++r) error[r] += scale * changed[r];
  }
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

TrialImage PixelTrial::render(const scene::Instrument& instrument, const plan::SkySets& sky, std::uint64_t seed) {
  plan_.sky = sky;
  TrialImage image;
  image.bands = instrument.bands.size();
  image.draw = draws_, image.pixels_per_run = pixels_per_run_;
  image.drawn_from = drawn_from_, image.left_out = left_out_;
  image.whole = whole_;
  renderer_.probe(instrument, plan_, simulation_.sun, seed, joined(tiles_, kWidestTile),
                  [&](const render::PixelProbe& probe) {
                    image.radiance.insert(image.radiance.end(), probe.radiance.begin(), probe.radiance.end());
                  });
  for (const auto& tile : tiles_)
    image.run_end.push_back((image.run_end.empty() ? 0 : image.run_end.back()) + tile.pixels());
  const PixelCounts counts =
      pixel_counts(plan_, static_cast<double>(instrument.samples_u) * instrument.samples_v, sky.directions, sky.share);
  rays_ +=
      static_cast<std::uint64_t>((counts.samples + counts.sun_rays + counts.sky_rays) * static_cast<double>(pixels_));
  cost_s_ += CostModel().seconds(counts) * static_cast<double>(pixels_);
  return image;
}

void PixelTrial::make_references() {
  if (one_.bands > 0) return;
  const scene::Instrument fine = sampled(scene::SamplerKind::jittered, kReferenceSide, kReferenceSide);
  one_ = render(fine, one_sky_, simulation_.seed + kOther);
  two_ = render(fine, one_sky_, simulation_.seed + 2 * kOther);
}

TrialError PixelTrial::sampling_error(scene::SamplerKind sampler, int samples_u, int samples_v) {
  make_references();
  return error_against(render(sampled(sampler, samples_u, samples_v), one_sky_, simulation_.seed), one_, two_, mean_);
}

TrialError PixelTrial::sky_error(int directions, int samples_u, int samples_v) {
  if (plan_.components() == 0) return {};
  // Points that the seed moves would put the samples' noise into the difference.
  const scene::Instrument tried = sampled(scene::SamplerKind::grid, samples_u, samples_v);
  const plan::SkySets sky =
      sky_for(plan_, simulation_, directions, plan::sky_share(simulation_.sky_share, samples_u * samples_v, directions),
              kTrialSets);
  const TrialImage one = render(tried, sky, simulation_.seed), two = render(tried, sky, simulation_.seed + kOther);
  return error_between(one, two, mean_);
}

}  // namespace raycube::planner
