#include "host/cli/lidar_dial.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <ostream>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/input_file.h"
#include "host/base/interrupt.h"
#include "host/base/json_text.h"
#include "host/base/publication.h"
#include "host/base/text.h"
#include "host/run/dial_run.h"
#include "host/run/python_chart.h"
#include "host/lidar/echoes.h"
#include "host/lidar/make_lidar_plan.h"
#include "host/lidar/volumes.h"
#include "host/products/csv_writer.h"
#include "scene_compiler/load_simulation.h"

namespace raycube::cli {

namespace {

constexpr double kPpmM = lidar::kMoleculesPerPpmM;

struct DialRequest {
  std::string folder, file, lidar;
  int average = 1;
};

/// The simulation file a run's command names.
std::string file_of_run(const std::string& folder) {
  base::finish_publication(folder);
  base::refuse_other_than_plain(folder + "/run.json");
  std::ifstream in(std::filesystem::path(folder) / "run.json");
  const auto record = nlohmann::json::parse(base::shallow_json(in), nullptr, false);
  if (record.is_object() && record.contains("command")) {
    std::istringstream words(record["command"].get<std::string>());
    for (std::string word; words >> word;)
      if (word.size() > 5 && word.compare(word.size() - 5, 5, ".toml") == 0 && std::filesystem::exists(word))
        return word;
  }
  throw base::Error(
      base::Fault::input,
      folder + ": its run.json names no simulation file that is there; give it: raycube lidar dial RUN FILE");
}

const scene::Lidar& pick(const scene::Simulation& simulation, const std::string& name, const DialRequest& o) {
  for (const scene::Lidar& lidar : simulation.lidars)
    if (name.empty() || lidar.name == name) return lidar;
  throw base::Error(base::Fault::input,
                    o.file + ": has no [[lidar]]" + (name.empty() ? "" : " called \"" + name + "\""));
}

/// The gas that lines tell from the rest, and which line sees it most and least.
struct Lines {
  std::string gas;
  int on = 0, off = 0;
  lidar::LineSection on_section, off_section;
};

Lines choose_lines(const scene::Simulation& simulation, const lidar::LidarPlan& plan) {
  if (plan.lines() < 2)
    throw base::Error(
        base::Fault::input,
        plan.lidar.name + ": has one laser line; differential absorption needs one on the absorption and one off it");
  Lines out;
  std::set<std::string> gases;
  int volume = -1;
  for (std::size_t v = 0; v < simulation.scene.volumes.size(); ++v) {
    if (simulation.scene.volumes[v].gas.empty()) continue;
    gases.insert(simulation.scene.volumes[v].gas);
    if (volume < 0) volume = static_cast<int>(v), out.gas = simulation.scene.volumes[v].gas;
  }
  if (volume < 0) throw base::Error(base::Fault::input, plan.lidar.name + ": the scene has no [[volume]] with a gas");
  if (gases.size() > 1)
    throw base::Error(base::Fault::input, plan.lidar.name + ": the scene has " + std::to_string(gases.size()) +
                                              " gases; this verb retrieves one");
  for (int line = 1; line < plan.lines(); ++line) {
    const double sigma = lidar::line_section(plan, volume, line).mean_sigma_cm2();
    if (sigma > lidar::line_section(plan, volume, out.on).mean_sigma_cm2()) out.on = line;
    if (sigma < lidar::line_section(plan, volume, out.off).mean_sigma_cm2()) out.off = line;
  }
  out.on_section = lidar::line_section(plan, volume, out.on),
  out.off_section = lidar::line_section(plan, volume, out.off);
  if (out.on == out.off)
    throw base::Error(base::Fault::input, plan.lidar.name + ": all laser lines see " + out.gas + " alike");
  return out;
}

lidar::Detection record_of(const run::DialRun::Line& line, int number, bool expected) {
  lidar::Detection d;
  d.line = number;
  d.waveform_pe = line.recorded;
  if (expected)
    d.waveform_pe.assign(line.expected.begin(), line.expected.end());
  else
    d.truth.background_pe = line.background_pe;
  return d;
}

/// Returns of pulses that are retrieved together.
struct Group {
  std::int64_t pulse = 0;
  int pixel = 0, members = 0;
  std::array<double, 3> at_m{};
  double range_m = 0, speckle = 0;  ///< speckle: variance of the logarithm
  lidar::NetCounts on, off, true_on, true_off;
};

void add(lidar::NetCounts& sum, const lidar::NetCounts& more) {
  sum.counts += more.counts, sum.variance += more.variance, sum.photons += more.photons;
}

/// Adds a record's ground return, the strongest of the off line; false: it has none.
bool add_record(Group& group, const run::DialRun::Record& record, const lidar::LidarPlan& plan, const Lines& lines) {
  const run::DialRun::Line &on = record.lines[static_cast<std::size_t>(lines.on)],
                           &off = record.lines[static_cast<std::size_t>(lines.off)];
  lidar::Detection seen = record_of(off, lines.off, false);
  const double largest = *std::max_element(off.expected.begin(), off.expected.end());
  seen.echoes =
      lidar::find_echoes(plan.lidar, seen.waveform_pe, lidar::detector_noise(plan.lidar, off.background_pe, largest));
  const lidar::Echo* ground = lidar::strongest_echo(seen);
  if (!ground) return false;
  if (group.members++ == 0) {
    group.pulse = record.pulse, group.pixel = record.pixel;
    group.on.photons = group.off.photons = group.true_on.photons = group.true_off.photons = 0;
  }
  const double part = 1.0 / group.members;  // running means
  for (std::size_t i = 0; i < 3; ++i)
    group.at_m[i] += part * (record.exit_m[i] + ground->range_m * record.axis[i] - group.at_m[i]);
  group.range_m += part * (ground->range_m - group.range_m);
  if (on.speckle_modes > 0 && off.speckle_modes > 0) group.speckle += 1 / on.speckle_modes + 1 / off.speckle_modes;
  add(group.on, lidar::net_counts(plan, record_of(on, lines.on, false), ground->time_s));
  add(group.off, lidar::net_counts(plan, seen, ground->time_s));
  add(group.true_on, lidar::net_counts(plan, record_of(on, lines.on, true), ground->time_s));
  add(group.true_off, lidar::net_counts(plan, record_of(off, lines.off, true), ground->time_s));
  return true;
}

const char* state_name(lidar::DialState state) {
  return state == lidar::DialState::good ? "good" : state == lidar::DialState::saturated ? "saturated" : "no signal";
}

/// Table, figures and totals of all groups.
class Report {
 public:
  Report(const Lines& lines, base::OutputFile& table)
      : lines_(lines),
        d_sigma_(lines.on_section.mean_sigma_cm2() - lines.off_section.mean_sigma_cm2()),
        writer_(table, {"pulse", "pixel", "averaged", "x_m", "y_m", "z_m", "range_m", "on_pe", "off_pe", "column_ppm_m",
                        "error_ppm_m", "column_thin_ppm_m", "expected_ppm_m", "state"}) {}

  void add(Group group) {
    group.true_on.variance = group.true_off.variance = 0;
    const double speckle = group.speckle / (static_cast<double>(group.members) * group.members);
    const lidar::DialColumn column =
        lidar::dial_column_of_line(group.on, group.off, lines_.on_section, lines_.off_section, speckle);
    const lidar::DialColumn thin = lidar::dial_column(group.on, group.off, d_sigma_, speckle);
    const lidar::DialColumn truth =
        lidar::dial_column_of_line(group.true_on, group.true_off, lines_.on_section, lines_.off_section);
    ++count_[static_cast<int>(column.state)];
    writer_.add(group.pulse).add(group.pixel).add(group.members);
    for (const double at : group.at_m) writer_.add(at);
    writer_.add(group.range_m)
        .add(group.on.counts)
        .add(group.off.counts)
        .add(column.column_cm2 / kPpmM)
        .add(column.error_cm2 / kPpmM);
    writer_.add(thin.column_cm2 / kPpmM).add(truth.column_cm2 / kPpmM).add(state_name(column.state)).end_row();
    if (column.state != lidar::DialState::good) return;
    const double z = (column.column_cm2 - truth.column_cm2) / column.error_cm2;
    z_sum_ += z, z_squares_ += z * z, within_ += std::abs(z) < 1;
    figures_["x_m"].push_back(group.at_m[0]), figures_["y_m"].push_back(group.at_m[1]);
    figures_["column"].push_back(column.column_cm2 / kPpmM), figures_["error"].push_back(column.error_cm2 / kPpmM);
    figures_["thin"].push_back(thin.column_cm2 / kPpmM), figures_["expected"].push_back(truth.column_cm2 / kPpmM);
    figures_["depth"].push_back(2 * truth.column_cm2 * lines_.on_section.mean_sigma_cm2());
  }

  nlohmann::json totals() const {
    const double n = std::max(1, count_[0]);
    return {{"good", count_[0]},
            {"saturated", count_[1]},
            {"no_signal", count_[2]},
            {"mean_deviation_sigma", z_sum_ / n},
            {"rms_deviation_sigma", std::sqrt(z_squares_ / n)},
            {"within_one_sigma", within_ / n}};
  }
  void none() { ++count_[2]; }
  nlohmann::json& figures() { return figures_; }
  products::CsvWriter& writer() { return writer_; }

 private:
  const Lines& lines_;
  double d_sigma_;
  products::CsvWriter writer_;
  nlohmann::json figures_;
  int count_[3] = {0, 0, 0};
  double z_sum_ = 0, z_squares_ = 0, within_ = 0;
};

int retrieve(DialRequest o, Invocation& invocation) {
  if (o.file.empty()) o.file = file_of_run(o.folder);
  scene::LoadOptions load;
  const scene::Simulation simulation = scene::load_simulation(o.file, load);
  const scene::Lidar& lidar = pick(simulation, o.lidar, o);
  const lidar::LidarPlan plan = lidar::make_lidar_plan(simulation, lidar, nullptr);
  const Lines lines = choose_lines(simulation, plan);
  const run::DialRun recorded(o.folder, plan);

  const std::filesystem::path chart = invocation.common.output.empty()
                                          ? std::filesystem::path(o.folder) / "columns.png"
                                          : std::filesystem::path(invocation.common.output);
  const std::string csv = std::filesystem::path(chart).replace_extension(".csv").string();
  if (csv == chart.string())
    throw base::Error(base::Fault::input, csv + ": a chart is a PNG; its table goes to the .csv beside it");
  const auto if_exists = invocation.common.overwrite ? base::IfExists::replace : base::IfExists::refuse;
  base::OutputFile table(csv, if_exists);
  Report report(lines, table);
  const int pixels = plan.pixels();
  for (int pixel = 0; pixel < pixels; ++pixel) {
    Group group;
    int taken = 0;
    for (std::int64_t number = pixel; number < recorded.records(); number += pixels) {
      base::throw_if_interrupted();
      if (!add_record(group, recorded.read(number), plan, lines)) report.none();
      if (++taken < o.average && number + pixels < recorded.records()) continue;
      if (group.members > 0) report.add(group);
      group = {}, taken = 0;
    }
  }
  report.writer().finish();
  table.sync();
  nlohmann::json totals = report.totals();
  nlohmann::json& figures = report.figures();
  figures["title"] = lidar.name, figures["gas"] = lines.gas, figures["totals"] = totals;
  const std::string numbers = run::draw_chart("lidar_dial.py", figures.dump(), chart.string(), if_exists);
  table.publish();
  if (invocation.common.json) {
    totals["chart"] = chart.string(), totals["table"] = csv, totals["figures"] = numbers, totals["gas"] = lines.gas;
    invocation.out << totals.dump() << "\n";
    return 0;
  }
  invocation.out << fmt::format("{}: {}, {} saturated, {} without signal\n", lines.gas,
                                base::counted(totals["good"].get<std::size_t>(), "column"),
                                totals["saturated"].get<int>(), totals["no_signal"].get<int>());
  invocation.out << fmt::format(
      "deviation from the noiseless return: mean {:.3f} sigma, rms {:.3f} sigma, {:.1f} % within one sigma\n",
      totals["mean_deviation_sigma"].get<double>(), totals["rms_deviation_sigma"].get<double>(),
      100 * totals["within_one_sigma"].get<double>());
  invocation.out << fmt::format("chart: {}\ntable: {}\n", chart.string(), csv);
  return 0;
}

}  // namespace

Verb verb_lidar_dial() {
  auto o = std::make_shared<DialRequest>();
  Verb verb("dial", "Retrieve a gas' column from the on-line and off-line returns of a run");
  verb.description =
      "Reads waveforms.img and pulses.csv of a LIDAR's folder and takes the strongest return of the line that absorbs "
      "least as the ground. Columns are one way, from "
      "the ratio of the returns, with the cross sections of the FILE's gas averaged over the laser's line after the "
      "exponential, so that a wide line makes no bias; "
      "column_thin_ppm_m has what the line's mean cross section alone would give. expected_ppm_m is the same retrieval "
      "from the noiseless returns. Errors come from "
      "counts, the detector and speckle. Writes a table (.csv), a chart (.png) and its figures (.json).";
  verb.examples = {"raycube lidar dial run/dial",
                   "raycube lidar dial run/dial scenes/lidar/pipeline_dial.toml --average 10 -o columns.png"};
  verb.common = kOutput;
  verb.output_default = "columns.png in RUN";
  verb.add_options = [o](base::OptionTable& table) {
    table.argument("RUN", "A LIDAR's folder, as render leaves it", o->folder);
    table.optional_argument("FILE", "The simulation file it was made from; default: the one its run.json names",
                            o->file);
    table.text("--lidar", "NAME", "Which of FILE's LIDARs", o->lidar).default_text = "the first";
    table.integer("--average", "pulses", 1, 1000000, "Pulses whose returns are summed before the ratio", o->average);
  };
  verb.run = [o](Invocation& invocation) { return retrieve(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
