// What a user waits for before the first tile: programs built and every kernel of the park launched once, in a process
// of its own, with PoCL's cache empty and again with what that left.
#include <stdlib.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "bench/device.h"
#include "bench/park_job.h"
#include "bench/timing.h"
#include "host/base/error.h"
#include "host/render/trace_stages.h"
#include "host/sensors/psf.h"
#include "host/sensors/ray_groups.h"

namespace raycube::bench {
namespace {

KernelBuild in_own_process(const Settings& settings, const std::string& cache) {
  const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
  const std::string command = "POCL_CACHE_DIR=" + shell_quoted(cache) + " " + shell_quoted(self) +
                              " --kernel-build --threads " + std::to_string(settings.threads) + " --scene " +
                              shell_quoted(settings.park_file);
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  KernelBuild build;
  char all[65] = "", trace[65] = "";
  if (!pipe || std::fscanf(pipe.get(), "%lf %64s %64s", &build.seconds, all, trace) != 3)
    throw base::Error(base::Fault::environment,
                      "bench: the process that builds the kernels gave no figure: " + command);
  build.programs = {all, trace};
  return build;
}

}  // namespace

KernelBuild kernel_build(const Settings& settings) {
  const scene::Simulation park = load_park(settings);
  const scene::Instrument& instrument = park.instruments.at(0);
  const run::CameraJob job = prepare_job(park, instrument);
  const auto shape = render::make_stage_shape(instrument, job.plan, sensors::pixels_per_group(instrument));
  const cl::Context context(pick_device(settings.threads));
  const render::SceneBuffers buffers(context, park.scene);
  const int lines = std::min(4, instrument.lines);
  const auto groups = sensors::make_ray_groups(instrument, park.scene, 0, lines);
  const auto pixels = static_cast<std::uint32_t>(instrument.pixels * lines);
  render::TraceBuffers traced(context, shape, pixels, groups.size());
  traced.groups.write(groups);
  render::RowBuffers rows(context, shape, pixels, 16);
  if (shape.environment) {  // none of the ground around: its rows are not baked here
    rows.environment_row.write(std::vector<std::uint32_t>(rows.environment_row.size(), 0));
    rows.environment_weight.write(std::vector<float>(rows.environment_weight.size(), 0.0f));
  }
  render::BandTable table(context, park.scene, job.plan, shape, 256 << 20);
  std::vector<std::uint64_t> keys;
  for (std::size_t m = 1; m <= park.scene.materials.size(); ++m) keys.push_back(m);
  table.ensure(keys);
  cl::Buffer<float> radiance(context, static_cast<std::size_t>(pixels) * static_cast<std::size_t>(shape.bands_padded),
                             cl::Access::read_write, "radiance");

  std::unique_ptr<render::RowStages> row_stages;
  std::unique_ptr<render::TraceStages> trace_stages;
  const double build_s = seconds_of([&] {
    row_stages =
        std::make_unique<render::RowStages>(context, buffers, job.plan, shape, sensors::SampleWeights(instrument));
    trace_stages = std::make_unique<render::TraceStages>(context, park.scene, buffers, job.plan, shape, park.seed);
  });
  const render::TileLayout layout{static_cast<std::uint32_t>(instrument.pixels), static_cast<std::uint32_t>(lines),
                                  static_cast<std::uint32_t>(shape.pixels_per_group)};
  const auto launch_all = [&] {
    std::map<std::string, double> stage_s;
    trace_stages->run(layout, 0, traced, stage_s);
    row_stages->shade({pixels, nullptr}, layout, traced, 0, sensors::kAllSamples, true, rows);
    row_stages->resolve(0, pixels, {pixels, nullptr}, layout, traced, table, rows);
    row_stages->integrate(0, pixels, {pixels, nullptr}, table, rows, radiance);
    context.finish();
  };
  // Each kernel is compiled for its launch size at the first launch; the work itself is what later launches take.
  const double first_s = seconds_of(launch_all);
  const double again_s = std::min({seconds_of(launch_all), seconds_of(launch_all), seconds_of(launch_all)});
  return {build_s + std::max(0.0, first_s - again_s),
          {render::program_hash(*trace_stages, *row_stages), trace_stages->program_hash()}};
}

void run_kernel_build(const Settings& settings, Report& report) {
  std::vector<double> cold, cached;
  for (int i = 0; i < 3; ++i) {
    std::string cache = (std::filesystem::temp_directory_path() / "raycube_bench_XXXXXX").string();
    if (!mkdtemp(cache.data()))
      throw base::Error(base::Fault::environment, "bench: no temporary folder can be made at " + cache);
    for (auto* seconds : {&cold, &cached}) {
      const KernelBuild build = in_own_process(settings, cache);
      seconds->push_back(build.seconds);
      report.add_programs("group build", build.programs);
    }
    std::filesystem::remove_all(cache);
  }
  report.add("kernel_build_cold_s", spread_of(cold), "s", Goal::at_most(3));
  report.add("kernel_build_cached_s", spread_of(cached), "s", Goal::at_most(0.1));
}

}  // namespace raycube::bench
