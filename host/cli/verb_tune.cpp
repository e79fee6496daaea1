// raycube tune: times a device's work-group and tile sizes on a simulation's own image and keeps the fastest.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <type_traits>

#include "host/base/error.h"
#include "host/base/sha256.h"
#include "host/run/lidar_job.h"
#include "host/run/input_check.h"
#include "host/cli/services.h"
#include "host/run/camera_job.h"
#include "host/run/load_job.h"
#include "host/lidar/shot.h"
#include "host/render/tuner.h"
#include "host/base/timing.h"

namespace raycube::cli {

namespace {

constexpr int kRounds = 5;
constexpr double kRun_s = 0.3;  ///< a run is at least so long, unless the tile or the survey ends
constexpr double kTileRun_s =
    /// about so long where tiles are compared, each kTileTimes in a row: memory is touched for the first time only once
    0.7;
constexpr int kTileTimes = 3;
constexpr std::size_t kLocalSizes[] = {1, 2, 4, 8, 16, 32, 64, 128, 256};

struct TuneRequest {
  std::string file, instrument;
};

/// A piece of work that can be run at any sizes.
struct Work {
  std::function<void()> run;
  std::function<std::string()> digest;  ///< runs, and says what came out
};

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return base::seconds_since(start);
}

template <class T>
void add(base::Sha256& hash, const std::vector<T>& values) {
  static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>);
  hash.add(values.data(), values.size() * sizeof(T));
}

/// The fastest local size of every kernel that `work` launches. Sizes that change a bit are a driver's fault: named and
/// never used.
std::map<std::string, render::SizeChoice> tune_local(cl::Context& device, const Work& work, run::Services& services) {
  const cl::LaunchSizes presets = cl::default_launch_sizes(device.device().info());
  const std::size_t preset = presets.other;
  const auto sized = [&](std::size_t size) { device.set_launch_sizes({size, {}, presets.rest_together}); };
  sized(preset);
  const std::string expected = work.digest();
  std::vector<std::size_t> sizes;
  for (const std::size_t size : kLocalSizes) {
    sized(size);
    if (size == preset || work.digest() == expected)
      sizes.push_back(size);
    else
      services.log.warning(fmt::format(
          "work-groups of {} change results on this device, which its driver should not let happen; they are not used",
          size));
  }
  return render::choose_sizes(sizes, preset, kRounds, [&](std::size_t size) {
    std::map<std::string, cl::KernelTime> times;
    sized(size);
    device.time_kernels(&times);
    work.run();
    device.time_kernels(nullptr);
    std::map<std::string, double> seconds;
    for (const auto& [kernel, time] : times)
      if (size == preset || time.most_items >= size)
        seconds[kernel] = time.seconds;  // a smaller launch has no work-group of that size
    return seconds;
  });
}

/// Tiles of one size over lines in the middle of the image.
std::vector<render::Tile> cut(const scene::Instrument& instrument, int lines, const render::TileSize& size) {
  std::vector<render::Tile> tiles;
  const int first = (instrument.lines - lines) / 2;
  for (int line = 0; line < lines; line += size.lines)
    for (int column = 0; column < instrument.pixels; column += size.columns)
      tiles.push_back({first + line, std::min(size.lines, lines - line), column,
                       std::min(size.columns, instrument.pixels - column)});
  return tiles;
}

nlohmann::ordered_json choice_json(const render::SizeChoice& choice, const char* name) {
  auto candidates = nlohmann::ordered_json::array();
  for (const auto& [size, seconds] : choice.candidates) candidates.push_back({{name, size}, {"seconds", seconds}});
  return {{name, choice.size},
          {"seconds", choice.seconds},
          {"seconds_of_the_preset", choice.preset_seconds},
          {"candidates", std::move(candidates)}};
}

/// What was found on one instrument or LIDAR.
struct Found {
  std::string name;
  std::map<std::string, render::SizeChoice> kernels;
  std::optional<render::SizeChoice> tile;
};

Found tune_cube(const scene::Simulation& simulation, const run::CameraJob& job, render::Renderer& renderer,
                run::Services& services) {
  const auto& instrument = *job.instrument;
  auto& device = renderer.context();
  const auto size_of = [&](std::size_t samples) { return renderer.tile_size(instrument, job.plan, samples); };
  const auto probe = [&](const std::vector<render::Tile>& tiles, const render::ProbeSink& sink) {
    return renderer.probe(instrument, job.plan, simulation.sun, simulation.seed, tiles, sink);
  };
  const std::size_t preset = render::default_tuning(device.device().info()).tile_samples;
  const render::TileSize usual = size_of(preset);
  const auto stages_s = [&](const std::vector<render::Tile>& tiles) {
    double sum = 0;
    for (const auto& [stage, seconds] : probe(tiles, {}).stage_s) sum += seconds;
    return sum;
  };
  int lines = 1;
  const auto tile = [&] { return std::vector<render::Tile>{cut(instrument, lines, usual).front()}; };
  stages_s(tile());
  while (lines < usual.lines && stages_s(tile()) < kRun_s) lines = std::min(2 * lines, usual.lines);
  Found found{instrument.name,
              tune_local(device,
                         {[&] { probe(tile(), {}); },
                          [&] {
                            base::Sha256 hash;
                            probe(tile(), [&](const render::PixelProbe& pixels) {
                              add(hash, pixels.radiance);
                              add(hash, pixels.truth);
                            });
                            return hash.hex();
                          }},
                         services),
              {}};
  cl::LaunchSizes best = cl::default_launch_sizes(device.device().info());
  for (const auto& [kernel, choice] : found.kernels) best.local[kernel] = choice.size;
  device.set_launch_sizes(best);

  const double line_s = stages_s(tile()) / lines * instrument.pixels / std::min(instrument.pixels, usual.columns);
  const int region = std::clamp(static_cast<int>(kTileRun_s / std::max(line_s, 1e-9)), usual.lines, instrument.lines);
  const auto digest = [&](std::size_t samples) {
    base::Sha256 hash;
    probe(cut(instrument, region, size_of(samples)),
          [&](const render::PixelProbe& pixels) { add(hash, pixels.radiance); });
    return hash.hex();
  };
  const std::string expected = digest(preset);
  std::vector<std::size_t> sizes{preset};
  std::set<std::pair<int, int>> seen{{usual.lines, usual.columns}};
  for (int power = -4; power <= 6; ++power) {
    const std::size_t samples = power < 0 ? preset >> -power : preset << power;
    const auto size = size_of(samples);
    if (size.lines > region || !seen.insert({size.lines, size.columns}).second) continue;
    if (digest(samples) == expected)
      sizes.push_back(samples);
    else
      services.log.warning(
          fmt::format("tiles of {} samples change results on this device, which its driver should not let happen; they "
                      "are not used",
                      samples));
  }
  const auto chosen =
      render::choose_sizes(sizes, preset, kRounds, [&](std::size_t samples) -> std::map<std::string, double> {
        std::vector<render::Tile> tiles;
        for (int time = 0; time < kTileTimes; ++time)
          for (const auto& one : cut(instrument, region, size_of(samples))) tiles.push_back(one);
        return {{"tile", stages_s(tiles)}};
      });
  found.tile = chosen.at("tile");
  return found;
}

Found tune_pulses(const scene::Simulation& simulation, const run::LidarJob& job, render::LidarRenderer& renderer,
                  run::Services& services) {
  std::int64_t count = std::min<std::int64_t>(64, job.lidar->pulses);
  auto shots = lidar::make_shots(*job.lidar, 0, count, simulation.seed);
  const auto render = [&](const render::ShotSink& sink) { renderer.render(job.plan, shots, sink, true); };
  const auto run = [&] { render([](lidar::ShotResult&&) {}); };
  run();
  while (seconds_of(run) < kRun_s && count < job.lidar->pulses) {
    count = std::min(2 * count, job.lidar->pulses);
    shots = lidar::make_shots(*job.lidar, 0, count, simulation.seed);
  }
  return {job.lidar->name,
          tune_local(renderer.context(),
                     {run,
                      [&] {
                        base::Sha256 hash;
                        render([&](lidar::ShotResult&& shot) {
                          add(hash, shot.first);
                          add(hash, shot.multiple);
                          add(hash, shot.air);
                          add(hash, shot.hits);
                          for (const lidar::Ledger& l : shot.ledger)
                            add(hash, std::vector<double>{l.absorbed, l.air, l.volumes, l.escaped, l.truncated,
                                                          l.collected, l.early, l.late, l.near});
                        });
                        return hash.hex();
                      }},
                     services),
          {}};
}

int run(const TuneRequest& options, Invocation& invocation) {
  run::Services services = services_of(invocation);
  const scene::Simulation simulation = run::load_job(options.file, invocation.common.seed, services);
  const auto instruments = run::pick_instruments(simulation, options.instrument);
  const auto lidars = run::pick_lidars(simulation, options.instrument);
  run::check_inputs(simulation, {.instruments = instruments, .lidars = lidars});
  auto settings = render_options(invocation.common);
  settings.tuned = false;
  const cl::DeviceInfo device = render::pick_device(settings).info();
  auto file = render::claim_tuning(device);
  std::vector<Found> all;
  if (!instruments.empty()) {
    render::Renderer renderer(simulation.scene, settings);
    run::Planning planning;
    planning.renderer = &renderer;
    all.push_back(tune_cube(simulation, run::prepare_camera(simulation, *instruments.front(), services, planning),
                            renderer, services));
  }
  if (!lidars.empty()) {
    render::LidarRenderer renderer(simulation.scene, settings);
    all.push_back(tune_pulses(
        simulation, run::prepare_lidar(simulation, *lidars.front(), services, {&renderer, nullptr, "", false}),
        renderer, services));
  }
  render::DeviceTuning tuning = render::read_tuning(device).value_or(render::default_tuning(device));
  nlohmann::ordered_json result = {{"device", device.name}, {"instruments", nlohmann::ordered_json::array()}};
  const std::size_t preset = cl::default_launch_sizes(device).other;
  for (const auto& found : all) {
    nlohmann::ordered_json kernels;
    std::string text = fmt::format("{} on {}\n  {:<16} {:>10} {:>10} {:>10}\n", found.name, device.name, "kernel",
                                   "work-group", "s", fmt::format("s with {}", preset));
    for (const auto& [kernel, choice] : found.kernels) {
      tuning.sizes.local[kernel] = choice.size;
      kernels[kernel] = choice_json(choice, "local_size");
      text += fmt::format("  {:<16} {:>10} {:>10.4f} {:>10.4f}\n", kernel, choice.size, choice.seconds,
                          choice.preset_seconds);
    }
    nlohmann::ordered_json item = {{"name", found.name}, {"kernels", kernels}};
    if (found.tile) {
      tuning.tile_samples = found.tile->size;
      item["tile"] = choice_json(*found.tile, "samples");
      text += fmt::format("  tiles of {} samples: {:.3f} s, of {}: {:.3f} s\n", found.tile->size, found.tile->seconds,
                          render::default_tuning(device).tile_samples, found.tile->preset_seconds);
    }
    result["instruments"].push_back(std::move(item));
    if (!invocation.common.json) invocation.out << text;
  }
  render::keep_tuning(device, tuning, file);
  result["file"] = file.final_path();
  if (invocation.common.json)
    invocation.out << result.dump(2) << "\n";
  else
    invocation.out << "kept in " << file.final_path()
                   << "; render, plan, chart and check use it on this device from now on\n";
  return 0;
}

}  // namespace

Verb verb_tune() {
  auto options = std::make_shared<TuneRequest>();
  Verb verb("tune", "Find and keep the launch sizes that are fastest on a device");
  verb.description =
      "Times work-groups of 1 to 256 items for every kernel, and tiles of several sizes, on the simulation's first "
      "instrument and first LIDAR (or the one named), "
      "in turn, and keeps the fastest for this device, driver and set of kernels under $XDG_CACHE_HOME/raycube/tuning "
      "(else ~/.cache). A size replaces the preset only where a kernel takes 0.05 s of the run, the size is 5 % "
      "faster, and faster in every round. "
      "No result changes by a bit: what each size computes is compared before it is timed. Tiles are timed without "
      "writing. Do it once on a machine that does nothing else; it takes some minutes. run.json says which sizes a "
      "render used. Delete the file to go back to the presets.";
  verb.examples = {"raycube tune park.toml", "raycube tune park.toml --instrument survey --device 1"};
  verb.common = kCompute;
  verb.add_options = [options](base::OptionTable& table) {
    table.argument("FILE", "The simulation file (TOML)", options->file);
    table.text("--instrument", "NAME", "This instrument or LIDAR instead of the first of each", options->instrument);
  };
  verb.run = [options](Invocation& invocation) { return run(*options, invocation); };
  return verb;
}

}  // namespace raycube::cli
