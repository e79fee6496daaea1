#include "host/run/dial_run.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "host/base/error.h"
#include "host/run/lidar_csv.h"
#include "host/products/envi_reader.h"
#include "scene_compiler/csv_file.h"

namespace raycube::run {

namespace {

/// A number that the run's writer may leave empty.
double cell(const scene::CsvFile& table, std::size_t row, const std::string& column, base::Problems& problems) {
  const auto at = table.column(column);
  if (!at || scene::trimmed(table.rows[row][*at]).empty()) return 0;
  return table.number(row, *at, problems).value_or(0);
}

}  // namespace

struct DialRun::State {
  State(const std::string& folder, const lidar::LidarPlan& plan_)
      : plan(plan_), cube((std::filesystem::path(folder) / "waveforms.hdr").string()) {
    const auto& header = cube.header();
    const scene::LidarGate& gate = plan.lidar.gate;
    if (header.samples != gate.bins)
      throw base::Error(base::Fault::input, folder + ": waveforms of " + std::to_string(header.samples) +
                                                " bins, but the simulation file's gate has " +
                                                std::to_string(gate.bins) + "; give the FILE the run was made from");
    for (int line = 0; line < plan.lines(); ++line) {
      const std::string name = line_name(plan.lidar, line);
      std::vector<std::size_t> parts;
      std::size_t recorded = header.band_names.size();
      for (std::size_t b = 0; b < header.band_names.size(); ++b) {
        const std::string& band = header.band_names[b];
        if (band == name + " recorded [photo-electrons]")
          recorded = b;
        else if (band.rfind(name + " ", 0) == 0 && band.find("[photons]") != std::string::npos)
          parts.push_back(b);
      }
      if (recorded == header.band_names.size() || parts.empty())
        throw base::Error(base::Fault::input, folder + ": waveforms.hdr has no recorded waveforms of line \"" + name +
                                                  "\"; render with a detector and the time cube");
      recorded_band.push_back(recorded), expected_bands.push_back(parts);
    }
    base::Problems problems;
    const std::string file = (std::filesystem::path(folder) / "pulses.csv").string();
    const auto table = scene::read_csv(file, {file, 0, 0, ""}, problems);
    problems.throw_if_any();
    const auto prefix = table->column("exit_easting_m")
                            ? std::array<const char*, 3>{"exit_easting_m", "exit_northing_m", "exit_height_m"}
                            : std::array<const char*, 3>{"exit_x_m", "exit_y_m", "exit_z_m"};
    const auto name_column = table->column("line"), pulse_column = table->column("pulse"),
               cube_column = table->column("cube_line");
    if (!name_column || !pulse_column || !cube_column)
      throw base::Error(base::Fault::input,
                        file + ": lacks a column pulse, line or cube_line; it is not a run's table of pulses");
    for (std::size_t row = 0; row < table->rows.size(); ++row) {
      const auto first = static_cast<std::int64_t>(cell(*table, row, "cube_line", problems));
      Record& record = pulses[first];
      record.pulse = static_cast<std::int64_t>(cell(*table, row, "pulse", problems));
      static const char* const axes[] = {"axis_x", "axis_y", "axis_z"};
      for (std::size_t i = 0; i < 3; ++i)
        record.exit_m[i] = cell(*table, row, prefix[i], problems),
        record.axis[i] = cell(*table, row, axes[i], problems);
      record.lines.resize(static_cast<std::size_t>(plan.lines()));
      for (int line = 0; line < plan.lines(); ++line) {
        if (table->rows[row][*name_column] != line_name(plan.lidar, line)) continue;
        Line& l = record.lines[static_cast<std::size_t>(line)];
        l.background_pe = cell(*table, row, "background_pe_per_bin", problems),
        l.speckle_modes = cell(*table, row, "speckle_modes", problems);
      }
    }
    problems.throw_if_any();
    if (pulses.empty() || pulses.begin()->first != 0)
      throw base::Error(base::Fault::input, file + ": its first pulse is not the time cube's");
  }

  const lidar::LidarPlan& plan;
  products::EnviReader cube;
  std::vector<std::size_t> recorded_band;
  std::vector<std::vector<std::size_t>> expected_bands;
  std::map<std::int64_t, Record> pulses;  ///< by first line of the cube
};

DialRun::DialRun(const std::string& folder, const lidar::LidarPlan& plan)
    : state_(std::make_unique<State>(folder, plan)) {}
DialRun::~DialRun() = default;

std::int64_t DialRun::records() const { return state_->cube.header().lines; }

DialRun::Record DialRun::read(std::int64_t number) const {
  const State& s = *state_;
  const auto pulse = std::prev(s.pulses.upper_bound(number));
  Record record = pulse->second;
  record.pixel = static_cast<int>(number - pulse->first);
  const std::vector<double> values = s.cube.read_lines(number, 1);
  const auto bins = static_cast<std::size_t>(s.cube.header().samples),
             bands = static_cast<std::size_t>(s.cube.header().bands);
  const double efficiency = s.plan.lidar.receiver.quantum_efficiency;
  for (std::size_t line = 0; line < record.lines.size(); ++line) {
    Line& l = record.lines[line];
    l.recorded.resize(bins), l.expected.assign(bins, 0.0);
    for (std::size_t i = 0; i < bins; ++i) {
      l.recorded[i] = static_cast<float>(values[i * bands + s.recorded_band[line]]);
      for (const std::size_t part : s.expected_bands[line]) l.expected[i] += efficiency * values[i * bands + part];
    }
  }
  return record;
}

}  // namespace raycube::run
