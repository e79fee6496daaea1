#include "host/cli/check_instrument.h"

#include "host/sensors/ray_groups.h"

namespace raycube::cli {

namespace {

/// Pixels that wait on the host before the reference takes them up together.
constexpr std::size_t kBatch = 256;
/// Rays that wait there for their first hits to be compared: 8 bytes each.
constexpr std::size_t kHitBatch = std::size_t{1} << 20;

/// Where pixel p of a tile lies, and its group among the tile's.
reference::PixelAddress address_of(const render::HitProbe& probe, std::size_t p, int width) {
  const int groups_per_line = (probe.tile.columns + width - 1) / width;
  const int line = static_cast<int>(p) / probe.tile.columns, column = static_cast<int>(p) % probe.tile.columns;
  reference::PixelAddress address;
  address.line = static_cast<std::uint32_t>(probe.tile.first_line + line);
  address.sample = static_cast<std::uint32_t>(probe.tile.first_column + column);
  address.group = probe.groups[static_cast<std::size_t>(line * groups_per_line + column / width)];
  address.lane = column % width;
  address.group_width = width;
  return address;
}

}  // namespace

reference::HitReport check_hits(render::Renderer& renderer, const scene::CompiledScene& scene,
                                const scene::Instrument& instrument, std::uint64_t seed, std::uint64_t rays, int threads,
                                const std::function<void(std::uint64_t)>& progress) {
  reference::HitComparison comparison(scene, instrument, seed, threads);
  const int width = sensors::pixels_per_group(instrument);
  const auto samples = static_cast<std::uint64_t>(instrument.samples_u) * static_cast<std::uint64_t>(instrument.samples_v);
  std::vector<reference::PixelHits> waiting;
  std::uint64_t waiting_rays = 0;
  const auto flush = [&] {
    comparison.add(waiting);
    if (progress) progress(waiting_rays);
    waiting.clear();
    waiting_rays = 0;
  };
  renderer.probe_hits(instrument, seed, pick_tiles(instrument, seed, (rays + samples - 1) / samples),
                      [&](const render::HitProbe& probe) {
                        for (std::size_t p = 0; p < probe.tile.pixels(); ++p) {
                          reference::PixelHits& pixel = waiting.emplace_back();
                          pixel.address = address_of(probe, p, width);
                          for (std::size_t s = p * samples; s < (p + 1) * samples; ++s)
                            pixel.hits.push_back({probe.hit_instance[s], probe.hit_primitive[s]});
                        }
                        waiting_rays += probe.tile.pixels() * samples;
                        if (waiting_rays >= kHitBatch) flush();
                      });
  flush();
  return comparison.report();
}

reference::Report check_instrument(render::Renderer& renderer, const scene::Simulation& simulation,
                                   const scene::Instrument& instrument, const plan::Plan& plan,
                                   const atmos::RenderTable& table, const CheckOptions& options,
                                   const std::function<void(std::uint64_t)>& progress) {
  reference::CompareOptions compare;
  compare.limits.model = simulation.tolerance;
  compare.threads = options.threads;
  compare.table = &table;
  compare.no_air = simulation.atmosphere.none;
  compare.model_pixels = options.model_pixels;
  compare.model_directions = options.model_directions;
  reference::Comparison comparison(simulation.scene, plan, instrument, simulation.seed, compare);
  const int width = sensors::pixels_per_group(instrument);
  std::vector<reference::DevicePixel> waiting;
  const auto flush = [&] {
    comparison.add(waiting);
    if (progress) progress(waiting.size());
    waiting.clear();
  };
  scene::Instrument in_full = instrument;  // adaptive pixels keep no samples to compare
  in_full.first_samples = 0;
  renderer.probe(in_full, plan, simulation.sun, simulation.seed, pick_tiles(instrument, simulation.seed, options.pixels),
                 [&](const render::PixelProbe& probe) {
                   const auto samples = static_cast<std::size_t>(probe.samples);
                   const std::size_t bands = plan.bands.size();
                   for (std::size_t p = 0; p < probe.tile.pixels(); ++p) {
                     reference::DevicePixel& pixel = waiting.emplace_back();
                     pixel.address = address_of(probe, p, width);
                     for (std::size_t s = p * samples; s < (p + 1) * samples; ++s) {
                       pixel.hits.push_back({probe.hit_instance[s], probe.hit_primitive[s]});
                       pixel.sun_visible.push_back(probe.sun_visible[s]);
                       const std::size_t planes = 4 * static_cast<std::size_t>(plan.components() > 4 ? 2 : 1);
                       for (std::size_t m = 0; m < planes; ++m) pixel.sky_blocked.push_back(probe.sky_blocked[planes * s + m]);
                     }
                     pixel.radiance.assign(probe.radiance.begin() + static_cast<std::ptrdiff_t>(p * bands),
                                           probe.radiance.begin() + static_cast<std::ptrdiff_t>((p + 1) * bands));
                   }
                   if (waiting.size() >= kBatch) flush();
                 });
  flush();
  return comparison.report();
}

}  // namespace raycube::cli
