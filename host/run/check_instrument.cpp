#include "host/run/check_instrument.h"

#include <algorithm>
#include <tuple>

#include "host/plan/bounces.h"
#include "host/render/tile_passes.h"
#include "host/run/check_bounced.h"
#include "host/sensors/ray_groups.h"
#include "kernels/sampling/sampler.h"
#include "kernels/shared/tile_layout.h"

namespace raycube::run {

namespace {

/// Pixels that wait on the host before the reference takes them up together.
constexpr std::size_t kBatch = 256;
/// Rays that wait there for their first hits to be compared: 8 bytes each.
constexpr std::size_t kHitBatch = std::size_t{1} << 20;

constexpr rc_u32 kSmallObjectDimension = 49;  ///< of the hash: no sampler uses it

/// Device and reference in full, on the pixels of these tiles.
reference::Report compare_tiles(render::Renderer& renderer, const scene::Simulation& simulation,
                                const scene::Instrument& instrument, const plan::Plan& plan,
                                const atmos::RenderTable& table, const CheckOptions& options,
                                const std::vector<render::Tile>& tiles,
                                const std::function<void(std::uint64_t)>& progress) {
  reference::CompareOptions compare;
  compare.limits.model = simulation.tolerance;
  compare.threads = options.threads;
  compare.table = &table;
  compare.no_air = simulation.atmosphere.none;
  compare.model_pixels = options.model_pixels;
  compare.model_directions = options.model_directions;
  compare.beside_paths = plan.bounces.any();
  const plan::Plan once = plan::without_paths(plan);  // light between surfaces is check_bounced's matter
  reference::Comparison comparison(simulation.scene, once, instrument, simulation.seed, compare);
  const int width = sensors::pixels_per_group(instrument);
  std::vector<reference::DevicePixel> waiting;
  const auto flush = [&] {
    comparison.add(waiting);
    if (progress) progress(waiting.size());
    waiting.clear();
  };
  renderer.probe(compared_in_full(instrument), once, simulation.sun, simulation.seed, tiles,
                 [&](const render::PixelProbe& probe) {
                   const auto samples = static_cast<std::size_t>(probe.samples);
                   const std::size_t bands = plan.bands.size();
                   for (std::size_t p = 0; p < probe.tile.pixels(); ++p) {
                     reference::DevicePixel& pixel = waiting.emplace_back();
                     pixel.address = address_of(probe, p, width);
                     for (std::size_t s = p * samples; s < (p + 1) * samples; ++s)
                       pixel.hits.push_back({probe.hit_instance[s], probe.hit_primitive[s]});
                     const std::size_t sides = static_cast<std::size_t>(probe.sides) * samples,
                                       values = sides * static_cast<std::size_t>(RC_SKY_PLANES_OF(plan.met_sources()));
                     const auto of_pixel = [p](const auto& all, std::size_t count) {
                       const auto begin = all.begin() + static_cast<std::ptrdiff_t>(p * count);
                       return std::remove_cvref_t<decltype(all)>(begin, begin + static_cast<std::ptrdiff_t>(count));
                     };
                     pixel.sun_visible = of_pixel(probe.sun_visible, sides);
                     pixel.sky_met = of_pixel(probe.sky_met, values);
                     pixel.radiance = of_pixel(probe.radiance, bands);
                   }
                   if (waiting.size() >= kBatch) flush();
                 });
  flush();
  return comparison.report();
}

}  // namespace

reference::PixelAddress address_of(const render::HitProbe& probe, std::size_t p, int width) {
  const int line = static_cast<int>(p) / probe.tile.columns, column = static_cast<int>(p) % probe.tile.columns;
  reference::PixelAddress address;
  address.line = static_cast<std::uint32_t>(probe.tile.first_line + line);
  address.sample = static_cast<std::uint32_t>(probe.tile.first_column + column);
  address.group =
      probe.groups[shared::rc_group_of(static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(probe.tile.columns),
                                       static_cast<std::uint32_t>(width))];
  address.lane = column % width;
  address.group_width = width;
  return address;
}

scene::Instrument compared_in_full(const scene::Instrument& instrument) {
  scene::Instrument out = instrument;
  out.first_samples = 0;
  out.replicates = 1;                            // the others are traced alike
  out.small_objects = scene::SmallObjects::off;  // theirs are check_small_objects' matter
  return out;
}

reference::HitReport check_hits(render::Renderer& renderer, const scene::CompiledScene& scene,
                                const scene::Instrument& instrument, std::uint64_t seed, std::uint64_t rays,
                                int threads, const std::function<void(std::uint64_t)>& progress) {
  reference::HitComparison comparison(scene, instrument, seed, threads);
  const int width = sensors::pixels_per_group(instrument);
  const auto samples =
      static_cast<std::uint64_t>(instrument.samples_u) * static_cast<std::uint64_t>(instrument.samples_v);
  std::vector<reference::PixelHits> waiting;
  std::uint64_t waiting_rays = 0;
  const auto flush = [&] {
    comparison.add(waiting);
    if (progress) progress(waiting_rays);
    waiting.clear();
    waiting_rays = 0;
  };
  renderer.probe_hits(instrument, seed, render::pick_tiles(instrument, seed, (rays + samples - 1) / samples),
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
  return compare_tiles(renderer, simulation, instrument, plan, table, options,
                       render::pick_tiles(instrument, simulation.seed, options.pixels), progress);
}

std::vector<SmallObjectReport> check_small_objects(render::Renderer& renderer, const scene::Simulation& simulation,
                                                   const scene::Instrument& instrument, const plan::Plan& plan,
                                                   const atmos::RenderTable& table,
                                                   const sensors::SmallObjectSurvey& survey,
                                                   const CheckOptions& options) {
  std::vector<SmallObjectReport> reports;
  if (!survey.on) return reports;
  const int width = sensors::pixels_per_group(instrument), tile_width = std::max(width, RC_GROUP_WIDTH);
  for (const auto& [samples, pixels] : survey.levels) {
    std::vector<std::pair<rc_u32, render::Tile>> picked;  // hash, tile
    for (const auto& group : survey.groups) {
      if (group.samples != samples) continue;
      const int column =
          group.sample / tile_width * tile_width;  // a tile starts at a multiple of 4 pixels, whatever the groups
      const auto number = sensors::pixel_number(instrument, group.line, column);
      picked.push_back({rc_hash(static_cast<rc_u32>(simulation.seed), number, 0, kSmallObjectDimension),
                        {group.line, 1, column, std::min(tile_width, instrument.pixels - column)}});
    }
    const auto before = [](const auto& a, const auto& b) {
      return std::tie(a.first, a.second.first_line, a.second.first_column) <
             std::tie(b.first, b.second.first_line, b.second.first_column);
    };
    const auto same = [](const auto& a, const auto& b) {
      return a.second.first_line == b.second.first_line && a.second.first_column == b.second.first_column;
    };
    std::sort(picked.begin(), picked.end(), before);
    picked.erase(std::unique(picked.begin(), picked.end(), same), picked.end());
    const std::uint64_t rays = static_cast<std::uint64_t>(samples) * static_cast<std::uint64_t>(tile_width);
    std::vector<render::Tile> tiles;
    for (std::size_t i = 0;
         i < std::min<std::size_t>(picked.size(), std::max<std::uint64_t>(1, kSmallObjectRays / rays)); ++i)
      tiles.push_back(picked[i].second);
    const scene::Instrument fine = sensors::with_fine_samples(instrument, samples);
    CheckOptions arithmetic = options;
    arithmetic.model_pixels = 0;  // the model does not depend on how many samples there are
    reports.push_back({samples, pixels, compare_tiles(renderer, simulation, fine, plan, table, arithmetic, tiles, {})});
  }
  return reports;
}

CameraCheck check_camera(render::Renderer& renderer, const scene::Simulation& simulation, const CameraJob& job,
                         const CheckOptions& options, std::uint64_t rays, const Services& services) {
  const scene::Instrument& instrument = *job.instrument;
  const auto samples =
      static_cast<std::uint64_t>(instrument.samples_u) * static_cast<std::uint64_t>(instrument.samples_v);
  const auto expected = [&](std::uint64_t pixels) {
    return render::pixels_of(render::pick_tiles(instrument, simulation.seed, pixels));
  };
  CameraCheck check;
  reference::HitReport hits;
  if (rays > 0) {
    const Step step(services, "hits of " + instrument.name, samples * expected((rays + samples - 1) / samples), "rays");
    hits = check_hits(renderer, simulation.scene, instrument, simulation.seed, rays, options.threads,
                      [&](std::uint64_t more) { step.advance(more); });
  }
  {
    const Step step(services, "check " + instrument.name, expected(options.pixels), "pixels");
    check.report = check_instrument(renderer, simulation, instrument, job.plan, job.table, options,
                                    [&](std::uint64_t more) { step.advance(more); });
  }
  check.report.first_hits = std::move(hits);
  if (job.plan.bounces.levels > 0) {
    const Step step(services, "light between surfaces of " + instrument.name,
                    expected(std::min(options.pixels, kBouncedPixels)), "pixels");
    check.report.bounced = check_bounced(renderer, simulation, instrument, job.plan, options,
                                         [&](std::uint64_t more) { step.advance(more); });
  }
  if (job.plan.bounces.levels > 0 && !job.plan.matter.plates) {
    const Step step(services, "paths of " + instrument.name, expected(std::min(options.pixels, kReplayedPixels)),
                    "pixels");
    check.report.replayed = replay_paths(renderer, simulation, instrument, job.plan, options,
                                         [&](std::uint64_t more) { step.advance(more); });
  }
  check.small = check_small_objects(renderer, simulation, instrument, job.plan, job.table, job.decision.small, options);
  return check;
}

}  // namespace raycube::run
