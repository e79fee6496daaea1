// Where a LIDAR's platform is at what time, and how many pulses it fires.
#include <algorithm>
#include <array>
#include <cmath>

#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/lidar_parts.h"
#include "host/base/units.h"

namespace raycube::scene::detail {
namespace {

constexpr double kMostPulses = 4e9;

std::vector<LidarPose> read_trajectory(const Record& lidar, const LidarReport& report) {
  auto& problems = report.problems;
  const auto csv = read_csv(lidar.text("trajectory"), lidar.place("trajectory"), problems);
  if (!csv) return {};
  static constexpr std::array<const char*, 7> kNames{"time_s",   "x_m",       "y_m",        "z_m",
                                                     "roll_deg", "pitch_deg", "heading_deg"};
  std::array<std::optional<std::size_t>, 7> columns;
  for (std::size_t i = 0; i < kNames.size(); ++i) columns[i] = csv->column(kNames[i]);
  const std::size_t before = problems.count();
  if (!columns[0] || !columns[1] || !columns[2] || !columns[3])
    problems.add({csv->file, csv->header_line, 0, ""}, "columns time_s, x_m, y_m and z_m are needed",
                 csv->columns_text(), "name them; roll_deg, pitch_deg and heading_deg are optional");
  for (const auto& name : csv->columns)
    if (std::find(kNames.begin(), kNames.end(), name) == kNames.end())
      problems.add({csv->file, csv->header_line, 0, ""}, "unknown column", "'" + name + "'",
                   "columns: time_s, x_m, y_m, z_m, roll_deg, pitch_deg, heading_deg");
  std::vector<LidarPose> poses;
  for (std::size_t row = 0; problems.count() == before && row < csv->rows.size(); ++row) {
    std::array<double, 7> v{
        0, 0, 0, 0, lidar.number("roll_deg"), lidar.number("pitch_deg"), lidar.number("heading_deg")};
    for (std::size_t i = 0; i < v.size(); ++i)
      if (columns[i]) v[i] = csv->number(row, *columns[i], problems).value_or(0);
    if (!poses.empty() && !(v[0] > poses.back().time_s))
      problems.add(csv->at(row, *columns[0]), "times must ascend",
                   number_text(v[0]) + " s after " + number_text(poses.back().time_s) + " s", "sort the rows");
    poses.push_back({v[0], v[1], v[2], v[3], v[4], v[5], v[6]});
  }
  return problems.count() == before ? poses : std::vector<LidarPose>{};
}

/// Pulses asked for; 0 after reporting.
std::int64_t count_pulses(const Record& lidar, const Lidar& out, double first_s, const LidarReport& report) {
  if (count_given(lidar, {"pulses", "duration_s"}) == 2) {
    report.problems.add(lidar.place("duration_s"), "'pulses' and 'duration_s' exclude each other", "both",
                        "remove one");
    return 0;
  }
  if (lidar.given("pulses")) return lidar.integer("pulses");
  double duration_s = 0;
  if (lidar.given("duration_s")) {
    duration_s = lidar.number("duration_s");
  } else if (out.trajectory.size() > 1) {
    duration_s = out.trajectory.back().time_s - first_s + 1 / out.prf_hz;
  } else if (out.scan.pattern == ScanPattern::raster) {
    return std::int64_t{out.scan.columns} * out.scan.rows;
  } else {
    report.problems.add(lidar.where, "LIDAR needs exactly one of pulses and duration_s", "none", "add one");
    return 0;
  }
  // A duration of n periods fires n pulses: rounding of the product is forgiven.
  const double pulses = std::floor(duration_s * out.prf_hz * (1 + 1e-12) + 1e-6);
  if (pulses >= 1 && pulses <= kMostPulses) return static_cast<std::int64_t>(pulses);
  report.problems.add(lidar.where, "the time fired for holds no pulse, or more than 4e9",
                      number_text(duration_s) + " s at " + number_text(out.prf_hz) + " Hz",
                      "change duration_s, first_pulse_s or prf_khz");
  return 0;
}

/// Turned so that the boresight (-z of the platform) meets the point, wings level.
void look_at(LidarPose& pose, const std::vector<double>& point, const Record& lidar, const LidarReport& report) {
  const double x = point[0] - pose.x_m, y = point[1] - pose.y_m, z = point[2] - pose.z_m, across = std::hypot(x, y);
  if (across == 0 && z == 0) {
    report.problems.add(lidar.place("look_at_m"), "'look_at_m' is the platform's own place", "", "move one");
    return;
  }
  pose.roll_deg = 0;
  pose.pitch_deg = base::deg_by_division(std::atan2(across, -z));
  pose.heading_deg = across == 0 ? 0 : base::deg_by_division(std::atan2(x, y));
}

/// The pose halfway between first and last pulse; nullopt without reporting when its keys were refused as such.
std::optional<LidarPose> middle_pose(const Record& lidar, const SceneParts& parts, const LidarReport& report) {
  LidarPose pose;
  if (lidar.given("altitude_agl_m")) {
    const auto& c = lidar.numbers("center_m");
    if (c.size() != 2) return std::nullopt;
    pose.x_m = c[0], pose.y_m = c[1];
    pose.z_m = parts.terrain_height_m(c[0], c[1]).value_or(0.0) + lidar.number("altitude_agl_m");
  } else {
    const auto& p = lidar.numbers("position_m");
    if (p.size() != 3) return std::nullopt;
    pose.x_m = p[0], pose.y_m = p[1], pose.z_m = p[2];
  }
  pose.roll_deg = lidar.number("roll_deg"), pose.pitch_deg = lidar.number("pitch_deg"),
  pose.heading_deg = lidar.number("heading_deg");
  if (!lidar.given("look_at_m")) return pose;
  refuse_keys(lidar, {"heading_deg", "pitch_deg", "roll_deg", "speed_m_s"}, "a platform with look_at_m", report);
  if (lidar.numbers("look_at_m").size() != 3) return std::nullopt;
  look_at(pose, lidar.numbers("look_at_m"), lidar, report);
  return pose;
}

}  // namespace

void read_platform(const Record& lidar, const SceneParts& parts, Lidar& out, const LidarReport& report) {
  auto& problems = report.problems;
  out.prf_hz = lidar.number("prf_khz") * 1e3;
  out.gps_start_s = lidar.number("gps_start_s");
  const int ways = count_given(lidar, {"altitude_agl_m", "position_m", "trajectory"});
  if (ways != 1) {
    problems.add(lidar.where, "LIDAR needs exactly one of altitude_agl_m, position_m, trajectory", std::to_string(ways),
                 "remove or add one");
    return;
  }
  if (lidar.given("center_m") && !lidar.given("altitude_agl_m"))
    problems.add(lidar.place("center_m"), "'center_m' goes with altitude_agl_m", "", "remove it");
  const bool flown = lidar.given("trajectory");
  if (flown) {
    refuse_keys(lidar, {"speed_m_s", "look_at_m"}, "a platform with trajectory", report);
    out.trajectory = read_trajectory(lidar, report);
    if (out.trajectory.empty()) return;
  }
  if (!(out.prf_hz > 0)) return;  // reported with the key
  out.first_pulse_s = lidar.given("first_pulse_s") ? lidar.number("first_pulse_s")
                      : flown                      ? out.trajectory.front().time_s
                                                   : 0;
  out.pulses = count_pulses(lidar, out, out.first_pulse_s, report);
  if (out.pulses == 0) {
    out.pulses = 1;
    return;
  }
  const double last_s = out.first_pulse_s + static_cast<double>(out.pulses - 1) / out.prf_hz;
  if (flown) {
    if (out.trajectory.size() > 1 &&
        (out.first_pulse_s < out.trajectory.front().time_s || last_s > out.trajectory.back().time_s + 0.5 / out.prf_hz))
      report.notice(lidar.place("trajectory"),
                    "pulses from " + number_text(out.first_pulse_s) + " to " + number_text(last_s) +
                        " s reach beyond the trajectory's " + number_text(out.trajectory.front().time_s) + " to " +
                        number_text(out.trajectory.back().time_s) + " s; those outside keep its ends");
    return;
  }
  const auto middle = middle_pose(lidar, parts, report);
  if (!middle) return;
  const double reach_m = 0.5 * lidar.number("speed_m_s") * (last_s - out.first_pulse_s),
               heading = base::rad_by_division(middle->heading_deg);
  out.trajectory = {*middle};
  out.trajectory.front().time_s = out.first_pulse_s;
  if (reach_m == 0) return;
  out.trajectory.push_back(*middle);
  out.trajectory.back().time_s = last_s;
  for (const int end : {0, 1}) {
    LidarPose& pose = out.trajectory[static_cast<std::size_t>(end)];
    pose.x_m += (2 * end - 1) * reach_m * std::sin(heading);
    pose.y_m += (2 * end - 1) * reach_m * std::cos(heading);
  }
}

}  // namespace raycube::scene::detail
