#include "host/study/device_timing.h"

#include <algorithm>

namespace raycube::study {

std::vector<float> device_radiance(render::Renderer& renderer, const scene::Instrument& instrument,
                                   const plan::Plan& plan, const scene::Sun& sun, std::uint64_t seed,
                                   const std::vector<render::Tile>& tiles) {
  std::vector<float> out;
  renderer.probe(instrument, plan, sun, seed, tiles, [&](const render::PixelProbe& probe) {
    out.insert(out.end(), probe.radiance.begin(), probe.radiance.end());
  });
  return out;
}

Timing time_image(render::Renderer& renderer, const scene::Instrument& instrument, const plan::Plan& plan,
                  const scene::Sun& sun, std::uint64_t seed, const std::vector<render::Tile>& tiles, int repeats) {
  Timing out;
  out.pixels = render::pixels_of(tiles);
  const double image = static_cast<double>(instrument.pixels) * instrument.lines,
               scale = image / static_cast<double>(out.pixels);
  std::vector<std::pair<double, std::map<std::string, double>>> runs;
  for (int repeat = 0; repeat <= repeats; ++repeat) {
    const render::RenderStatistics statistics = renderer.probe(instrument, plan, sun, seed, tiles, {});
    if (repeat == 0) {
      out.rays_per_pixel = static_cast<double>(statistics.primary_rays + statistics.sun_rays + statistics.sky_rays) /
                           static_cast<double>(out.pixels);
      out.terms_per_pixel = statistics.terms_p50;
      continue;
    }
    double seconds = 0;
    for (const auto& [stage, s] : statistics.stage_s) seconds += stage == "bake" ? s : s * scale;
    runs.emplace_back(seconds, statistics.stage_s);
  }
  std::sort(runs.begin(), runs.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  out.median_s = runs[runs.size() / 2].first;
  if (runs.size() % 2 == 0) out.median_s = (out.median_s + runs[runs.size() / 2 - 1].first) / 2;
  out.low_s = runs.front().first, out.high_s = runs.back().first;
  out.stage_s = runs[runs.size() / 2].second;
  return out;
}

}  // namespace raycube::study
