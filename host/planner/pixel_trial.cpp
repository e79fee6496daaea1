#include "host/planner/pixel_trial.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "host/planner/judged_pixels.h"
#include "host/planner/sample_pattern.h"

namespace raycube::planner {

namespace {

/// Cells of a reference's grid along a side, each with a random point: 1024 points, whose own error is a third of that
/// of 11 x 11 grid points and drops out of the estimate but for its noise.
constexpr int kReferenceSide = 32;
constexpr int kWidestTile = 512;  ///< pixels traced at once
/// Sky directions of a pixel while samples are held against references: their noise drops out but for its own.
constexpr int kTriedDirections = 32, kReferenceDirections = 128;
/// Added to the seed for draws that must not repeat the render's.
constexpr std::uint64_t kOther = 0x5bd1e995u;
constexpr double kReplicates = 4;
/// A trial's replicates take this part of the whole image's time, or this many nominal seconds where that is less.
constexpr double kPartOfRender = 0.07, kLeastTrial_s = 0.15;
/// The look takes this part of a usual render (so many samples and directions), all of a small image's pixels, and of
/// others no fewer runs than these.
constexpr double kPartOfLook = 0.03;
constexpr int kUsualSamples = 89, kUsualDirections = 40, kFewestLooks = 192;
constexpr int kFewestDraws = 64;
/// Of paths for two rays: the second look's, those that are chosen from, and the gain that is worth another look.
constexpr int kMorePaths = 4;
constexpr int kPathsPerTwo[] = {1, 2, 4, kMostPathsPerTwo};
constexpr double kWorthSharing = 0.9;
/// The law of paths' errors does not know how evenly so many fall: more of them that it finds at most so much slower
/// for an error are rendered too.
constexpr double kNearlyAsFast = 1.25;
constexpr int kReferences = 4;  ///< renders of each reference that a draw is held against, where that is quick

}  // namespace

PixelTrial::PixelTrial(render::Renderer& renderer, const scene::Simulation& simulation,
                       const scene::Instrument& instrument, const plan::Plan& plan, int look_directions,
                       TrialProgress progress)
    : renderer_(renderer),
      simulation_(simulation),
      instrument_(instrument),
      plan_(plan),
      progress_(std::move(progress)) {
  instrument_.first_samples = 0;                         // errors of all samples
  instrument_.small_objects = scene::SmallObjects::off;  // and of the law that holds for most pixels
  make_look(look_directions);
}

scene::Instrument PixelTrial::sampled(scene::SamplerKind sampler, int samples_u, int samples_v) const {
  scene::Instrument out = instrument_;
  out.sampler = sampler, out.samples_u = samples_u, out.samples_v = samples_v;
  return out;
}

scene::Instrument PixelTrial::sampled(int samples) const {
  scene::Instrument out = instrument_;
  give_samples(out, samples);
  return out;
}

double PixelTrial::pixel_cost_s(const scene::Instrument& sampled, int directions) {
  return CostModel().seconds(
      pixel_counts(plan_, static_cast<double>(sampled.samples_u) * sampled.samples_v, directions));
}

void PixelTrial::make_look(int directions) {
  const double all = static_cast<double>(instrument_.pixels) * instrument_.lines;
  const scene::Instrument look = sampled(sample_pattern(instrument_).look);
  const double part = kPartOfLook * pixel_cost_s(sampled(kUsualSamples), kUsualDirections) /
                      (kReplicates * pixel_cost_s(look, directions));
  // Of other figures than the rms the rarest errors count: as many pixels as a look may have.
  const bool rms = simulation_.tolerance_of.figure == scene::ErrorFigure::rms;
  const int runs = all <= kLookRuns * kRunPixels || !rms
                       ? kLookRuns
                       : std::clamp(static_cast<int>(part * all / kRunPixels), kFewestLooks, kLookRuns);
  looked_ = trial_tiles(instrument_, simulation_.seed, runs);
  for (const auto& tile : looked_) looked_at_ += tile.pixels();
  drawn_from_ = static_cast<double>(looked_.size());
  left_out_ = 1 - static_cast<double>(looked_at_) / all;
  whole_ = left_out_ <= 0;
  pixels_per_run_ = static_cast<double>(looked_at_) / drawn_from_;
  tiles_ = looked_, pixels_ = looked_at_;
  look_directions_ = directions;
  weigh_look();
  look_ = with_cells(sample_pattern(instrument_).look, replicates_on_pixels(look, directions));
}

void PixelTrial::weigh_look() {
  look_weight_ = pixel_weights(renderer_, simulation_, instrument_, plan_, looked_);
  meets_listed_ = look_weight_.empty() ||
                  std::any_of(look_weight_.begin(), look_weight_.end(), [](float weight) { return weight > 0; });
  if (!meets_listed_) look_weight_.clear();
}

/// Of the pixels that are tried now, out of those of the look.
std::vector<float> PixelTrial::weights_of_tiles() const {
  if (look_weight_.empty() || draws_.empty()) return look_weight_;
  std::vector<std::size_t> first = {0};
  for (const auto& tile : looked_) first.push_back(first.back() + tile.pixels());
  std::vector<float> out;
  for (const Draw& draw : draws_)
    for (std::size_t p = first[draw.run]; p < first[draw.run + 1]; ++p) out.push_back(look_weight_[p]);
  return out;
}

int PixelTrial::choose_paths() {
  if (!plan_.bounces.any() || plan_.components() == 0) return 1;
  const int rays = look_directions_;
  const std::uint64_t seed = simulation_.seed + 3 * kOther;
  const scene::Instrument look = sampled(sample_pattern(instrument_).look);
  const auto pair_error = [&](int per_two) {  // of the look's first samples, under the same two draws
    plan_.sky.paths_per_two = per_two;
    const auto images = render(look, rays, {{seed, 0}, {seed, 2}});
    return error_between(images[0], images[1], mean_);
  };
  const TrialError &fewer = look_pair_, more = pair_error(kMorePaths);

  // Variances of one ray and of one path, band by band: e^2 = sky / rays + path / paths.
  const auto paths = [&](int per_two) { return static_cast<double>(plan::paths_beside(rays, per_two)); };
  const std::size_t bands = fewer.bands.estimate.size();
  std::vector<double> sky(bands), path(bands);
  for (std::size_t b = 0; b < bands; ++b) {
    const double e2 = fewer.bands.estimate[b] * fewer.bands.estimate[b],
                 less = e2 - more.bands.estimate[b] * more.bands.estimate[b];
    path[b] = std::clamp(less / (1 / paths(1) - 1 / paths(kMorePaths)), 0.0, e2 * paths(1));
    sky[b] = (e2 - path[b] / paths(1)) * rays;
  }
  const auto square = [&](std::size_t b, int per_two) { return sky[b] / rays + path[b] / paths(per_two); };
  const auto time_of = [&](double square_error, int per_two) {  // which grows as its square error is to fall
    const auto cost_s = [&](int directions) {
      return CostModel().seconds(pixel_counts(plan_, 0, directions, per_two));
    };
    return square_error * (cost_s(2 * kTriedDirections) - cost_s(kTriedDirections));
  };
  const auto time_by_law = [&](int per_two) {  // of the worst band
    double worst = 0;
    for (std::size_t b = 0; b < bands; ++b) worst = std::max(worst, square(b, per_two));
    return time_of(worst, per_two);
  };
  int best = kPathsPerTwo[0];
  for (const int per_two : kPathsPerTwo)
    if (time_by_law(per_two) < (best == kPathsPerTwo[0] ? kWorthSharing : 1) * time_by_law(best)) best = per_two;
  if (best == 1) {
    plan_.sky.paths_per_two = 1;
    return 1;
  }
  // What was found of a setting counts as measured: what was not rendered is rendered now.
  const int least = best;
  double least_time = std::numeric_limits<double>::infinity();
  for (const int per_two : kPathsPerTwo) {
    if (per_two < least || time_by_law(per_two) > kNearlyAsFast * time_by_law(least)) continue;
    const TrialError found = per_two == kMorePaths ? more : pair_error(per_two);
    const auto& estimate = found.bands.estimate;
    const double time = time_of(std::pow(*std::max_element(estimate.begin(), estimate.end()), 2), per_two);
    if (time < least_time) least_time = time, best = per_two, look_.sky = found;
  }
  plan_.sky.paths_per_two = best;
  return best;
}

/// By what the look saw of each run's error; all runs where the look has no more than `whole`.
void PixelTrial::draw_pixels(int draws, int whole) {
  draws_ = draw_runs(look_error_, simulation_.seed, draws, whole);
  whole_ = left_out_ <= 0 && draws_.size() == looked_.size();
  tiles_.clear(), pixels_ = 0;
  for (const Draw& draw : draws_) tiles_.push_back(looked_[draw.run]), pixels_ += tiles_.back().pixels();
}

std::vector<TrialImage> PixelTrial::render(const scene::Instrument& instrument, int directions,
                                           const std::vector<render::PixelDraw>& draws) {
  if (plan_.sends_rays()) plan_.sky.rays = directions;
  TrialImage image;
  image.bands = instrument.bands.size();
  image.draw = draws_, image.pixels_per_run = pixels_per_run_;
  image.drawn_from = drawn_from_, image.left_out = left_out_;
  image.whole = whole_;
  image.figure = simulation_.tolerance_of.figure, image.weight = weights_of_tiles();
  for (const auto& tile : tiles_)
    image.run_end.push_back((image.run_end.empty() ? 0 : image.run_end.back()) + tile.pixels());
  std::vector<TrialImage> out(draws.size(), image);
  const auto tiles = joined(tiles_, kWidestTile);
  std::function<void(std::uint64_t)> advance;
  if (progress_)
    advance = progress_(
        fmt::format("trial of {}, {}, {} sky rays", instrument.name,
                    sampler_text(instrument.sampler, instrument.samples_u, instrument.samples_v), plan_.sky.rays),
        tiles.size(), "pieces");
  std::uint64_t told = 0;
  auto radiance =
      renderer_.draws_of(instrument, plan_, simulation_.sun, draws, tiles, [&](std::uint64_t done, std::uint64_t all) {
        if (!advance || done == all) return;  // what is soon done needs no line
        advance(done - told);
        told = done;
      });
  for (std::size_t d = 0; d < draws.size(); ++d) out[d].radiance = std::move(radiance[d]);
  const PixelCounts counts =
      pixel_counts(plan_, static_cast<double>(instrument.samples_u) * instrument.samples_v, plan_.sky.rays);
  const double rendered = static_cast<double>(pixels_ * draws.size());
  rays_ += static_cast<std::uint64_t>(counts.rays() * rendered);
  cost_s_ += CostModel().seconds(counts) * rendered;
  return out;
}

SettingErrors PixelTrial::replicates_on_pixels(const scene::Instrument& sampled, int directions) {
  const std::uint64_t seed = simulation_.seed + 3 * kOther, other = simulation_.seed + 4 * kOther;
  const bool sky = plan_.sends_rays();
  const auto images = sky ? render(sampled, directions, {{seed, 0}, {other, 1}, {seed, 2}, {other, 3}})
                          : render(sampled, directions, {{seed, 0}, {other, 1}});
  if (mean_.empty()) mean_ = judged_means(images[0]);
  if (look_error_.empty()) {
    look_error_ = run_differences(images[0], images[1], mean_);
    if (sky) look_pair_ = error_between(images[0], images[2], mean_);
  }
  if (!sky) return {error_between(images[0], images[1], mean_), {0, 0, {{0}, {0}}}};
  return {common_spread(images[0], images[2], images[1], images[3], mean_),
          error_between_pairs(images[0], images[2], images[1], images[3], mean_)};
}

SettingErrors PixelTrial::replicates(scene::SamplerKind sampler, int samples_u, int samples_v, int directions) {
  return replicates(sampled(sampler, samples_u, samples_v), directions);
}

SettingErrors PixelTrial::replicates(int samples, int directions) {
  return with_cells(samples, replicates(sampled(samples), directions));
}

/// Random points in cells weigh a point spread by its cells' means: an error that all replicates have.
SettingErrors PixelTrial::with_cells(int samples, SettingErrors found) {
  if (instrument_.box_pixels()) return found;
  const scene::Instrument cells = sampled(samples);
  found.samples = sampling_error(cells.sampler, cells.samples_u, cells.samples_v);
  return found;
}

void PixelTrial::draw_for_replicates(const scene::Instrument& tried, int directions) {
  const double all = static_cast<double>(instrument_.pixels) * instrument_.lines;
  const double pixels = std::max(kPartOfRender * all, kLeastTrial_s / pixel_cost_s(tried, directions)) / kReplicates;
  const double draws = std::min(pixels / pixels_per_run_, static_cast<double>(looked_.size()));
  const int runs = std::max(kFewestDraws, static_cast<int>(draws));
  draw_pixels(runs, runs);
}

SettingErrors PixelTrial::replicates(const scene::Instrument& tried, int directions) {
  draw_for_replicates(tried, directions);
  return replicates_on_pixels(tried, directions);
}

TrialError PixelTrial::sky_error(int samples, int directions) {
  const scene::Instrument tried = sampled(samples);
  draw_for_replicates(tried, directions);
  const std::uint64_t seed = simulation_.seed + 3 * kOther;
  const auto images = render(tried, directions, {{seed, 0}, {seed, 2}});
  return error_between(images[0], images[1], mean_);
}

TrialError PixelTrial::own_draw(int samples, int directions) {
  const scene::Instrument drawn = sampled(samples);
  if (left_out_ > 0)
    draw_for_replicates(drawn, directions);
  else
    draw_pixels(static_cast<int>(looked_.size()), static_cast<int>(looked_.size()));
  // As many renders as are quick, of the programs that the image takes: other words of samples are other programs.
  const double all_s = static_cast<double>(pixels_) * pixel_cost_s(drawn, directions);
  const bool rms =
      simulation_.tolerance_of.figure == scene::ErrorFigure::rms;  // else references must be near the truth
  const int each = all_s < kLeastTrial_s || !rms ? kReferences : 1;
  std::vector<render::PixelDraw> draws = {{simulation_.seed, 0}};
  for (int k = 0; k < 2 * each; ++k)
    draws.push_back({simulation_.seed + static_cast<std::uint64_t>(3 + k) * kOther, 0});
  std::vector<TrialImage> images = render(drawn, directions, draws);
  const auto mean_of = [&](int first) {
    TrialImage mean = std::move(images[static_cast<std::size_t>(first)]);
    for (int k = 1; k < each; ++k) {
      const TrialImage& more = images[static_cast<std::size_t>(first + k)];
      for (std::size_t i = 0; i < mean.radiance.size(); ++i)
        mean.radiance[i] += (more.radiance[i] - mean.radiance[i]) / static_cast<float>(k + 1);
    }
    return mean;
  };
  const TrialImage one = mean_of(1), two = mean_of(1 + each);
  return error_against(images[0], one, two, mean_);
}

void PixelTrial::make_references() {
  draw_pixels(kDraws, kWholeRuns);
  if (one_.bands > 0) return;
  const scene::Instrument fine = sampled(scene::SamplerKind::jittered, kReferenceSide, kReferenceSide);
  auto images =
      render(fine, kReferenceDirections, {{simulation_.seed + kOther, 0}, {simulation_.seed + 2 * kOther, 0}});
  one_ = std::move(images[0]), two_ = std::move(images[1]);
}

TrialError PixelTrial::sampling_error(scene::SamplerKind sampler, int samples_u, int samples_v) {
  make_references();
  const scene::Instrument tried = sampled(sampler, samples_u, samples_v);
  const auto images = render(tried, kTriedDirections, {{simulation_.seed, 0}, {simulation_.seed, 1}});
  if (!plan_.sends_rays()) return error_against(images[0], one_, two_, mean_);
  return common_error(images[0], images[1], one_, two_, mean_);
}

TrialError PixelTrial::sky_error(int directions, int samples_u, int samples_v) {
  if (!plan_.sends_rays()) return {0, 0, {{0}, {0}}};
  draw_pixels(kDraws, kWholeRuns);
  const scene::Instrument tried = sampled(scene::SamplerKind::grid, samples_u, samples_v);
  const auto images = render(tried, directions, {{simulation_.seed, 0}, {simulation_.seed, 1}});
  return error_between(images[0], images[1], mean_);
}

}  // namespace raycube::planner
