#include "host/planner/open_share.h"

#include <algorithm>
#include <cmath>

#include "host/planner/pixel_trial.h"
#include "host/planner/replicated.h"
#include "host/planner/sample_pattern.h"
#include "host/planner/trial_pixels.h"
#include "host/reference/contact.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/shape_list.h"

namespace raycube::planner {

namespace {

constexpr std::uint64_t kOpenShare = 0x3c6ef372u;  ///< added to the seed: pixels and draws of its own
constexpr int kRuns = 32, kWidest = 512;           ///< of 8 pixels each; pixels traced at once
constexpr float kHalf = 0.5f;                      ///< taken for granted while it is measured
/// A surface that few rays left is thought of as all others are, with the weight of so many rays.
constexpr double kPrior = 16;
/// Shares are told in so many steps: what devices round differently does not move them.
constexpr double kSteps = 64;
constexpr double kMetSteps = 1024;  ///< of what meets surfaces: some of it decides whether light goes between them

double told(double share, double steps) { return std::round(std::max(share, 0.0) * steps) / steps; }

struct Seen {
  double open = 0, all = 0, rays = 0;  ///< light that rays met and could have met, and their number
};

/// What the rays of one pixel say of the directions from its surfaces: hidden sky, and what is below the horizon.
struct PixelSeen {
  double hidden = 0, all = 0;  ///< light
  double below = 0, rays = 0;  ///< share of a tilted surface's directions, summed; number
  bool any = false;            ///< it sees a surface, whose directions are all below the horizon where no ray left it

  double low() const { return rays > 0 ? below / rays : any ? 1 : 0; }
  double share() const { return all > 0 ? hidden / all : 0; }
  double met() const { return low() + (1 - low()) * share(); }
  /// Of met(), without what the chance of rays adds to it; of one ray nothing is known of that.
  double met_squared() const {
    const double h = share(), square = rays > 1 ? h * h - h * (1 - h) / (rays - 1) : h;
    return low() * low() + 2 * low() * (1 - low()) * h + (1 - low()) * (1 - low()) * square;
  }
};

/// Whether some used material's shape may send more than its curve.
bool reaches_far(const scene::CompiledScene& scene) {
  const auto used = scene::used_families(scene);
  return std::any_of(used.begin(), used.end(), [&](std::uint32_t material) {
    return !scene::shape_entry(scene.materials[material].front.number).conserves;
  });
}

/// radiance: [pixel][band]; a pixel counts by how bright it is, the darker ones as all do on average.
plan::SkyRays::Met met_of(const std::vector<PixelSeen>& pixels, const std::vector<double>& radiance) {
  const std::size_t bands = pixels.empty() ? 0 : radiance.size() / pixels.size();
  const auto count = static_cast<double>(pixels.size());
  std::vector<double> means(bands), by_band(bands);
  for (std::size_t i = 0; i < radiance.size(); ++i) means[i % bands] += radiance[i];
  means = judged_means(std::move(means), count);
  double sum = 0, squares = 0;
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    const double here = pixels[p].met_squared();
    sum += pixels[p].met(), squares += here;
    for (std::size_t b = 0; b < bands; ++b) {
      const double bright = means[b] > 0 ? std::max(1.0, radiance[p * bands + b] / means[b]) : 1;
      by_band[b] += here * bright * bright;
    }
  }
  if (bands == 0) return {};
  const double worst = *std::max_element(by_band.begin(), by_band.end());
  return {true, told(std::sqrt(std::max(0.0, worst / count)), kMetSteps), told(sum / count, kMetSteps),
          told(sum > 0 ? squares / sum : 0, kMetSteps)};
}

}  // namespace

scene::Instrument first_launched(const scene::Simulation& simulation, const scene::Instrument& instrument,
                                 const plan::Plan& plan) {
  scene::Instrument few = instrument;
  if (!few.samples_given)
    give_samples(few, may_replicate(simulation, few, plan)
                          ? first_size(few, plan, simulation.tolerance / few.share_of_draws).samples
                          : sample_pattern(few).look);
  few.first_samples = 0, few.small_objects = scene::SmallObjects::off, few.standard_error = scene::StandardError::off;
  return few;
}

void measure_open_share(render::Renderer& renderer, const scene::Simulation& simulation,
                        const scene::Instrument& instrument, plan::Plan& plan) {
  plan.sky.open_share.clear();
  if (plan.components() == 0) return;
  const auto& scene = simulation.scene;
  const scene::Instrument few = first_launched(simulation, instrument, plan);
  plan::Plan half = plan;
  half.sky.open_share.assign(scene.surfaces.size(), kHalf);
  half.bounces.levels = 0;
  // By lobes that reach far above and below Lambert's a ray's sign would not tell its fate.
  if (!plan.matter.glossy && reaches_far(scene)) {
    half.matter.shaped = half.matter.plates = false, half.matter.further = 0;
    half.thermal.albedo_at.clear(), half.thermal.albedo.clear();
  }
  half.sky.rays = std::min(plan.sky.rays, few.samples_u * few.samples_v);  // one ray a sample: its sign tells its fate
  std::vector<Seen> seen(scene.surfaces.size());
  std::vector<PixelSeen> pixels;
  std::vector<double> radiance;
  // Of the first component: without any sky it is the surroundings', whose light is -1.
  const double bright = plan.sky_components + plan.thermal.sky_components > 0 ? 1 : -1;
  renderer.probe_together(
      few, half, simulation.sun, simulation.seed + kOpenShare,
      joined(trial_tiles(few, simulation.seed + kOpenShare, kRuns), kWidest), [&](const render::PixelProbe& probe) {
        const auto samples = static_cast<std::size_t>(probe.samples);
        const std::size_t planes = probe.sky_met.size() / std::max<std::size_t>(1, probe.hit_instance.size()) /
                                   static_cast<std::size_t>(probe.sides);
        const std::size_t before = pixels.size(), sides = static_cast<std::size_t>(probe.sides);
        pixels.resize(before + probe.hit_instance.size() / samples);
        radiance.insert(radiance.end(), probe.radiance.begin(), probe.radiance.end());
        for (std::size_t i = 0; i < probe.hit_instance.size(); ++i)
          if (probe.hit_instance[i] != RC_NONE) pixels[before + i / samples].any = true;
        for (std::size_t i = 0; i < probe.sky_met.size() / planes; ++i) {
          const std::size_t p = i / samples / sides, s = i % samples;
          const double met = bright * static_cast<double>(probe.sky_met[planes * i]);
          if (met == 0) continue;
          const std::uint32_t primitive = probe.hit_primitive[p * samples + s];
          const reference::Hit hit{probe.hit_instance[p * samples + s], primitive};
          const double up = std::abs(reference::world_normal(scene, hit).z);  // views look down
          const std::size_t side = i / samples % sides;
          if (side > (plan.matter.through ? 1u : 0u)) continue;  // of gloss nothing is granted; lobes share rays
          const bool far_side = side > 0;
          PixelSeen& pixel = pixels[before + p];
          pixel.hidden += std::abs(met) - met, pixel.all += 2 * std::abs(met);
          pixel.below += 0.5 * (far_side ? 1 + up : 1 - up), pixel.rays += 1;
          Seen& at =
              seen[scene::family_surface(scene, scene.blocks[primitive / RC_BLOCK].surface[primitive % RC_BLOCK])];
          at.open += std::abs(met) + met, at.all += 2 * std::abs(met), at.rays += 1;
        }
      });
  Seen whole;
  for (const Seen& at : seen) whole.open += at.open, whole.all += at.all, whole.rays += at.rays;
  plan.sky.met = met_of(pixels, radiance);
  if (!(whole.all > 0)) return;
  const double mean = whole.open / whole.all, each = whole.all / whole.rays;
  for (std::uint32_t surface = 0; surface < seen.size(); ++surface) {
    const Seen& at = seen[scene::family_surface(scene, surface)];  // whose members lie side by side
    const double share = (at.open + kPrior * each * mean) / (at.all + kPrior * each);
    plan.sky.open_share.push_back(static_cast<float>(told(std::min(share, 1.0), kSteps)));
  }
}

}  // namespace raycube::planner
