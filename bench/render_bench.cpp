// The park rendered by `raycube render` itself: lengths of its real term lists, what integration makes of them, and
// whether the programs it launched are those the other groups time.
#include <stdlib.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "bench/cases.h"
#include "bench/park_job.h"
#include "bench/timing.h"
#include "bench/write_bandwidth.h"
#include "host/base/error.h"
#include "kernels/shared/tile_layout.h"

namespace raycube::bench {
namespace {

nlohmann::json read_run(const std::string& path) {
  std::ifstream file(path);
  nlohmann::json run = nlohmann::json::parse(file, nullptr, false);
  for (const char* key : {"program_hash", "trace_program_hash"})
    if (!run.is_object() || !run.contains(key) || !run[key].is_string())
      throw base::Error(base::Fault::input, "bench: " + path + " is no run.json of `raycube render` with " + key +
                                                "; render again with this version");
  return run;
}

Programs programs_in(const nlohmann::json& run) { return {run.at("program_hash"), run.at("trace_program_hash")}; }

/// A folder that goes when it does.
struct TemporaryFolder {
  TemporaryFolder() : path((std::filesystem::temp_directory_path() / "raycube_bench_XXXXXX").string()) {
    if (!mkdtemp(path.data()))
      throw base::Error(base::Fault::environment, "bench: no temporary folder can be made at " + path);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string path;
};

/// run.json of the park's first instrument, rendered by the program beside this one.
nlohmann::json render_park(const Settings& settings, const std::string& file, const std::string& instrument) {
  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "raycube";
  const TemporaryFolder temporary;
  const std::string& folder = temporary.path;
  const std::string command = shell_quoted(program.string()) + " render " + shell_quoted(file) + " --instrument " +
                              shell_quoted(instrument) + " --threads " + std::to_string(settings.threads) + " -q -o " +
                              shell_quoted(folder) + " > /dev/null";
  if (std::system(command.c_str()) != 0)
    throw base::Error(base::Fault::environment, "bench: the park was not rendered by: " + command);
  return read_run(folder + "/" + instrument + "/run.json");
}

/// The park's first instrument over the same ground with 512 x 512 pixels and so many sky directions, in `folder`.
std::string write_large_park(const Settings& settings, const std::string& folder, const std::string& sky_directions) {
  const std::filesystem::path park(settings.park_file);
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::absolute(park).parent_path()))
    if (entry.path().filename() != park.filename())
      std::filesystem::create_symlink(entry.path(), std::filesystem::path(folder) / entry.path().filename());
  std::ifstream in(park);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  for (const auto& [from, to] :
       {std::pair<std::string, std::string>{"sky_directions = 484", "bounces = 0\nsky_directions = " + sky_directions},
        {"gsd_m = 1.0\n", "gsd_m = 0.625\n"},
        {"pixels = 320", "pixels = 512"},
        {"lines = 320", "lines = 512"}}) {
    const auto at = text.find(from);
    if (at == std::string::npos)
      throw base::Error(base::Fault::input,
                        "bench: " + park.string() + " has no '" + from + "'; is this the shipped scene?");
    text.replace(at, from.size(), to);
  }
  const std::string file = folder + "/large.toml";
  std::ofstream(file) << text;
  return file;
}

double traced_s(const nlohmann::json& stage_s) {
  double sum = 0;
  for (const char* name : {"trace_primary", "trace_sun", "trace_sky"}) sum += stage_s.value(name, 0.0);
  return sum;
}

/// From the first launch to the last byte.
double image_s(const nlohmann::json& run) {
  double s = run.at("total_s");
  for (const char* name : {"load", "atmosphere", "kernels", "plan"}) s -= run.at("stage_s").at(name).get<double>();
  return s;
}

}  // namespace

Programs programs_of_run(const std::string& run_json) { return programs_in(read_run(run_json)); }

void run_render(const Settings& settings, Report& report) {
  const scene::Simulation park = load_park(settings);
  const scene::Instrument& spectir = park.instruments.at(0);
  const std::size_t roof_floats = (std::size_t{384} << 20) / sizeof(float);
  const auto release = [](float* p) { std::free(p); };
  const std::unique_ptr<float, decltype(release)> roof(
      static_cast<float*>(std::aligned_alloc(64, roof_floats * sizeof(float))), release);
  fill16(roof.get(), roof_floats, 1.0f, settings.threads);

  const auto fill = [&](float value) {
    return seconds_of([&] { fill16(roof.get(), roof_floats, value, settings.threads); });
  };
  // One render of the whole park, the roof measured on both sides of it.
  Pairs pairs;
  pairs.reference_s = {fill(2.0f)};
  const nlohmann::json run = render_park(settings, settings.park_file, spectir.name);
  pairs.reference_s.push_back(fill(3.0f));
  report.add_programs("raycube render", programs_in(run));
  report.add_programs("group render", kernel_build(settings).programs);

  const auto& stage_s = run.at("stage_s");
  const auto stage = [&](const char* name) { return stage_s.at(name).get<double>(); };
  pairs.ours_s.assign(2, stage("integrate"));
  const double padded = static_cast<double>(RC_PADDED(spectir.bands.size()));
  const double scale = padded * spectir.pixels * spectir.lines / static_cast<double>(roof_floats);
  const Spread ratio = pairs.ratio();
  report.add("park_integrate_vs_write_bandwidth",
             Spread{ratio.median * scale, ratio.lowest * scale, ratio.highest * scale, ratio.count}, "x");
  report.add("park_terms_p50", run.at("rows").at("terms_p50").get<double>(), "terms");
  report.add("park_terms_p95", run.at("rows").at("terms_p95").get<double>(), "terms");
  report.add("park_render_s", image_s(run), "s");
  report.add("park_integrate_vs_trace", stage("integrate") / (stage("trace_primary") + stage("trace_sun")), "x",
             Goal::at_most(1));

  const auto end_to_end = [&](const std::string& sky_directions) {
    const TemporaryFolder large;
    const std::string large_file = write_large_park(settings, large.path, sky_directions);
    const nlohmann::json cube = render_park(settings, large_file, spectir.name);
    const auto& large_s = cube.at("stage_s");
    return image_s(cube) /
           std::max(traced_s(large_s) + large_s.at("integrate").get<double>(), large_s.at("write").get<double>());
  };
  report.add("cube_end_to_end_vs_max_stage", end_to_end("484"), "x", Goal::at_most(1.3));
  // Tracing hides less of what goes on beside it.
  report.add("cube_end_to_end_one_direction", end_to_end("1"), "x");
  report.set_text("device", run.at("device").at("name"));
}

}  // namespace raycube::bench
