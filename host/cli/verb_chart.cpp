// `raycube chart`: every knob's levels, timed and held against a converged reference.
#include <fstream>
#include <map>
#include <memory>
#include <ostream>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/output_file.h"
#include "host/cl/device.h"
#include "host/run/chart_point.h"
#include "host/run/input_check.h"
#include "host/run/lidar_job.h"
#include "host/run/python_chart.h"
#include "host/cli/services.h"
#include "host/run/camera_job.h"
#include "host/run/load_job.h"
#include "host/products/csv_writer.h"

namespace raycube::cli {
namespace {

struct ChartRequest : run::ChartOptions {
  std::string file, instrument;
};

/// Begun before anything is rendered: what must not be replaced is known then.
struct Files {
  Files(const std::string& folder, base::IfExists if_exists)
      : set(folder, if_exists), csv(set.add("chart.csv")), png(set.add("chart.png")), json(set.add("chart.json")) {}
  base::OutputSet set;
  base::OutputFile &csv, &png, &json;

  void write(const run::Chart& chart) {
    products::CsvWriter table(
        csv, {"device", "knob", "label", "level", "error", "error_low", "error_high", "rms", "p95", "worst_band",
              "time_s", "time_low_s", "time_high_s", "rays", "terms", "front", "refused"});
    for (const run::ChartPoint& p : chart.points) {
      table.add(p.device).add(p.knob).add(p.label).add(p.level);
      const bool refused = !p.refused.empty();
      for (const double value : {p.error, p.error_low, p.error_high, p.rms, p.p95, static_cast<double>(p.worst_band),
                                 p.time_s, p.time_low_s, p.time_high_s, p.rays, p.terms}) {
        if (refused)
          table.add("");
        else
          table.add(value);
      }
      table.add(p.front ? 1 : 0).add(p.refused);
      table.end_row();
    }
    table.finish();
    json.append(run::chart_json(chart).dump(2) + "\n");
    run::draw_into("chart.py", json, png);
    set.publish();
  }
};

/// Model name of the processor and how many threads it has: a CPU device's name does not always say.
std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  std::string name = "processor unknown";
  for (std::string line; std::getline(file, line);)
    if (line.rfind("model name", 0) == 0) {
      name = line.substr(line.find(':') + 2);
      break;
    }
  return name + ", " + std::to_string(std::thread::hardware_concurrency()) + " threads";
}

/// Table of the front and, per knob, of all points.
std::string chart_text(const run::Chart& chart) {
  std::string out =
      fmt::format("{} {}: error against {} {} by {}\n  its own error {:.3g}, tolerance {:g}{}\n  time of {}\n",
                  chart.kind, chart.name, chart.validated, chart.kind == "cube" ? "pixels" : "pulses", chart.reference,
                  chart.own_error, chart.tolerance,
                  chart.kind == "cube" ? " (" + measure_text(chart.measure) + ")" : std::string(), chart.what_time);
  out += fmt::format("  {:<27} {:<12} {:>9} {:>19} {:>9} {:>9} {:>21} {:>9}\n", "knob", "level", "error", "from to",
                     "p95", "time s", "from to", "rays");
  for (const run::ChartPoint& p : chart.points) {
    if (!p.refused.empty()) {
      out += fmt::format("  {:<27} {:<12} no plan: {}\n", p.knob, p.label, p.refused);
      continue;
    }
    out += fmt::format("{} {:<27} {:<12} {:>9.2e} {:>9.2e} {:>9.2e} {:>9.2e} {:>9.4g} {:>10.4g} {:>10.4g} {:>9.0f}\n",
                       p.front ? '*' : ' ', p.knob, p.label, p.error, p.error_low, p.error_high, p.p95, p.time_s,
                       p.time_low_s, p.time_high_s, p.rays);
  }
  return out + "  * nothing is both faster and more accurate\n";
}

int run(Invocation& invocation, const ChartRequest& options) {
  run::Services services = services_of(invocation);
  scene::Simulation simulation = run::load_job(options.file, invocation.common.seed, services, invocation.common.set);
  run::check_inputs(simulation, {.instruments = run::pick_instruments(simulation, options.instrument),
                                 .lidars = run::pick_lidars(simulation, options.instrument)});
  const auto wanted = [&](const std::string& name) { return options.instrument.empty() || name == options.instrument; };
  std::vector<std::string> devices;
  if (!invocation.common.device.empty())
    devices = {invocation.common.device};
  else
    for (std::size_t i = 0; i < cl::list_devices().size(); ++i) devices.push_back(std::to_string(i));
  // A knob that is named need not belong to every instrument, but to one.
  const auto applies = [&](const knobs::Subject& subject) {
    if (options.knobs.empty()) return true;
    for (const std::string& name : options.knobs)
      if (knobs::find_knob(name).applies(subject)) return true;
    return false;
  };
  struct Job {
    std::size_t index;
    bool lidar;
    std::string name;
  };
  std::vector<Job> jobs;
  for (std::size_t i = 0; i < simulation.instruments.size(); ++i)
    if (wanted(simulation.instruments[i].name) && applies(run::chart_subject(simulation, i, options.knobs)))
      jobs.push_back({i, false, simulation.instruments[i].name});
  for (std::size_t i = 0; i < simulation.lidars.size(); ++i)
    if (wanted(simulation.lidars[i].name) && applies({simulation, nullptr, &simulation.lidars[i]}))
      jobs.push_back({i, true, simulation.lidars[i].name});
  if (jobs.empty())
    throw base::Error(base::Fault::input,
                      options.file + ": none of the knobs that are named changes anything of what it has");
  const std::string folder = invocation.common.output.empty() ? "out" : invocation.common.output;
  std::map<std::string, Files> files;
  for (const Job& job : jobs)
    files.try_emplace(job.name, folder + "/" + job.name + "_chart", if_exists(invocation.common));
  const render::RenderOptions where = render_options(invocation.common);
  nlohmann::ordered_json all;
  for (const Job& job : jobs) {
    run::Chart chart = job.lidar ? run::chart_pulses(simulation, job.index, options, devices, where, services)
                                 : run::chart_cube(simulation, job.index, options, devices, where, services);
    chart.machines.push_back(processor());
    if (5 * chart.own_error > chart.tolerance)
      invocation.log.warning(job.name + ": the reference's own error, " + std::to_string(100 * chart.own_error) +
                             " %, is more than a fifth of the tolerance: what lies near it is not told apart; give a "
                             "larger --reference-grid, or --pulses");
    files.at(job.name).write(chart);
    invocation.log.info("wrote " + files.at(job.name).set.folder() + "/chart.csv, chart.json and chart.png");
    if (invocation.common.json)
      all[job.name] = run::chart_json(chart);
    else
      invocation.out << chart_text(chart);
  }
  if (invocation.common.json) invocation.out << all.dump(2) << "\n";
  return 0;
}

}  // namespace

Verb verb_chart() {
  auto o = std::make_shared<ChartRequest>();
  Verb verb("chart", "Chart error against time for every knob, on every device");
  std::string knobs;
  for (const auto& knob : knobs::all_knobs())
    knobs += "\n\n" + knob.name + (knob.unit.empty() ? "" : " (" + knob.unit + ")") + ": " + knob.text;
  verb.description =
      "Sweeps each knob around the file's own setting, and samples with sky directions together. Each setting is "
      "rendered at pixels picked by hash and held "
      "against a converged reference: Embree and double precision, the full tables, about two thousand samples a "
      "pixel. It is computed once and kept in "
      "~/.cache/raycube/reference (or $XDG_CACHE_HOME). The error is that of `tolerance`: rms over pixels, divided by "
      "the band's mean, worst band; or the figure and the pixels that tolerance_of and tolerance_materials ask for, "
      "the worst then being that of the pixels picked. Its bar "
      "takes the reference's own variance off and holds one standard error over the pixels.\n\n"
      "Times are medians after a warm-up, their bars the least and the largest repeat. Cubes: stages of a few strips, "
      "scaled to the whole image. LIDARs: "
      "launches of the picked pulses, scaled to the survey; the error is the rms of the waveforms over that of their "
      "peaks, without turbulence.\n\n"
      "DIR/INSTRUMENT_chart/ gets chart.csv, chart.json and chart.png. Without --device every device is charted.\n\n"
      "Knobs:" +
      knobs;
  verb.examples = {"raycube chart park.toml --instrument spectir",
                   "raycube chart park.toml --knob samples --knob sky_directions --pixels 2000 -o out"};
  verb.common = kOutput | kCompute | kSet;
  verb.output_default = "out";
  verb.add_options = [o](base::OptionTable& table) {
    table.argument("FILE", "A simulation file", o->file);
    table.text("--instrument", "NAME", "Only this instrument or LIDAR", o->instrument);
    table.texts("--knob", "NAME", "Only this knob; may be repeated", o->knobs);
    table.integer<std::uint64_t>("--pixels", "", 4, 10000000,
                                 "Pixels of each instrument held against the reference, rounded up to groups of 4",
                                 o->pixels);
    table.integer<std::uint64_t>("--pulses", "", 0, 10000000,
                                 "Pulses of each LIDAR; 0: 100, fewer where those have more than 3e5 rays", o->pulses);
    table.integer<std::uint64_t>("--timed-pixels", "", 64, 100000000,
                                 "Pixels that are timed, fewer where those have more than 4e6 rays", o->timed_pixels);
    table.integer<int>(
        "--reference-grid", "", 4, 1000,
        "n of the two n x n samples of a pixel's reference; more where its own error is too near the tolerance",
        o->reference_grid);
    table.integer<int>("--repeats", "", 1, 1000, "Timings of each setting after the warm-up", o->repeats);
  };
  verb.run = [o](Invocation& invocation) { return run(invocation, *o); };
  return verb;
}

}  // namespace raycube::cli
