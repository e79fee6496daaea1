#include "host/run/check_bounced.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "host/base/parallel.h"
#include "host/plan/bounces.h"
#include "host/reference/bounced_light.h"
#include "host/reference/path_replay.h"
#include "host/sensors/ray_groups.h"

namespace raycube::run {

namespace {

std::vector<reference::PixelAddress> addresses_of(render::Renderer& renderer, const scene::Instrument& instrument,
                                                  std::uint64_t seed, const std::vector<render::Tile>& tiles) {
  std::vector<reference::PixelAddress> out;
  const int width = sensors::pixels_per_group(instrument);
  renderer.probe_hits(instrument, seed, tiles, [&](const render::HitProbe& probe) {
    for (std::size_t p = 0; p < probe.tile.pixels(); ++p) out.push_back(address_of(probe, p, width));
  });
  return out;
}

/// What paths add to the pixels, [draw][pixel * bands + band]: the same samples with and without, and the same rays
/// into the sky.
std::vector<std::vector<float>> added_by_paths(render::Renderer& renderer, const scene::Simulation& simulation,
                                               const scene::Instrument& instrument, const plan::Plan& plan,
                                               const std::vector<render::Tile>& tiles) {
  std::vector<render::PixelDraw> draws;
  for (std::uint32_t draw = 0; draw < kBouncedDraws; ++draw) draws.push_back({simulation.seed, draw});
  const plan::Plan once = plan::without_paths(plan);
  auto out = renderer.draws_of(instrument, plan, simulation.sun, draws, tiles);
  const auto without = renderer.draws_of(instrument, once, simulation.sun, draws, tiles);
  for (std::size_t d = 0; d < out.size(); ++d)
    for (std::size_t i = 0; i < out[d].size(); ++i) out[d][i] -= without[d][i];
  return out;
}

/// Adds the device's means, and the variance of each by what its draws scatter in every pixel.
void add_device(reference::BouncedReport& report, const std::vector<std::vector<float>>& draws) {
  const std::size_t bands = report.bands.size();
  const double count = static_cast<double>(draws.size()), pixels = static_cast<double>(report.pixels);
  for (std::size_t b = 0; b < bands; ++b) {
    auto& band = report.bands[b];
    for (std::size_t p = 0; p < report.pixels; ++p) {
      double sum = 0, square = 0;
      for (const std::vector<float>& draw : draws) {
        const double l = static_cast<double>(draw[p * bands + b]);
        sum += l, square += l * l;
      }
      band.device += sum / count / pixels;
      band.error += std::max(0.0, square - sum * sum / count) / (count - 1) / count / (pixels * pixels);
    }
  }
}

struct PixelLight {
  std::vector<double> mean, size, variance;  ///< [band]: of paths; without regard to their sign; of the mean
};

PixelLight light_of(const reference::BouncedLight& light, const reference::SampledPixel& pixel, std::uint64_t seed,
                    std::size_t bands) {
  PixelLight out{std::vector<double>(bands), std::vector<double>(bands), std::vector<double>(bands)};
  for (std::uint32_t path = 0; path < kBouncedPaths; ++path) {
    const std::vector<double> l = light.by_path(pixel, seed, path);
    for (std::size_t b = 0; b < bands; ++b)
      out.mean[b] += l[b], out.size[b] += std::abs(l[b]) / kBouncedPaths, out.variance[b] += l[b] * l[b];
  }
  for (std::size_t b = 0; b < bands; ++b) {
    out.mean[b] /= kBouncedPaths;
    out.variance[b] = std::max(0.0, out.variance[b] / kBouncedPaths - out.mean[b] * out.mean[b]) / (kBouncedPaths - 1);
  }
  return out;
}

void add_reference(reference::BouncedReport& report, const std::vector<PixelLight>& found) {
  const double pixels = static_cast<double>(found.size());
  for (std::size_t b = 0; b < report.bands.size(); ++b) {
    auto& band = report.bands[b];
    for (const PixelLight& pixel : found)
      band.reference += pixel.mean[b] / pixels, band.size += pixel.size[b] / pixels,
          band.error += pixel.variance[b] / (pixels * pixels);
    band.error = std::sqrt(band.error);
  }
}

}  // namespace

reference::BouncedReport check_bounced(render::Renderer& renderer, const scene::Simulation& simulation,
                                       const scene::Instrument& instrument, const plan::Plan& plan,
                                       const CheckOptions& options,
                                       const std::function<void(std::uint64_t)>& progress) {
  reference::BouncedReport report;
  if (plan.bounces.levels == 0) return report;
  const std::size_t bands = plan.bands.size();
  const std::vector<render::Tile> tiles =
      render::pick_tiles(instrument, simulation.seed, std::min(options.pixels, kBouncedPixels));
  const scene::Instrument in_full = compared_in_full(instrument);
  const std::vector<reference::PixelAddress> addresses = addresses_of(renderer, in_full, simulation.seed, tiles);
  report.bands.resize(bands);
  report.pixels = addresses.size(), report.paths = addresses.size() * kBouncedPaths;
  if (plan.bounces.strength > 0) report.skeleton_error = plan.bounces.error / plan.bounces.strength;
  add_device(report, added_by_paths(renderer, simulation, in_full, plan, tiles));
  const reference::ReferenceScene scene(simulation.scene);
  const reference::BouncedLight light(scene, plan, plan.bounces.levels);
  std::vector<PixelLight> found(addresses.size());
  constexpr std::size_t kTogether = 16;
  for (std::size_t first = 0; first < found.size(); first += kTogether) {
    const std::size_t count = std::min(kTogether, found.size() - first);
    base::for_each_index(count, options.threads, [&](std::size_t i) {
      const auto pixel = scene.sample_pixel(in_full, plan, simulation.seed, addresses[first + i]);
      found[first + i] = light_of(light, pixel, simulation.seed, bands);
    });
    if (progress) progress(count);
  }
  add_reference(report, found);
  return report;
}

reference::ReplayReport replay_paths(render::Renderer& renderer, const scene::Simulation& simulation,
                                     const scene::Instrument& instrument, const plan::Plan& plan,
                                     const CheckOptions& options, const std::function<void(std::uint64_t)>& progress) {
  reference::ReplayReport report;
  if (plan.bounces.levels == 0 || plan.matter.plates) return report;
  const scene::Instrument in_full = compared_in_full(instrument);
  plan::Plan logged = plan;
  logged.bounces.logged = true;
  const std::uint64_t steps_of_pixel = static_cast<std::uint64_t>(plan.paths()) * (plan.bounces.levels + 1);
  const std::uint64_t pixels = std::clamp<std::uint64_t>(kMostSteps / steps_of_pixel, 1,
                                                         std::clamp<std::uint64_t>(options.pixels, 1, kReplayedPixels));
  const auto tiles = render::pick_tiles(in_full, simulation.seed, pixels);
  // Handing over steps takes another program: it must be the same to the bit.
  std::vector<std::vector<float>> rendered;
  renderer.probe(in_full, plan, simulation.sun, simulation.seed, tiles,
                 [&](const render::PixelProbe& probe) { rendered.push_back(probe.radiance); });
  std::size_t tile = 0;
  const reference::ReferenceScene scene(simulation.scene);
  const reference::PathReplay replay(scene, logged, in_full, simulation.seed);
  const int width = sensors::pixels_per_group(in_full);
  renderer.probe(in_full, logged, simulation.sun, simulation.seed, tiles, [&](const render::PixelProbe& probe) {
    const std::size_t count = probe.tile.pixels(), samples = static_cast<std::size_t>(probe.samples),
                      steps = probe.steps.size() / count, lines = probe.glow.size() / count;
    std::vector<reference::ReplayReport> found(count);
    base::for_each_index(count, options.threads, [&](std::size_t p) {
      std::vector<reference::Hit> hits;
      for (std::size_t s = p * samples; s < (p + 1) * samples; ++s)
        hits.push_back({probe.hit_instance[s], probe.hit_primitive[s]});
      found[p] = replay.replay(address_of(probe, p, width), hits, std::span(probe.steps).subspan(p * steps, steps),
                               std::span(probe.glow).subspan(p * lines, lines));
    });
    for (const auto& pixel : found) report.add(pixel);
    report.other_bits += probe.radiance != rendered.at(tile++);
    if (progress) progress(count);
  });
  return report;
}

}  // namespace raycube::run
