// The park rendered as `raycube render` does it: lengths of its real term lists and what integration makes of them.
#include <cstdlib>
#include <memory>

#include "bench/cases.h"
#include "bench/park_job.h"
#include "bench/timing.h"
#include "bench/write_bandwidth.h"
#include "host/render/renderer.h"

namespace raycube::bench {

void run_render(const Settings& settings, Report& report) {
  const scene::Simulation park = load_park(settings);
  const scene::Instrument& spectir = park.instruments.at(0);
  const cli::InstrumentJob job = prepare_job(park, spectir);
  render::RenderOptions options;
  options.threads = settings.threads;
  render::Renderer renderer(park.scene, options);
  const std::size_t roof_floats = (std::size_t{384} << 20) / sizeof(float);
  const auto release = [](float* p) { std::free(p); };
  const std::unique_ptr<float, decltype(release)> roof(static_cast<float*>(std::aligned_alloc(64, roof_floats * sizeof(float))), release);
  fill16(roof.get(), roof_floats, 1.0f, settings.threads);

  const auto fill = [&](float value) { return seconds_of([&] { fill16(roof.get(), roof_floats, value, settings.threads); }); };
  // One render of the whole park, the roof measured on both sides of it.
  Pairs pairs;
  pairs.reference_s = {fill(2.0f)};
  render::RenderStatistics statistics;
  const double render_s = seconds_of([&] {
    statistics = renderer.render(spectir, job.plan, park.sun, park.seed, [](const render::Strip&) {});
  });
  pairs.reference_s.push_back(fill(3.0f));
  pairs.ours_s.assign(2, statistics.stage_s.at("integrate"));
  const double padded = static_cast<double>((spectir.bands.size() + 15) / 16 * 16);
  const double scale = padded * spectir.pixels * spectir.lines / static_cast<double>(roof_floats);
  const Spread ratio = pairs.ratio();
  report.add("park_integrate_vs_write_bandwidth", Spread{ratio.median * scale, ratio.lowest * scale, ratio.highest * scale, ratio.count}, "x");
  report.add("park_terms_p50", statistics.terms_p50, "terms");
  report.add("park_terms_p95", statistics.terms_p95, "terms");
  report.add("park_render_s", render_s, "s");
  report.set_text("device", renderer.device_name());
  report.set_text("program_hash", statistics.program_hash);
}

}  // namespace raycube::bench
