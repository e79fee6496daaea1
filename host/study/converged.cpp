#include "host/study/converged.h"

#include <algorithm>
#include <mutex>
#include <optional>

#include "host/base/interrupt.h"
#include "host/base/parallel.h"
#include "host/reference/bounced_light.h"
#include "host/reference/radiance.h"
#include "host/sensors/ray_groups.h"
#include "kernels/sampling/sampler.h"

namespace raycube::study {

namespace {

constexpr rc_u32 kSeedDimension = 47;  ///< of the hash: no sampler uses it
constexpr int kHalves = 2;

std::vector<reference::PixelAddress> addresses(const scene::Instrument& instrument, const scene::CompiledScene& scene,
                                               const std::vector<render::Tile>& tiles) {
  const int width = sensors::pixels_per_group(instrument), per_line = sensors::groups_per_line(instrument);
  std::vector<reference::PixelAddress> out;
  for (const render::Tile& tile : tiles) {
    const auto groups = sensors::make_ray_groups(instrument, scene, tile.first_line, tile.lines);
    for (int line = 0; line < tile.lines; ++line)
      reference::append_addresses(out, tile.first_line + line, tile.first_column, tile.columns,
                                  groups.data() + line * per_line, width);
  }
  return out;
}

/// Adds the mean of a half's paths.
void add_between(const reference::BouncedLight& light, const reference::SampledPixel& pixel, std::uint64_t seed,
                 int paths, std::vector<double>& radiance) {
  for (int path = 0; path < paths; ++path) {
    const std::vector<double> one = light.by_path(pixel, seed, static_cast<std::uint32_t>(path));
    for (std::size_t b = 0; b < radiance.size(); ++b) radiance[b] += one[b] / paths;
  }
}

}  // namespace

Converged converge(const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::Plan& plan,
                   const atmos::RenderTable& table, const std::vector<render::Tile>& tiles,
                   const ConvergedSettings& settings, const std::function<void(std::uint64_t)>& progress) {
  scene::Instrument fine = instrument;
  fine.sampler = scene::SamplerKind::jittered;
  fine.samples_u = fine.samples_v = settings.grid, fine.replicates = 1;
  const reference::ReferenceScene scene(simulation.scene);
  // The second half's sky is turned by half the spiral's step, so that what the spiral itself is off shows between
  // them.
  std::vector<reference::TableModel> models;
  for (int half = 0; half < kHalves; ++half)
    models.emplace_back(scene, plan, table, simulation.atmosphere.none, settings.directions,
                        reference::SkyShare{settings.per_sample, half * reference::SkyShare::kHalfStep_rad},
                        settings.levels > 0);

  std::optional<reference::BouncedLight> between;
  if (settings.levels > 0) between.emplace(scene, plan, settings.levels);
  const std::vector<reference::PixelAddress> pixels = addresses(instrument, simulation.scene, tiles);
  Converged out;
  out.bands = plan.bands.size();
  out.radiance.resize(pixels.size() * out.bands);
  out.half.resize(out.radiance.size());
  std::mutex mutex;
  base::for_each_index(pixels.size(), settings.threads, [&](std::size_t p) {
    base::throw_if_interrupted();
    std::vector<double> found[kHalves];
    for (rc_u32 half = 0; half < kHalves; ++half) {
      const std::uint64_t seed = rc_hash(static_cast<rc_u32>(simulation.seed), half,
                                         static_cast<rc_u32>(simulation.seed >> 32), kSeedDimension);
      const reference::SampledPixel pixel = scene.sample_pixel(fine, plan, seed, pixels[p]);
      const reference::BandRadiance once = models[half].radiance(pixel);
      for (std::size_t b = 0; b < out.bands; ++b) found[half].push_back(once.total(b));
      if (between) add_between(*between, pixel, seed, settings.paths, found[half]);
    }
    for (std::size_t b = 0; b < out.bands; ++b) {
      const double first = found[0][b], second = found[1][b];
      out.radiance[p * out.bands + b] = (first + second) / 2;
      out.half[p * out.bands + b] = (first - second) / 2;
    }
    if (!progress) return;
    const std::lock_guard lock(mutex);
    progress(1);
  });
  return out;
}

}  // namespace raycube::study
